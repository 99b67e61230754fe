"""A table of data as a smooth function: piecewise cubics in each of its arguments, and their products.

The value in a cell is the sum over powers a, b, c from 0 to 3 of coefficients times d1^a d2^b d3^c, where d is the
distance from the lower corner of the cell. This is one formula a cell and the same work in every cell; `cubic` and a
smoothed `linear` have two continuous derivatives, as a function of a problem must (paper, section 5.5).
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import field
from functools import cached_property, reduce
from typing import Any

import numpy as np

from ..lean.records import dataclass
from ..quantities import Range
from ..text import short_repr
from .choices import ERROR, HOLD
from .fits import ORDER, fit_of

Array = np.ndarray


@dataclass(frozen=True)
class TableAxis:
    """One argument: its name, the range of its points, what is done outside, and the breaks between its m cells.

    inner: (m - 1,) the breaks, increasing.
    """

    name: str
    points: Range
    outside: str
    inner: Array

    @property
    def cells(self) -> int:
        return len(self.inner) + 1


@short_repr
@dataclass(frozen=True, eq=False)
class Table:
    """axes: one for each argument. rows: (cells, 4**n + n) the coefficients of each cell, the powers of the last axis
    next to each other, and then its lower corner; cells count along the last axis first."""

    name: str
    axes: tuple[TableAxis, ...]
    rows: Array = field(repr=False)

    @cached_property
    def content(self) -> Hashable:
        """Equal for tables that are the same function."""
        axes = ((own.points, own.outside, own.inner.tobytes()) for own in self.axes)
        return (*axes, self.rows.tobytes())

    @property
    def called(self) -> str:
        """How expressions call it: "thrust(mach, h)"."""
        return f"{self.name}({', '.join(axis.name for axis in self.axes)})"

    def evaluate(self, functions: Any, operands: Sequence[Any]) -> Any:
        """The value, one operand for each argument.

        functions: `numpy`; `pyomo.core`, which gets an external function that carries this table as `table`; or what
            stands for another module and says itself what `table_value` of a table and its operands is.
        operands: numbers, arrays of shapes that fit, also complex ones (the complex step), or expressions.
        """
        if functions is np or all(isinstance(operand, int | float) for operand in operands):
            return self(*operands)
        if hasattr(functions, "table_value"):
            return functions.table_value(self, operands)
        function = functions.ExternalFunction(fgh=self._for_pyomo, name=self.name)
        function.table = self
        return function(*operands)

    def __call__(self, *arguments: Any) -> Array:
        """The values at points: arrays of shapes that fit, real or complex."""
        return self.derivative(arguments, (0,) * len(self.axes))

    def derivative(self, arguments: Sequence[Any], orders: Sequence[int]) -> Array:
        """A partial derivative of any order up to three in each argument.

        arguments: one for each axis, arrays of shapes that fit.
        orders: how often it is taken by each.
        """
        points, n = np.broadcast_arrays(*arguments), len(self.axes)
        read = self.rows[self.cells([np.real(p) for p in points])]
        found: Array = read[..., :-n].reshape(*points[0].shape, *[ORDER] * n)
        distances = [p - read[..., i - n] for i, p in enumerate(points)]
        for distance, order in zip(reversed(distances), reversed(orders), strict=True):
            beside = distance[(...,) + (None,) * (found.ndim - 1 - points[0].ndim)]
            found = _horner(found, beside, order)
        return found

    def cells(self, points: Sequence[Array] | Array) -> Array:
        """The number of the cell that each point is in; not-a-number is in the last along its axis.

        points: real, one array of one shape for each axis.
        """
        cell = self.axes[0].inner.searchsorted(points[0], side="right")
        for axis, p in zip(self.axes[1:], points[1:], strict=True):
            cell = cell * axis.cells + axis.inner.searchsorted(p, side="right")
        return np.asarray(cell)

    def outside(self, arguments: Sequence[Any]) -> Array:
        """Whether points are outside of what the table is about, by an argument that may not be."""
        beyond = [(np.asarray(p) < axis.points.lower) | (np.asarray(p) > axis.points.upper)
                  for axis, p in zip(self.axes, arguments, strict=True) if axis.outside == ERROR]  # fmt: skip
        return reduce(np.logical_or, beyond, np.zeros((), bool))

    def _for_pyomo(self, arguments: Sequence[float], order: int, fixed: Any) -> tuple[Any, Any, Any]:
        """Value, gradient and the upper triangle of the Hessian, by columns, as Pyomo asks for them."""
        n = len(self.axes)
        unit = np.eye(n, dtype=int)
        first = [float(self.derivative(arguments, unit[i])) for i in range(n)]
        second = [float(self.derivative(arguments, unit[i] + unit[j])) for j in range(n) for i in range(j + 1)]
        return float(self(*arguments)), first if order else None, second if order > 1 else None


def _horner(coefficients: Array, distance: Array, order: int) -> Array:
    """The derivative of that order of a polynomial whose coefficients are along the last axis."""
    factors = np.polynomial.polynomial.polyder(np.eye(ORDER), order) if order else np.eye(ORDER)
    derived = coefficients @ factors.T
    found: Array = derived[..., -1]
    for power in range(derived.shape[-1] - 2, -1, -1):
        found = found * distance + derived[..., power]
    return found


def fitted(
    name: str,
    points: Mapping[str, Sequence[float]],
    values: Any,
    kind: str,
    outside: Mapping[str, str],
    smooth: Mapping[str, float],
) -> Table:
    """The table through values on a grid.

    name: what expressions call it.
    points: argument -> its points, increasing, at least two.
    values: nested lists, one index for each argument in the order of `points`.
    kind: cubic, linear, or for one argument monotone.
    outside: argument -> error, hold or extrapolate.
    smooth: argument -> half the width over which the kinks of `linear` are rounded.
    """
    coefficients, axes, left = np.asarray(values, float), [], []
    for i, (argument, given) in enumerate(points.items()):
        at = np.array(given, float)
        # The axes that are done are (cells, 4) pairs at the front; the next one is fitted along its own index.
        moved = np.moveaxis(coefficients, 2 * i, 0)
        breaks, fit = fit_of(kind, smooth.get(argument, 0.0))(at, moved, outside[argument] == HOLD)
        coefficients = np.moveaxis(fit, (0, 1), (2 * i, 2 * i + 1))
        axes.append(TableAxis(argument, Range(at[0], at[-1]), outside[argument], breaks[1:-1]))
        left.append(breaks[:-1])
    n = len(axes)
    ordered = coefficients.transpose(*range(0, 2 * n, 2), *range(1, 2 * n, 2)).reshape(-1, ORDER**n)
    corners = np.stack(np.meshgrid(*left, indexing="ij"), axis=-1).reshape(-1, n)
    return Table(name, tuple(axes), np.hstack([ordered, corners]))
