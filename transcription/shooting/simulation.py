"""Simulated segments and their exact derivatives, composed from those of the dynamics at one point.

On a segment everything is a function of its own unknowns y = (x at its start, t0, tF, p, u at its nodes). The stages

    k_ij = F(v_ij),   v_ij = (x_ij, u_ij, p, t_ij, H),    F = H (f, w):   dynamics and integrands times H
    x_ij = X_i + sum_l a_jl k_il,         X_(i+1) = X_i + sum_j b_j k_ij

are linear but for F, so that with the tangents V_ij = dv_ij/dy (a forward sweep) and the adjoints mu_ij of k_ij in a
Lagrangian (a backward sweep) its Hessian on the segment is exactly

    sum_ij  V_ij' [d2 (mu_ij . F) / dv2] V_ij     + the same for the path constraints at the points of the mesh.

A symbolic nested expression would grow exponentially with the stages; this costs two sweeps, for all segments at once.
Nothing depends on controls to come, which stand last in y: substep i takes its first seen[i] entries only.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from functools import cached_property
from typing import Any

import numpy as np

from ..method_kind import TIMES
from ..program.pointwise import PointFunctions
from ..schemes.mesh import Mesh
from ..schemes.segment import SegmentGroup
from ..schemes.shooting import Shooting, shooting_scheme

STEP = "[step]"
"""The name of H among the arguments: no name that a file can declare."""


class Segments:
    """The segments of one scheme of a phase, with n states, q integrals, m nodes of u on each, P points, S substeps.

    columns: (G, n_y) where y stands in z, -1 for what is fixed; `fixed` (n_y,) has its value then. dynamics, path:
    functions of (states, inputs, parameters, t, STEP), the last two being data where both times are fixed. bounded: the
    states whose bounds are constraints inside the segment. The points at which path constraints hold are the first P
    nodes of u on each segment, `held` among its state nodes.
    """

    def __init__(self, mesh: Mesh, group: SegmentGroup, sizes: tuple[int, int, int], *, columns: np.ndarray,
                 fixed: np.ndarray, dynamics: PointFunctions, path: PointFunctions, bounded: Sequence[int],
                 ) -> None:  # fmt: skip
        self.scheme = shooting_scheme(group.scheme)
        self.columns, self.fixed, self.dynamics, self.path = columns, fixed, dynamics, path
        self.n, self.n_u, self.n_p = sizes
        self.bounded = np.array(bounded, int)
        self.held = nodes_of_path(self.scheme)
        self.per = len(self.held) // self.scheme.substeps  # points on a substep
        self.edges, self.widths = mesh.edges[group.segments], mesh.widths[group.segments]
        self.nodes = self.n + 2 + self.n_p  # the place of u in y
        self.seen = self.nodes + self.n_u * (self.scheme.substep_nodes[:, -1] + 1)
        stage = np.arange(self.scheme.substeps)[:, None] + self.scheme.table.c
        self.stage_times = self.edges[:, None, None] + self.widths[:, None, None] * stage / self.scheme.substeps
        self.point_times = self.edges[:, None] + self.widths[:, None] * self.scheme.sigma[self.held]
        # Over all nodes of the segment, mostly zeros: one product then gives the controls of all stages.
        basis = np.zeros((*stage.shape, len(self.scheme.c)))
        basis[np.arange(len(basis))[:, None, None], np.arange(stage.shape[1])[:, None],
              self.scheme.substep_nodes[:, None]] = self.scheme.stage_basis  # fmt: skip
        self.stage_basis = basis
        # u, p, t and H are linear in y, so these rows never change; `differentiate` fills in those of x.
        self._stage_tangents = self._constant_tangents(self.stage_times, basis)
        self._point_tangents = self._constant_tangents(self.point_times, np.eye(len(self.held), len(self.scheme.c)))
        self._differentiated = False

    def _constant_tangents(self, times: np.ndarray, basis: np.ndarray) -> np.ndarray:
        """dv/dy at given normalised times (G, ...), u being basis (..., m) times its nodes; rows of x are left 0."""
        n, n_u, n_p = self.n, self.n_u, self.n_p
        V = np.zeros((*times.shape, self.dynamics.size, self.columns.shape[1]))
        for i in range(n_u):
            V[..., n + i, self.nodes + i :: n_u] = basis
        for i in range(n_p):
            V[..., n + n_u + i, n + 2 + i] = 1
        # Where both times are fixed, t and H are data. Else t = (1 - s) t0 + s tF and H = (tF - t0) width / S.
        if self.dynamics.size > n + n_u + n_p:
            step = (self.widths / self.scheme.substeps).reshape(-1, *[1] * (times.ndim - 1))
            V[..., -2, n], V[..., -2, n + 1] = 1 - times, times
            V[..., -1, n], V[..., -1, n + 1] = -step, step
        return V

    def with_number(self, name: str, value: float) -> Segments:
        """The same with another number: of a parameter that is data, or of a given time. It shares the arrays of
        tangents, so it is good for values only."""
        other = copy(self)
        other.dynamics, other.path = self.dynamics.with_number(name, value), self.path.with_number(name, value)
        if name in TIMES:
            other.fixed = self.fixed.copy()
            other.fixed[self.n + TIMES.index(name)] = value
        return other

    # -- values ----------------------------------------------------------------------------------------------------

    def move(self, z: np.ndarray) -> None:
        """Simulate the segments for the unknowns z, shape (n_z,)."""
        y = np.where(self.columns >= 0, z[self.columns], self.fixed)
        # A line search asks for values at many z and for derivatives at few: tangents wait until they are asked for.
        self._differentiated = False
        u = y[:, self.nodes :].reshape(len(y), len(self.scheme.c), self.n_u)
        self.stages = self._arguments(self.stage_times, np.einsum("ijm,gma->gija", self.stage_basis, u), y)
        self.points = self._arguments(self.point_times, u[:, : len(self.held)], y)
        A, b, S = self.scheme.table.A, self.scheme.table.b, self.scheme.substeps
        self.x = np.zeros((len(y), S + 1, self.dynamics.outputs))
        self.x[:, 0, : self.n] = y[:, : self.n]
        k = np.zeros((len(y), S, len(b), self.dynamics.outputs))
        for i in range(S):
            for j in range(len(b)):
                # Integrals are simulated like states, but nothing depends on them: a stage needs the states only.
                self.stages[:, i, j, : self.n] = self.x[:, i, : self.n] + _mix(A[j, :j], k[:, i, :j, : self.n])
                k[:, i, j] = self.dynamics.values(self.stages[:, i, j])
            self.x[:, i + 1] = self.x[:, i] + _mix(b, k[:, i])
        self.points[:, :: self.per, : self.n] = self.x[:, :-1, : self.n]
        if self.per == 2:
            middle = _mix(self.scheme.table.middle, k, 2)[..., : self.n]
            self.points[:, 1::2, : self.n] = self.x[:, :-1, : self.n] + middle

    def _arguments(self, times: np.ndarray, u: np.ndarray, y: np.ndarray) -> np.ndarray:
        v = np.zeros((*times.shape, self.n + self.n_u + self.n_p + 2))
        lift = (slice(None), *[None] * (times.ndim - 1))
        start, duration = y[:, self.n][lift], (y[:, self.n + 1] - y[:, self.n])[lift]
        v[..., self.n : self.n + self.n_u] = u
        v[..., self.n + self.n_u : -2] = y[lift][..., self.n + 2 : self.nodes]
        v[..., -2] = start + duration * times
        v[..., -1] = duration * self.widths[lift] / self.scheme.substeps
        return v

    # -- tangents ----------------------------------------------------------------------------------------------------

    def differentiate(self) -> None:
        """Tangents at the last z: of the end (G, n + q, n_y), of the points (G, P, n_v, n_y) and of the stages."""
        if self._differentiated:
            return
        A, b, n = self.scheme.table.A, self.scheme.table.b, self.n
        self.F_v, self.g_v = self.dynamics.jacobian(self.stages), self.path.jacobian(self.points)
        # Both are written in place: the entries that are not written are zero, or constant, at every z.
        V, at_points = self._stage_tangents, self._point_tangents
        # D is dx/dy at the start of a substep: the same recursion as of the values, with F_v V in the place of F.
        D = np.zeros((len(self.columns), self.dynamics.outputs, self.columns.shape[1]))
        D[:, :n, :n] = np.eye(n)
        for i, seen in enumerate(self.seen.tolist()):
            here = D[..., :seen]
            K = np.zeros((len(D), len(b), *here.shape[1:]))
            for j in range(len(b)):
                V[:, i, j, :n, :seen] = here[:, :n] + _mix(A[j, :j], K[:, :j, :n])
                K[:, j] = self.F_v[:, i, j] @ V[:, i, j, :, :seen]
            at_points[:, self.per * i, :n, :seen] = here[:, :n]
            if self.per == 2:
                at_points[:, 2 * i + 1, :n, :seen] = here[:, :n] + _mix(self.scheme.table.middle, K[:, :, :n])
            # A view of D, which is to be the tangent at the start of the next substep.
            here += _mix(b, K)
        self.end_tangents, self._differentiated = D, True

    @property
    def path_tangents(self) -> np.ndarray:
        """d g / dy at the points, shape (G, P, n_g, n_y)."""
        return self.g_v @ self._point_tangents

    @property
    def bound_tangents(self) -> np.ndarray:
        """dx / dy of the bounded states at the points after the first, shape (G, P - 1, n_b, n_y)."""
        return self._point_tangents[:, 1:, self.bounded]

    @cached_property
    def causal(self) -> np.ndarray:
        """Whether a point depends on an entry of y, shape (P, n_y): not on controls of later substeps."""
        last = self.scheme.sigma[self.held]
        if self.per == 2:  # a middle is computed from the stages up to the end of its substep
            last = last + np.tile([0, 0.5 / self.scheme.substeps], self.scheme.substeps)
        # The node of a constant control is the middle of its substep, but it acts from the start.
        if self.scheme.control == "constant":
            last = last + 0.5 / self.scheme.substeps
        mask = np.ones((len(last), self.columns.shape[1]), bool)
        mask[:, self.nodes :] = np.repeat(self.scheme.c <= last[:, None] + 1e-12, self.n_u, axis=1)
        return mask

    # -- adjoints and second derivatives ---------------------------------------------------------------------------

    def adjoint(self, end: np.ndarray, path: np.ndarray, bound: np.ndarray) -> tuple[np.ndarray, ...]:
        """The sweep back through the stages.

        end: (G, n + q) multipliers of the states and integrals at the end of each segment.
        path: (G, P, n_g) of the path constraints at the points.
        bound: (G, P - 1, n_b) of the bounds of states at the points after the first.

        Returns mu (G, S, r, n + q) of the stages; the derivative of the Lagrangian by x at the starts of the substeps
        without the constraints there (G, S, n); and that of these constraints alone (G, S, n).
        """
        self.differentiate()
        A, b, n, S = self.scheme.table.A, self.scheme.table.b, self.n, self.scheme.substeps
        own = np.einsum("gpo,gpox->gpx", path, self.g_v[..., :n])
        own[:, 1:, self.bounded] += bound
        own = own.reshape(len(end), S, -1, n)
        mu, after = np.zeros((len(end), S, len(b), end.shape[1])), np.zeros((len(end), S, n))
        lam = end.copy()
        # `after` is taken before the constraints at the start of the substep are added to `lam`: a costate may jump by
        # what acts at a point, and the caller divides that between both sides.
        for i in reversed(range(S)):
            pulled = np.zeros((len(end), len(b), n))  # (dF/dx)' mu of each stage
            for j in reversed(range(len(b))):
                # All that k_ij acts on: the end of the substep by b_j, later stages by a_lj, the point in the middle.
                mu[:, i, j] = b[j] * lam
                mu[:, i, j, :n] += _mix(A[j + 1 :, j], pulled[:, j + 1 :])
                if self.per == 2:
                    mu[:, i, j, :n] += self.scheme.table.middle[j] * own[:, i, 1]
                pulled[:, j] = (mu[:, i, j, None] @ self.F_v[:, i, j, :, :n])[:, 0]
            lam[:, :n] += pulled.sum(axis=1) + own[:, i, 1:].sum(axis=1)
            after[:, i] = lam[:, :n]
            lam[:, :n] += own[:, i, 0]
        return mu, after, own[:, :, 0]

    def hessian(self, end: np.ndarray, path: np.ndarray, bound: np.ndarray) -> np.ndarray:
        """Second derivatives of the Lagrangian of each segment by its y, shape (G, n_y, n_y).

        end, path, bound: multipliers, as of `adjoint`.
        """
        mu, _, _ = self.adjoint(end, path, bound)
        # Bounds have no curvature of their own, as they are linear in x: their multipliers are in mu.
        M, V = self.dynamics.hessian(self.stages, mu), self._stage_tangents
        M_g, V_g = self.path.hessian(self.points, path), self._point_tangents
        H = np.zeros((len(V), V.shape[-1], V.shape[-1]))
        for i, seen in enumerate(self.seen.tolist()):
            H[:, :seen, :seen] += _congruence(V[:, i, ..., :seen], M[:, i])
            if self.path.outputs:
                points = slice(self.per * i, self.per * (i + 1))
                H[:, :seen, :seen] += _congruence(V_g[:, points, :, :seen], M_g[:, points])
        return H


def nodes_of_path(scheme: Shooting) -> np.ndarray:
    """The state nodes of a segment at which path constraints hold, the last node being the next segment's."""
    return np.arange(0, len(scheme.sigma) - 1, 2 if scheme.control == "constant" else 1)


def _mix(weights: np.ndarray, k: np.ndarray, axis: int = 1) -> Any:
    """sum_j weights[j] k[..., j, ...] over one axis. Most weights of a table are zero, and most arrays are small."""
    along = np.moveaxis(k, axis, 0)
    return sum(float(w) * along[j] for j, w in enumerate(weights) if w)


def _congruence(V: np.ndarray, M: np.ndarray) -> np.ndarray:
    """The sum of V' M V over all axes between the first and the last two: shape (G, n_y, n_y)."""
    # All axes of the sum in one: a single matrix product for each segment adds them up.
    rows = -1, V.shape[-1]
    left, right = V.reshape(len(V), *rows), (M @ V).reshape(len(V), *rows)
    return left.swapaxes(1, 2) @ right
