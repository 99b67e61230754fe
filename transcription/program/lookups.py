"""Tables of data in compiled functions: their values and partial derivatives are arguments, filled in beforehand.

A family of functions looks up table k at arguments a1, a2, ... that are expressions themselves. The compiled code of
the family reads

    t<k>            the value
    t<k>_<i>        the first partial derivatives
    t<k>_<i>_<j>    the second ones, i <= j

and the chain rule is done in symbols, so its derivatives are exact. Before it is called, the arguments are computed for
all points at once, those of tables inside others first; a sorted search finds the cell of each point, and one compiled
call evaluates the polynomials of the cells with their derivatives.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import cache
from itertools import combinations_with_replacement
from math import factorial, prod
from typing import Any

import numpy as np
import symengine as se

from ...problems.lean.records import dataclass
from ...problems.tables.fits import ORDER
from ...problems.tables.table import Table
from ..cache.kept import made
from .backend import LLVM, lambdify


@dataclass(frozen=True)
class CompiledLookup:
    """A table at arguments. number: of the lookup in its family. arguments: expressions, one for each argument."""

    number: int
    table: Table
    arguments: tuple[se.Basic, ...]

    @property
    def symbols(self) -> list[se.Symbol]:
        """Value, first and second partial derivatives, in the order of the columns."""
        return [se.Symbol(f"t{self.number}{suffix}") for suffix in _suffixes(len(self.arguments))]

    @property
    def value(self) -> se.Symbol:
        return self.symbols[0]

    def slopes(self) -> dict[se.Symbol, list[se.Symbol]]:
        """Value and first derivatives -> their derivatives by each argument of the table."""
        by_suffix, n = dict(zip(_suffixes(len(self.arguments)), self.symbols, strict=True)), len(self.arguments)
        first = [by_suffix[f"_{i}"] for i in range(n)]
        second = {first[i]: [by_suffix[f"_{min(i, j)}_{max(i, j)}"] for j in range(n)] for i in range(n)}
        return {self.value: first, **second}


def _suffixes(n: int) -> list[str]:
    return ["".join(f"_{i}" for i in own) for own in _orders(n)]


def _orders(n: int) -> list[tuple[int, ...]]:
    """The axes of each derivative, from the value to the second ones."""
    return [own for order in range(3) for own in combinations_with_replacement(range(n), order)]


class ChainRule:
    """Derivatives of expressions by the variables, through the tables that they look up.

    variables: symbol -> its number.
    """

    def __init__(self, variables: dict[se.Symbol, int], lookups: Sequence[CompiledLookup]) -> None:
        self.variables, self.symbols = variables, {j: s for s, j in variables.items()}
        self.arguments = {symbol: own.arguments for own in lookups for symbol in own.slopes()}
        self.slopes = {symbol: slopes for own in lookups for symbol, slopes in own.slopes().items()}
        self._known: dict[se.Symbol, dict[int, se.Basic]] = {}

    def derivatives(self, y: se.Basic) -> list[tuple[int, se.Basic]]:
        """(number of the variable, derivative) for each that is not zero."""
        present = sorted(y.free_symbols & (self.variables.keys() | self.slopes.keys()), key=str)
        total: dict[int, se.Basic] = {}
        for symbol in present:
            outer = y.diff(symbol)
            inner = {self.variables[symbol]: 1} if symbol in self.variables else self._of_table(symbol)
            for j, slope in inner.items():
                total[j] = total.get(j, 0) + outer * slope
        return [(j, total[j]) for j in sorted(total) if total[j] != 0]

    def _of_table(self, symbol: se.Symbol) -> dict[int, se.Basic]:
        """The derivatives by the variables of a value or a first derivative that was looked up."""
        if symbol not in self._known:
            found: dict[int, se.Basic] = {}
            for slope, argument in zip(self.slopes[symbol], self.arguments[symbol], strict=True):
                for j, inner in self.derivatives(argument):
                    found[j] = found.get(j, 0) + slope * inner
            self._known[symbol] = found
        return self._known[symbol]


Group = list[CompiledLookup]
"""Lookups of one table, made at once."""


def levels(lookups: Sequence[CompiledLookup]) -> list[list[Group]]:
    """The lookups in an order in which they can be made: those of one level need only those of the levels before."""
    depth: dict[se.Symbol, int] = {}
    found: list[dict[int, Group]] = []
    for own in lookups:  # an inner one has the smaller number: it is translated first
        inner = (depth[s] for a in own.arguments for s in a.free_symbols if s in depth)
        level = max((1 + d for d in inner), default=0)
        depth |= dict.fromkeys(own.symbols, level)
        if level == len(found):
            found.append({})
        found[level].setdefault(id(own.table), []).append(own)
    return [list(groups.values()) for groups in found]


def in_order(lookups: Sequence[CompiledLookup]) -> list[CompiledLookup]:
    """The lookups in the order of their columns: by level, and in it by table."""
    return [own for groups in levels(lookups) for group in groups for own in group]


READ = 2**16
"""Numbers of a table that are read at once: they stay near the processor."""


class Cells:
    """A table at many points: value, first and second partial derivatives, in the order of `Lookup.symbols`."""

    def __init__(self, table: Table, backend: str) -> None:
        self.table, self.code = table, _polynomial(len(table.axes), backend)
        self.width = len(_orders(len(table.axes)))

    def __call__(self, points: np.ndarray) -> np.ndarray:
        """points: (S, n). Returns (S, 1 + n + n (n + 1)/2)."""
        n = points.shape[1]
        cells, rows = self.table.cells(points.T), self.table.rows
        size = READ // rows.shape[1]
        if len(points) <= size:
            read = rows.take(cells, axis=0)
            np.subtract(points, read[:, -n:], out=read[:, -n:])
            return np.asarray(self.code(read))
        found = np.empty((len(points), self.width))
        whole = np.empty((size, rows.shape[1]))
        for start in range(0, len(points), size):
            own = slice(start, start + size)
            read = rows.take(cells[own], axis=0, out=whole[: len(cells[own])], mode="clip")
            np.subtract(points[own], read[:, -n:], out=read[:, -n:])
            self.code(read, out=found[own])
        return found


@cache
def _polynomial(n: int, backend: str) -> Any:
    """Compiled code: the coefficients of a cell and the distances from its corner -> what `Cells` gives."""

    def make() -> Any:
        c = [se.Symbol(f"c{i}") for i in range(ORDER**n)]
        d = [se.Symbol(f"d{i}") for i in range(n)]
        taylor = _contracted(c, d, 2)
        counts = [tuple(map(own.count, range(n))) for own in _orders(n)]
        return lambdify(c + d, [prod(map(factorial, own)) * taylor[own] for own in counts], backend, opt_level=3)

    return made("polynomial of a cell", n, make) if backend == LLVM else make()


def _contracted(coefficients: list[Any], distances: list[Any], most: int) -> dict[tuple[int, ...], Any]:
    """Taylor coefficients of the polynomial of a cell at a point: orders by each axis -> partial derivative/orders!.

    The last axis is contracted first: what it gives for an order serves all orders of the axes before it.

    coefficients: of the powers of the last axis first.
    distances: of the point from the corner of the cell, by axis.
    most: the largest sum of orders.
    """
    if not distances:
        return {(): coefficients[0]}
    rows = [_taylor(coefficients[k : k + ORDER], distances[-1], most) for k in range(0, len(coefficients), ORDER)]
    return {
        (*before, order): own
        for order in range(most + 1)
        for before, own in _contracted([row[order] for row in rows], distances[:-1], most - order).items()
    }


def _taylor(c: list[Any], x: Any, most: int) -> list[Any]:
    """Value, slope and half the second derivative of a cubic, by Horner's rule applied to its own steps."""
    found = []
    for _ in range(most + 1):
        steps = [c[-1]]
        for own in reversed(c[:-1]):
            steps.append(own + steps[-1] * x)
        found.append(steps.pop())
        c = steps[::-1]
    return found


