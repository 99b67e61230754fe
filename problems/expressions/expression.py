"""Expression strings as functions of named values: arithmetic, never code.

An expression may hold numbers, names, pi, + - * / **, parentheses and the functions of the table in functions.py, and
at the boundary q[initial] and q[final]. `tree.parse_tree` turns it into a small tree, and a walk over that tree
evaluates it. A walk does the same operations in the same order at every call, so that every function is consistent in
the sense of the paper, section 5.5.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from dataclasses import field, replace
from functools import cached_property, lru_cache
from graphlib import TopologicalSorter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..lean.records import dataclass
from ..text import shorten, tidy
from .functions import FUNCTIONS
from .slips import MAX_EXPONENT
from .smooth import STAND_INS
from .tokens import ExpressionError
from .tree import Chain, Link, Lookup, Name, Node, Number, Operation, nodes, parse_tree

if TYPE_CHECKING:  # tables import SciPy
    from ..tables.table import Table


class Fault(NamedTuple):
    """The innermost sub-expression without a finite value.

    text: the sub-expression. at: index into the array of values, 0 for scalars. values: each of its names -> its value
    there. why: one phrase, such as "divides by zero".
    """

    text: str
    at: int
    values: dict[str, float]
    why: str


@dataclass(frozen=True)
class Expression:
    """A function of named values (`problem.Function`), read by `parse` and completed by `bind`."""

    text: str
    root: Node = field(repr=False)
    parameters: Mapping[str, float] = field(default_factory=dict, repr=False, compare=False)
    definitions: Mapping[str, Expression] = field(default_factory=dict, repr=False, compare=False)
    static: frozenset[str] = field(default=frozenset(), repr=False, compare=False)
    tables: Mapping[str, Table] = field(default_factory=dict, repr=False, compare=False)

    def __call__(self, values: Mapping[str, Any], functions: Any) -> Any:
        """The value; `functions` is numpy or pyomo.core. A parameter among the values is not taken for its number."""
        return _Walk(values, functions).evaluate(self)

    def bind(
        self,
        parameters: Mapping[str, float],
        definitions: Mapping[str, Expression],
        static: frozenset[str] = frozenset(),
        tables: Mapping[str, Table] | None = None,
    ) -> Expression:
        """This expression with numbers for its parameters and expressions for the names defined by others.

        parameters: name -> number, in the unit of the file.
        definitions: name -> the expression that the name stands for; others are evaluated after those they refer to.
        static: names of the static parameters; like `parameters` they are the same at both ends of time.
        tables: name -> the table of data that it looks up; None for those that it has.
        """
        own = self.tables if tables is None else tables
        bound = replace(self, parameters=parameters, definitions=definitions, static=static, tables=own)
        # Of the tree alone; `parse` keeps expressions, so the next problem with this text need not walk through it.
        bound.__dict__.update(nodes=self.nodes, leaves=self.leaves)
        return bound

    def at(self, end: str) -> Expression:
        """This expression over time, taken at an end: "initial" or "final"."""
        name = "taken at an end"  # no name of a file has spaces
        return replace(self, root=Name(0, 0, name, end), definitions={**self.definitions, name: self})

    def less(self, name: str) -> Expression:
        """This expression minus a named value: the change in one step, of the value after it."""
        span, text = (0, len(self.text)), f"({self.text}) - {name}"
        return replace(self, text=text, root=Chain(*span, self.root, (Link(*span, "-", Name(*span, name, None)),)))

    def fault(self, values: Mapping[str, Any]) -> Fault | None:
        """The innermost sub-expression without a finite value; None if the expression is finite everywhere.

        values: numbers, or arrays over time of one shape (K,). Names that are not given are unknown, and what depends
        on them is passed over: `fault({})` finds mistakes that no variable can mend, such as a division by a constant
        zero.
        """
        walk = _Audit(values, np)
        try:
            with np.errstate(all="ignore"):
                walk.evaluate(self)
        except _Found as found:
            return found.fault
        return None

    @cached_property
    def nodes(self) -> tuple[Node, ...]:
        """Every node of the tree, from the left: kept, as checks walk through a definition again and again."""
        return tuple(nodes(self.root))

    @cached_property
    def leaves(self) -> tuple[Name, ...]:
        """Every name in the text, from the left."""
        return tuple(node for node in self.nodes if isinstance(node, Name))

    @cached_property
    def names(self) -> frozenset[str]:
        """Names whose values a call needs, spelled "q1[final]" at the boundary."""
        inner = [self._keys(definition, end) for definition, end in self.steps.values()]
        return frozenset().union(self._keys(self, None), *inner) - self.steps.keys() - self.parameters.keys()

    @cached_property
    def constants(self) -> frozenset[str]:
        """The parameters that stand in the expression or in a definition that is needed."""
        own = (self, *(definition for definition, _ in self.steps.values()))
        return frozenset(leaf.name for part in own for leaf in part.leaves) & self.parameters.keys()

    @cached_property
    def steps(self) -> dict[str, tuple[Expression, str | None]]:
        """The definitions that are needed, those of others first: key -> definition and the end it is taken at."""
        found: dict[str, tuple[Expression, str | None]] = {}
        graph: dict[str, set[str]] = {}
        waiting = [(n.name, n.end) for n in self.leaves if n.name in self.definitions]
        while waiting:
            name, end = waiting.pop()
            key = self._key(name, end)
            if name not in self.definitions or key in found:
                continue
            definition = self.definitions[name]
            found[key] = definition, end
            graph[key] = self._keys(definition, end)
            waiting += [(n.name, end) for n in definition.leaves]
        return {key: found[key] for key in TopologicalSorter(graph).static_order() if key in found}

    def _keys(self, part: Expression, end: str | None) -> set[str]:
        return {self._key(n.name, n.end or end) for n in part.leaves}

    def _key(self, name: str, end: str | None) -> str:
        fixed = end is None or name in self.parameters or name in self.static
        return name if fixed else f"{name}[{end}]"

    def constant(self) -> float:
        """The value of an expression of parameters alone: a float, which is not finite where `fault` says why."""
        with np.errstate(all="ignore"):
            return float(_Walk({}, np, np.float64).evaluate(self))


def _power(base: Any, exponent: Any) -> Any:
    """base ** exponent; a whole exponent stays whole, so that x**2 is x*x and not exp(2 log x)."""
    if isinstance(exponent, float) and exponent.is_integer():
        exponent = int(exponent)
    return base**exponent


_ARITHMETIC: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "**": _power,
}


class _Walk:
    """One evaluation: `scope` grows by parameters and definitions as they are needed, over the values that are given.

    The values may be made when they are asked for, so only what stands in the expression is asked for.
    """

    def __init__(self, values: Mapping[str, Any], functions: Any, number: Any = float):
        self.values, self.functions, self.number = values, functions, number
        self.scope: dict[str, Any] = {}

    def evaluate(self, expression: Expression) -> Any:
        self.key, self.tables = expression._key, expression.tables
        numbers, given = expression.parameters, self.values
        self.scope = {n: given[n] if n in given else self.number(numbers[n]) for n in expression.constants}
        for key, (definition, end) in expression.steps.items():
            self.scope[key] = self.start(definition, end)
        return self.start(expression, None)

    def start(self, expression: Expression, end: str | None) -> Any:
        self.expression, self.end = expression, end
        return self.visit(expression.root)

    def visit(self, node: Node) -> Any:
        match node:
            case Number():
                return self.number(node.value)
            case Name():
                return self.lookup(node)
            case Operation(symbol=symbol, operands=operands):
                return self.apply(symbol, node, [self.visit(operand) for operand in operands])
            case Lookup(operands=operands):
                return self.look_up(node, [self.visit(operand) for operand in operands])
            case Chain(first=first, links=links):
                result = self.visit(first)
                for link in links:
                    result = self.apply(link.symbol, link, [result, self.visit(link.operand)])
                return result
        raise TypeError(f"{type(node).__name__} is no node of an expression")

    def lookup(self, node: Name) -> Any:
        key = self.key(node.name, node.end or self.end)
        return self.scope[key] if key in self.scope else self.values[key]

    def apply(self, symbol: str, node: Node, operands: list[Any]) -> Any:
        if symbol in FUNCTIONS:
            return FUNCTIONS[symbol].evaluate(self.functions, operands)
        if symbol in STAND_INS:
            return STAND_INS[symbol](self.functions, operands)
        return -operands[0] if len(operands) == 1 else _ARITHMETIC[symbol](*operands)

    def look_up(self, node: Lookup, operands: list[Any]) -> Any:
        return self.tables[node.table].evaluate(self.functions, operands)


class _Found(Exception):  # noqa: N818 - it ends a walk and is no error
    def __init__(self, fault: Fault):
        self.fault = fault


class _Audit(_Walk):
    """An evaluation with NumPy that stops at the first value that is not finite; None stands for unknown."""

    def __init__(self, values: Mapping[str, Any], functions: Any):
        arrays = {name: np.asarray(value, float) for name, value in values.items()}
        super().__init__(arrays, functions, np.float64)
        self.constants_only = not values

    def lookup(self, node: Name) -> Any:
        value = self.known(self.key(node.name, node.end or self.end))
        if value is not None:
            self.refuse(node, ~np.isfinite(value), "is not finite")
        return value

    def apply(self, symbol: str, node: Node, operands: list[Any]) -> Any:
        second = operands[-1]
        if second is not None and symbol == "/":
            self.refuse(node, second == 0, "divides by zero")
        if second is not None and symbol == "**" and self.constants_only:
            self.refuse(node, np.abs(second) > MAX_EXPONENT, f"has an exponent larger than {MAX_EXPONENT}")
        if second is not None and symbol in FUNCTIONS and FUNCTIONS[symbol].width is not None:
            self.refuse(node, second <= 0, "has a width that is not positive")
        if any(operand is None for operand in operands):
            return None
        result = super().apply(symbol, node, list(np.broadcast_arrays(*operands)))
        return self.finite(node, result)

    def look_up(self, node: Lookup, operands: list[Any]) -> Any:
        if node.table not in self.tables or any(operand is None for operand in operands):
            return None
        if self.constants_only:
            self.refuse(node, self.tables[node.table].outside(operands), f"is outside of the points of {node.table}")
        return self.finite(node, super().look_up(node, operands))

    def known(self, key: str) -> Any:
        return self.scope.get(key, self.values.get(key))

    def finite(self, node: Node, result: Any) -> Any:
        if isinstance(node, Operation) and node.symbol in FUNCTIONS:
            row = FUNCTIONS[node.symbol]
            self.refuse(node, np.isnan(result), row.not_a_number)
            self.refuse(node, np.isneginf(result), row.minus_infinity)
        self.refuse(node, np.isnan(result), "is not a real number")
        self.refuse(node, np.isinf(result), "is too large a number")
        return result

    def refuse(self, node: Node, bad: Any, why: str) -> None:
        """End the walk if any element is bad: report the first one."""
        if not np.any(bad):
            return
        index, values = int(np.argmax(bad)), {}
        for name in self.expression.leaves:
            key = self.key(name.name, name.end or self.end)
            if node.start <= name.start and name.stop <= node.stop and self.known(key) is not None:
                array = np.ravel(self.known(key))
                values[key] = float(array[index if len(array) > 1 else 0])
        raise _Found(Fault(self.expression.text[node.start : node.stop], index, values, why))


@lru_cache(maxsize=4096)
def parse(text: str, called: frozenset[str] = frozenset()) -> Expression:
    """The expression that the text means.

    text: as a user writes it.
    called: the names of the tables of data and of the functions of the file.

    Raises ExpressionError, which says what is wrong, where in the text, and how to mend it; also for a constant part
    that has no finite value, such as 1/0 or 9**9**9.
    """
    text = tidy(text)
    expression = Expression(text, parse_tree(text, called))
    if fault := expression.fault({}):
        raise ExpressionError(f'"{shorten(fault.text)}" {fault.why}', "give it a finite value or leave it out")
    return expression
