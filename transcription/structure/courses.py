"""What a solution shows of bounds: the arcs of every bounded control, state and path constraint.

Both the distance from a bound and its multiplier are needed, as an interior-point method leaves both above zero where
one should vanish. Along the central path their product is small, so that a bound acts where, in units of the range of
what is bounded and of 1 + |J|,

    multiplier > slack.

On an arc of a control its bound acts at most points: not where it begins, and where a state is held by it, too (the
last fuel of a rocket that has burnt out). A state may stay on a bound that costs something at its ends only (Bryson and
Denham's problem); there it is enough that it acts somewhere. How far from it the engine leaves a state on an arc is
seen on that arc, so that the parabola before it does not count.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property, partial
from itertools import pairwise

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.problem import Phase
from ...problems.quantities import Range
from ..arcs import CLOSE, CONTROL, HELD, INSIDE, LOWER, PATH, SINGULAR, STATE, UPPER, Arc, Course
from ..constraint_kinds import BOUND
from ..constraint_kinds import PATH as PATH_ROWS
from ..dual.multipliers import Multipliers
from ..engines.outcome import Outcome
from ..layout import Layout, Transcription
from ..program.contract import NonlinearProgram
from ..refinement.switches import JUMP, Switches
from ..solution.trajectory import Trajectory
from .affine import is_affine
from .runs import arcs_of, snapped, with_touches

NEAR_CONTROL, NEAR_STATE = 1e-3, 1e-4
"""Of the range of a control, and of a state or path constraint: what is farther from a bound is not on it."""

STEP = 0.05  # of the range of a control, at least, from one arc to the next: less is a kink
MOST = 0.5  # of the points of an arc
BEYOND, ROUNDING = 10.0, 1e-9
"""Times the median slack of a state on an arc, and at least, in units of its range: what is farther is not on it."""


def courses(
    transcription: Transcription, nlp: NonlinearProgram, outcome: Outcome, trajectories: Sequence[Trajectory]
) -> tuple[tuple[Course, ...], ...]:
    """The arcs of each phase: of what is on a bound somewhere, and of controls that are singular.

    transcription: of the problem.
    nlp: its program.
    outcome: its solution, with multipliers.
    trajectories: one for each phase.
    """
    own = Multipliers(transcription, nlp, outcome)
    phases = zip(transcription.phases, trajectories, strict=True)
    known = (_Phase(own, layout, tr).courses if tr.lasts and not tr.phase.exact else () for layout, tr in phases)
    return tuple(known)


@dataclass(frozen=True)
class _Phase:
    multipliers: Multipliers
    layout: Layout
    trajectory: Trajectory

    @cached_property
    def courses(self) -> tuple[Course, ...]:
        own = self._controls()
        times = [arc.end for _, course in own for arc in course.arcs[:-1]]
        others = [course for course in (*self._states(times), *self._paths(times)) if _on_a_bound(course)]
        controls = [self._told(course, affine, others) for affine, course in own]
        shown = [course for course in controls if _on_a_bound(course) or course.arcs[0].by == SINGULAR]
        return (*shown, *(course for course in others if len(course.arcs) > 1))

    @cached_property
    def switches(self) -> Switches:
        return Switches(self.trajectory)

    @property
    def phase(self) -> Phase:
        return self.layout.phase

    @property
    def size(self) -> float:
        return 1 + abs(self.multipliers.outcome.objective)

    def _controls(self) -> list[tuple[bool, Course]]:
        """Whether the Hamiltonian is linear in each, and its arcs."""
        mesh, o, found = self.layout.mesh, self.multipliers.outcome, []
        points = [group.collocated for group in mesh.groups]
        for i, control in enumerate(self.phase.controls):
            if not _bounded(control.bounds):
                continue
            u, places = self.trajectory.u[i], self.layout.u[i]
            per_time = np.where((places >= 0) & (mesh.weights > 0), 1 / np.maximum(mesh.weights, 1e-300), 0.0)
            below, above, width = _slacks(u, control.bounds)
            on = np.where(above <= NEAR_CONTROL, 1, np.where(below <= NEAR_CONTROL, -1, 0))
            push = on * (o.z_upper - o.z_lower)[places] * per_time * width / self.size
            acts = self._acting(push > np.where(on > 0, above, below), MOST)
            affine = is_affine(self.trajectory, i)
            smeared = np.ptp(self.switches.u[i], axis=1) > JUMP * width if affine else None
            arcs = arcs_of(on, points, mesh, self.trajectory.knots, acts, partial(self._switch, i, width), smeared)
            found.append((affine, Course(control.name, CONTROL, control.bounds, arcs)))
        return found

    def _states(self, times: Sequence[float]) -> list[Course]:
        o, found = self.multipliers.outcome, []
        points = [nodes[:, 1:-1] if (nodes := group.nodes).shape[1] > 2 else nodes for group in self.layout.mesh.groups]
        for state, x, places in zip(self.phase.states, self.trajectory.x, self.layout.x, strict=True):
            if _bounded(state.bounds):
                mass = np.where(places >= 0, o.z_upper[places] - o.z_lower[places], 0.0)
                rows = self.multipliers.of_rows(self.phase, BOUND, state.name)
                found.append(self._course(state.name, STATE, state.bounds, x, points, mass, rows[:2], times))
        return found

    def _paths(self, times: Sequence[float]) -> list[Course]:
        tr, found = self.trajectory, []
        values = self.phase.arguments(tr.times, tr.x, tr.u, tr.parameters)
        points = [group.collocated for group in self.layout.mesh.groups]
        for c in self.phase.path:
            if _bounded(c.bounds):
                g = np.broadcast_to(c.function(values, np), tr.times.shape)
                rows = self.multipliers.of_rows(self.phase, PATH_ROWS, c.name)
                found.append(self._course(c.name, PATH, c.bounds, g, points, np.zeros(len(g)), rows[:2], times))
        return found

    def _course(
        self,
        name: str,
        kind: str,
        bounds: Range,
        values: np.ndarray,
        points: Sequence[np.ndarray],
        mass: np.ndarray,
        rows: tuple[np.ndarray, np.ndarray],
        times: Sequence[float],
    ) -> Course:
        """Of a state or path constraint, with the multipliers of its values (K,), and of rows: normalised times and
        multipliers. times: at which controls switch."""
        fractions, (s, y) = self.layout.mesh.fractions, rows
        if len(s):
            np.add.at(mass, np.searchsorted(fractions, s - 1e-14).clip(max=len(mass) - 1), y)
        below, above, width = _slacks(values, bounds)
        on = np.where(above <= NEAR_STATE, 1, np.where(below <= NEAR_STATE, -1, 0))
        slack = np.where(on > 0, above, below)
        acting = on * mass * width / self.size > slack
        on = _sharpened(on, slack, acting)
        cut = partial(self._contact, on)
        arcs = arcs_of(on, points, self.layout.mesh, self.trajectory.knots, self._acting(acting, 0.0), cut)
        return Course(name, kind, bounds, with_touches(snapped(arcs, times), self._touches(on, acting, np.abs(mass))))

    def _acting(self, acting: np.ndarray, share: float) -> Callable[[float, float], bool]:
        """Whether a bound acts, from one time to another, at more than a share of the collocation points."""
        points = self.layout.mesh.collocated
        times = self.trajectory.times[points]
        return lambda start, end: bool(np.mean(acting[points][(times >= start) & (times <= end)]) > share)

    def _contact(self, on: np.ndarray, before: int, after: int) -> float:
        """When a state comes to a bound or leaves it, between two arcs: next to the last point that is as before."""
        points, times = self.layout.mesh.knots, self.trajectory.times
        between = np.arange(points[before + 1], points[after] + 1)
        same = on[between] == on[points[before + 1] - 1]
        last = int(np.argmin(same)) if not same.all() else len(same)
        return float(times[between[max(last - 1, 0) : last + 1]].mean())

    def _switch(self, i: int, width: float, before: int, after: int) -> float:
        """When control i jumps between two arcs: as the states around it are right to first order, so is its mean,

            mean u = tau u_left + (1 - tau) u_right.

        Where both arcs meet, and it only has a kink, when that is.
        """
        u, knots = self.switches.u[i], self.trajectory.knots
        left, right = u[before, -1], u[after, 0]
        if abs(left - right) > STEP * width:
            means = np.trapezoid(u[before + 1 : after], axis=1) / (u.shape[1] - 1)
            beyond = float(((means - right) * self.trajectory.h[before + 1 : after]).sum())
            return float(np.clip(knots[before + 1] + beyond / (left - right), knots[before + 1], knots[after]))
        kinks = [(kink.height, s, kink.tau) for s in range(before + 1, after) if (kink := self.switches.kink(s))]
        if not kinks:
            return float((knots[before + 1] + knots[after]) / 2)
        _, s, tau = max(kinks)
        return float(knots[s] + tau * self.trajectory.h[s])

    def _touches(self, on: np.ndarray, acting: np.ndarray, mass: np.ndarray) -> list[tuple[float, str]]:
        """Where bounds act at single points, away from the ends: neighbours that act are one, at the mean of them."""
        times, knots = self.trajectory.times, self.trajectory.knots
        inner = np.flatnonzero(acting & (times > knots[1]) & (times < knots[-2]))
        groups = np.split(inner, np.flatnonzero((np.diff(inner) > 1) | (np.diff(on[inner]) != 0)) + 1)
        return [
            (float(np.average(times[own], weights=mass[own])), UPPER if on[own[0]] > 0 else LOWER)
            for own in groups
            if len(own)
        ]

    def _told(self, course: Course, affine: bool, others: Sequence[Course]) -> Course:
        """The arcs of a control with what determines it inside its bounds. affine: whether H is linear in it."""

        def by(arc: Arc) -> str:
            if arc.on != INSIDE:
                return ""
            held = [other for other in others if _share(other, arc) > 0.5]
            return f"{HELD}{held[0].name}" if held else SINGULAR if affine else ""

        cuts = [arc.end for other in others for arc in other.arcs[:-1] if arc.end > arc.start]
        arcs = [part for arc in course.arcs for part in (_split(arc, cuts) if arc.on == INSIDE else (arc,))]
        return replace(course, arcs=_joined([replace(arc, by=by(arc)) for arc in arcs]))


def _bounded(bounds: Range) -> bool:
    return not bounds.fixed and bounds != Range()


def _on_a_bound(course: Course) -> bool:
    return any(arc.on != INSIDE for arc in course.arcs)


def _slacks(values: np.ndarray, bounds: Range) -> tuple[np.ndarray, np.ndarray, float]:
    """The distances from both bounds, in units of the range; and that: what the values span, if a bound is missing."""
    width = bounds.upper - bounds.lower
    if not np.isfinite(width):
        width = float(np.nanmax(values) - np.nanmin(values)) or 1.0
    return (values - bounds.lower) / width, (bounds.upper - values) / width, width


def _sharpened(on: np.ndarray, slack: np.ndarray, acting: np.ndarray) -> np.ndarray:
    """The points on bounds (K,), as of `arcs_of`, without those at the ends that are too far and do not act."""
    kept = on.copy()
    for run in np.split(np.arange(len(on)), np.flatnonzero(np.diff(on)) + 1):
        if on[run[0]]:
            level = max(BEYOND * np.sort(slack[run])[len(run) // 2], ROUNDING)
            close = np.flatnonzero((slack[run] <= level) | acting[run])
            kept[run[: close[0]]] = kept[run[close[-1] + 1 :]] = 0
    return kept


def _share(other: Course, arc: Arc) -> float:
    """For which part of an arc another quantity is on a bound; 0 for an arc of no duration."""
    on = [min(own.end, arc.end) - max(own.start, arc.start) for own in other.arcs if own.on != INSIDE]
    return sum(part for part in on if part > 0) / (arc.end - arc.start) if arc.end > arc.start else 0.0


def _split(arc: Arc, cuts: Sequence[float]) -> list[Arc]:
    """An arc in parts, at the times of others' switches that are well inside of it."""
    margin = CLOSE * (arc.end - arc.start)
    inner = sorted(t for t in cuts if arc.start + margin < t < arc.end - margin)
    ends = [arc.start, *inner, arc.end]
    return [replace(arc, start=a, end=b) for a, b in pairwise(ends)]


def _joined(arcs: Sequence[Arc]) -> tuple[Arc, ...]:
    """Arcs without switches between those that are alike."""
    found: list[Arc] = []
    for arc in arcs:
        if found and (found[-1].on, found[-1].by) == (arc.on, arc.by):
            found[-1] = replace(found[-1], end=arc.end)
        else:
            found.append(arc)
    return tuple(found)
