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

from collections.abc import Sequence
from functools import cache
from itertools import combinations_with_replacement
from math import prod
from typing import Any

import numpy as np
import symengine as se

from ...problems.lean.records import dataclass
from ...problems.tables.fits import ORDER
from ...problems.tables.table import Table
from .backend import lambdify


@dataclass(frozen=True)
class Lookup:
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
    orders = (own for order in range(3) for own in combinations_with_replacement(range(n), order))
    return ["".join(f"_{i}" for i in own) for own in orders]


class Chain:
    """Derivatives of expressions by the variables, through the tables that they look up.

    variables: symbol -> its number.
    """

    def __init__(self, variables: dict[se.Symbol, int], lookups: Sequence[Lookup]) -> None:
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


Group = list[Lookup]
"""Lookups of one table, made at once."""


def levels(lookups: Sequence[Lookup]) -> list[list[Group]]:
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


def in_order(lookups: Sequence[Lookup]) -> list[Lookup]:
    """The lookups in the order of their columns: by level, and in it by table."""
    return [own for groups in levels(lookups) for group in groups for own in group]


class Cells:
    """A table at many points: value, first and second partial derivatives, in the order of `Lookup.symbols`."""

    def __init__(self, table: Table, backend: str) -> None:
        self.table, self.code = table, _polynomial(len(table.axes), backend)

    def __call__(self, points: np.ndarray) -> np.ndarray:
        """points: (S, n). Returns (S, 1 + n + n (n + 1)/2)."""
        read = self.table.rows.take(self.table.cells(points.T), axis=0)
        distance = read[:, -points.shape[1] :]
        np.subtract(points, distance, out=distance)
        return self.code(read)


@cache
def _polynomial(n: int, backend: str) -> Any:
    """Compiled code: the coefficients of a cell and the distances from its corner -> what `Cells` gives."""
    c = [se.Symbol(f"c{i}") for i in range(ORDER**n)]
    d = [se.Symbol(f"d{i}") for i in range(n)]
    orders = (own for order in range(3) for own in combinations_with_replacement(range(n), order))
    outputs = [_horner(c, d, [own.count(i) for i in range(n)]) for own in orders]
    return lambdify(c + d, outputs, backend, opt_level=3)


def _horner(coefficients: list[Any], distances: list[Any], orders: list[int]) -> Any:
    """A partial derivative of the polynomial of a cell, whose coefficients have the powers of the last axis first."""
    if not distances:
        return coefficients[0]
    rows = [coefficients[k : k + ORDER] for k in range(0, len(coefficients), ORDER)]
    order, x = orders[-1], distances[-1]
    inner = []
    for row in rows:
        derived = [prod(range(k - order + 1, k + 1)) * own for k, own in enumerate(row)][order:]
        found = derived[-1]
        for own in reversed(derived[:-1]):
            found = found * x + own
        inner.append(found)
    return _horner(inner, distances[:-1], orders[:-1])


class Filled:
    """The columns of one family's arguments that hold what is looked up.

    lookups: of tables. passes: compiled code of the arguments of each level of them, as of `levels`. first: the column
    of the first.
    """

    def __init__(self, lookups: Sequence[Lookup], passes: Sequence[Any], first: int, backend: str) -> None:
        self.steps, start = [], first
        for groups, code in zip(levels(lookups), passes, strict=True):
            places, at = [], 0
            for group in groups:
                n, width = len(group[0].arguments), sum(len(own.symbols) for own in group)
                asked, columns = slice(at, at + n * len(group)), slice(start, start + width)
                places.append((asked, n, columns, Cells(group[0].table, backend)))
                at, start = asked.stop, columns.stop
            self.steps.append((code, places))

    def fill(self, arguments: np.ndarray) -> None:
        """Look everything up, for arguments (S, K) whose variables and data are there."""
        for code, places in self.steps:
            points = code(arguments).reshape(len(arguments), -1)
            for asked, n, columns, cells in places:
                values = cells(points[:, asked].reshape(-1, n))
                arguments[:, columns] = values.reshape(len(arguments), -1)
