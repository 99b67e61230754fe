"""Expressions as one list of operations: numbers are computed by it, each part that several of them share once.

The operations are those of a walk over the trees (see `evaluation`), in the same order, so the values are the same to
the last bit.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import Any

from .evaluation import Evaluated, Work, work_of
from .tree import Lookup, Name, Node, Number, Operation, OperatorChain


class Tape:
    """The values of some expressions that share their parameters, definitions and tables.

    cells: numbers in their places, None where a value comes.
    loads: places and names of the values that are asked for.
    given: places and names of parameters, whose numbers are in `cells`, and count unless they are among the values.
    operations: place of the value, work, places of the operands.
    results: places of the values of the expressions.
    """

    def __init__(self, expressions: Sequence[Evaluated]) -> None:
        made = _Making()
        for expression in expressions:
            made.add(expression)
        self.loads, self.given = made.loads, made.given
        self.operations, self.results, self.cells = _in_few_cells(made)

    def __call__(self, values: Mapping[str, Any], functions: Any) -> list[Any]:
        """The value of each expression; arguments as of `Expression.__call__`."""
        cells = self.cells.copy()
        for place, name in self.given:
            if name in values:
                cells[place] = values[name]
        for place, name in self.loads:
            cells[place] = values[name]
        for place, work, operands in self.operations:
            cells[place] = work(functions, [cells[k] for k in operands])
        return [cells[place] for place in self.results]


class _Making:
    """A tape in which every value has a place of its own."""

    def __init__(self) -> None:
        self.places: dict[Hashable, int] = {}
        self.numbers: dict[int, float] = {}
        self.loads: list[tuple[int, str]] = []
        self.given: list[tuple[int, str]] = []
        self.operations: list[tuple[int, Work, tuple[int, ...]]] = []
        self.results: list[int] = []
        self.scope: dict[str, int] = {}
        self.parameters: Mapping[str, float] = {}
        self.definitions: Mapping[str, Evaluated] = {}

    def add(self, expression: Evaluated) -> None:
        if expression.parameters is not self.parameters or expression.definitions is not self.definitions:
            self.scope = {}  # names may mean something else than they did before
            self.parameters, self.definitions = expression.parameters, expression.definitions
        self.key, self.tables = expression.key, expression.tables
        for name in expression.constants - self.scope.keys():
            self.scope[name] = self.parameter(name, expression.parameters[name])
        for key, (definition, end) in expression.steps.items():
            if key not in self.scope:
                self.scope[key] = self.place(definition.root, end)
        self.results.append(self.place(expression.root, None))

    def new(self, what: Hashable) -> tuple[int, bool]:
        """The place of a value, and whether it is a new one."""
        known = len(self.places)
        return (place := self.places.setdefault(what, known)), place == known

    def parameter(self, name: str, number: float) -> int:
        place, new = self.new((Name, name, number))
        if new:
            self.numbers[place] = float(number)
            self.given.append((place, name))
        return place

    def place(self, node: Node, end: str | None) -> int:
        match node:
            case Number(value=value):
                place, _ = self.new((Number, value))
                self.numbers[place] = float(value)
                return place
            case Name():
                return self.name(self.key(node.name, node.end or end))
            case Operation(symbol=symbol, operands=operands):
                return self.work(symbol, work_of(symbol, len(operands)), [self.place(own, end) for own in operands])
            case Lookup(table=name, operands=operands):
                table = self.tables[name]

                def look_up(functions: Any, values: Sequence[Any]) -> Any:
                    return table.evaluate(functions, values)

                return self.work((Lookup, name), look_up, [self.place(own, end) for own in operands])
            case OperatorChain(first=first, links=links):
                place = self.place(first, end)
                for link in links:
                    place = self.work(link.symbol, work_of(link.symbol, 2), [place, self.place(link.operand, end)])
                return place
        raise TypeError(f"{type(node).__name__} is no node of an expression")

    def name(self, key: str) -> int:
        if key in self.scope:
            return self.scope[key]
        place, new = self.new((Name, key))
        if new:
            self.loads.append((place, key))
        return place

    def work(self, symbol: Hashable, work: Work, operands: list[int]) -> int:
        place, new = self.new((Operation, symbol, *operands))
        if new:
            self.operations.append((place, work, tuple(operands)))
        return place


def _in_few_cells(made: _Making) -> tuple[list[tuple[int, Work, tuple[int, ...]]], list[int], list[Any]]:
    """Operations, results and cells where what no operation needs any more gives its place to another value: values
    may be arrays of a million points."""
    last = {k: i for i, (_, _, operands) in enumerate(made.operations) for k in operands}
    fixed = {*made.numbers, *(place for place, _ in made.loads), *made.results}
    moved: dict[int, int] = {}
    free: list[int] = []
    operations = []
    for i, (place, work, operands) in enumerate(made.operations):
        own = tuple(moved.get(k, k) for k in operands)
        free += [moved.get(k, k) for k in set(operands) if k not in fixed and last[k] == i]
        moved[place] = free.pop() if free and place not in fixed else place
        operations.append((moved[place], work, own))
    return operations, made.results, [made.numbers.get(k) for k in range(len(made.places))]
