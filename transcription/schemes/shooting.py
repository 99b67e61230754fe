"""Shooting as data: the scheme of a segment that is simulated by an explicit Runge-Kutta method.

A segment is cut into S equal substeps of duration H, each with its own piece of the control polynomial. On a substep

    k_j = f(t + c_j H, x + H sum_l a_jl k_l, u(t + c_j H))            stages, l < j
    x(t + H) = x + H sum_j b_j k_j                                    its end
    x(t + H/2) = x + H sum_j m_j k_j                                  its middle, of order one less (2 at least)

    control      nodes of u on a substep      points of the mesh        state between the points, from
    constant     middle                       ends and middle           x at the ends and the middle, f in the middle
    linear       ends                         ends                      x and f at the ends
    quadratic    ends and middle              ends and middle           x at the ends and the middle, f at the ends

The middle's weights m solve the order conditions at 1/2: no evaluation of f is added. A linear or quadratic control is
continuous, as its end nodes are shared.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import ClassVar, cast

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.text import short_repr
from .polynomials import lagrange_basis
from .runge_kutta import CONTROLS, ButcherTable
from .segment import Interpolant, KindOfMethod, Points, Segment, SegmentGroup

_SLOPES = {"constant": (0.5,), "linear": (0.0, 1.0), "quadratic": (0.0, 1.0)}
COSTATE_NODES = 4  # of the polynomial through neighbouring costates


def shooting_scheme(segment: Segment) -> Shooting:
    """A segment of a mesh whose kind of method is shooting, as the scheme that it is."""
    return cast(Shooting, segment)


@short_repr
@dataclass(frozen=True, eq=False)
class Shooting:
    """A segment that is simulated: one row of the table of methods, for a number of substeps and a control polynomial.

    A `segment.Segment`, of which only the states at the ends are unknowns.
    """

    table: ButcherTable
    substeps: int
    control: str

    kind: ClassVar[KindOfMethod] = "shooting"
    family: ClassVar[str] = "shooting, explicit Runge-Kutta"
    rows: ClassVar[tuple[int, ...]] = (0,)
    degree: ClassVar[int | None] = None
    differential: ClassVar[bool] = False
    equal: ClassVar[bool] = False
    coarsens: ClassVar[bool] = False
    has_costates: ClassVar[bool] = True
    simulated: ClassVar[bool] = True

    @property
    def options(self) -> Mapping[str, int | str]:
        return {"substeps": self.substeps, "control": self.control}

    @property
    def densities(self) -> bool:
        """Not where controls stand in the middles only: the ends have no weight."""
        return self.control != "constant"

    @property
    def name(self) -> str:
        return self.table.name

    @property
    def order(self) -> int:
        return self.table.order

    @property
    def source(self) -> str:
        return self.table.source

    @property
    def state_interpolant(self) -> str:
        return str(len(self.x_nodes) + len(_SLOPES[self.control]) - 1)

    @property
    def control_interpolant(self) -> str:
        return str(len(self.u_nodes) - 1)

    @property
    def u_nodes(self) -> np.ndarray:
        """The nodes of the control on the unit substep."""
        return np.array(CONTROLS[self.control])

    @property
    def x_nodes(self) -> np.ndarray:
        """The points of the mesh on the unit substep."""
        return np.array([0.0, 1.0] if self.control == "linear" else [0.0, 0.5, 1.0])

    @property
    def stride(self) -> int:
        """From the point at one end of a substep to that at the other."""
        return len(self.x_nodes) - 1

    @cached_property
    def sigma(self) -> np.ndarray:
        count = self.stride * self.substeps
        return np.arange(count + 1) / count

    @cached_property
    def collocated(self) -> tuple[int, ...]:
        """The index in sigma of each node of the control."""
        step = 2 if self.control == "constant" else 1
        return tuple(range(step - 1, len(self.sigma), step))

    @property
    def error_order(self) -> int:
        """eta of a part of a segment falls as h^(this + 1), as long as the parts have as many substeps."""
        return min(len(self.u_nodes) + 1, self.order)

    @cached_property
    def c(self) -> np.ndarray:
        return self.sigma[list(self.collocated)]

    @cached_property
    def b(self) -> np.ndarray:
        """Weights of a composite quadrature on the nodes of the control: what makes a multiplier a density."""
        local = {"constant": [1.0], "linear": [1 / 2, 1 / 2], "quadratic": [1 / 6, 4 / 6, 1 / 6]}[self.control]
        return np.bincount(self.substep_nodes.ravel(), np.tile(local, self.substeps)) / self.substeps

    @property
    def quadrature(self) -> tuple[np.ndarray, np.ndarray]:
        """Nodes and weights on the unit segment: integrals are simulated along with the states."""
        nodes = (np.arange(self.substeps)[:, None] + self.table.c) / self.substeps
        return nodes.ravel(), np.tile(self.table.b, self.substeps) / self.substeps

    @cached_property
    def substep_nodes(self) -> np.ndarray:
        """The numbers of the control's nodes on each substep, shape (S, nodes a substep)."""
        count = len(self.u_nodes)
        return np.arange(self.substeps)[:, None] * max(count - 1, 1) + np.arange(count)

    @cached_property
    def stage_basis(self) -> np.ndarray:
        """u at the stages from u at the nodes of the substep, shape (r, nodes a substep)."""
        return lagrange_basis(self.u_nodes, self.table.c)

    def interpolant(self, tau: np.ndarray) -> Interpolant:
        tau = np.asarray(tau, float)
        rows, i = np.arange(len(tau))[:, None], self._substep(tau)
        theta = tau * self.substeps - i
        x_at, slope_at = self.x_nodes, np.array(_SLOPES[self.control])
        (X, F), (dX, dF) = _hermite(x_at, slope_at, theta)
        full = [np.zeros((len(tau), len(nodes))) for nodes in (self.sigma, self.c, self.sigma, self.c)]
        points = i[:, None] * self.stride + np.arange(len(x_at))
        slopes = self.substep_nodes[i][:, np.isin(self.u_nodes, slope_at)]
        for array, columns, values in zip(
            full,
            (points, slopes, points, slopes),
            (X, F / self.substeps, dX * self.substeps, dF),
            strict=True,
        ):
            array[rows, columns] = values
        X, F, dX, dF = full
        return Interpolant(X, F, dX, dF, self.control_basis(tau))

    def control_basis(self, tau: np.ndarray) -> np.ndarray:
        """Weights (m, n) of the controls at the nodes of the substep that tau, shape (m,), is in."""
        tau = np.asarray(tau, float)
        i = self._substep(tau)
        basis = np.zeros((len(tau), len(self.c)))
        columns = self.substep_nodes[i]
        basis[np.arange(len(tau))[:, None], columns] = lagrange_basis(self.u_nodes, tau * self.substeps - i)
        return basis

    def costate_basis(self, tau: np.ndarray) -> np.ndarray:
        """Weights (m, d + 1) of the costates at the ends of up to three neighbouring substeps, for those at tau."""
        tau = np.asarray(tau, float)
        count = min(COSTATE_NODES, self.substeps + 1)
        first = np.clip(self._substep(tau) - (count - 1) // 2, 0, self.substeps + 1 - count)
        basis = np.zeros((len(tau), len(self.sigma)))
        columns = (first[:, None] + np.arange(count)) * self.stride
        basis[np.arange(len(tau))[:, None], columns] = lagrange_basis(np.arange(count), tau * self.substeps - first)
        return basis

    def complete(self, points: Points, group: SegmentGroup) -> None:
        """The states inside the segments, from those at their starts and the controls."""
        phase, p = points.phase, points.parameters
        A, b, c, middle = self.table.A, self.table.b, self.table.c, self.table.middle
        u = points.u[:, group.collocated]
        H = points.h[group.segments] / self.substeps
        start = points.knots[group.segments]
        x = points.x[:, group.nodes[:, 0]]
        for i in range(self.substeps):
            k = np.zeros((len(b), *x.shape))
            for j in range(len(b)):
                stage = x + H * np.tensordot(A[j, :j], k[:j], 1)
                inputs = u[:, :, self.substep_nodes[i]] @ self.stage_basis[j]
                k[j] = phase.dynamics(start + (i + c[j]) * H, stage, inputs, p)
            if self.stride == 2:
                points.x[:, group.nodes[:, 2 * i + 1]] = x + H * np.tensordot(middle, k, 1)
            x = x + H * np.tensordot(b, k, 1)
            if i < self.substeps - 1:
                points.x[:, group.nodes[:, self.stride * (i + 1)]] = x

    def defect_multipliers(self, costate: np.ndarray) -> np.ndarray:
        """mu = -lambda at the end of the segment."""
        return -costate[..., -1:]

    def _substep(self, tau: np.ndarray) -> np.ndarray:
        return np.clip(np.searchsorted(self.sigma[:: self.stride], tau, side="right") - 1, 0, self.substeps - 1)


def _hermite(values: np.ndarray, slopes: np.ndarray, theta: np.ndarray) -> tuple:
    """Weights of the values and slopes at some nodes for the polynomial at theta, and those for its derivative."""
    powers = np.arange(len(values) + len(slopes))
    lowered = np.maximum(powers - 1, 0)
    conditions = np.vstack([values[:, None] ** powers, powers * slopes[:, None] ** lowered])
    weights = [theta[:, None] ** powers, powers * theta[:, None] ** lowered] @ np.linalg.inv(conditions)
    return tuple(np.split(w, [len(values)], axis=1) for w in weights)
