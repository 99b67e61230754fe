"""Second-order finite differences as a method on one segment; `collocation.differences` has their equations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.text import short_repr
from .polynomials import lagrange_basis
from .segment import Interpolant, KindOfMethod, Points, SegmentGroup


@short_repr
@dataclass(frozen=True, eq=False)
class FiniteDifference:
    """Second-order central differences for positions, on equal segments: a `segment.Segment`.

    Between the points the state is the cubic Hermite polynomial of its values and slopes, the control is linear.
    """

    name: str = "finite-difference"
    family: str = "differences, second order"
    source: str = "An introduction to direct collocation, section 6, (40)-(42)"
    kind: KindOfMethod = "differences"
    order: int = 2
    error_order: int = 2
    sigma: np.ndarray = field(default_factory=lambda: np.array([0.0, 1.0]))
    c: np.ndarray = field(default_factory=lambda: np.array([0.0, 1.0]))
    b: np.ndarray = field(default_factory=lambda: np.array([0.5, 0.5]))
    collocated: tuple[int, ...] = (0, 1)
    rows: tuple[int, ...] = (0,)
    degree: int | None = None
    differential: bool = False
    options: Mapping[str, int | str] = field(default_factory=dict)
    quadrature: None = None
    equal: bool = True
    coarsens: bool = False
    has_costates: bool = False
    densities: bool = False
    simulated: bool = False
    state_interpolant: str = "3"
    control_interpolant: str = "1"

    def interpolant(self, tau: np.ndarray) -> Interpolant:
        t = np.asarray(tau, float)
        X = np.stack([(1 + 2 * t) * (1 - t) ** 2, t**2 * (3 - 2 * t)], axis=1)
        F = np.stack([t * (1 - t) ** 2, t**2 * (t - 1)], axis=1)
        dX = np.stack([6 * t * (t - 1), 6 * t * (1 - t)], axis=1)
        dF = np.stack([(1 - t) * (1 - 3 * t), t * (3 * t - 2)], axis=1)
        return Interpolant(X, F, dX, dF, self.control_basis(t))

    def control_basis(self, tau: np.ndarray) -> np.ndarray:
        return lagrange_basis(self.c, tau)

    def costate_basis(self, tau: np.ndarray) -> np.ndarray:
        raise TypeError("finite differences have no costates")

    def complete(self, points: Points, group: SegmentGroup) -> None:
        """The velocities: differences of the positions, central inside, of three points at the ends."""
        names = [state.name for state in points.phase.states]
        for i, state in enumerate(points.phase.states):
            if state.velocity_of:
                x = points.x[names.index(state.velocity_of)]
                points.x[i] = np.gradient(x, points.h[0], edge_order=2)

    def defect_multipliers(self, costate: np.ndarray) -> np.ndarray:
        raise TypeError("finite differences have no costates")
