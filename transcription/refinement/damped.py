"""The term that damps controls: 1/2 |D z|^2."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.text import short_repr

PAIRS = tuple((i, j) for i in range(3) for j in range(i + 1))
"""The nonzeros of the lower triangle of what one row of D adds to the Hessian."""


@short_repr
@dataclass(frozen=True)
class Squares:
    """A `program.contract.ObjectiveTerm`.

    columns, factors: (M, 3) the nonzeros of the rows of D.
    """

    columns: np.ndarray
    factors: np.ndarray

    def _product(self, z: np.ndarray) -> np.ndarray:
        """D z, shape (M,)."""
        return (self.factors * z[self.columns]).sum(axis=1)

    def objective(self, z: np.ndarray) -> float:
        """1/2 |D z|^2."""
        return float(np.sum(self._product(z) ** 2)) / 2

    def gradient(self, z: np.ndarray) -> np.ndarray:
        """D' D z, shape (n,)."""
        terms = self.factors * self._product(z)[:, None]
        return np.bincount(self.columns.ravel(), terms.ravel(), len(z))

    @cached_property
    def structure(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns of the nonzeros of the Hessian."""
        one, other = (np.concatenate([self.columns[:, pair[side]] for pair in PAIRS]) for side in (0, 1))
        return np.maximum(one, other), np.minimum(one, other)

    def hessian(self, z: np.ndarray) -> np.ndarray:
        """D' D, the same everywhere."""
        return np.concatenate([self.factors[:, i] * self.factors[:, j] for i, j in PAIRS])
