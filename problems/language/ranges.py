"""What a loop goes over, `i in 1..2*N`, and the whole numbers that stand in braces, `{i + 1}`."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from math import isclose, isfinite
from typing import Any

from ..expressions.expression import parse
from ..expressions.tokens import ExpressionError
from ..text import brief, did_you_mean
from ..yaml.document import in_words

MOST = 10_000
"""Entries that one template may make."""

Values = Mapping[str, int | str]

BRACES = re.compile(r"\{([^{}]*)\}")
NAME = re.compile(r"[A-Za-z_]\w*")
_LOOP = re.compile(r"\s*([A-Za-z]\w*)\s+in\s+(.+?)\s*")
_BETWEEN = re.compile(r"\s*,\s*(?=[A-Za-z]\w*\s+in\s)")
_WORD = re.compile(r"\w+")


class Mistaken(Exception):  # noqa: N818 - it ends the writing out of one entry
    """What is wrong with an entry or a text, and the remedy. text: the part of it that is wrong."""

    def __init__(self, what: str, remedy: str, text: str = ""):
        self.what, self.remedy, self.text = what, remedy, text
        super().__init__(what)


def whole_numbers(parameters: Any) -> dict[str, int | str]:
    """The parameters of a file that are whole numbers: what a range may depend on."""
    found: dict[str, int | str] = {}
    for name, entry in parameters.items() if isinstance(parameters, dict) else ():
        value = entry.get("value") if isinstance(entry, dict) else entry
        if isinstance(value, int | float) and not isinstance(value, bool) and value % 1 == 0:
            found[name] = int(value)
    return found


def pairs(loop: Any, values: Values, numbers: Values) -> Iterator[tuple[str, int | str]]:
    """(variable, value) for each value of a loop. Raises Mistaken if it is none.

    loop: "i in 1..N", "leg in left, right".
    values: of the variables of loops around it.
    numbers: parameters that are whole numbers.
    """
    if isinstance(loop, str) and (several := _in_one_text(loop)):
        raise Mistaken(f'"{brief(loop)}" is one text', f"write for: {several}, without quotes")
    match = _LOOP.fullmatch(loop) if isinstance(loop, str) else None
    if match is None:
        what = f"{in_words(loop)} says not what is repeated"
        raise Mistaken(what, "write a name and a range, i in 1..20, or a name and words, leg in left, right")
    name, over = match.groups()
    if name in values or name in numbers:
        what = f"{name} is {'a parameter' if name in numbers else 'the variable of another loop'} already"
        raise Mistaken(what, "give the variable another name")
    first, dots, last = over.partition("..")
    if dots:
        ends = [whole(end, values, numbers) for end in (first, last)]
        if ends[1] - ends[0] > MOST:
            raise Mistaken(f"this makes more than {MOST} entries", "write a shorter range")
        yield from ((name, value) for value in range(ends[0], ends[1] + 1))
        return
    words = [word.strip() for word in over.strip("[]").split(",")]
    for word in words:
        if not _WORD.fullmatch(word):
            what = f'"{brief(over)}" is neither a range nor a list of words'
            raise Mistaken(what, "write two ends, 1..20, or words with commas between them")
        yield name, int(word) if word.isdigit() else word


def _in_one_text(loop: str) -> str:
    """The loops of a text with brackets around it, or with several in it, as a file writes them; "" for other texts."""
    inside = loop.strip()
    bracketed = inside.startswith("[") and inside.endswith("]")
    loops = _BETWEEN.split(inside[1:-1] if bracketed else inside)
    if not (bracketed or len(loops) > 1) or not all(map(_LOOP.fullmatch, loops)):
        return ""
    return f"[{', '.join(own.strip() for own in loops)}]" if len(loops) > 1 else loops[0].strip()


def braces_filled(text: str, values: Values, numbers: Values, of_all: bool = True) -> str:
    """A text with the values in place of what stands in braces. Raises Mistaken for braces without a value.

    text: with {i} or {2*i + 1} in it.
    values: of the variables of loops.
    numbers: parameters that are whole numbers.
    of_all: False to leave braces as they are whose variables are not known.
    """

    def instead(braces: re.Match[str]) -> str:
        inside = braces[1].strip()
        if not of_all and not {*NAME.findall(inside)} <= {*values, *numbers}:
            return braces[0]
        return str(values[inside] if inside in values else whole(inside, values, numbers))

    return BRACES.sub(instead, text)


def whole(text: str, values: Values, numbers: Values, in_loop: bool = True) -> int:
    """The whole number that an expression is. Raises Mistaken if it is none.

    text: the expression.
    values: of the variables of loops.
    numbers: parameters that are whole numbers.
    in_loop: whether there may be such variables.
    """
    try:
        expression = parse(text)
    except ExpressionError as error:
        raise Mistaken(error.what, error.remedy) from error
    known = {**numbers, **values}
    for leaf in expression.leaves:
        if not isinstance(known.get(leaf.name), int):
            parameter = "parameter that is a whole number"
            lacks = "no variable of a loop" if in_loop else f"no {parameter}"
            what = f"{leaf.name} is {'a word' if leaf.name in known else lacks}"
            otherwise = f"{'name a variable of the loop, or' if in_loop else 'write a number, or name'} a {parameter}"
            raise Mistaken(f'"{brief(text)}": {what}', did_you_mean(leaf.name, known, otherwise))
    value = expression.bind({name: float(own) for name, own in known.items() if isinstance(own, int)}, {}).constant()
    if not isfinite(value) or not isclose(value, round(value), abs_tol=1e-9):
        raise Mistaken(f'"{brief(text)}" is {value:g}, no whole number', "change it")
    return round(value)
