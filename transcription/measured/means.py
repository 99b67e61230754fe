"""The weighted squared residuals of measured means (see `problems.language.means`), as a function of the unknowns.

    W = sum over measurements m of  w_m r_m^2,          r_m = (U(b_m) - U(a_m)) / (b_m - a_m) - y_m

U(a_m) and U(b_m) are unknown states at knots, so that W is quadratic in the unknowns.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..layout import Layout
from ..program.contract import cross_factor
from .knots import knots_at


class MeanResiduals:
    """Of one phase with measured means; the arguments are those of `residuals.Residuals`."""

    def __init__(self, layout: Layout, parameters: np.ndarray, names: Sequence[str], seconds: dict) -> None:
        phase, mesh = layout.phase, layout.mesh
        rows = {state.name: row for state, row in zip(phase.states, layout.x, strict=True)}
        columns, slopes, values, weights = [], [], [], []
        for own in phase.measured:
            if own.spans is not None:
                knots = mesh.knots[knots_at(mesh, phase.fractions_of(own.spans))]
                columns.append(rows[own.state][knots])
                slopes.append(np.array([-1.0, 1.0]) / np.diff(own.spans))
                values.append(own.values)
                weights.append(own.weights)
        self.columns, self.slopes = np.concatenate(columns), np.concatenate(slopes)
        self.values, self.weights = np.concatenate(values), np.concatenate(weights)
        i, j = np.tril_indices(2)
        a, b = self.columns[:, i], self.columns[:, j]
        self.rows_columns = np.maximum(a, b).ravel(), np.minimum(a, b).ravel()
        second = 2 * self.weights[:, None] * self.slopes[:, i] * self.slopes[:, j]
        self.second = (second * cross_factor(a, b, i != j)).ravel()

    def _missed(self, z: np.ndarray) -> np.ndarray:
        return (self.slopes * z[self.columns]).sum(axis=1) - self.values

    def value(self, z: np.ndarray) -> float:
        """W at z, shape (n,)."""
        return float((self.weights * self._missed(z) ** 2).sum())

    def gradient(self, z: np.ndarray) -> np.ndarray:
        """dW/dz, shape (n,)."""
        terms = 2 * (self.weights * self._missed(z))[:, None] * self.slopes
        return np.bincount(self.columns.ravel(), terms.ravel(), len(z))

    def hessian(self, z: np.ndarray) -> np.ndarray:
        """The nonzeros of d2W/dz2 in the lower triangle, at `rows_columns`."""
        return self.second
