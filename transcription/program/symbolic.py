"""Pyomo templates -> SymEngine expressions, and the numbers they read.

A templated constraint family holds one Pyomo expression with a placeholder s for its index:

    x['q1', s + 1] - x['q1', s] == h[s] * x['v1', s]

Here it becomes one SymEngine expression in arguments v0, v1, ... (variables) and d0, d1, ... (data), and one table that
says which number each argument is for each value of s. Every number has a slot in one long vector

    [ z | fixed variables and parameters ]

so that a variable which is fixed at some indices only is no special case: some of its slots lie behind z.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import prod
from typing import Any

import numpy as np
import symengine as se

from ...problems.expressions.functions import FUNCTIONS
from ...problems.tables.table import Table
from ..libraries.pyomo import (
    GetItemExpression,
    IndexTemplate,
    TemplateSumExpression,
    native_numeric_types,
    native_types,
    value,
)
from ..libraries.pyomo import numeric_expr as ne
from .lookups import CompiledLookup
from .slots import Slots
from .templates import SumTerm, TemplateError, linear_parts, table_of

SYMENGINE = {row.name: getattr(se, row.name) for row in FUNCTIONS.values() if row.composed is None}
EXACT_INTEGER = 2**53  # floats beyond it are not all integers, and integers beyond it not all floats


class Arguments:
    """The arguments of one family of templates over S index values, as its expressions are translated.

    variables, data: SymEngine symbols v0, v1, ... and d0, d1, ..., in order of first appearance; variable_slots and
    data_slots: for each of them the (S,) slots it stands for. lookups: of tables of data, inner ones first.
    """

    def __init__(self, slots: Slots, values: np.ndarray) -> None:
        self.slots, self.values = slots, values
        self.variables: list[se.Symbol] = []
        self.data: list[se.Symbol] = []
        self.variable_slots: list[np.ndarray] = []
        self.data_slots: list[np.ndarray] = []
        self.lookups: list[CompiledLookup] = []
        self._known: dict[Any, se.Symbol] = {}
        self._looked_up: dict[tuple, np.ndarray] = {}

    def translate(self, expression: Any, template: IndexTemplate | None) -> se.Basic:
        """The SymEngine expression of a Pyomo one. Raises TemplateError for what has no exact second derivative."""
        return _Translation(self, template)(expression)

    def numbers(self, expression: Any, template: IndexTemplate | None) -> np.ndarray:
        """Values (S,) of an expression in numbers, parameters and the template index: an index or a bound."""
        return np.broadcast_to(self._numbers(expression, template), self.values.shape)

    def _numbers(self, e: Any, template: Any) -> Any:
        if e.__class__ in native_types:
            return e
        if e is template:
            return self.values
        if isinstance(e, GetItemExpression):
            shape = _shape(e, template)
            if shape not in self._looked_up:
                index = [self._index(a, template) for a in e.args[1:]]
                self._looked_up[shape] = self.slots.table(e.args[0]).value_at(index)
            return self._looked_up[shape]
        if not e.is_expression_type():
            return value(e)
        parts = [self._numbers(a, template) for a in e.args]
        return _operation(e, parts, parts[0])

    def _index(self, e: Any, template: Any) -> Any:
        i = self._numbers(e, template)
        if isinstance(i, str):
            return i
        # Arithmetic such as (s + 1) / 2 gives floats, which are indices as long as they are whole.
        whole = np.asarray(i).astype(np.intp)
        if np.any(whole != i):
            raise TemplateError(f"the index {e} is not a whole number")
        return whole if whole.ndim else int(whole)

    def leaf(self, e: Any, template: Any) -> se.Symbol:
        """The symbol of a variable or parameter, indexed by the template or not."""
        indexed = isinstance(e, GetItemExpression)
        shape = _shape(e, template) if indexed else id(e)
        if shape not in self._known:
            slot = (
                self.slots.table(e.args[0]).lookup([self._index(a, template) for a in e.args[1:]])
                if indexed
                else self.slots.single(e)
            )
            self._known[shape] = self._symbol(np.broadcast_to(slot, self.values.shape))
        return self._known[shape]

    def look_up(self, table: Table, arguments: Sequence[se.Basic]) -> se.Symbol:
        """The symbol of the value of a table; the same lookup is made once."""
        # A symbol, as SymEngine cannot differentiate a table: its derivatives are put in afterwards (see `lookups`).
        key = (id(table), *arguments)
        if key not in self._known:
            self.lookups.append(CompiledLookup(len(self.lookups), table, tuple(map(se.sympify, arguments))))
            self._known[key] = self.lookups[-1].value
        return self._known[key]

    def _symbol(self, slot: np.ndarray) -> se.Symbol:
        # Two leaves that are the same number at every index are one argument, whatever they are called.
        key = slot.tobytes()
        if key not in self._known:
            # Free at one index is free at all: the entries of derivatives by what stands behind z are dropped later.
            free = bool((slot < self.slots.n).any())
            symbols, slots = (self.variables, self.variable_slots) if free else (self.data, self.data_slots)
            self._known[key] = se.Symbol(f"{'v' if free else 'd'}{len(symbols)}")
            symbols.append(self._known[key])
            slots.append(slot)
        return self._known[key]


def _shape(e: Any, template: Any) -> Any:
    """A key that is equal for equal index expressions, so that each is evaluated once a family."""
    # What is no expression goes by its identity: == of two Pyomo objects makes an equation, and tells nothing.
    if e.__class__ in native_types:
        return e
    if e is template:
        # Not the object: each template of a family has a placeholder of its own, and all mean the same index.
        return IndexTemplate
    if isinstance(e, GetItemExpression):
        return (id(e.args[0]), *(_shape(a, template) for a in e.args[1:]))
    if e.is_expression_type():
        return (e.__class__, *(_shape(a, template) for a in e.args))
    return id(e)


class _Translation:
    def __init__(self, arguments: Arguments, template: IndexTemplate | None) -> None:
        self.arguments, self.template = arguments, template
        self.memo: dict[int, se.Basic] = {}  # by identity, as the root that is translated keeps all its parts

    def __call__(self, e: Any) -> se.Basic:
        """The parts of an expression before itself, on a stack of our own: Python's is too short for long products."""
        waiting = [e]
        while waiting:
            # A rule that uses a subexpression again makes a graph; walked as a tree it can be exponentially large.
            if self._known(last := waiting[-1]):
                waiting.pop()
            elif parts := [part for part in _parts(last) if not self._known(part)]:
                waiting += reversed(parts)  # from the left, which numbers the arguments in the order of the text
            else:
                self.memo[id(last)] = self.node(last)
        return self.value(e)

    def _known(self, e: Any) -> bool:
        return e.__class__ in native_numeric_types or id(e) in self.memo

    def value(self, e: Any) -> se.Basic:
        """What a part has been translated to."""
        return exact_number(e) if e.__class__ in native_numeric_types else self.memo[id(e)]

    def node(self, e: Any) -> se.Basic:
        if isinstance(e, GetItemExpression) or not e.is_expression_type():
            if e.__class__ is IndexTemplate:
                raise TemplateError("the index of a template stands outside the brackets of a variable or parameter")
            return self.arguments.leaf(e, self.template)
        if isinstance(e, TemplateSumExpression):
            raise TemplateError(f"{e} is a sum over a Set inside an indexed family or a nonlinear term")
        if isinstance(e, ne.ExternalFunctionExpression):
            return self.table(e)
        parts = [self.value(a) for a in e.args]
        if isinstance(e, ne.UnaryFunctionExpression):
            return _real(_function(e)(parts[0]), parts)
        return _real(_operation(e, parts, se.Integer(0)), parts)

    def table(self, e: Any) -> se.Basic:
        found = table_of(e)
        if found is None:
            raise TemplateError(f"the external function {e.getname()} has no derivative here")
        table, operands = found
        return self.arguments.look_up(table, [self.value(a) for a in operands])


