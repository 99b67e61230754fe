"""A solved phase as functions of time, by the interpolants of the scheme that solved it (paper, 3.4 and 4.4).

On a segment that starts at t_k and lasts h, with tau = (t - t_k) / h and l_j the Lagrange polynomials of the
scheme's collocation nodes:

    u(t) = sum_j u_j l_j(tau)                                 (3.6), (4.10)
    x(t) = x_k + h sum_j f_j (integral of l_j to tau)         (3.10), (4.13) as corrected
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.problem import Guess, Phase
from ...problems.quantities import Delayed
from ...problems.sets import without
from ...problems.text import short_repr
from ..layout import Layout, Transcription
from ..schemes.mesh import Mesh

DENSE_PER_SEGMENT = 30  # of the dense grid: 15 on each half of a Hermite-Simpson segment, as in the paper's figures
ROUNDING = 1e-9  # of the largest time
MOVED = 1e-6  # of 1 + the size of a state: it has moved
NO_TIME = 1e-9  # of its guessed duration: in that nothing moves, but in a program that has no other solution
NOTHING = 1e-6  # of its guessed duration: a phase shorter than that has shrunk to nothing
ALIGNED = 1e-12  # of the duration: a time this near to the initial one is there
DENSE_POINTS = 10_000  # about; large meshes get fewer points on each segment


@short_repr
class Sample(NamedTuple):
    """Values of a trajectory at times t (...): x, its slope dx/dt and its costate (n_x, ...); inputs u (n_u, ...)."""

    t: np.ndarray
    x: np.ndarray
    u: np.ndarray
    dx: np.ndarray
    costate: np.ndarray | None


@short_repr
@dataclass(frozen=True, eq=False)
class Trajectory:
    """One phase of a solution.

    t: (2,) initial and final time. x: (n_x, K) and inputs u: (n_u, K) at the points of the mesh; u is NaN at a point
    that is no collocation point. parameters: the optimised static parameters by name. costate: (n_x, K + N - 1) at the
    slots of the mesh (see `costate`), or None. before: of the phase in which states at earlier times are read
    before the initial time.
    """

    phase: Phase
    mesh: Mesh
    t: np.ndarray
    x: np.ndarray
    u: np.ndarray
    parameters: Mapping[str, float]
    costate: np.ndarray | None = None
    before: Trajectory | None = None

    @property
    def initial_time(self) -> float:
        return float(self.t[0])

    @property
    def final_time(self) -> float:
        return float(self.t[1])

    @property
    def lasts(self) -> bool:
        """Whether the phase takes any time, and has not shrunk to nothing."""
        guess = self.phase.guess
        return self.final_time - self.initial_time > NOTHING * (guess.final_time - guess.initial_time)

    @property
    def leaps(self) -> bool:
        """Whether states move in no time, or in a negative one, which no dynamics do."""
        guess, shift = self.phase.guess, np.abs(self.x[:, -1] - self.x[:, 0])
        if self.phase.exact or self.final_time - self.initial_time > NO_TIME * (guess.final_time - guess.initial_time):
            return False
        return bool((shift > MOVED * (1 + np.abs(self.x).max(axis=1))).any())

    @cached_property
    def times(self) -> np.ndarray:
        """The times of the points, shape (K,)."""
        return self.t[0] + (self.t[1] - self.t[0]) * self.mesh.fractions

    @cached_property
    def knots(self) -> np.ndarray:
        """The times of the segment edges, shape (N + 1,)."""
        return self.t[0] + (self.t[1] - self.t[0]) * self.mesh.edges

    def told(self, t: float) -> float:
        """A time as words tell it: 0 for what is 0 but for rounding, as in a phase that has shrunk to nothing."""
        guess = self.phase.guess
        largest = max(abs(own) for own in (*self.t.tolist(), guess.initial_time, guess.final_time))
        return 0.0 if abs(t) < ROUNDING * largest else float(t)

    @cached_property
    def h(self) -> np.ndarray:
        """The durations of the segments, shape (N,)."""
        return (self.t[1] - self.t[0]) * self.mesh.widths

    @property
    def at_collocated(self) -> dict[str, Any]:
        """What functions are called with: names -> values at the collocation points, (M,) each, and parameters."""
        k = self.mesh.collocated
        return self.phase.arguments(self.times[k], self.x[:, k], self.u[:, k], self.parameters)

    @cached_property
    def f(self) -> np.ndarray:
        """The dynamics at the points, shape (n_x, K)."""
        return self.phase.dynamics(self.times, self.x, self.u, self.parameters)

    def grid(self, segments: np.ndarray, tau: np.ndarray) -> Sample:
        """The trajectory at the same normalised times tau, shape (M,), of segments, shape (G,): shapes (..., G, M)."""
        return self._sample(segments, tau, common=True)

    def inputs(self, tau: np.ndarray) -> np.ndarray:
        """The inputs at the same normalised times tau, shape (M,), of all segments: shape (n_u, N, M)."""
        u = np.empty((len(self.u), self.mesh.segments, len(tau)))
        for group in self.mesh.groups:
            u[:, group.segments] = self.u[:, group.collocated] @ group.scheme.control_basis(tau).T
        return u

    def inputs_of(self, segment: int) -> Callable[[float], np.ndarray]:
        """The inputs of one segment, shape (n_u,), as a function of its normalised time."""
        group = self.mesh.groups[self.mesh.group_of[segment]]
        (row,) = np.flatnonzero(group.segments == segment)
        nodes, basis = self.u[:, group.collocated[row]], group.scheme.control_basis
        return lambda tau: nodes @ basis(np.array([tau]))[0]

    def at(self, s: np.ndarray) -> Sample:
        """The trajectory at normalised times s in [0, 1] of the phase, shape (M,)."""
        edges = self.mesh.edges
        segment = np.clip(np.searchsorted(edges, s, side="right") - 1, 0, self.mesh.segments - 1)
        return self._sample(segment, (s - edges[segment]) / self.mesh.widths[segment], common=False)

    @np.errstate(all="ignore")  # the last iterate of a failed solve need not be finite
    def _sample(self, segments: np.ndarray, tau: np.ndarray, common: bool) -> Sample:
        """tau is common to all segments, shape (M,), or each segment has one, shape (G,)."""

        def combine(nodal: np.ndarray, basis: np.ndarray) -> Any:
            return nodal @ basis.T if common else (nodal * basis).sum(axis=-1)

        lift = (slice(None), None) if common else slice(None)
        t = self.knots[segments][lift] + self.h[segments][lift] * tau
        x, dx = np.empty((2, len(self.x), *t.shape))
        u = np.empty((len(self.u), *t.shape))
        costate = None if self.costate is None else np.empty_like(x)
        groups = self.mesh.group_of[segments]
        for number, group in enumerate(self.mesh.groups):
            here = np.flatnonzero(groups == number)
            if not len(here):
                continue
            row, h, own = np.searchsorted(group.segments, segments[here]), self.h[segments[here]], tau
            if not common:
                own = tau[here]
            X, F, dX, dF, U = group.scheme.interpolant(own)
            nodes, f = self.x[:, group.nodes[row]], self.f[:, group.collocated[row]]
            x[:, here] = combine(nodes, X) + h[lift] * combine(f, F)
            dx[:, here] = combine(nodes, dX) / h[lift] + combine(f, dF)
            u[:, here] = combine(self.u[:, group.collocated[row]], U)
            if costate is not None and self.costate is not None:
                costate[:, here] = combine(self.costate[:, group.slots[row]], group.scheme.costate_basis(own))
        for late, values in zip(self.phase.delayed, u[self.phase.rows_of_delayed], strict=True):
            values[:] = self.earlier(late, t)
        return Sample(t, x, u, dx, costate)

    def earlier(self, own: Delayed, t: np.ndarray) -> np.ndarray:
        """A state at an earlier time than t, of any shape: its own interpolant, here or before, or its history."""
        return self._read(own, np.ravel(t) - own.lag).reshape(np.shape(t))

    def _read(self, own: Delayed, t: np.ndarray) -> np.ndarray:
        """The state at times t (M,), none of which is after the final time."""
        (t0, tF), edges = self.t, self.mesh.edges
        i = next(i for i, state in enumerate(self.phase.states) if state.name == own.state)
        s = (t - t0) / (tF - t0)
        here = s >= -ALIGNED
        values = np.empty(len(t))
        values[~here] = self.past(own, t[~here])
        inside = np.flatnonzero(here)
        segments = np.clip(np.searchsorted(edges, s[inside], side="right") - 1, 0, self.mesh.segments - 1)
        tau = (s[inside] - edges[segments]) / self.mesh.widths[segments]
        for number, group in enumerate(self.mesh.groups):
            own_here = np.flatnonzero(self.mesh.group_of[segments] == number)
            X, F, _, _, _ = group.scheme.interpolant(tau[own_here])
            row, h = np.searchsorted(group.segments, segments[own_here]), self.h[segments[own_here]]
            nodes, f = self.x[i, group.nodes[row]], self.f[i, group.collocated[row]]
            values[inside[own_here]] = (nodes * X).sum(axis=-1) + h * (f * F).sum(axis=-1)
        return values

    def past(self, own: Delayed, t: np.ndarray) -> np.ndarray:
        """A state at times t (M,) before the initial time: that of the phase before, if it has it, or its history."""
        if not len(t):
            return np.zeros(0)
        before = self.before if self.before and own.state in {s.name for s in self.before.phase.states} else None
        return before._read(own, t) if before else own.before(t)

    @property
    def point_costate(self) -> np.ndarray:
        """Costates at the points, shape (n_x, K); the mean of both sides at a knot.

        Where something is measured costates jump at knots: there the sides count as their segments do in what the
        control at the knot is optimal for.
        """
        assert self.costate is not None
        points, parts = self.mesh.slot_points, np.ones(len(self.mesh.slot_points))
        if self.phase.measured:
            parts = np.where(self.mesh.weights[points] > 0, self.mesh.slot_parts, 1.0)
        total = np.bincount(points, weights=parts)
        own = [np.bincount(points, weights=parts * costate) / total for costate in self.costate]
        return np.stack(own) if own else np.zeros((0, len(total)))

    def samples(self, s: np.ndarray) -> dict[str, np.ndarray]:
        """States and inputs at normalised times s, shape (M,), by name: a trajectory is a guess for the next mesh."""
        sample = self.at(s)
        return self._named(sample.x, sample.u)

    def with_controls(self, controls: Mapping[str, np.ndarray]) -> Guess:
        """The trajectory as a guess at its points, with other values of some controls, name -> (K,)."""
        values = self._named(self.x, self.u) | dict(controls)
        return Guess(self.initial_time, self.final_time, self.mesh.fractions, values, self.parameters)

    def _named(self, x: np.ndarray, u: np.ndarray) -> dict[str, np.ndarray]:
        """The rows of states and inputs, by their names."""
        names = [variable.name for variable in (*self.phase.states, *self.phase.inputs)]
        return dict(zip(names, (*x, *u), strict=True))

    @cached_property
    def dense(self) -> Sample:
        """The trajectory on a fine grid, shapes (M,): equally spaced times on each segment, and the final one."""
        segments = self.mesh.segments
        degree = int(self.mesh.degrees.max())
        count = int(np.clip(DENSE_POINTS // segments, 2 * degree, max(DENSE_PER_SEGMENT, 10 * degree)))
        inside = self.grid(np.arange(segments), np.arange(count) / count)
        end = self.grid(np.array([segments - 1]), np.ones(1))

        def join(a: np.ndarray | None, b: np.ndarray | None) -> Any:
            if a is None or b is None:
                return None
            return np.concatenate([a.reshape(*a.shape[:-2], a.shape[-2] * a.shape[-1]), b[..., 0]], axis=-1)

        return Sample(*map(join, inside, end))

    def by_segment(self, values: np.ndarray) -> np.ndarray:
        """Values on the dense grid, shape (M,), as those of each segment, shape (N, M // N); without the final one."""
        return values[:-1].reshape(self.mesh.segments, -1)


def trajectories(transcription: Transcription, z: np.ndarray) -> tuple[Trajectory, ...]:
    """Read the unknowns z, shape (n,), back into one trajectory for each phase."""
    names = [p.name for p in transcription.problem.parameters]
    parameters = dict(zip(names, z[transcription.parameters].tolist(), strict=True))
    found: dict[str, Trajectory] = {}
    for layout in transcription.phases:  # a phase stands after the one before it
        found[layout.phase.name] = _trajectory(layout, z, parameters, found.get(layout.phase.before))
    return tuple(found.values())


def _trajectory(layout: Layout, z: np.ndarray, parameters: dict, before: Trajectory | None) -> Trajectory:
    phase, mesh = layout.phase, layout.mesh
    t = np.array(
        [
            z[i] if i >= 0 else bounds.lower
            for i, bounds in zip(layout.t, (phase.initial_time, phase.final_time), strict=True)
        ]
    )
    x = np.where(layout.x >= 0, z[layout.x], np.nan)
    u = np.where(layout.u >= 0, z[layout.u], np.nan)
    trajectory = Trajectory(phase, mesh, t, x, u, parameters, before=before)
    for group in mesh.groups:
        group.scheme.complete(trajectory, group)
    _extrapolate_inputs(trajectory)
    return trajectory


def _extrapolate_inputs(trajectory: Trajectory) -> None:
    """Write the inputs at points that are no collocation points into trajectory.u, by the interpolant of the segment.

    A knot takes the value of the segment that starts there, the last one that of the segment that ends there.
    """
    mesh, u = trajectory.mesh, trajectory.u
    missing = without(np.arange(len(mesh.fractions)), mesh.collocated)
    for k in missing:
        segment = min(int(np.searchsorted(mesh.knots, k, side="right")) - 1, mesh.segments - 1)
        scheme = mesh.schemes[segment]
        tau = scheme.sigma[k - mesh.first[segment]]
        inside = u[:, mesh.first[segment] + np.array(scheme.collocated)]
        u[:, k] = np.where(np.isnan(u[:, k]), inside @ scheme.control_basis(np.array([tau]))[0], u[:, k])
    for row, own in zip(u[trajectory.phase.rows_of_delayed], trajectory.phase.delayed, strict=True):
        row[missing] = trajectory.earlier(own, trajectory.times[missing])
        vars(trajectory).pop("f", None)  # it had what was extrapolated
