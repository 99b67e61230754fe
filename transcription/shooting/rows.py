"""Single and multiple shooting (paper, 9.5 and 9.6): unknowns and constraints.

On segment s, with x_s the unknown state at its start and Phi_s the simulation to its end (see `schemes.shooting`),

    x_(s+1) == Phi_s(x_s, u on the segment, t0, tF, p)                                   the defects
    lower <= g <= upper, and bounds of x, at the points of the mesh inside the segment, where x is simulated

and integrals are summed by the same Runge-Kutta weights. One segment is single shooting. Path constraints hold at the
ends of the substeps, and in the middle too where the control has a node there: what an equation of the controls leaves
free there, the integral would exploit. Algebraic variables are interpolated like controls, and their residuals are such
equations.

The unknowns are ordered point by point, as for collocation: x at the ends of the segments, u at its nodes; then the
times and the parameters.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from math import isfinite, prod
from typing import Any

import numpy as np

from ...problems.errors import Mistake, SpecError
from ...problems.lean.records import dataclass
from ...problems.problem import Curves, Phase, Problem
from ...problems.quantities import Constraint, Range
from ...problems.text import short_repr
from ..constraint_kinds import BOUND, BOUNDARY, DEFECT, INTEGRAL, PATH, RESIDUAL, ConstraintKind
from ..layout import Family, Layout, Transcription, Unknown, places
from ..method_kind import no_delays
from ..schemes.mesh import Mesh
from ..schemes.shooting import shooting_scheme
from .simulation import nodes_of_path

MAX_TANGENTS = 200_000_000  # numbers, 1.6 GB: the derivatives of a segment are dense in its unknowns


@short_repr
@dataclass(frozen=True, eq=False)
class ConstraintRows:
    """The rows of one group of constraints, in the order of their times, and their common bounds."""

    name: str
    rows: np.ndarray
    bounds: Range


@short_repr
@dataclass(frozen=True, eq=False)
class PhaseRows:
    """The rows of a phase: defects (G, n) of each group of segments; g (G, P, n_g) and bounds of states (G, P - 1, n_b)
    at the points inside; g at the final point (n_g,); boundary and integral constraints. bounded: the states meant."""

    defects: list[np.ndarray]
    path: list[np.ndarray]
    bounds: list[np.ndarray]
    final: np.ndarray
    boundary: np.ndarray
    integral: np.ndarray
    bounded: list[int]


@short_repr
@dataclass(frozen=True)
class ShootingTranscription(Transcription):
    """What the nonlinear program of a shooting method is made from; it has no Pyomo model."""

    rows: tuple[PhaseRows, ...] = ()


def by_shooting(
    problem: Problem, meshes: Sequence[Mesh], guess: Sequence[Curves], templates: bool = True
) -> ShootingTranscription:
    """The program of shooting methods, as `transcribe.transcribe`.

    problem: one that `refused_by_shooting` says nothing against.
    meshes: one for each phase.
    guess: one for each phase.
    templates: must be true: there is no model to expand, and SpecError is raised.
    """
    if not templates:
        what = "a simulation has no equations to write down, so a shooting method cannot be exported"
        raise SpecError(Mistake("mesh", what, "export with another method, as --method hermite-simpson"))
    variables, phases, rows, families = [], [], [], []

    def place(bounds: Range, value: float) -> int:
        lower, upper = (b if isfinite(b) else None for b in (bounds.lower, bounds.upper))
        variables.append(Unknown(float(value), (lower, upper)))
        return len(variables) - 1

    for phase, mesh, start in zip(problem.phases, meshes, guess, strict=True):
        phases.append(_lay_out(phase, mesh, start, place))
    values = problem.start_of_parameters(guess)
    parameters = [place(p.bounds, values[p.name]) for p in problem.parameters]
    next_row = 0
    for phase, mesh in zip(problem.phases, meshes, strict=True):
        builder = _RowBuilder(phase, mesh, next_row)
        rows.append(builder.build())
        families += builder.families
        next_row = builder.next
    return ShootingTranscription(
        problem, None, tuple(variables), tuple(phases), np.array(parameters, int), tuple(families), tuple(rows)
    )


def path_constraints(phase: Phase) -> list[tuple[ConstraintKind, Constraint]]:
    """(kind, constraint) of all that holds over time."""
    return [(RESIDUAL, c) for c in phase.residuals] + [(PATH, c) for c in phase.path]


def refused_by_shooting(problem: Problem, phase: Phase, mesh: Mesh) -> Iterator[Mistake]:
    """Why a phase cannot be simulated on a mesh.

    problem: its static parameters are arguments of every simulation.
    phase: one with algebraic variables needs controls that are not constant on substeps.
    mesh: may not have more derivatives of stages than MAX_TANGENTS.
    """
    yield from no_delays(problem, mesh.schemes[0].name)
    n = len(phase.states) + len(phase.integral) + 1
    n_u, n_p = len(phase.inputs), len(problem.parameters)
    for group in mesh.groups:
        scheme = shooting_scheme(group.scheme)
        if phase.algebraic and scheme.control == "constant":
            name = phase.algebraic[0].name
            what = f"constant controls on substeps cannot follow algebraic variables such as '{name}'"
            yield Mistake("mesh.control", what, "write control: linear or quadratic")
        y = n + n_u * len(scheme.c) + n_p + 2
        size = len(group.segments) * scheme.substeps * len(scheme.table.b) * (2 * n + n_u + n_p + 2) * y
        if size > MAX_TANGENTS:
            count = len(group.segments)
            what = f"{scheme.substeps} substeps on {count} segments have {size} derivatives, more than trajopt takes"
            yield Mistake("mesh", what, "use more segments of fewer substeps each")


def _lay_out(phase: Phase, mesh: Mesh, guess: Curves, place: Callable[[Range, float], int]) -> Layout:
    """Number the unknowns of one phase, with their values from the guess."""
    knots, nodes = set(mesh.knots.tolist()), set(mesh.collocated.tolist())
    curves, last = guess.samples(mesh.fractions), len(mesh.fractions) - 1
    times = ((phase.initial_time, guess.initial_time), (phase.final_time, guess.final_time))

    def state(i: int, k: int) -> int:
        own = phase.states[i]
        bounds = {0: own.initial, last: own.final}.get(k, own.bounds)
        return place(bounds, curves[own.name][k]) if k in knots else -1

    def own_input(i: int, k: int) -> int:
        variable = phase.inputs[i]
        return place(variable.bounds, curves[variable.name][k]) if k in nodes else -1

    def time(end: int) -> int:
        bounds, value = times[end]
        return -1 if bounds.fixed else place(bounds, value)

    return Layout(phase, mesh, *places(phase, mesh, state, own_input, time))


class _RowBuilder:
    """Numbers the rows of one phase and tells what they are."""

    def __init__(self, phase: Phase, mesh: Mesh, first: int) -> None:
        self.phase, self.mesh, self.next = phase, mesh, first
        self.families: list[Family] = []
        self.bounded = [i for i, state in enumerate(phase.states) if state.bounds != Range()]
        self.weights = _point_weights(mesh)

    def build(self) -> PhaseRows:
        phase, groups = self.phase, self.mesh.groups
        over_time = path_constraints(phase)
        defects = [self._take(len(g.segments), len(phase.states)) for g in groups]
        inside = [g.nodes[:, nodes_of_path(shooting_scheme(g.scheme))] for g in groups]
        path = [self._take(*points.shape, len(over_time)) for points in inside]
        bounds = [self._take(len(points), points.shape[1] - 1, len(self.bounded)) for points in inside]
        ends = [self._take(len(c)) for c in (over_time, phase.boundary, phase.integral)]
        for number, (group, rows) in enumerate(zip(groups, defects, strict=True)):
            span = self.mesh.edges[group.segments], self.mesh.edges[group.segments + 1]
            for i, state in enumerate(phase.states):
                self._add(rows[:, i], DEFECT, state.name, Range(0.0, 0.0), span, group=number)
        for points, g, x in zip(inside, path, bounds, strict=True):
            for i, (kind, constraint) in enumerate(over_time):
                self._at(points, g[..., i], kind, constraint.name, constraint.bounds)
            for j, i in enumerate(self.bounded):
                self._at(points[:, 1:], x[..., j], BOUND, phase.states[i].name, phase.states[i].bounds)
        for i, (kind, constraint) in enumerate(over_time):
            self._at(self.mesh.knots[-1:], ends[0][[i]], kind, constraint.name, constraint.bounds)
        for kind, constraints, rows in zip(
            (BOUNDARY, INTEGRAL), (phase.boundary, phase.integral), ends[1:], strict=True
        ):
            for i, constraint in enumerate(constraints):
                self._add(rows[[i]], kind, constraint.name, constraint.bounds, (0.0, 1.0))
        final, boundary, integral = ends
        return PhaseRows(defects, path, bounds, final, boundary, integral, self.bounded)

    def _take(self, *shape: int) -> np.ndarray:
        rows = self.next + np.arange(prod(shape)).reshape(shape)
        self.next += rows.size
        return rows

    def _at(self, points: np.ndarray, rows: np.ndarray, kind: ConstraintKind, name: str, bounds: Range) -> None:
        times = self.mesh.fractions[points.ravel()]
        self._add(rows.ravel(), kind, name, bounds, (times, times), self.weights[points.ravel()])

    def _add(
        self,
        rows: np.ndarray,
        kind: ConstraintKind,
        name: str,
        bounds: Range,
        span: Any,
        weights: np.ndarray | float = 1.0,
        group: int = 0,
    ) -> None:
        if rows.size:
            span = np.atleast_2d(np.transpose(span))
            component = ConstraintRows(f"{kind} {name}", rows, bounds)
            weights = np.broadcast_to(weights, len(span))
            self.families.append(Family(component, self.phase.name, kind, name, span, weights, group))


def _point_weights(mesh: Mesh) -> np.ndarray:
    """Composite quadrature weights of the points at which path constraints hold, shape (K,)."""
    weights = np.zeros(len(mesh.fractions))
    for group in mesh.groups:
        scheme = shooting_scheme(group.scheme)
        local = [1 / 6, 4 / 6, 1 / 6] if scheme.control == "quadratic" else [1 / 2, 1 / 2]
        points = np.append(nodes_of_path(scheme), len(scheme.sigma) - 1)
        for w, first in zip(local, range(len(local)), strict=True):
            at = group.nodes[:, points[first :: len(local) - 1]][:, : scheme.substeps]
            weights += w * np.bincount(
                at.ravel(),
                np.repeat(mesh.widths[group.segments] / scheme.substeps, scheme.substeps),
                len(weights),
            )
    return weights
