"""A nonlinear program with a quadratic term more: f(z) + 1/2 |D z|^2 in place of f(z), under the same constraints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...problems.text import short_repr
from ..program.contract import NonlinearProgram

PAIRS = tuple((i, j) for i in range(3) for j in range(i + 1))
"""The nonzeros of the lower triangle of what one row of D adds to the Hessian."""


@short_repr
@dataclass(frozen=True)
class Damped:
    """A `NonlinearProgram` around another.

    nlp: the program without the term.
    columns, factors: (M, 3) the nonzeros of the rows of D.
    """

    nlp: NonlinearProgram
    columns: np.ndarray
    factors: np.ndarray

    @property
    def n(self) -> int:
        return self.nlp.n

    @property
    def m(self) -> int:
        return self.nlp.m

    @property
    def cl(self) -> np.ndarray:
        return self.nlp.cl

    @property
    def cu(self) -> np.ndarray:
        return self.nlp.cu

    @property
    def seconds(self) -> dict[str, float]:
        return self.nlp.seconds

    def rows(self, component: Any) -> np.ndarray:
        return self.nlp.rows(component)

    def row_name(self, row: int) -> tuple[str, int | None]:
        return self.nlp.row_name(row)

    def _product(self, z: np.ndarray) -> np.ndarray:
        """D z, shape (M,)."""
        return (self.factors * z[self.columns]).sum(axis=1)

    def added(self, z: np.ndarray) -> float:
        """1/2 |D z|^2."""
        return float(np.sum(self._product(z) ** 2)) / 2

    def objective(self, z: np.ndarray) -> float:
        return self.nlp.objective(z) + self.added(z)

    def gradient(self, z: np.ndarray) -> np.ndarray:
        """df/dz + D' D z."""
        gradient = np.array(self.nlp.gradient(z))
        np.add.at(gradient, self.columns, self.factors * self._product(z)[:, None])
        return gradient

    def constraints(self, z: np.ndarray) -> np.ndarray:
        return self.nlp.constraints(z)

    def constraints_unchecked(self, z: np.ndarray) -> np.ndarray:
        return self.nlp.constraints_unchecked(z)

    def jacobianstructure(self) -> tuple[np.ndarray, np.ndarray]:
        return self.nlp.jacobianstructure()

    def jacobian(self, z: np.ndarray) -> np.ndarray:
        return self.nlp.jacobian(z)

    def hessianstructure(self) -> tuple[np.ndarray, np.ndarray]:
        rows, columns = self.nlp.hessianstructure()
        one, other = (np.concatenate([self.columns[:, pair[side]] for pair in PAIRS]) for side in (0, 1))
        return np.append(rows, np.maximum(one, other)), np.append(columns, np.minimum(one, other))

    def hessian(self, z: np.ndarray, y: np.ndarray, sigma: float) -> np.ndarray:
        """d2(sigma f + y g)/dz2 + sigma D' D."""
        own = [self.factors[:, i] * self.factors[:, j] for i, j in PAIRS]
        return np.append(self.nlp.hessian(z, y, sigma), sigma * np.concatenate(own))
