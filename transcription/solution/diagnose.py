"""A failed solve in the user's terms: which constraint, which expression, which phase, when, by how much."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import symengine as se

from ...problems.problem import Function, Phase, Variable
from ...problems.text import shorten
from ..constraint_kinds import BOUNDARY, INTEGRAL, PATH, RESIDUAL, ConstraintKind
from ..engines.outcome import Outcome, Status
from ..layout import Family, Layout, Transcription
from ..program.contract import NonlinearProgram
from .trajectory import Trajectory, trajectories

LISTED = 6
NEGLIGIBLE = 1e-7  # IPOPT itself lets constraints be missed by 1e-8
ACTIVE = 1e-4  # of the largest multiplier: smaller ones are what the barrier leaves on constraints that do not act
RUNAWAY = 1e10  # no unit makes an honest state or control as large

BROKEN = (Status.INVALID_NUMBER, Status.STEP_FAILED, Status.RESTORATION_FAILED, Status.STALLED, Status.FAILED)
"""Statuses that a function without a finite value explains, if there was one at the end."""


@dataclass(frozen=True)
class Violation:
    """A constraint that an iterate violates by `amount`, between the times `start` and `end`."""

    phase: str
    kind: ConstraintKind
    name: str
    start: float
    end: float
    amount: float

    def __str__(self) -> str:
        when = _when(self.start, self.end) if self.kind.timed else ""
        return f"{_what(self.phase, self.kind, self.name)}{when} missed by {self.amount:.2e}"


NEVER_RAN = (Status.INVALID_OPTION, Status.INVALID_PROBLEM, Status.NO_MEMORY)
"""What the guess violates is no reason for these."""


def diagnose(
    transcription: Transcription, nlp: NonlinearProgram, outcome: Outcome
) -> tuple[tuple[Violation, ...], str]:
    """The constraints that the last iterate violates, worst first, and what explains the failure, or "".

    transcription: says what each row and each unknown is in the user's terms.
    nlp: its compiled program.
    outcome: of a solve; one that is solved, or in which the engine never ran, has nothing to explain.
    """
    if outcome.status in (Status.SOLVED, Status.FEASIBLE, *NEVER_RAN):
        return (), ""
    if outcome.status is Status.INVALID_NUMBER:  # the guess violates much, and that is not why
        return (), explain_non_finite(transcription, outcome.failed)
    found = tuple(violations(transcription, nlp, outcome.z))
    if outcome.failed and outcome.status in BROKEN:
        return found, explain_non_finite(transcription, outcome.failed)
    if outcome.status is Status.INFEASIBLE:
        return found, _conflict(transcription, nlp, outcome)
    if outcome.status is Status.OVERDETERMINED:
        return found, _count(transcription, nlp)
    return found, _runaway(transcription, outcome)


def violations(transcription: Transcription, nlp: NonlinearProgram, z: np.ndarray) -> list[Violation]:
    """The largest violation of each constraint, worst first; without those that do not matter.

    transcription: says what each row is in the user's terms.
    nlp: its compiled program.
    z: values of the unknowns, shape (n,); a constraint without a finite value there counts as infinitely violated.
    """
    g = nlp.constraints_unchecked(z)
    excess = np.maximum(np.maximum(nlp.cl - g, g - nlp.cu), 0.0)
    excess[np.isnan(excess)] = np.inf
    phases = {trajectory.phase.name: trajectory for trajectory in trajectories(transcription, z)}
    worst: dict[tuple, Violation] = {}
    for family in transcription.families:
        violation = _worst(family, excess[family.rows(nlp)], phases[family.phase])
        key = family.phase, family.kind, family.name
        worst[key] = max(worst.get(key, violation), violation, key=lambda v: v.amount)
    large = max((v.amount for v in worst.values()), default=0.0) * ACTIVE
    telling = (v for v in worst.values() if v.amount > max(large, NEGLIGIBLE))
    return sorted(telling, key=lambda v: -v.amount)[:LISTED]


def _worst(family: Family, excess: np.ndarray, trajectory: Trajectory) -> Violation:
    i = int(np.argmax(excess))
    start, end = _times(trajectory, family.span[i])
    return Violation(family.phase, family.kind, family.name, start, end, float(excess[i]))


def _times(trajectory: Trajectory, s: np.ndarray) -> list[float]:
    return (trajectory.t[0] + (trajectory.t[1] - trajectory.t[0]) * s).tolist()


def _when(start: float, end: float) -> str:
    return f" at t = {start:.6g}" if start == end else f" between t = {start:.6g} and {end:.6g}"


def _what(phase: str, kind: ConstraintKind, name: str) -> str:
    """A constraint by its name; the phase is told where the file has phases."""
    return kind.phrase.format(name) + ("" if phase == "main" else f" of phase {phase}")


# -- constraints that contradict each other ------------------------------------------------------------------------


def _conflict(transcription: Transcription, nlp: NonlinearProgram, outcome: Outcome) -> str:
    """Which constraints stand in each other's way at a point of least infeasibility.

    There IPOPT's multipliers are those of its restoration phase, which minimises the sum of all violations: zero for
    whatever could be dropped without making the point less infeasible.
    """
    phases = {trajectory.phase.name: trajectory for trajectory in trajectories(transcription, outcome.z)}
    limit = ACTIVE * np.abs(outcome.y).max(initial=0.0)
    parts = list(_constraints_in_conflict(transcription, nlp, outcome, phases, limit=limit))
    for layout in transcription.phases:
        parts += _bounds_in_conflict(layout, outcome, phases[layout.phase.name], limit)
    if not parts or not limit:
        return ""
    more = [f"and {len(parts) - LISTED} more"] if len(parts) > LISTED else []
    return f"these cannot all hold: {', '.join([*parts[:LISTED], *more])}"


def _constraints_in_conflict(
    transcription: Transcription,
    nlp: NonlinearProgram,
    outcome: Outcome,
    phases: Mapping[str, Trajectory],
    *,
    limit: float,
) -> Iterator[str]:
    constraints: dict[tuple[str, ConstraintKind, str], list[Family]] = {}
    for family in transcription.families:
        if not family.kind.model:
            constraints.setdefault((family.phase, family.kind, family.name), []).append(family)
    for key, same in constraints.items():
        acting = [f.span[np.abs(outcome.y[f.rows(nlp)]) / f.weights > limit] for f in same]
        s = np.concatenate(acting).ravel()
        if len(s):
            phase, kind, _ = key
            yield _what(*key) + (_when(*_times(phases[phase], np.array([s.min(), s.max()]))) if kind.timed else "")


def _bounds_in_conflict(layout: Layout, outcome: Outcome, trajectory: Trajectory, limit: float) -> Iterator[str]:
    """Bounds of states and inputs that act over time, then values at the ends."""
    phase, mesh, ends = layout.phase, layout.mesh, []
    variables = (*phase.states, *phase.inputs)
    for variable, places in zip(variables, (*layout.x, *layout.u), strict=True):
        sides = np.where(places >= 0, np.abs([outcome.z_lower[places], outcome.z_upper[places]]), 0.0)
        if variable in phase.states:
            fixed = sides[:, [0, -1]].max(axis=0) > limit
            ends += [f"the {end} value of {variable.name}" for end in np.array(["initial", "final"])[fixed]]
            sides[:, [0, -1]] = 0.0
        for side, force in zip(("lower", "upper"), sides, strict=True):
            s = mesh.fractions[force / mesh.weights > limit]
            if len(s):
                yield f"the {side} bound of {variable.name}{_when(*_times(trajectory, s[[0, -1]]))}"
    yield from ends


def _count(transcription: Transcription, nlp: NonlinearProgram) -> str:
    """How many equalities there are, of which kind, and how many unknowns."""
    ranges = [variable.bounds for variable in transcription.variables]
    free = sum(lower is None or lower != upper for lower, upper in ranges)
    counts: dict[str, int] = {}
    for family in transcription.families:
        rows = family.rows(nlp)
        what = _what(family.phase, family.kind, family.name)
        counts[what] = counts.get(what, 0) + int((nlp.cl[rows] == nlp.cu[rows]).sum())
    parts = [f"{count} from {what}" for what, count in counts.items() if count]
    return f"{sum(counts.values())} equations for {free} unknowns: {', '.join(parts)}"


def _runaway(transcription: Transcription, outcome: Outcome) -> str:
    """The largest value, if it is so large that the problem cannot be meant so."""
    found = []
    for trajectory in trajectories(transcription, outcome.z):
        names = [v.name for v in (*trajectory.phase.states, *trajectory.phase.inputs)]
        for name, values in zip(names, np.nan_to_num(np.vstack([trajectory.x, trajectory.u])), strict=True):
            k = int(np.argmax(np.abs(values)))
            found.append((abs(values[k]), f"{name} runs to {values[k]:.3g} at t = {trajectory.times[k]:.6g}"))
    size, text = max(found)
    return f"{text}: give it bounds, or check the sign of the objective" if size > RUNAWAY else ""


# -- functions without a finite value -----------------------------------------------------------------------------


def explain_non_finite(transcription: Transcription, failed: tuple | None) -> str:
    """Say which expression, or which derivative of it, has no finite value, at which time and with which values.

    failed: (z, [(component name, index), ...]) as in `outcome.Outcome`.
    """
    if not failed:
        return ""
    for explain in (_value_fault, _derivative_fault):
        for trajectory in trajectories(transcription, failed[0]):
            for owner, function, at_ends in _functions(trajectory.phase):
                values = _end_values(trajectory) if at_ends else _point_values(trajectory)
                if found := explain(function, values, trajectory.phase):
                    what, i, there = found
                    time = "" if at_ends else f" at t = {values['t'][i]:.6g}"
                    return f"{owner}: {what}{time}{_where(there)}{_relaxed(trajectory.phase, there)}"
    name, index = failed[1][0]
    return f"a derivative has no finite value in {name}" + ("" if index is None else f", index {index}")


def _value_fault(function: Function, values: dict, _: Phase) -> tuple[str, int, dict] | None:
    """(what, index, values there) of the innermost sub-expression that is not finite."""
    fault = getattr(function, "fault", lambda values: None)(values)
    return fault and (f'"{shorten(fault.text)}" {fault.why}', fault.at, fault.values)


def _derivative_fault(function: Function, values: dict, phase: Phase) -> tuple[str, int, dict] | None:
    """The same for its first or second derivatives, which IPOPT needs as well."""
    symbols = {name: se.Symbol(name) for name in values}
    expression = se.sympify(function(symbols, se))
    names = [name for name, symbol in symbols.items() if symbol in expression.free_symbols]
    times = ("t", "t[initial]", "t[final]") if phase.initial_time.fixed and phase.final_time.fixed else ()
    unknowns = [name for name in names if name not in times]
    if not unknowns:
        return None
    first = [expression.diff(symbols[name]) for name in unknowns]
    second = [slope.diff(symbols[name]) for slope in first for name in unknowns]
    points = np.stack(np.broadcast_arrays(*(np.asarray(values[name], float) for name in names)), axis=-1)
    for order, derivatives in (("derivative", first), ("second derivative", second)):
        numbers = se.Lambdify([symbols[name] for name in names], derivatives)(points).reshape(len(points), -1)
        bad = np.argwhere(~np.isfinite(numbers))
        if len(bad):
            i, j = bad[0].tolist()
            text = shorten(getattr(function, "text", "this function"))
            what = f'the {order} of "{text}" by {unknowns[j % len(unknowns)]} is not finite'
            return what, i, dict(zip(names, points[i].tolist(), strict=True))
    return None


def _where(values: dict[str, float]) -> str:
    parts = [f"{name} = {value:.6g}" for name, value in values.items() if name != "t"][:LISTED]
    return f", where {', '.join(parts)}" if parts else ""


def _relaxed(phase: Phase, values: dict[str, float]) -> str:
    """A hint where IPOPT has left the bounds a little, as it does unless it is told not to."""
    variables: tuple[Variable, ...] = (*phase.states, *phase.inputs)
    left = [v.name for v in variables if v.name in values and v.bounds.clip(values[v.name]) != values[v.name]]
    if not left:
        return ""
    return f" (IPOPT leaves bounds by 1e-8 unless 'solver: {{bound_relax_factor: 0}}' forbids it for {left[0]})"


def _functions(phase: Phase) -> Iterator[tuple]:
    """(whose, function, whether it is one of the boundary values) for every function of the phase."""
    yield from ((f"rate of {state.name}", state.rate, False) for state in phase.states)
    if phase.lagrange:
        yield "integral objective", phase.lagrange, False
    for kind, constraints in ((RESIDUAL, phase.residuals), (PATH, phase.path), (INTEGRAL, phase.integral)):
        yield from ((_what(phase.name, kind, c.name), c.function, False) for c in constraints)
    if phase.mayer:
        yield "terminal objective", phase.mayer, True
    yield from ((_what(phase.name, BOUNDARY, c.name), c.function, True) for c in phase.boundary)


def _point_values(trajectory: Trajectory) -> dict:
    """Names -> values at the collocation points; without those where a computed state has no value for itself."""
    points = trajectory.mesh.collocated
    points = points[np.isfinite(np.vstack([trajectory.x, trajectory.u])[:, points]).all(axis=0)]
    x, u = trajectory.x[:, points], trajectory.u[:, points]
    return trajectory.phase.arguments(trajectory.times[points], x, u, trajectory.parameters)


def _end_values(trajectory: Trajectory) -> dict:
    """Names such as "q1[final]" -> values, shape (1,)."""
    rows = trajectory.phase.arguments(trajectory.times, trajectory.x, trajectory.u, {})
    ends = {
        f"{name}[{end}]": values[[k]]
        for name, values in rows.items()
        for end, k in (("initial", 0), ("final", -1))
        if np.isfinite(values[k])  # what is not known at an end is passed over
    }
    return {**ends, **trajectory.parameters}
