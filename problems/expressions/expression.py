"""Expression strings as functions of named values: arithmetic, never code.

An expression may hold numbers, names, pi, + - * / **, parentheses and the functions of the table in functions.py, and
at the boundary q[initial] and q[final]. `tree.parse_tree` turns it into a small tree, and a list of
operations made of that tree gives its values (see `tape`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace
from functools import cached_property, lru_cache
from graphlib import TopologicalSorter
from typing import TYPE_CHECKING, Any

import numpy as np

from ..lean.records import dataclass, only_fields
from ..lean.same import Same
from ..quantities import Function
from ..text import shorten, tidy
from .evaluation import Fault, Walk, first_fault
from .tape import Tape
from .tokens import ExpressionError
from .tree import Link, Name, Node, OperatorChain, nodes, parse_tree

if TYPE_CHECKING:  # tables import SciPy
    from ..tables.table import Table


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
        return self.tape(values, functions)[0]

    __getstate__ = only_fields  # a tape is made of functions, which have no pickle

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
        bound = Expression(self.text, self.root, parameters, definitions, static, own)
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
        return replace(
            self, text=text, root=OperatorChain(*span, self.root, (Link(*span, "-", Name(*span, name, None)),))
        )

    def fault(self, values: Mapping[str, Any]) -> Fault | None:
        """The innermost sub-expression without a finite value; None if the expression is finite everywhere.

        values: numbers, or arrays over time of one shape (K,). Names that are not given are unknown, and what depends
        on them is passed over: `fault({})` finds mistakes that no variable can mend, such as a division by a constant
        zero.
        """
        return first_fault(self, values)

    @cached_property
    def nodes(self) -> tuple[Node, ...]:
        """Every node of the tree, from the left: kept, as checks walk through a definition again and again."""
        return tuple(nodes(self.root))

    @cached_property
    def tape(self) -> Tape:
        return Tape([self])

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
        return frozenset(leaf.name for part in self.parts for leaf in part.leaves) & self.parameters.keys()

    @cached_property
    def steps(self) -> dict[str, tuple[Expression, str | None]]:
        """The definitions that are needed, those of others first: key -> definition and the end it is taken at."""
        found: dict[str, tuple[Expression, str | None]] = {}
        graph: dict[str, list[str]] = {}
        waiting = [(n.name, n.end) for n in self.leaves if n.name in self.definitions]
        if not waiting:
            return {}
        while waiting:
            name, end = waiting.pop()
            key = self.key(name, end)
            if name not in self.definitions or key in found:
                continue
            definition = self.definitions[name]
            found[key] = definition, end
            graph[key] = sorted(self._keys(definition, end))  # a set has another order in each process
            waiting += [(n.name, end) for n in definition.leaves]
        return {key: found[key] for key in TopologicalSorter(graph).static_order() if key in found}

    @cached_property
    def parts(self) -> tuple[Expression, ...]:
        """The expression and the definitions that it needs."""
        return (self, *(definition for definition, _ in self.steps.values()))

    def _keys(self, part: Expression, end: str | None) -> set[str]:
        return {self.key(n.name, n.end or end) for n in part.leaves}

    def key(self, name: str, end: str | None) -> str:
        """How a name is spelled whose value is asked for at an end, or over time."""
        fixed = end is None or name in self.parameters or name in self.static
        return name if fixed else f"{name}[{end}]"

    def constant(self) -> float:
        """The value of an expression of parameters alone: a float, which is not finite where `fault` says why."""
        if self.tables or self.steps:
            return _constant(self)
        return _constant_with(Same(self.root), tuple((name, float(self.parameters[name])) for name in self.constants))


Together = Callable[[Mapping[str, Any], Any], list[Any]]
"""As `Function`, for the values of several functions."""


def together(functions: Sequence[Function]) -> Together:
    """What gives the values of several functions of one phase at once: expressions compute a part that they share once.

    functions: in the order of the values.
    """
    expressions = [own for own in functions if isinstance(own, Expression)]
    if len(expressions) == len(functions):
        return Tape(expressions)
    return lambda values, module: [own(values, module) for own in functions]


def _constant(expression: Expression) -> float:
    with np.errstate(all="ignore"):
        return float(Walk({}, np, np.float64).evaluate(expression))


@lru_cache(maxsize=4096)
def _constant_with(root: Same[Node], numbers: tuple[tuple[str, float], ...]) -> float:
    return _constant(Expression("", root.own, dict(numbers)))


def fault_with(expression: Expression, numbers: Mapping[str, float]) -> Fault | None:
    """What no variable can mend, see `Expression.fault`; kept, as most expressions of a sweep have the same numbers in
    each case.

    expression: without tables, as `parse` gives it.
    numbers: those of its names that are known.
    """
    return _fault_with(Same(expression), tuple(numbers.items()))


@lru_cache(maxsize=4096)
def _fault_with(expression: Same[Expression], numbers: tuple[tuple[str, float], ...]) -> Fault | None:
    return expression.own.bind(dict(numbers), {}).fault({})


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
