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
