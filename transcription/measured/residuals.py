"""The weighted squared residuals of the measurements of a phase, as a function of the unknowns.

    W = sum over measurements m of  w_m (h_m(t_m, x(t_m), p) - y_m)^2

x(t_m) is the unknown state at the knot at t_m, so that derivatives are exact:

    dW   = sum  2 w_m r_m dh_m,                      r_m = h_m - y_m
    d2W  = sum  2 w_m (dh_m dh_m^T + r_m d2h_m)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...problems.problem import Phase
from ...problems.quantities import Measured
from ..layout import Layout
from ..program.contract import cross_factor
from ..program.pointwise import PointFunctions
from .knots import knots_at

TIME = "t"


class Residuals:
    """Of one phase with measurements.

    layout: of the phase among all unknowns; its mesh has knots at the times.
    parameters: where the static parameters stand among the unknowns, and names: of them.
    seconds: of the program, to which what differentiating and compiling takes is added.
    """

    def __init__(self, layout: Layout, parameters: np.ndarray, names: Sequence[str], seconds: dict) -> None:
        phase: Phase = layout.phase
        states = [state.name for state in phase.states]
        measured = [own for own in phase.measured if own.spans is None]
        self.functions = PointFunctions([own.function for own in measured], [*states, *names], [TIME], seconds)
        self.times = np.unique(np.concatenate([own.times for own in measured]))
        knots = layout.mesh.knots[knots_at(layout.mesh, phase.fractions_of(self.times))]
        places = [layout.x[:, knots].T, np.broadcast_to(parameters, (len(knots), len(parameters)))]
        self.columns = np.hstack(places).astype(int)
        self.values, self.weights = np.zeros((2, len(self.times), len(measured)))
        self._gather(measured)
        i, j = np.tril_indices(self.columns.shape[1])
        a, b = self.columns[:, i], self.columns[:, j]
        self.lower = i, j
        self.rows_columns = np.maximum(a, b).ravel(), np.minimum(a, b).ravel()
        self.factor = cross_factor(a, b, i != j)

    def _gather(self, measured: Sequence[Measured]) -> None:
        """Of several measurements of one quantity at one time, as of one that is their mean; `apart` is what is left.

        w_1 (h - y_1)^2 + w_2 (h - y_2)^2 = (w_1 + w_2) (h - y)^2 + w_1 (y - y_1)^2 + w_2 (y - y_2)^2
        """
        self.apart = 0.0
        for j, own in enumerate(measured):
            at = np.searchsorted(self.times, own.times)
            total = np.bincount(at, own.weights, len(self.times))
            mean = np.bincount(at, own.weights * own.values, len(self.times)) / np.where(total > 0, total, 1.0)
            self.weights[:, j], self.values[:, j] = total, mean
            self.apart += float((own.weights * (own.values - mean[at]) ** 2).sum())

    def _arguments(self, z: np.ndarray) -> np.ndarray:
        return np.hstack([z[self.columns], self.times[:, None]])

    def _missed(self, arguments: np.ndarray) -> np.ndarray:
        """r, shape (times, quantities); 0 where nothing was measured."""
        return np.where(self.weights > 0, self.functions.values(arguments) - self.values, 0.0)

    def value(self, z: np.ndarray) -> float:
        """W at z, shape (n,)."""
        return float((self.weights * self._missed(self._arguments(z)) ** 2).sum()) + self.apart

    def gradient(self, z: np.ndarray) -> np.ndarray:
        """dW/dz, shape (n,)."""
        arguments = self._arguments(z)
        slopes = 2 * self.weights * self._missed(arguments)
        terms = (slopes[..., None] * self.functions.jacobian(arguments)).sum(axis=1)
        return np.bincount(self.columns.ravel(), terms.ravel(), len(z))

    def hessian(self, z: np.ndarray) -> np.ndarray:
        """The nonzeros of d2W/dz2 in the lower triangle, at `rows_columns`."""
        arguments = self._arguments(z)
        slopes, J = 2 * self.weights * self._missed(arguments), self.functions.jacobian(arguments)
        H = self.functions.hessian(arguments, slopes) + np.einsum("kj,kja,kjb->kab", 2 * self.weights, J, J)
        i, j = self.lower
        return (H[:, i, j] * self.factor).ravel()


def squares_with(
    layout: Layout, own: Measured, z: np.ndarray, p: Mapping[str, float], name: str, value: float
) -> float:
    """The sum of weighted squares of one quantity with another number for a parameter of the file.

    layout: of the phase.
    own: the quantity, whose function is an expression.
    z: the unknowns.
    p: the static parameters.
    name: of the parameter.
    value: its number.
    """
    phase = layout.phase

    def values(t: np.ndarray) -> dict[str, Any]:
        x = z[layout.x[:, layout.mesh.knots[knots_at(layout.mesh, phase.fractions_of(t))]]]
        return {TIME: t, **dict(zip((state.name for state in phase.states), x, strict=True)), **p, name: value}

    return float((own.weights * (own.along(values) - own.values) ** 2).sum())
