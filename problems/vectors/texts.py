"""A text in which there may be vectors: its tree, what the names in it mean, what is said of mistakes in it."""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

from ..expressions.lacking import LACKING
from ..expressions.slips import check_syntax
from ..expressions.tokens import ExpressionError
from ..language.ranges import Mistaken
from ..text import shorten
from .algebra import FUNCTIONS, Scalar, Value
from .parsed import parsed, with_colons

OWN = frozenset(FUNCTIONS) - {"norm", "sum"}
"""Functions that no text without vectors has."""

_NAME = re.compile(r"[A-Za-z_][\w.]*")
_COMPONENT = re.compile(r"([A-Za-z_][\w.]*)\[\s*(\d+)\s*\]")
_LIST = re.compile(r"(?:^|[-+*/@(,\[])\s*\[")


class FileFunction(NamedTuple):
    """A function of the file. of_vectors: whether its body has vectors in it whatever its arguments are."""

    arguments: Sequence[str]
    body: str
    of_vectors: bool


class Scope(Protocol):
    """What names mean in a text. called: those that have arguments, of tables and of functions of the file."""

    called: frozenset[str]

    def vector(self, name: str) -> Value | None:
        """The components of a name, which may be that of a phase, a point, and a name in it; None for a scalar."""

    def function(self, name: str) -> FileFunction | None:
        """The function of the file that has the name."""

    def fixed(self, name: str) -> bool:
        """Whether a name has the same value at all times."""


class NoExpression(Mistaken):
    """What no expression may look like, with vectors or without."""


class Text:
    """A text, which may be the body of a function.

    arguments: what the names of its arguments stand for.
    """

    def __init__(self, text: str, scope: Scope, arguments: Mapping[str, Value]):
        self.text, self.scope, self.arguments = with_colons(text), scope, arguments
        self.colons = ":" in text
        self.tree = parsed(self.text)
        self.concerned: set[int] = set()  # the nodes that have something of vectors in or below them
        for node in reversed(list(ast.walk(self.tree))) if self.tree else ():
            inside = any(id(own) in self.concerned for own in ast.iter_child_nodes(node))
            if inside or self.is_special(node):
                self.concerned.add(id(node))

    def mentions_vectors(self) -> bool:
        """Whether a text that cannot be read has the name of a vector in it."""
        return any(isinstance(self.named(name), list) for name in _NAME.findall(self.text))

    def plain(self, text: str) -> str:
        """A text that cannot be read, with names in place of the components in it. Raises Mistaken for a slip in it."""
        new = _COMPONENT.sub(self._plain, text)
        try:
            check_syntax(new.replace("@", "*"), self.scope.called)
        except ExpressionError as error:
            if _LIST.search(new):  # which is none of the slips that are looked for
                what = f'"{shorten(text, 60)}" cannot be read as an expression'
                raise NoExpression(what, "look for a missing operator, bracket or comma") from error
            raise NoExpression(error.what, error.remedy) from error
        return new

    def _plain(self, found: re.Match[str]) -> str:
        value, index = self.named(found[1]), int(found[2])
        own = value[index - 1] if isinstance(value, list) and 1 <= index <= len(value) else None
        return own.text if isinstance(own, Scalar) else found[0]

    def is_lacking(self, node: ast.AST) -> bool:
        """Whether a node calls interp(...) and the like, of which the reader of plain expressions tells."""
        name = node.func.id if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else ""
        return name in LACKING and name not in FUNCTIONS and name not in self.scope.called

    def is_special(self, node: ast.AST) -> bool:
        match node:
            case ast.Name(id=name):
                return name in self.arguments or self.scope.vector(name) is not None
            case ast.Attribute(value=ast.Name(id=phase), attr=name):
                return self.scope.vector(f"{phase}.{name}") is not None
            case ast.Call(func=ast.Name(id=name)):
                own = self.scope.function(name)
                return name in OWN if own is None else own.of_vectors
            case ast.List() | ast.MatMult():
                return True
        return False

    def named(self, name: str) -> Value | None:
        return self.arguments[name] if name in self.arguments else self.scope.vector(name)

    def source(self, node: ast.expr) -> str:
        return self.text[node.col_offset : node.end_col_offset]

    def refuse(self, node: ast.expr, what: str, remedy: str) -> Mistaken:
        """The mistake in a part of the text.

        node: the part.
        what: is wrong with it.
        remedy: for it.
        """
        shown = self.source(node) if self.colons else self.source(node).replace(":", "..")
        return Mistaken(f'"{shorten(shown, 60)}": {what}', remedy, shown)
