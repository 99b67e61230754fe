"""The Lagrangian of one phase of the continuous problem at a solution, segment by segment (see `objective_error`)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.quantities import Function
from ...problems.text import short_repr
from ..constraint_kinds import INTEGRAL
from ..dual.multipliers import ConstraintMeasure, Density, Multipliers
from ..layout import Layout
from ..schemes.mesh import Mesh
from ..schemes.polynomials import gauss_legendre
from ..schemes.segment import SegmentGroup
from ..schemes.shooting import shooting_scheme
from .hamiltonian import Constrained, Values, minimise
from .implicit import Nearby, consistent_inputs, where_defined
from .trajectory import Sample, Trajectory

GAUSS_POINTS = 4  # between neighbouring nodes of a segment; 6 change the bar by 1 %
SAFETY = 2.0
TOUCHED = 3.0  # an instant between two points exceeds by up to 3 times what the mean over their interval says
INSET = 1e-9  # of a substep, from its ends: constant controls jump there
DIFFERENCE = 1e-6  # of derivatives by a state, relative to 1 + its size

TERMS = ("quadrature", "dynamics", "control", "constraints")

Point = tuple[np.ndarray, np.ndarray, np.ndarray]
"""t, x and inputs u at some samples."""


@short_repr
@dataclass
class SegmentTerms:
    """Contributions of the segments of a phase, (N,): to the minimised objective by kind, and to the bar."""

    signed: dict[str, np.ndarray]
    shares: np.ndarray


def no_terms(mesh: Mesh) -> SegmentTerms:
    """Zero on every segment."""
    return SegmentTerms({kind: np.zeros(mesh.segments) for kind in TERMS}, np.zeros(mesh.segments))


COLUMNS = ("t", "s", "x", "dx", "costate", "u")
"""What `Samples` have a column of for each sample."""


@dataclass(frozen=True)
class Samples:
    """A group of segments at S Gauss points each, all in one row: t (M,), x, dx and costate (n_x, M), inputs u (n_u, M)
    with consistent algebraic variables; s: normalised times; weights (segments, S)."""

    t: np.ndarray
    s: np.ndarray
    x: np.ndarray
    dx: np.ndarray
    costate: np.ndarray
    u: np.ndarray
    weights: np.ndarray

    def integral(self, values: np.ndarray) -> np.ndarray:
        """Of values (M,) over each segment."""
        return (self.weights * values.reshape(self.weights.shape)).sum(axis=1)

    def some(self, k: np.ndarray) -> Samples:
        """Some of the samples of one segment, which stand for all."""
        arrays = {name: getattr(self, name)[..., k] for name in COLUMNS}
        weights = self.weights[:, k]
        return Samples(**arrays, weights=weights * self.weights.sum() / weights.sum())


class PhaseLagrangian:
    """One phase of the Lagrangian, for the minimised objective."""

    def __init__(self, number: int, multipliers: Multipliers, trajectory: Trajectory) -> None:
        self.number, self.multipliers = number, multipliers
        self.layout: Layout = multipliers.transcription.phases[number]
        self.phase, self.mesh, self.p = trajectory.phase, trajectory.mesh, trajectory.parameters
        self.duration = float(trajectory.t[1] - trajectory.t[0])
        self.sense = multipliers.transcription.problem.sense
        costate = trajectory.costate + self.sense * multipliers.at_knots(self.layout)
        self.trajectory = replace(trajectory, costate=costate)
        self.n = len(self.phase.controls)
        self.why_not = ""

    @cached_property
    def integrands(self) -> list[tuple[float, Any]]:
        """(multiplier, function) of the integrals in the Lagrangian: the objective's, and the constrained ones."""
        own = [(self.sense, self.phase.lagrange)] if self.phase.lagrange else []
        rows = [self.multipliers.of_rows(self.phase, INTEGRAL, c.name)[1] for c in self.phase.integral]
        return own + [(float(y[0]), c.function) for y, c in zip(rows, self.phase.integral, strict=True)]

    @cached_property
    def of_controls(self) -> list[Density]:
        return self.multipliers.of_controls(self.layout, self.duration)

    @cached_property
    def of_states(self) -> list[tuple[ConstraintMeasure, np.ndarray, np.ndarray]]:
        """The measures, with their densities at the points and between them."""
        tr, found, known = self.trajectory, [], dict[bytes, Sample]()
        for measure in self.multipliers.of_states(self.layout):
            at = known.get(measure.s.tobytes()) or known.setdefault(measure.s.tobytes(), tr.at(measure.s))
            u = at.u if self.n else self._inputs(at.t, at.x, at.u)  # with controls, what asks for inputs is no measure
            g = self.values(measure.function, at.t, at.x, u)
            nearest = np.diff(np.concatenate([[0.0], (measure.s[1:] + measure.s[:-1]) / 2, [1.0]]))
            theta = self.multipliers.acting(measure.mass / nearest, np.abs(g - measure.bound), measure.bound)
            found.append((measure, measure.spread(theta, self.duration), measure.between(theta, self.duration)))
        return found

    # -- functions of the problem ------------------------------------------------------------------------------------

    def _inputs(self, t: np.ndarray, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return consistent_inputs(self.phase, t, x, u, self.p)

    def values(self, function: Function, t: np.ndarray, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        """The values of a function of the problem, in the shape of t.

        function: of the phase.
        t, x, u: as of `Phase.arguments`.
        """
        return np.broadcast_to(function(self.phase.arguments(t, x, u, self.p), np), np.shape(t))

    def _running(self, t: np.ndarray, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        """The integrands, times their multipliers."""
        values, total = self.phase.arguments(t, x, u, self.p), np.zeros(np.shape(t))
        for multiplier, function in self.integrands:
            total = total + multiplier * function(values, np)
        return total

    def _hamiltonian(self, t: np.ndarray, x: np.ndarray, u: np.ndarray, costate: np.ndarray) -> np.ndarray:
        return self._running(t, x, u) + (costate * self.phase.dynamics(t, x, u, self.p)).sum(axis=0)

    # -- terms -------------------------------------------------------------------------------------------------------

    def terms(self) -> SegmentTerms:
        terms = no_terms(self.mesh)
        for group in self.mesh.groups:
            samples, here, signed = self._samples(group), group.segments, terms.signed
            H = self._hamiltonian(samples.t, samples.x, samples.u, samples.costate)
            running = self._running(samples.t, samples.x, samples.u)
            signed["quadrature"][here] = samples.integral(running) - self._own_integrals(group)
            signed["dynamics"][here] = samples.integral(H - running - (samples.costate * samples.dx).sum(axis=0))
            terms.shares[here] += SAFETY * np.abs(signed["quadrature"][here] + signed["dynamics"][here])
            signed["control"][here], share = self._control(samples, H)
            terms.shares[here] += share
            signed["constraints"][here], share = self._constraints(samples)
            terms.shares[here] += share
        return terms

    def _samples(self, group: SegmentGroup) -> Samples:
        tr, sigma = self.trajectory, group.scheme.sigma
        nodes, weights = gauss_legendre(GAUSS_POINTS)
        width = np.diff(sigma)[:, None]
        tau = (sigma[:-1, None] + width * (nodes + 1) / 2).ravel()
        sample = tr.grid(group.segments, tau)
        assert sample.costate is not None
        costate = self.sense * sample.costate
        if group.scheme.simulated:
            costate = self._simulated_costate(group, tau)
        t = sample.t.ravel()
        x, dx, u, costate = (a.reshape(len(a), t.size) for a in (sample.x, sample.dx, sample.u, costate))
        h = tr.h[group.segments][:, None] * (width * weights / 2).ravel()
        u = where_defined(self.phase, lambda own: self._hamiltonian(t, x, own, costate), self._inputs(t, x, u))
        return Samples(t, (t - tr.t[0]) / self.duration, x, dx, costate, u, h)

    def _own_integrals(self, group: SegmentGroup) -> np.ndarray:
        """The integrals of the Lagrangian over each segment of a group, as the nonlinear program takes them."""
        tr, m = self.trajectory, self.multipliers
        if group.scheme.simulated:
            rows = m.nlp.integrals(m.outcome.z)[self.number][:, group.segments]
            return np.array([multiplier for multiplier, _ in self.integrands]) @ rows
        assert group.scheme.quadrature is not None  # what has costates has a quadrature
        tau, weights = group.scheme.quadrature
        at = tr.grid(group.segments, tau)
        return tr.h[group.segments] * (self._running(at.t, at.x, at.u) @ weights)

    def _control(self, samples: Samples, H: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What the least H over the controls is less than H, over each segment, and its share of the bar."""
        if not self.n:
            none = np.zeros(len(samples.weights))
            return none, none
        every, u = np.arange(len(samples.t)), samples.u[: self.n]
        hamiltonian, constrained = self.over_controls(samples)
        least = minimise(hamiltonian, u, self.control_bounds, constrained)
        if not least.found.all():
            t = samples.t[np.argmin(least.found)]
            self.why_not = f"the Hamiltonian has no minimum over the controls at t = {t:.6g}"
        within = hamiltonian(np.clip(u, *self.control_bounds[:, :, None])[:, None], every)[0]
        share = SAFETY * np.abs(samples.integral(least.value - within)) + samples.integral(np.abs(within - H))
        return samples.integral(least.value - H), share

    @property
    def control_bounds(self) -> np.ndarray:
        """Lower and upper bounds of the controls, shape (2, n)."""
        return np.array([[c.bounds.lower, c.bounds.upper] for c in self.phase.controls]).T

    def over_controls(self, samples: Samples) -> tuple[Values, Constrained | None]:
        """H as a function of the controls at samples, and what constrains them beside their bounds."""
        at = Nearby(self.phase, samples.t, samples.x, samples.u, self.p).inputs

        def hamiltonian(controls: np.ndarray, k: np.ndarray) -> np.ndarray:
            return self._hamiltonian(*at(controls, k), samples.costate[:, None, k])

        return hamiltonian, self._constrained(at, samples)

    def at_points(self) -> Samples:
        """The collocation points, in one row of weights (1, M); of what is simulated, those of each segment."""
        tr, points = self.trajectory, self.mesh.collocated
        if any(group.scheme.simulated for group in self.mesh.groups):
            return _joined([self._simulated_points(group) for group in self.mesh.groups])
        t, x, u, f = (a[..., points] for a in (tr.times, tr.x, tr.u, tr.f))
        costate = self.sense * tr.point_costate[:, points]
        weights = self.mesh.weights[points] * self.duration
        return Samples(t, self.mesh.fractions[points], x, f, costate, self._inputs(t, x, u), weights[None])

    def _simulated_points(self, group: SegmentGroup) -> Samples:
        """The points of simulated segments, with costates of their full order."""
        tr, scheme = self.trajectory, group.scheme
        points = group.collocated.ravel()
        costate = self._simulated_costate(group, np.asarray(scheme.sigma)[list(scheme.collocated)])
        t, x, u, f = (a[..., points] for a in (tr.times, tr.x, tr.u, tr.f))
        weights = (self.mesh.widths[group.segments, None] * scheme.b).ravel() * self.duration
        s = self.mesh.fractions[points]
        return Samples(t, s, x, f, costate.reshape(len(x), -1), self._inputs(t, x, u), weights[None])

    def sizes(self, samples: Samples) -> np.ndarray:
        """The largest modulus of each term of H at samples."""
        values = self.phase.arguments(samples.t, samples.x, samples.u, self.p)
        running = [abs(multiplier) * np.abs(function(values, np)).max() for multiplier, function in self.integrands]
        rates = np.abs(samples.costate * self.phase.dynamics(samples.t, samples.x, samples.u, self.p)).max(axis=1)
        return np.concatenate([running, rates])

    def _constrained(self, at: Callable[..., Point], samples: Samples) -> Constrained | None:
        own = self.of_controls
        if not own:
            return None

        def values(controls: np.ndarray, k: np.ndarray) -> np.ndarray:
            point = at(controls, k)
            return np.stack([self.values(c.function, *point) for c in own])

        lower, upper = np.array([[c.bounds.lower, c.bounds.upper] for c in own]).T
        return Constrained(values, lower, upper, np.stack([np.interp(samples.s, c.s, c.density) for c in own]))

    def _constraints(self, samples: Samples) -> tuple[np.ndarray, np.ndarray]:
        """Multipliers times what the states exceed their constraints by, over each segment; its share of the bar."""
        total, share = np.zeros((2, len(samples.weights)))
        for measure, spread, between in self.of_states:
            beyond = self.values(measure.function, samples.t, samples.x, samples.u) - measure.bound
            inside = between[np.searchsorted(measure.s, samples.s)] * beyond
            total += samples.integral(inside)
            share += np.abs(samples.integral(np.interp(samples.s, measure.s, spread) * beyond))
            share += TOUCHED * np.abs(samples.integral(np.maximum(inside, 0.0)))
        return total, share

    def _simulated_costate(self, group: SegmentGroup, tau: np.ndarray) -> np.ndarray:
        """Costates of segments that are simulated, shape (n_x, G, M): on each substep Hermite's cubic of those at its
        ends and of their slopes, - dL/dx. Without the slopes they would be of a lower order than the states are."""
        tr, segments = self.trajectory, group.segments
        ends = group.scheme.sigma[:: shooting_scheme(group.scheme).stride]
        width = np.diff(ends)
        inner = np.stack([ends[:-1] + INSET * width, ends[1:] - INSET * width], axis=1).ravel()
        at = tr.grid(segments, inner)
        assert at.costate is not None
        costate, slope = self.sense * at.costate, self._costate_slopes(at)
        i = np.clip(np.searchsorted(ends, tau, side="right") - 1, 0, len(width) - 1)
        a, H = (tau - ends[i]) / width[i], width[i] * tr.h[segments][:, None]
        first, last = costate[..., 2 * i], costate[..., 2 * i + 1]
        values = first + a**2 * (3 - 2 * a) * (last - first)
        return values + H * a * (1 - a) * ((1 - a) * slope[..., 2 * i] - a * slope[..., 2 * i + 1])

    def _costate_slopes(self, at: Sample) -> np.ndarray:
        """- dL/dx by differences, L being H + the constraints over time times their multipliers: (n_x, G, M)."""
        n = len(at.x)
        step = DIFFERENCE * (1 + np.abs(at.x).reshape(n, -1).max(axis=1))
        shape = (2 * n, *at.t.shape)
        x = at.x[:, None] + (np.concatenate([np.eye(n), -np.eye(n)]).T * step[:, None])[:, :, None, None]
        t, s = np.broadcast_to(at.t, shape), (at.t - self.trajectory.t[0]) / self.duration
        u = self._inputs(t, x, np.broadcast_to(at.u[:, None], (len(at.u), *shape)))
        assert at.costate is not None
        L = self._hamiltonian(t, x, u, self.sense * at.costate[:, None])
        for measure, spread, _ in self.of_states:
            L = L + np.interp(s, measure.s, spread) * self.values(measure.function, t, x, u)
        for c in self.of_controls:
            L = L + np.interp(s, c.s, c.density) * self.values(c.function, t, x, u)
        return (L[n:] - L[:n]) / (2 * step[:, None, None])


def _joined(parts: list[Samples]) -> Samples:
    """All samples in one row."""
    arrays = {name: np.concatenate([getattr(part, name) for part in parts], axis=-1) for name in COLUMNS}
    return Samples(**arrays, weights=np.concatenate([part.weights.ravel() for part in parts])[None])
