"""Vectors and small matrices in an expression, written out: its text becomes one text for each component.

A vector q of size 3 stands for the names q1, q2, q3, as templates make them (see `loops`). Python's parser reads the
text; whatever has no vector in it stays as it was written. What cannot be read stays too: the reader of plain
expressions says what is wrong with it.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from ..expressions.slips import ENDS, MAX_LENGTH, RATE
from ..language.ranges import Mistaken
from ..text import shorten, tidy
from . import algebra
from .algebra import (
    ATOM,
    FUNCTIONS,
    POWER,
    PRODUCT,
    SUM,
    Scalar,
    Unfit,
    Value,
    each,
    each_mapped,
    elementwise,
    shape_in_words,
    shape_of,
)
from .parsed import names_of
from .texts import OWN, FileFunction, NoExpression, Scope, Text
from .wanted import unknown_function

MAX_CALLS = 200  # of functions of the file in one text, and in their bodies

_OF_ALL = ("min", "max")  # of one vector: of its components

_OPERATORS: dict[type[ast.operator], Callable[[Value, Value], Value]] = {
    ast.Add: partial(elementwise, algebra.plus),
    ast.Sub: partial(elementwise, algebra.less),
    ast.Mult: partial(elementwise, algebra.times),
    ast.Div: partial(elementwise, algebra.over),
    ast.MatMult: algebra.matrix_product,
}
_SPINE = tuple(_OPERATORS)
_LEVELS = {ast.Mult: PRODUCT, ast.Div: PRODUCT, ast.Pow: POWER}
_ATOMS = (ast.Name, ast.Constant, ast.Call, ast.Attribute, ast.Subscript)

_END = re.compile(rf"\[({'|'.join(ENDS)})\]")


def evaluate(text: str, scope: Scope) -> Value | None:
    """The components of an expression as texts; None where it has no vectors in it, and may stay as it is.

    Raises Mistaken for vectors that do not go together, or of which there is no such component.
    """
    return _Reader(tidy(text), scope, {}).whole()


def is_of_vectors(text: str, arguments: Sequence[str], scope: Scope) -> bool:
    """Whether a function of the file is one of vectors, whatever it is called with.

    text: its body.
    arguments: their names.
    scope: what other names mean.
    """
    scalars = {name: Scalar(name) for name in arguments}
    return _Reader(tidy(text), scope, scalars).has_vectors()


class _Reader(Text):
    """Reads one text, which may be the body of a function.

    arguments: what the names of its arguments stand for.
    within: the functions that are called around it.
    calls: how many calls there were so far.
    """

    def __init__(
        self,
        text: str,
        scope: Scope,
        arguments: Mapping[str, Value],
        within: tuple[str, ...] = (),
        calls: list[int] | None = None,
    ):
        super().__init__(text, scope, arguments)
        self.within, self.calls = within, calls or [0]

    def whole(self) -> Value | None:
        """The value of the text; None if it is a scalar without vectors in it, or calls what the language lacks."""
        if self.tree is not None and any(self.is_lacking(node) for node in ast.walk(self.tree)):
            return None
        if self.tree is None:
            return Scalar(self.plain(self.text), SUM) if self.mentions_vectors() else None
        if id(self.tree) not in self.concerned:
            return None
        return self.value(self.tree)

    def has_vectors(self) -> bool:
        """Whether there is anything of vectors in the text, or its arguments, now scalars, are to be such."""
        inside = ast.walk(self.tree) if self.tree else ()
        if any(self.is_special(node) and getattr(node, "id", None) not in self.arguments for node in inside):
            return True
        try:
            self.whole()
        except NoExpression:  # of which is told where the function is declared
            return False
        except Mistaken:
            return True
        return False

    def value(self, node: ast.expr) -> Value:
        """The value of a node."""
        if id(node) not in self.concerned:
            level = _LEVELS.get(type(node.op), SUM) if isinstance(node, ast.BinOp) else SUM
            return Scalar(self.source(node), ATOM if isinstance(node, _ATOMS) else level)
        match node:
            case ast.Name() | ast.Attribute():
                return self.named(self.source(node)) or Scalar(self.source(node))
            case ast.List(elts=items):
                return self._list(node, items)
            case ast.Subscript(value=base, slice=index):
                return self._subscript(node, self.value(base), index)
            case ast.Call(func=function, args=given, keywords=[]):
                return self._call(node, function, [self.value(own) for own in given])
        return self._operation(node) or Scalar(self.plain(self.source(node)), SUM)

    def _operation(self, node: ast.expr) -> Value | None:
        match node:
            case ast.UnaryOp(op=ast.USub(), operand=operand):
                return each_mapped(self.value(operand), algebra.minus)
            case ast.UnaryOp(op=ast.UAdd(), operand=operand):
                return self.value(operand)
            case ast.BinOp(op=ast.Pow(), left=left, right=right):
                return self.made(node, elementwise, algebra.power, self.value(left), self.value(right))
            case ast.BinOp(op=op) if isinstance(op, _SPINE):
                return self._chain(node)
        return None

    def _list(self, node: ast.expr, items: Sequence[ast.expr]) -> Value:
        values = [self.value(item) for item in items]
        if not values or any(shape_of(own) != shape_of(values[0]) for own in values):
            raise self.refuse(
                node, "the items of this list are not alike", "write one value each, or rows of one length"
            )
        return values

    def _chain(self, node: ast.expr) -> Value:
        """Sums and products from the left; they may be long."""
        spine = []
        while isinstance(node, ast.BinOp) and isinstance(node.op, _SPINE) and id(node) in self.concerned:
            spine.append(node)
            node = node.left
        result = self.value(node)
        for own in reversed(spine):
            right = self.value(own.right)
            if isinstance(own.op, ast.Mult) and (product := self._product(own, result, right)):
                raise product
            result = self.made(own, _OPERATORS[type(own.op)], result, right)
        return result

    def _product(self, node: ast.BinOp, left: Value, right: Value) -> Mistaken | None:
        """What is said of a matrix times a vector by *; None where * is right, or the two have no product at all."""
        a, b = shape_of(left), shape_of(right)
        if {len(a), len(b)} != {1, 2} or a[-1] != b[0] or 1 in (*a, *b):
            return None
        what = f"{shape_in_words(a)} and {shape_in_words(b)} are multiplied by @, and * goes element by element"
        return self.refuse(node, what, f"write {self.source(node.left)} @ {self.source(node.right)}")

    def made(self, node: ast.expr, work: Callable[..., Value], *operands: Any) -> Value:
        """What an operation makes of its operands; its mistakes are told with the text of the node."""
        try:
            value = work(*operands)
        except Unfit as unfit:
            raise self.refuse(node, unfit.what, unfit.remedy) from unfit
        if any(len(own.text) > MAX_LENGTH for own in each(value)):
            what = f"written out, a component of this has more than {MAX_LENGTH} characters"
            raise self.refuse(node, what, "name parts of it under expressions:")
        return value

    def _subscript(self, node: ast.Subscript, base: Value, index: ast.expr) -> Value:
        match index:
            case ast.Name(id=mark) if mark in (*ENDS, RATE):
                if any(name in self.arguments for name in names_of(node.value)):
                    what = "this is an argument here, and has one value"
                    raise self.refuse(node, what, f"write {self.source(node.value)}")
                return each_mapped(base, lambda own: Scalar(f"{own.text}[{mark}]"))
            case ast.Tuple(elts=items):
                for item in items:
                    base = self._component(node, base, item)
                return base
        return self._component(node, base, index)

    def _component(self, node: ast.Subscript, base: Value, index: ast.expr) -> Value:
        name = self.source(node.value)
        if isinstance(base, Scalar):
            raise self.refuse(node, f"{shorten(name, 40)} is one value, and has no components", f"write {name}")
        match index:
            case ast.Constant(value=int(i)) if 1 <= i <= len(base):
                return base[i - 1]
            case ast.Slice(lower=ast.Constant(value=int(i)), upper=ast.Constant(value=int(j)), step=None):
                if self.colons:
                    what = "a range of components has two points, as in loops"
                    raise self.refuse(node, what, f"write {name}[{i}..{j}], with both ends included")
                if 1 <= i <= j <= len(base):
                    return base[i - 1 : j]
        count = len(base)
        what = f"{name} has the components {name}[1] to {name}[{count}]"
        remedy = "write one of them, or several as " + f"{name}[1..{min(2, count)}]; in a loop {name}[{{i}}]"
        raise self.refuse(node, what, remedy)

    def _call(self, node: ast.Call, function: ast.expr, given: list[Value]) -> Value:
        name = function.id if isinstance(function, ast.Name) else ""
        if own := self.scope.function(name):
            return self._inlined(node, own, given)
        vectors = [own for own in given if isinstance(own, list)]
        if name in OWN or (name in FUNCTIONS and len(given) == 1):
            return self.made(node, partial(algebra.of_vectors, name, shown=list(map(self.source, node.args))), given)
        if name in ("", *self.arguments) or self.scope.vector(name) is not None:  # q(t - tau), q[1](t - tau)
            inside, base = self.text[function.end_col_offset : node.end_col_offset], self.value(function)
            if isinstance(function, ast.Attribute) and isinstance(base, Scalar):
                return Scalar(self.plain(self.source(node)))
            return each_mapped(base, lambda own: Scalar(f"{own.text}{inside}"))
        if name in _OF_ALL and len(given) == len(vectors) == 1:
            return Scalar(f"{name}({', '.join(own.text for own in each(given[0]))})")
        if unknown := unknown_function(name, self.scope.called):
            raise self.refuse(node, *unknown)
        call = lambda *own: Scalar(f"{name}({', '.join(a.text for a in own)})")  # noqa: E731
        return self.made(node, elementwise, call, *given)

    def _inlined(self, node: ast.Call, own: FileFunction, given: list[Value]) -> Value:
        """A function of the file with what it is given in place of its arguments; a call of scalars stays one."""
        name, wanted = self.source(node.func), own.arguments
        called = f"{name}({', '.join(wanted)})"
        if len(given) != len(wanted):
            what = f"{name} takes {len(wanted)} argument{'s' * (len(wanted) > 1)}, not {len(given)}"
            raise self.refuse(node, what, f"write {called}")
        if not own.of_vectors and all(isinstance(value, Scalar) for value in given):
            return Scalar(f"{name}({', '.join(value.text for value in given if isinstance(value, Scalar))})")
        self.calls[0] += 1
        if name in self.within or self.calls[0] > MAX_CALLS:
            what = f"{name} calls itself" if name in self.within else f"this makes more than {MAX_CALLS} calls"
            raise self.refuse(node, what, "name parts of it under expressions:, without arguments")
        by_name = dict(zip(wanted, given, strict=True))
        body = _Reader(tidy(own.body), self.scope, by_name, (*self.within, name), self.calls)
        if any(_END.search(scalar.text) for value in given for scalar in each(value)):
            body.refuse_free_names(called)
        found = body.whole()
        return Scalar(body.text, SUM) if found is None else found

    def refuse_free_names(self, called: str) -> None:
        """At an end of time a body has its arguments and fixed names only: of others it is not clear where."""
        for name in sorted(names_of(self.tree) - self.arguments.keys()) if self.tree else ():
            if not self.scope.fixed(name):
                what = f"{called} uses {name}, and it is not clear at which end it is meant"
                raise Mistaken(what, f"make {name} an argument of the function")
