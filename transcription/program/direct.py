"""Functions of unknowns as they are, a few rows: at the final point, at both ends of a phase, between phases."""

from __future__ import annotations

from copy import copy

import numpy as np

from .contract import cross_factor
from .pointwise import PointFunctions


class Direct:
    """Compiled functions, each of one row, and where their arguments stand.

    functions: compiled.
    columns: where each argument stands in z, -1 for what is fixed.
    fixed: the value of what is fixed, for each argument.
    rows: of each function.
    """

    def __init__(self, functions: PointFunctions, columns: np.ndarray, fixed: np.ndarray, rows: np.ndarray) -> None:
        self.functions, self.columns, self.fixed, self.rows = functions, columns, fixed, rows
        free = columns >= 0
        code = functions.code
        o, j = code.jacobian_at.T if code else np.zeros((2, 0), int)
        a, b = code.hessian_at.T if code else np.zeros((2, 0), int)
        self.o, self.j = o[free[j]], j[free[j]]
        self.a, self.b = (i[free[a] & free[b]] for i in (a, b))
        self.factor = cross_factor(columns[self.a], columns[self.b], self.a != self.b)

    def with_number(self, name: str, value: float) -> Direct:
        """The same with another number: of a parameter that is data, or of an argument that is fixed."""
        other = copy(self)
        other.functions = self.functions.with_number(name, value)
        named = np.array([own == name for own in self.functions.names], bool)
        other.fixed = np.where(named & (self.columns < 0), value, self.fixed)
        return other

    def move(self, z: np.ndarray) -> None:
        self.arguments = np.where(self.columns >= 0, z[self.columns], self.fixed)

    def values(self) -> np.ndarray:
        """Of each function, shape (n_f,)."""
        return self.functions.values(self.arguments)

    def jacobian(self) -> np.ndarray:
        """The derivatives of function `o` by argument `j`, shape (len(o),)."""
        return self.functions.jacobian(self.arguments)[self.o, self.j]

    def hessian(self, weights: np.ndarray) -> np.ndarray:
        """The second derivatives by arguments `a` and `b`, shape (len(a),); weights: of each function, (n_f,)."""
        return self.functions.hessian(self.arguments, weights)[self.a, self.b] * self.factor
