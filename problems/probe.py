"""What a function of a problem asks for, and what it depends on: found by calling it with numbers of no meaning."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .expressions.expression import Expression, Together
from .quantities import Function

if TYPE_CHECKING:  # tables import SciPy
    from .tables.table import Table

SAMPLES = 8
TINY = 1e-30
"""The complex step: the derivative has no subtraction in it, so any tiny number will do."""
INDICES = np.arange(1.0, SAMPLES + 1.0)


class _Anywhere:
    """NumPy, but a table of data is something that changes with all of its arguments, wherever its points are."""

    def __getattr__(self, name: str) -> Any:
        return getattr(np, name)

    def table_value(self, table: Table, operands: Sequence[Any]) -> Any:
        return sum(np.sin((i + 1.0) * operand) for i, operand in enumerate(operands))


_ANYWHERE = _Anywhere()


class _Asked(dict[str, np.ndarray]):
    """Values that are made when they are asked for, and so remember the names."""

    def __missing__(self, name: str) -> np.ndarray:
        irrational = np.sqrt(len(self) + math.e)  # the multiples of such a number are anywhere between whole numbers
        self[name] = 0.1 + 0.8 * (INDICES * irrational % 1.0)
        return self[name]


def names_asked(function: Function) -> set[str]:
    """The names of the values that a function looks up."""
    if isinstance(function, Expression):
        return {name for _, name in function.tape.loads}
    asked = _Asked()
    with np.errstate(all="ignore"):
        function(asked, _ANYWHERE)
    return set(asked)


def depends_on(function: Function, names: Collection[str]) -> bool:
    """Whether a function's value changes with any of these names: x + 0*u does not depend on u.

    A function that has no finite value at the samples counts as one that depends on all that it asks for.
    """
    if isinstance(function, Expression) and names_asked(function).isdisjoint(names):
        return False
    values = _Asked()
    with np.errstate(all="ignore"):
        before = function(values, _ANYWHERE)
        moved = {name: 1.0 - value if name in names else value for name, value in values.items()}
        after = function(moved, _ANYWHERE)
    if moved.keys().isdisjoint(names):
        return False
    finite = np.isfinite(before) & np.isfinite(after)
    return not finite.any() or bool((np.not_equal(before, after) & finite).any())


def derivatives(functions: Together, values: Mapping[str, Any], names: Sequence[str]) -> np.ndarray:
    """The derivatives of several functions by several names, shape (functions, len(names), ...).

    All complex steps are taken in one call, side by side.

    functions: made of what NumPy continues to complex numbers.
    values: of every name that they ask for, numbers or arrays of one shape (...).
    names: some of them.
    """
    shape = np.broadcast_shapes(*(np.shape(value) for value in values.values()))
    steps = (1j * TINY * np.eye(len(names))).reshape(len(names), len(names), *(1 for _ in shape))
    moved = {name: values[name] + step for name, step in zip(names, steps, strict=True)}
    found = functions({**values, **moved}, np)
    slopes = np.zeros((len(found), len(names), *shape))
    for row, own in zip(slopes, found, strict=True):
        row[:] = np.imag(own) / TINY
    return slopes