def _parts(e: Any) -> Sequence[Any]:
    """What an expression is made of; nothing for a variable, a parameter or a number, indexed or not."""
    if e.__class__ in native_numeric_types or isinstance(e, GetItemExpression | TemplateSumExpression):
        return ()
    if not e.is_expression_type():
        return ()
    if isinstance(e, ne.ExternalFunctionExpression):
        _, operands = table_of(e) or (None, ())
        return operands
    return e.args


def _function(e: Any) -> Callable:
    if e.getname() not in SYMENGINE:
        raise TemplateError(f"the function {e.getname()} has no derivative here; known: {', '.join(SYMENGINE)}")
    return SYMENGINE[e.getname()]


def _operation(e: Any, parts: list, zero: Any) -> Any:
    """Apply the arithmetic of one Pyomo node to the values of its parts, numbers, arrays or SymEngine expressions."""
    if isinstance(e, ne.SumExpressionBase):
        return sum(parts[1:], parts[0]) if parts else zero
    if isinstance(e, ne.ProductExpression):
        return parts[0] * parts[1]
    if isinstance(e, ne.DivisionExpression):
        return parts[0] / parts[1]
    if isinstance(e, ne.NegationExpression):
        return -parts[0]
    if isinstance(e, ne.PowExpression):
        return parts[0] ** parts[1]
    # Not every node has this method; bool() is False.
    if getattr(e, "is_named_expression_type", bool)():
        return parts[0]
    raise TemplateError(f"{type(e).__name__} has no translation: {e}")


