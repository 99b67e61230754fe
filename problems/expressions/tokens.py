"""An expression cut into tokens, and the mistake that an expression may be."""

from __future__ import annotations

import re
from typing import NamedTuple, NoReturn

from ..text import excerpt

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<name>[A-Za-z_]\w*(?:\.[A-Za-z_]\w*\b(?!\s*\())?)"
    r"|(?P<operator>\*\*|//|[-+*/()\[\],.])|(?P<other>\S))",
    re.ASCII,
)

DEGREES = frozenset(["deg", "degs", "degree", "degrees"])
_UNITS = frozenset(
    [
        "kg",
        "g",
        "mg",
        "lb",
        "t",
        "s",
        "ms",
        "min",
        "h",
        "hr",
        "day",
        "m",
        "km",
        "cm",
        "mm",
        "ft",
        "in",
        "N",
        "kN",
        "mN",
        "Nm",
        "J",
        "kJ",
        "W",
        "kW",
        "MW",
        "Pa",
        "kPa",
        "MPa",
        "bar",
        "V",
        "A",
        "C",
        "K",
        "Hz",
        "rad",
        "rpm",
    ]
)
"""Units that people write after a number. A number beside any other name lacks its operator."""


class ExpressionError(ValueError):
    """A string is not an expression. what: the mistake and where it stands in the string. remedy: how to mend it."""

    def __init__(self, what: str, remedy: str):
        self.what, self.remedy = what, remedy
        super().__init__(f"{what}; {remedy}")


class Token(NamedTuple):
    """category: number, name, called (a name of the file before its arguments), operator, separator (a comma between
    arguments), other or end (an empty token)."""

    category: str
    text: str
    start: int
    stop: int


def tokens_of(text: str) -> list[Token]:
    """All tokens, with an empty one at either end so that every token has neighbours."""
    matches = ((str(m.lastgroup), m) for m in _TOKEN.finditer(text))
    found = [Token(category, m[category], *m.span(category)) for category, m in matches]
    return [Token("end", "", 0, 0), *found, Token("end", "", len(text), len(text))]


def closing(text: str, bracket: Token) -> Token:
    """The partner of an opening parenthesis; the end of the text if it has none."""
    depth = 0
    for i in range(bracket.start, len(text)):
        if text[i] == "(":
            depth += 1
        elif text[i] == ")":
            depth -= 1
        if depth == 0:
            return Token("operator", ")", i, i + 1)
    return Token("end", "", len(text), len(text))


def fail(text: str, first: Token, last: Token, what: str, remedy: str) -> NoReturn:
    """Raise ExpressionError that quotes a part of an expression.

    text: the expression.
    first: the first token that is quoted.
    last: the last one.
    what: the mistake.
    remedy: how to mend it.
    """
    raise ExpressionError(f"{excerpt(text, first.start, last.stop)}: {what}", remedy)


def check_number(text: str, number: Token, name: Token) -> None:
    """Raise ExpressionError for a number that goes on in letters, as other languages write it, or that has a unit.

    text: the expression.
    number: a number in it.
    name: the name that follows it without an operator.
    """
    if number.stop == name.start and re.fullmatch(r"[_\d]+(?:[eE]\d*)?", name.text):
        written = re.match(r"[_\d.]+(?:[eE][-+]?\d+)?", text[number.start :])
        assert written is not None  # it starts with the number
        last = Token("number", "", number.start, number.start + written.end())
        fail(text, number, last, "there is no _ in a number", f"write {written[0].replace('_', '')}")
    if number.stop == name.start and (exponent := re.match(r"[dD]([-+]?\d+)", text[name.start :])):
        last = Token("number", "", name.start, name.start + exponent.end())
        fail(text, number, last, "the exponent of a number is written with e", f"write {number.text}e{exponent[1]}")
    if name.text in DEGREES:
        fail(text, number, name, "angles are in radians", f"write {number.text}*pi/180")
    if name.text in _UNITS and name.start > number.stop:
        remedy = f"write {number.text}, or name it under parameters: as a: {{value: {number.text}, unit: {name.text}}}"
        fail(text, number, name, "units do not stand in expressions", remedy)


def head_of(operand: Token) -> str:
    """The end of an operand, as a message shows it."""
    return operand.text if operand.text not in (")", "]") else "..." + operand.text
