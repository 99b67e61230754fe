"""Expressions as one list of operations: numbers are computed by it, each part that several of them share once.

The operations are those of a walk over the trees (see `evaluation`), in the same order, so the values are the same to
the last bit.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

from ..lean.same import Same
from .evaluation import Evaluated, Work, work_of
from .tree import Lookup, Name, Node, Number, Operation, OperatorChain


class Part(NamedTuple):
    """An expression without the numbers of its parameters: what the operations of a tape depend on.

    root: of its tree. constants: the parameters that it needs. steps: its definitions, as `Expression.steps` has them.
    static: of the expression. scope: which of the expressions of a tape share their parameters and definitions.
    """

    root: Same[Node]
    constants: frozenset[str]
    steps: tuple[tuple[str, Same[Node], str | None], ...]
    static: frozenset[str]
    scope: int

    def key(self, name: str, end: str | None) -> str:
        """As of `Expression`."""
        return name if end is None or name in self.constants or name in self.static else f"{name}[{end}]"


class Tape:
    """The values of some expressions that share their parameters, definitions and tables.

    cells: numbers in their places, None where a value comes.
    loads: places and names of the values that are asked for.
    given: places and names of parameters, whose numbers are in `cells`, and count unless they are among the values.
    operations: place of the value, work, places of the operands.
    results: places of the values of the expressions.

    All but the numbers is the same for all problems of one form, and is kept.
    """

    def __init__(self, expressions: Sequence[Evaluated]) -> None:
        scopes: list[Evaluated] = []
        parts = tuple(_part(own, scopes) for own in expressions)
        made = _Making(parts, scopes) if any(own.tables for own in expressions) else _kept(parts)
        self.loads, self.operations, self.results = made.loads, made.operations, made.results
        self.cells = made.cells.copy()
        self.given = [(place, name) for place, name, _ in made.given]
        for place, name, scope in made.given:
            self.cells[place] = float(scopes[scope].parameters[name])

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


def _part(expression: Evaluated, scopes: list[Evaluated]) -> Part:
    """An expression without its numbers; one with new parameters or definitions joins `scopes`."""
    numbers, definitions = expression.parameters, expression.definitions
    same = (i for i, own in enumerate(scopes) if own.parameters is numbers and own.definitions is definitions)
    if (scope := next(same, len(scopes))) == len(scopes):
        scopes.append(expression)
    steps = tuple((key, Same(own.root), end) for key, (own, end) in expression.steps.items())
    return Part(Same(expression.root), frozenset(expression.constants), steps, frozenset(expression.static), scope)


@lru_cache(maxsize=256)
def _kept(parts: tuple[Part, ...]) -> _Making:
    return _Making(parts, ())


class _Making:
    """The parts of a tape, of expressions of which some have tables: `scopes`, as of `Part.scope`."""

    def __init__(self, parts: Sequence[Part], scopes: Sequence[Evaluated]) -> None:
        self.places: dict[Hashable, int] = {}
        self.numbers: dict[int, float] = {}
        self.loads: list[tuple[int, str]] = []
        self.given: list[tuple[int, str, int]] = []
        self.steps: list[tuple[int, Work, tuple[int, ...]]] = []
        self.results: list[int] = []
        self.scope: dict[str, int] = {}
        before: Part | None = None
        for part in parts:
            if before is None or part.scope != before.scope:
                self.scope = {}  # names may mean something else than they did before
            self.key, self.tables = part.key, scopes[part.scope].tables if scopes else {}
            self.add(part)
            before = part
        self.operations, self.cells = _in_few_cells(self)
        del self.places, self.numbers, self.scope, self.steps  # a tape needs none of them, and is kept

    def add(self, part: Part) -> None:
        for name in sorted(part.constants - self.scope.keys()):
            self.scope[name] = self.parameter(name, part.scope)
        for key, root, end in part.steps:
            if key not in self.scope:
                self.scope[key] = self.place(root.own, end)
        self.results.append(self.place(part.root.own, None))

    def new(self, what: Hashable) -> tuple[int, bool]:
        """The place of a value, and whether it is a new one."""
        known = len(self.places)
        return (place := self.places.setdefault(what, known)), place == known

    def parameter(self, name: str, scope: int) -> int:
        place, new = self.new((Name, name, scope))
        if new:
            self.given.append((place, name, scope))
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
            self.steps.append((place, work, tuple(operands)))
        return place


def _in_few_cells(made: _Making) -> tuple[list[tuple[int, Work, tuple[int, ...]]], list[Any]]:
    """Operations and cells where what no operation needs any more gives its place to another value: values may be
    arrays of a million points."""
    last = {k: i for i, (_, _, operands) in enumerate(made.steps) for k in operands}
    own_places = (place for place, *_ in (*made.loads, *made.given))
    fixed = {*made.numbers, *own_places, *made.results}
    moved: dict[int, int] = {}
    free: list[int] = []
    operations = []
    for i, (place, work, operands) in enumerate(made.steps):
        own = tuple(moved.get(k, k) for k in operands)
        free += [moved.get(k, k) for k in set(operands) if k not in fixed and last[k] == i]
        moved[place] = free.pop() if free and place not in fixed else place
        operations.append((moved[place], work, own))
    return operations, [made.numbers.get(k) for k in range(len(made.places))]