MANY = 500
"""Indices of a family from which on it pays to look for points that are asked for twice."""


class Repeats:
    """Which lookups of a table are at the points of others, one index later.

    The end of a segment is the start of the next, so of three lookups in each segment one need not be made. What is
    equal at one call may not be so at the next: pairs are compared at each call, and those that differ are left from
    then on.
    """

    def __init__(self, count: int, arguments: int) -> None:
        """Of so many lookups in a table of so many arguments; of one, a lookup costs no more than to compare."""
        numbers = range(count if arguments > 1 else 0)
        self.pairs = [(late, early) for late in numbers for early in numbers if late != early]

    def of(self, points: np.ndarray) -> dict[int, int]:
        """The number of a lookup -> that of another, which is at its points one index before.

        points: (S, k, n), of k lookups in a table of n arguments.
        """
        if len(points) < MANY:
            return {}
        found: dict[int, int] = {}
        kept = []
        for late, early in self.pairs:
            apart = (points[0, late] != points[1, early]).any()
            if apart or not np.array_equal(points[:-1, late], points[1:, early]):
                continue
            kept.append((late, early))
            if early not in found and late not in found and late not in found.values():
                found[late] = early
        self.pairs = kept
        return found


class Filled:
    """The columns of one family's arguments that hold what is looked up.

    lookups: of tables. passes: compiled code of the arguments of each level of them, as of `levels`. first: the column
    of the first.
    """

    def __init__(self, lookups: Sequence[CompiledLookup], passes: Sequence[Any], first: int, backend: str) -> None:
        self.steps, start = [], first
        for groups, code in zip(levels(lookups), passes, strict=True):
            places, at = [], 0
            for group in groups:
                n, width = len(group[0].arguments), sum(len(own.symbols) for own in group)
                asked, columns = slice(at, at + n * len(group)), slice(start, start + width)
                places.append((asked, n, columns, Cells(group[0].table, backend), Repeats(len(group), n)))
                at, start = asked.stop, columns.stop
            self.steps.append((code, places))

    def fill(self, arguments: np.ndarray) -> None:
        """Look everything up, for arguments (S, K) whose variables and data are there."""
        size = len(arguments)
        for code, places in self.steps:
            points = code(arguments).reshape(size, -1)
            for asked, n, columns, cells, repeats in places:
                wanted = points[:, asked].reshape(size, -1, n)
                values = arguments[:, columns].reshape(size, wanted.shape[1], -1)  # a view
                again = repeats.of(wanted)
                for own in _runs(k for k in range(wanted.shape[1]) if k not in again):
                    values[:, own] = cells(wanted[:, own].reshape(-1, n)).reshape(values[:, own].shape)
                for late, early in again.items():
                    values[:-1, late] = values[1:, early]
                    values[-1:, late] = cells(wanted[-1:, late])


def _runs(numbers: Iterable[int]) -> list[slice]:
    """Increasing numbers as slices, which NumPy need not copy."""
    found: list[slice] = []
    for k in numbers:
        if found and found[-1].stop == k:
            found[-1] = slice(found[-1].start, k + 1)
        else:
            found.append(slice(k, k + 1))
    return found
