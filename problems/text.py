"""Helpers for texts that people read: on one line, short, and with the word that was probably meant."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields, is_dataclass
from decimal import ROUND_UP, Context
from enum import Enum
from math import floor, log10
from typing import TypeVar
from unicodedata import category
from unicodedata import name as title

T = TypeVar("T")

SAMPLED = 100
"""Items of a long container that are looked at for a repr."""

FEWEST, MOST = 4, 10
"""Significant digits of a value with an error bar."""

_COMPARED = re.compile("(<=|>=|==|<|>|=)")
SIDES = {"<": "upper", "<=": "upper", ">": "lower", ">=": "lower", "=": "equals", "==": "equals"}
"""What a sign makes of its right side: a bound of the left one."""


def compared(text: str) -> tuple[list[str], list[str]]:
    """The sides of a comparison, and the signs between them."""
    parts = _COMPARED.split(text)
    return [side.strip() for side in parts[::2]], parts[1::2]


def tidy(text: str) -> str:
    """The text on one line with single spaces (folded YAML scalars carry line breaks)."""
    return " ".join(text.split())


def unprintable(character: str) -> bool:
    """Whether a character steers a terminal or is no text at all: a control character or a lone surrogate."""
    return category(character) in ("Cc", "Cs")


def escaped(text: str, hidden: Callable[[str], bool] = unprintable) -> str:
    """The text with the escape of every character that is hidden, but for breaks of lines and tabs.

    text: any.
    hidden: whether a character is; without it those that steer a terminal or are no text.
    """
    return "".join(c.encode("unicode_escape").decode() if hidden(c) and c not in "\n\t" else c for c in text)


def named(character: str) -> str:
    """A character by its code and its name: U+00A0, no-break space."""
    return f"U+{ord(character):04X}" + (f", {called.lower()}" if (called := title(character, "")) else "")


def printable(text: str) -> str:
    """The text with a space for every white space, and ? for what cannot be printed."""
    return "".join(" " if c.isspace() else c if c.isprintable() else "?" for c in text)


def shorten(text: str, limit: int = 80) -> str:
    """The text with its middle left out where it is longer than `limit` characters."""
    return text if len(text) <= limit else f"{text[: limit // 2 - 2]} ... {text[-limit // 2 + 3 :]}"


def brief(word: str | int) -> str:
    """A word of the user's on one short line, for messages: nothing in it steers a terminal."""
    return shorten(printable(tidy(str(word))), 40)


def with_bar(value: float, bar: float) -> tuple[str, str]:
    """A value with the digits that its error bar supports, and the bar with one: ("58.80767", "3e-8").

    value: finite.
    bar: positive and finite.

    The value's last digit stands where the bar's is, within FEWEST and MOST digits. The bar is rounded up, with what
    rounding has moved the value: what the two say together is never more than what is known.
    """
    place = floor(log10(bar))
    first = floor(log10(abs(value))) if value else 0
    digits = min(max(first - place + 1, FEWEST), MOST)
    fixed = -5 <= first < 15
    shown = f"{value:.{max(digits - 1 - first, 0)}f}" if fixed else f"{value:.{digits - 1}e}"
    reach = f"{bar + abs(float(shown) - value):.6e}"  # six digits: 3e-8 is a little more than that in binary
    up = float(Context(prec=1, rounding=ROUND_UP).create_decimal(reach))
    return shown, re.sub(r"e([+-])0", r"e\1", f"{up:g}")


def excerpt(text: str, start: int, stop: int, margin: int = 30) -> str:
    """The offending piece of an expression in quotes, inside enough of the expression to find it.

    text: the whole expression.
    start, stop: indices of the piece in it.
    margin: number of characters shown on either side.
    """
    piece = f'"{shorten(text[start:stop].strip())}"'
    if text[start:stop].strip() == text:
        return piece
    left, right = max(0, start - margin), min(len(text), stop + margin)
    around = ("..." if left else "") + text[left:right].strip() + ("..." if right < len(text) else "")
    return f'{piece} in "{shorten(around, 120)}"'


def nearest(word: str | int, known: Iterable[str | int], likeness: float = 0.6) -> str | None:
    """The known word most like this one, or None if none is like it.

    word: as the user wrote it.
    known: the words it may be.
    likeness: that a word must have, from 0 to 1.
    """
    by_lower_case = {str(k).lower(): str(k) for k in known}
    found = difflib.get_close_matches(str(word).lower(), by_lower_case, n=1, cutoff=likeness)
    return by_lower_case[found[0]] if found else None


def did_you_mean(
    word: str | int, known: Iterable[str | int], otherwise: str = "", always: str = "", likeness: float = 0.6
) -> str:
    """A remedy for an unknown word.

    word: as the user wrote it.
    known: the words it may be; the one most like it is proposed.
    otherwise: what is said if none is like it.
    always: what is said after either.
    likeness: that a word must have to be proposed, from 0 to 1.
    """
    close = nearest(word, known, likeness)
    return " ".join(filter(None, [f"did you mean {close}?" if close else otherwise, always]))


def short_repr(kind: type[T]) -> type[T]:
    """A decorator of dataclasses and named tuples: their repr is one line, however much they hold.

    Arrays are told by their shapes, containers by the names of what is in them, objects by their own name.
    """

    def one_line(self: T) -> str:
        names = [field.name for field in fields(self)] if is_dataclass(self) else getattr(self, "_fields", ())
        told = ", ".join(f"{name}={_hint(getattr(self, name))}" for name in names)
        return f"<{kind.__name__} {shorten(told, 400)}>"

    kind.__repr__ = one_line  # type: ignore[method-assign, assignment]
    return kind


def _hint(value: object) -> str:
    """What a value is, on a part of a line."""
    shape = getattr(value, "shape", None)
    if isinstance(shape, tuple) and shape:
        return f"array{shape}".replace(",)", ")")
    if isinstance(value, Mapping):
        return "{" + shorten(", ".join(map(str, value))) + "}"
    if isinstance(value, tuple | list):
        kinds = dict.fromkeys(map(_hint, value[:SAMPLED]))
        return f"{len(value)} of {shorten(', '.join(kinds))}" if len(value) > 1 else f"({', '.join(kinds)})"
    if isinstance(value, bytes):
        return f"{len(value)} bytes"
    if value is None or isinstance(value, str | int | float):
        return shorten(tidy(repr(value)), 40)
    name = value.name if isinstance(value, Enum) else getattr(value, "name", None)
    return shorten(tidy(name), 40) if isinstance(name, str) else f"<{type(value).__name__}>"
