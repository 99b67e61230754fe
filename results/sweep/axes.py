"""What is swept: "PATH=VALUES" as values of one field, each a piece of YAML as an override takes it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import isfinite

import numpy as np

from ...problems.errors import Mistake, SpecError
from ...problems.lean.records import dataclass
from ...problems.schema.solving import MAX_CASES
from ...problems.text import brief
from ...problems.yaml.document import in_words, value_of
from ...problems.yaml.overrides import as_text

FORMS = "write START:STOP:COUNT, log:START:STOP:COUNT, or values with commas between them"
_OPENING, _CLOSING = "([{", ")]}"
_WHOLE = re.compile(r"\s*[-+]?\d+\s*")


@dataclass(frozen=True)
class NumberRange:
    """A range of numbers; even in the logarithm if `log`."""

    start: float
    stop: float
    log: bool

    def at(self, shares: np.ndarray) -> list[float]:
        """The numbers at shares of the way from start to stop, shape (K,)."""
        if self.log:
            return np.exp(np.log(self.start) + shares * np.log(self.stop / self.start)).tolist()
        return (self.start + shares * (self.stop - self.start)).tolist()


@dataclass(frozen=True)
class Axis:
    """One swept field: its path, and its values as YAML. span: where these come from, if from a range of numbers."""

    path: str
    values: tuple[str, ...]
    span: NumberRange | None = None


def parse_axis(text: str, sampled: bool = False) -> Axis:
    """The axis of "PATH=VALUES". sampled: a range needs no COUNT then. Raises SpecError."""
    path, equals, values = text.partition("=")
    if not equals or not path.strip() or not values.strip():
        raise SpecError(Mistake(f"--over {text}", "this is not PATH=VALUES", "write parameters.u_max=8:20:25"))
    return axis_of(path.strip(), values.strip(), f"--over {path.strip()}", sampled)


def axis_of(path: str, values: object, where: str, sampled: bool = False) -> Axis:
    """The axis of a path.

    path: of the field.
    values: as a text after `--over PATH=`, or a number or a list from a problem file.
    where: for messages.
    sampled: whether a range may leave out its COUNT.

    Raises SpecError for what is no range and no list of different values.
    """
    if isinstance(values, str):
        if "," not in _outside(values) and ":" in _outside(values):
            return _range(path, values, where, sampled)
        items = _split(values)
    else:
        listed = values if isinstance(values, list) else [values]
        items = [as_text({"value": value})[0].removeprefix("value=") for value in listed]
    if "" in items or not items:
        raise SpecError(Mistake(where, "a value is missing between two commas, or at an end", FORMS))
    _refuse_doubles([value_of(item, where) for item in items], where)
    return Axis(path, tuple(items))


def _refuse_doubles(values: Sequence[object], where: str) -> None:
    texts = list(map(repr, values))
    if len(set(texts)) < len(texts):
        twice = next(value for value, text in zip(values, texts, strict=True) if texts.count(text) > 1)
        raise SpecError(Mistake(where, f"{in_words(twice)} is given twice", "remove one of them"))


def _range(path: str, text: str, where: str, sampled: bool) -> Axis:
    """START:STOP:COUNT or log:START:STOP:COUNT; START:STOP is enough for a sample."""
    parts = text.split(":")
    log = parts[0].strip() == "log"
    ends, count = parts[log : log + 2], parts[log + 2 :]
    span = NumberRange(_number(ends[0], where), _number(ends[1], where), log) if len(ends) == 2 else None
    if span is None or len(count) > 1 or (not count and not sampled):
        raise SpecError(Mistake(where, f'"{brief(text)}" is neither a range nor a list', FORMS))
    if log and (span.start <= 0 or span.stop <= 0):
        what = f"a logarithmic range from {span.start:g} to {span.stop:g} leaves the positive numbers"
        raise SpecError(Mistake(where, what, "give a positive START and STOP, or leave out log:"))
    if span.start == span.stop and count != ["1"]:
        raise SpecError(Mistake(where, f"the range starts and ends at {span.start:g}", "give another STOP"))
    points = _count(count[0], where) if count else 1
    numbers = [float(f"{number:.15g}") for number in span.at(np.linspace(0.0, 1.0, points))]  # 0.01, not 0.01...02
    whole = all(map(_WHOLE.fullmatch, ends)) and all(abs(x - round(x)) <= 1e-12 * abs(x) for x in numbers)
    return Axis(path, tuple(str(round(x)) if whole else repr(x) for x in numbers), span)


def _number(text: str, where: str) -> float:
    """A finite number. Raises SpecError."""
    try:
        number = float(text)
    except ValueError:
        number = float("nan")
    if not isfinite(number):
        raise SpecError(Mistake(where, f'"{brief(text)}" is no number to start or end a range', FORMS))
    return number


def _count(text: str, where: str) -> int:
    if not _WHOLE.fullmatch(text) or not 1 <= int(text) <= MAX_CASES:
        what = f'"{brief(text)}" is no COUNT of values'
        raise SpecError(Mistake(where, what, f"write a whole number from 1 to {MAX_CASES}"))
    return int(text)


def _depths(text: str) -> list[int]:
    """How many brackets are open at each letter; inside quotes one more."""
    depths, depth, quote = [], 0, ""
    for letter in text:
        if quote:
            quote = "" if letter == quote else quote
            depths.append(depth + 1)
            continue
        quote = letter if letter in "\"'" else ""
        depth += (letter in _OPENING) - (letter in _CLOSING)
        depths.append(depth + (letter in _CLOSING) + bool(quote))
    return depths


def _outside(text: str) -> str:
    """The letters that stand in no brackets and no quotes."""
    return "".join(letter for letter, depth in zip(text, _depths(text), strict=True) if depth == 0)


def _split(text: str) -> list[str]:
    """The parts between the commas that stand in no brackets and no quotes."""
    parts = [""]
    for letter, depth in zip(text, _depths(text), strict=True):
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return [part.strip() for part in parts]
