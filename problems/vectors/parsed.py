"""Texts of a file as Python's parser reads them, with the ranges of components in them."""

from __future__ import annotations

import ast
import re
from warnings import catch_warnings, simplefilter

from ..expressions.slips import MAX_LENGTH
from ..text import tidy

_RANGE = re.compile(r"(\[\s*\d+)\s*\.\.\s*(\d+\s*\])")


def with_colons(text: str) -> str:
    """A text in which q[1..3] is q[1:3], which Python can read."""
    return _RANGE.sub(r"\1:\2", text)


def parsed(text: str) -> ast.expr | None:
    """The tree of a text; None if it is no expression, or one that is refused for its size."""
    if len(text) > MAX_LENGTH or not text.isascii():
        return None
    try:
        with catch_warnings():
            simplefilter("ignore")  # of a number that goes on in letters, which is told later
            return ast.parse(text, mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None


def names_in(text: str) -> set[str]:
    """The names in a text, without those of functions; none in one that cannot be read."""
    tree = parsed(with_colons(tidy(text)))
    return names_of(tree) if tree else set()


def names_of(node: ast.expr) -> set[str]:
    """The names in a tree, without those of functions."""
    called = {id(own.func) for own in ast.walk(node) if isinstance(own, ast.Call)}
    return {own.id for own in ast.walk(node) if isinstance(own, ast.Name) and id(own) not in called}
