"""Multipliers of the nonlinear program as what the continuous problem has: functions of time, and measures.

    rows over time       y / (weight * duration)    density nu of a path constraint or of an algebraic variable's bound
    bounds of states     y, mass at a point         their multiplier is a measure: it may act at one instant only
    end values, times, parameters, boundary and integral rows     one number each

The barrier leaves a product of multiplier and slack at every inequality; their sum is the gap. What an inequality adds
to the objective by it is

    - theta * multiplier * slack,      theta = nu / (nu + a s),

nu being the multiplier's density and s the slack in units of 1 + |J| and of 1 + |bound|: 1 where it acts, 0 where it
does not, 1/2 where it begins to act. (Along the central path  s nu = mu  the objective changes by  s'(mu) nu  per mu;
with a curvature a of the Lagrangian, s' nu = nu / (nu + a s). The curvature is not known, but only matters between the
two; it is taken as 1 in these units.)
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import Any

import numpy as np

from ...problems.conserved.determined import determined, of_states_alone
from ...problems.lean.records import dataclass
from ...problems.probe import depends_on
from ...problems.problem import Phase
from ...problems.quantities import Function, Range
from ...problems.sets import distinct
from ...problems.text import short_repr
from ..constraint_kinds import BOUND, PATH, ConstraintKind, Multiplier
from ..engines.outcome import Outcome
from ..layout import Family, Layout, Transcription, bounded_start
from .end_masses import without_end_masses

ACTS = 0.5
"""Of theta: an inequality with less does not act."""


@short_repr
@dataclass(frozen=True)
class Density:
    """lower <= function <= upper at every time, and the density of its multiplier (K,) at normalised times s (K,)."""

    function: Function
    bounds: Range
    s: np.ndarray
    density: np.ndarray


@short_repr
@dataclass(frozen=True)
class ConstraintMeasure:
    """A side of a constraint on the states: function <= bound or >= bound, or an equation.

    mass: (K,) of its multiplier at normalised times s (K,), positive where it keeps the function from growing.
    places: (K,) of the n unknowns that it bounds, or n + those of its rows.
    """

    function: Function
    bound: float
    s: np.ndarray
    mass: np.ndarray
    places: np.ndarray

    def spread(self, theta: np.ndarray, duration: float) -> np.ndarray:
        """The mass that acts, as a density at s: each over the points nearest to it."""
        edges = np.concatenate([[0.0], (self.s[1:] + self.s[:-1]) / 2, [1.0]])
        return theta * self.mass / (np.diff(edges) * duration)

    def between(self, theta: np.ndarray, duration: float) -> np.ndarray:
        """The mass that both neighbours of an interval share, as a density on the K + 1 intervals around s.

        An instant between two points at which a multiplier acts leaves a mass at both; one at a point, or beside an arc
        on which it acts, leaves none between.
        """
        mass = theta * self.mass
        a, b = mass[:-1], mass[1:]
        shared = np.where(a * b > 0, 2 * a * b / np.where(a * b > 0, a + b, 1.0), 0.0)
        return np.concatenate([[0.0], shared / (np.diff(self.s) * duration), [0.0]])


@short_repr
@dataclass(frozen=True)
class Multipliers:
    """The multipliers of an outcome, those of the minimised objective."""

    transcription: Transcription
    nlp: Any
    outcome: Outcome

    @cached_property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper bounds of the unknowns, each (n,)."""
        return bounded_start(self.transcription)[1:]

    @cached_property
    def g(self) -> np.ndarray:
        return self.nlp.constraints_unchecked(self.outcome.z)

    @cached_property
    def equations(self) -> np.ndarray:
        """Which rows are equations, shape (m,)."""
        return self.nlp.cl == self.nlp.cu

    @cached_property
    def sides(self) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """(multipliers, slacks, bounds) of the lower and upper bounds of the unknowns, all (n,), and of the rows that
        are no equations, (m,): the side that the multiplier's sign says. Zero multipliers where there is no bound."""
        o, y = self.outcome, self.outcome.y
        near = np.where(y > 0, self.nlp.cu, self.nlp.cl)
        rows = np.where(self.equations, 0.0, np.abs(y)), np.abs(near - self.g), near
        sides = []
        for z, slack, bound in (
            (o.z_lower, o.z - self.bounds[0], self.bounds[0]),
            (o.z_upper, self.bounds[1] - o.z, self.bounds[1]),
            rows,
        ):
            none = ~np.isfinite(bound)
            sides.append((np.where(none, 0.0, z), np.where(none, 0.0, slack), np.where(none, 0.0, bound)))
        return sides

    @cached_property
    def over_time(self) -> np.ndarray:
        """Multipliers of the rows, shape (m,), without what path constraints do at the ends only."""
        return without_end_masses(self.transcription, self.nlp, self.outcome)

    @property
    def gap(self) -> float:
        """The sum of multiplier times slack over all inequalities."""
        return float(sum((z * s).sum() for z, s, _ in self.sides))

    @property
    def largest_product(self) -> float:
        """Of multiplier and slack, over all inequalities."""
        return max(float((z * s).max(initial=0.0)) for z, s, _ in self.sides)

    @property
    def acting_gap(self) -> tuple[float, float]:
        """What of the gap acts, and about how many inequalities act; multipliers at points stand for densities here."""
        gap = count = 0.0
        for z, s, bound in self.sides:
            theta = np.where(z * s > 0, self.acting(z, s, bound), 0.0)
            gap, count = gap + float((theta * z * s).sum()), count + float(theta.sum())
        return gap, count

    @property
    def missed(self) -> np.ndarray:
        """Multiplier times residual of the equations, shape (m,): what it is worth that they hold to a tolerance."""
        return np.where(self.equations, self.outcome.y * (self.g - self.nlp.cl), 0.0)

    def acting(self, multiplier: np.ndarray, slack: np.ndarray, bound: np.ndarray | float) -> np.ndarray:
        """theta, see above, in the shape of the multipliers.

        multiplier: per normalised time, for what is bounded over time.
        slack: how far the bound is, in its unit; the same shape.
        bound: in the same unit.
        """
        size = 1 + np.abs(bound)
        nu, s = np.abs(multiplier) * size / (1 + abs(self.outcome.objective)), np.maximum(slack, 0.0) / size
        return np.where(nu + s > 0, nu / np.where(nu + s > 0, nu + s, 1.0), 1.0)

    @property
    def single(self) -> float:
        """What the gap of inequalities that hold at no more than one instant adds to the objective.

        In discrete time every instant is one.
        """
        t = self.transcription
        exact = [layout for layout in t.phases if layout.phase.exact]
        held = [(own.x.ravel(), own.u.ravel()) for own in exact]
        held += [(own.t, np.concatenate([own.x[:, 0], own.x[:, -1], _determined_at_ends(own)])) for own in t.phases]
        places = distinct(np.concatenate([t.parameters, *(p for own in held for p in own)]))
        places = places[places >= 0]
        names = {own.phase.name for own in exact}
        single = [f.rows(self.nlp) for f in t.families if f.kind.multiplier is Multiplier.NUMBER or f.phase in names]
        single += [
            f.rows(self.nlp)[_at_an_end(f)]
            for f in t.families
            if f.kind is PATH and f.phase not in names and self._of_states_alone(f)
        ]
        rows = np.concatenate([np.zeros(0, int), *single])
        total = 0.0
        for (z, s, bound), own in zip(self.sides, (places, places, rows), strict=True):
            total -= float((self.acting(z[own], s[own], bound[own]) * z[own] * s[own]).sum())
        return total

    def _of_states_alone(self, family: Family) -> bool:
        phases = (layout.phase for layout in self.transcription.phases)
        return any(
            phase.name == family.phase and c.name == family.name and of_states_alone(phase, c.function)
            for phase in phases
            for c in phase.path
        )

    # -- over time ---------------------------------------------------------------------------------------------------

    def of_rows(self, phase: Phase, kind: ConstraintKind, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Normalised times, multipliers and quadrature weights of the rows of one constraint, each (K,).

        phase: that it is of.
        kind: such as PATH.
        name: in the file.
        """
        s, rows, weights = self._rows(phase, kind, name)
        return s, self.over_time[rows], weights

    def _rows(self, phase: Phase, kind: ConstraintKind, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Normalised times, numbers and quadrature weights of the rows of one constraint, each (K,)."""
        wanted = (phase.name, kind, name)
        same = [f for f in self.transcription.families if (f.phase, f.kind, f.name) == wanted]
        if not same:
            return np.zeros(0), np.zeros(0, int), np.zeros(0)
        s = np.concatenate([f.span[:, 0] for f in same])
        rows = np.concatenate([f.rows(self.nlp) for f in same])
        weights = np.concatenate([f.weights for f in same])
        order = np.argsort(s, kind="stable")
        return s[order], rows[order], weights[order]

    def at_knots(self, layout: Layout) -> np.ndarray:
        """What bounds of states at the knots add to the costates of `costate`, shape (n_x, K + N - 1), at the slots.

        There a bound's multiplier stands between the costates of both sides, whole. Where the bound acts over time, its
        parts belong to both segments, as those of a path constraint do. Costates of states that are fixed all the time
        have it already.
        """
        mesh, o = layout.mesh, self.outcome
        inner = np.arange(1, mesh.segments)
        starts, ends = mesh.offset[inner], mesh.offset[inner - 1] + mesh.degrees[inner - 1]
        parts = mesh.slot_parts
        places = layout.x[:, mesh.knots[inner]]
        varies = np.array([not state.bounds.fixed for state in layout.phase.states], bool)[:, None]
        z = np.where((places >= 0) & varies, o.z_upper[places] - o.z_lower[places], 0.0)
        added = np.zeros((len(layout.x), len(mesh.slot_points)))
        added[:, starts], added[:, ends] = parts[starts] * z, -parts[ends] * z
        return added

    def of_controls(self, layout: Layout, duration: float) -> list[Density]:
        """What bounds the controls beside their own bounds: path constraints, and bounds of algebraic variables."""
        phase = layout.phase
        found: list[Density] = []
        if not phase.controls:
            return found
        for c in phase.path:
            if _depends_on_inputs(phase, c.function):
                s, y, weights = self.of_rows(phase, PATH, c.name)
                found.append(Density(c.function, c.bounds, s, y / (weights * duration)))
        weights = layout.mesh.weights
        for variable, places in zip(phase.algebraic, layout.u[phase.rows_of_delayed.stop :], strict=True):
            if variable.bounds != Range():
                k = np.flatnonzero((places >= 0) & (weights > 0))
                y = self.outcome.z_upper[places[k]] - self.outcome.z_lower[places[k]]
                s = layout.mesh.fractions[k]
                found.append(Density(_value_of(variable.name), variable.bounds, s, y / (weights[k] * duration)))
        return found

    def of_states(self, layout: Layout) -> Iterator[ConstraintMeasure]:
        """What bounds the states: their bounds, but not those at the ends, and path constraints without controls."""
        phase, o = layout.phase, self.outcome
        for state, places in zip(phase.states, layout.x, strict=True):
            inside = np.flatnonzero(places >= 0)
            inside = inside[(inside > 0) & (inside < len(places) - 1)]
            s, rows, _ = self._rows(phase, BOUND, state.name)
            y = self.over_time[rows]
            times = np.concatenate([layout.mesh.fractions[inside], s])
            order = np.argsort(times, kind="stable")
            own = np.concatenate([places[inside], self.nlp.n + rows])[order]
            for z, bound, sign in ((o.z_lower, state.bounds.lower, -1), (o.z_upper, state.bounds.upper, 1)):
                if np.isfinite(bound) and len(times):
                    mass = np.concatenate([sign * z[places[inside]], np.where(sign * y > 0, y, 0.0)])
                    yield ConstraintMeasure(_value_of(state.name), bound, times[order], mass[order], own)
        for c in phase.path:
            if phase.controls and _depends_on_inputs(phase, c.function):
                continue
            s, rows, _ = self._rows(phase, PATH, c.name)
            y, own = self.over_time[rows], self.nlp.n + rows
            if c.bounds.fixed:
                yield ConstraintMeasure(c.function, c.bounds.lower, s, y, own)
                continue
            for bound, sign in ((c.bounds.lower, -1), (c.bounds.upper, 1)):
                if np.isfinite(bound):
                    yield ConstraintMeasure(c.function, bound, s, np.where(sign * y > 0, y, 0.0), own)


def _depends_on_inputs(phase: Phase, function: Function) -> bool:
    return depends_on(function, {variable.name for variable in phase.found})


def _value_of(name: str) -> Function:
    return lambda values, functions: values[name]


def _determined_at_ends(layout: Layout) -> np.ndarray:
    """Where the unknowns stand at both ends that the states determine, of any number."""
    phase = layout.phase
    names = determined(phase).names if phase.algebraic else ()
    known = [own.name in names for own in phase.inputs]
    return layout.u[np.array(known, bool)][:, [0, -1]].ravel() if any(known) else np.zeros(0, int)


def _at_an_end(family: Family) -> np.ndarray:
    """Which rows of a family hold at the initial or the final time, shape (M,)."""
    return np.isin(family.span[:, 0], (0.0, 1.0))