def exact_number(x: float) -> se.Basic:
    """Whole numbers and halves exactly: x**2.0 is then a multiplication, x**0.5 a square root."""
    x = float(x)
    if x.is_integer() and abs(x) < EXACT_INTEGER:
        return se.Integer(int(x))
    if (2 * x).is_integer() and abs(x) < EXACT_INTEGER:
        return se.Rational(int(2 * x), 2)
    return se.RealDouble(x)


def _real(result: se.Basic, parts: list) -> se.Basic:
    """SymEngine works in the complex plane; what has no real value there, as 1/(x - x), is NaN when evaluated."""
    # Only numbers are evaluated here by SymEngine; what has a symbol in it goes to code that knows real numbers only.
    if all(p.is_Number for p in parts):
        try:
            if not np.isfinite(float(result)):
                return se.RealDouble(np.nan)
        except (RuntimeError, TypeError, ValueError):
            return se.RealDouble(np.nan)
    return result


def product_of(arguments: Arguments, factors: list, e: Any, template: Any) -> se.Basic:
    """product(factors) * e in SymEngine.

    arguments: of the family that the product belongs to.
    factors: Pyomo expressions or numbers.
    e: a Pyomo expression.
    template: its index placeholder, or None.
    """
    return prod((arguments.translate(f, template) for f in factors), start=arguments.translate(e, template))


def without_sums(sides: list, arguments: Arguments, c: Any, row: int, sums: list) -> se.Basic:
    """The terms of a scalar row that stand in no sum over a Set; the others are put down in `sums`.

    Written out, a sum over the points would be one expression of all unknowns, and its derivatives would take longer to
    make the larger the mesh is. Put down, what is summed over a Set becomes a family: one expression for all points.

    sides: (sign, Pyomo expression) each.
    arguments: of the family of the row.
    c: the component that the row is of.
    row: its number.
    sums: gets a SumTerm for each sum.
    """
    plain = se.Integer(0)
    for sign, side in sides:
        for total, factors, e in linear_parts(side):
            if total is None:
                plain += product_of(arguments, [sign, *factors], e, None)
            else:
                sums.append(SumTerm(c, int(row), total, [sign, *factors], e))
    return plain
