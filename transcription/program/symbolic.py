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
from typing import Any

import numpy as np
import symengine as se
from pyomo.core.base.var import VarData
from pyomo.core.expr import numeric_expr as ne
from pyomo.core.expr.numvalue import native_numeric_types, native_types, value
from pyomo.core.expr.template_expr import GetItemExpression, IndexTemplate, TemplateSumExpression

from ...problems.expressions.functions import FUNCTIONS
from ...problems.tables.table import Table
from .lookups import Lookup
from .templates import TemplateError, table_of

SYMENGINE = {row.name: getattr(se, row.name) for row in FUNCTIONS.values() if row.composed is None}
EXACT_INTEGER = 2**53  # floats beyond it are not all integers, and integers beyond it not all floats


class Slots:
    """The vector of all numbers that templates read. `position` of a variable in z; `data`, what stands behind z."""

    def __init__(self, variables: Sequence[VarData]) -> None:
        self.n = len(variables)
        # By identity: == of two Pyomo variables is no comparison, it makes an expression.
        self.position = dict(zip(map(id, variables), range(self.n), strict=True))
        self.data: list[float] = []
        self._tables: dict[int, _Table] = {}
        self._single: dict[int, int] = {}

    def single(self, leaf: Any) -> int:
        """The slot of one VarData or ParamData."""
        slot = self.position.get(id(leaf), self._single.get(id(leaf)))
        if slot is None:
            if leaf.is_variable_type() and not leaf.fixed:
                raise TemplateError(f"{leaf.name} is neither among the compiled variables nor fixed")
            slot = self._single[id(leaf)] = self._append([value(leaf)])[0]
        return slot

    def table(self, component: Any) -> _Table:
        """The slots of an indexed Var or Param."""
        if id(component) not in self._tables:
            is_variable = issubclass(component._ComponentDataClass, VarData)
            make = self._variable_slots if is_variable else self._parameter_slots
            self._tables[id(component)] = _Table(component.name, *make(component))
        return self._tables[id(component)]

    def _append(self, values: Sequence[float]) -> range:
        start = self.n + len(self.data)
        self.data.extend(map(float, values))
        return range(start, self.n + len(self.data))

    def _variable_slots(self, component: Any) -> Any:
        keys, leaves = list(component.keys()), list(component.values())
        # A free variable that is not compiled is no mistake as long as no template reads it: `lookup` raises, not this.
        slots = np.array([self.position.get(i, -1) for i in map(id, leaves)], dtype=np.intp)
        for i in np.flatnonzero(slots < 0):
            if leaves[i].fixed:
                slots[i] = self.single(leaves[i])
        return keys, slots, None

    def _parameter_slots(self, component: Any) -> Any:
        # In their own type too, as the vector holds floats: a parameter may be an index, or part of one.
        values = component.extract_values()
        return list(values), np.array(self._append(values.values()), dtype=np.intp), np.array(list(values.values()))


class _Table:
    """Index -> slot for one component, for many indices at once.

    Each position of the index has a code (an integer less the lowest, or the rank of a name), and the codes together
    are a mixed-radix number that looks the slot up. -1 marks an index that does not exist, or a free variable that
    is not compiled.
    """

    def __init__(self, name: str, keys: list, slots: np.ndarray, values: np.ndarray | None) -> None:
        self.name, self.values = name, values
        positions = list(zip(*keys, strict=True)) if keys and isinstance(keys[0], tuple) else [keys]
        self.codes = [_codes(p) for p in positions]
        flat = np.zeros(len(keys), np.intp)
        for (radix, code), position in zip(self.codes, positions, strict=True):
            if callable(code):
                flat = flat * radix + np.fromiter(map(code, position), np.intp, len(keys))
            else:
                flat = flat * radix + (np.array(position, dtype=np.intp) - code)
        self.slots = np.full(int(np.prod([radix for radix, _ in self.codes])), -1, dtype=np.intp)
        self.order = np.zeros_like(self.slots)
        self.slots[flat], self.order[flat] = slots, np.arange(len(keys))

    def _flat(self, index: Sequence) -> Any:
        flat: Any = 0
        for (radix, code), i in zip(self.codes, index, strict=True):
            # Each position is checked by itself: a code out of its range would still make the number of another index.
            k = code(i) if callable(code) else i - code
            if k is None or np.min(k) < 0 or np.max(k) >= radix:
                raise TemplateError(f"{self.name} has no index {i}")
            flat = flat * radix + k
        if np.min(self.slots[flat]) < 0:
            raise TemplateError(f"{self.name} at index {index} does not exist, or is neither compiled nor fixed")
        return flat

    def lookup(self, index: Sequence) -> np.ndarray:
        """The slots at `index`, one entry (an integer array, an integer or a name) for each index position."""
        return self.slots[self._flat(index)]

    def value_at(self, index: Sequence) -> np.ndarray:
        """The values of a parameter at `index`, in their own type: integers stay integers."""
        if self.values is None:
            raise TemplateError(f"{self.name} is a variable and stands where only data can")
        return self.values[self.order[self._flat(index)]]


def _codes(values: Sequence) -> tuple[int, Callable | int]:
    distinct = dict.fromkeys(values)
    if distinct and all(isinstance(v, int | np.integer) for v in distinct):
        # Integers are shifted, not looked up: whole arrays of indices then take one subtraction.
        low = min(distinct)
        return max(distinct) - low + 1, low
    return len(distinct), {v: i for i, v in enumerate(distinct)}.get


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
        self.lookups: list[Lookup] = []
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
        key = (id(table), *arguments)
        if key not in self._known:
            self.lookups.append(Lookup(len(self.lookups), table, tuple(map(se.sympify, arguments))))
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
        self.memo: dict[int, se.Basic] = {}

    def __call__(self, e: Any) -> se.Basic:
        if e.__class__ in native_numeric_types:
            return number(e)
        # A rule that uses a subexpression again makes a graph; walked as a tree it can be exponentially large.
        if id(e) not in self.memo:
            self.memo[id(e)] = self.node(e)
        return self.memo[id(e)]

    def node(self, e: Any) -> se.Basic:
        if isinstance(e, GetItemExpression) or not e.is_expression_type():
            if e.__class__ is IndexTemplate:
                raise TemplateError("the index of a template stands outside the brackets of a variable or parameter")
            return self.arguments.leaf(e, self.template)
        if isinstance(e, TemplateSumExpression):
            raise TemplateError(f"{e} is a sum over a Set inside an indexed family or a nonlinear term")
        if isinstance(e, ne.ExternalFunctionExpression):
            return self.table(e)
        parts = [self(a) for a in e.args]
        if isinstance(e, ne.UnaryFunctionExpression):
            return _real(_function(e)(parts[0]), parts)
        return _real(_operation(e, parts, se.Integer(0)), parts)

    def table(self, e: Any) -> se.Basic:
        found = table_of(e)
        if found is None:
            raise TemplateError(f"the external function {e.getname()} has no derivative here")
        table, operands = found
        return self.arguments.look_up(table, [self(a) for a in operands])


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


def number(x: float) -> se.Basic:
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
