"""Functions without a finite value: which expression, or which derivative of it, at which time, with which values."""

from __future__ import annotations

from collections.abc import Collection, Iterator

import numpy as np

from ...problems.probe import names_asked
from ...problems.problem import Phase, Problem
from ...problems.quantities import Function, Variable
from ...problems.text import shorten
from ..constraint_kinds import BOUNDARY, CONDITION, INTEGRAL, PATH, RESIDUAL, kind_between
from ..engines.ipopt import MOST_RELAXED
from ..layout import BETWEEN, Transcription
from ..program.pointwise import PointFunctions
from ..solution.trajectory import Trajectory, trajectories
from ..solution.violation import constraint_named

LISTED = 6  # values at the place


def explain_non_finite(transcription: Transcription, failed: tuple | None) -> str:
    """Say which expression, or which derivative of it, has no finite value, at which time and with which values.

    failed: (z, [(component name, index), ...]) as in `outcome.Outcome`.
    """
    if not failed:
        return ""
    read = trajectories(transcription, failed[0])
    ends = {f"{own.phase.name}.{name}": value for own in read for name, value in _end_values(own).items()}
    given = {f"{own.phase.name}.{name}" for own in read for name in _given_times(own.phase)}
    for explain in (_value_fault, _derivative_fault):
        for trajectory in read:
            phase = trajectory.phase
            for owner, function, at_ends in _functions(phase):
                values = _end_values(trajectory) if at_ends else _point_values(trajectory)
                if not at_ends and not len(values["t"]):
                    continue  # no point has finite values
                if found := explain(function, values, _given_times(phase)):
                    what, i, there = found
                    time = "" if at_ends else f" at t = {values['t'][i]:.6g}"
                    return f"{owner}: {what}{time}{_where(there)}{_relaxed(phase, there)}"
        for owner, function in _functions_between(transcription.problem):
            if found := explain(function, {**ends, **read[0].parameters}, given):
                return f"{owner}: {found[0]}{_where(found[2])}"
    name, index = failed[1][0]
    return f"a function or a derivative has no finite value in {name}" + ("" if index is None else f", index {index}")


def _given_times(phase: Phase) -> Collection[str]:
    """The names of the times of a phase, where they are no unknowns."""
    return ("t", "t[initial]", "t[final]") if phase.initial_time.fixed and phase.final_time.fixed else ()


def _value_fault(function: Function, values: dict, _: Collection[str]) -> tuple[str, int, dict] | None:
    """(what, index, values there) of the innermost sub-expression that is not finite."""
    fault = getattr(function, "fault", lambda values: None)(values)
    return fault and (f'"{shorten(fault.text)}" {fault.why}', fault.at, fault.values)


def _derivative_fault(function: Function, values: dict, given: Collection[str]) -> tuple[str, int, dict] | None:
    """The same for its first or second derivatives, which IPOPT needs as well; given: names that are no unknowns."""
    data = [name for name in values if name in given]
    unknowns = [name for name in values if name not in given]
    compiled = PointFunctions([function], unknowns, data, dict.fromkeys(("differentiate", "compile"), 0.0))
    names = (*unknowns, *data)
    points = np.stack(np.broadcast_arrays(*(np.asarray(values[name], float) for name in names)), axis=-1)
    first, second = compiled.jacobian(points), compiled.hessian(points, np.ones((len(points), 1)))
    asked = names_asked(function)
    for order, numbers in (("derivative", first), ("second derivative", second)):
        bad = np.argwhere(~np.isfinite(numbers))
        if len(bad):
            i, *_, j = bad[0].tolist()
            text = shorten(getattr(function, "text", "this function"))
            what = f'the {order} of "{text}" by {unknowns[j]} is not finite'
            there = zip(names, points[i].tolist(), strict=True)
            return what, i, {name: value for name, value in there if name in asked}
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
    leaves = f"IPOPT leaves bounds by up to {MOST_RELAXED:.0e} of 1 + their size"
    return f" ({leaves} unless 'solver: {{bound_relax_factor: 0}}' forbids it for {left[0]})"


def _functions(phase: Phase) -> Iterator[tuple]:
    """(whose, function, whether it is one of the boundary values) for every function of the phase."""
    yield from ((f"rate of {state.name}", state.rate, False) for state in phase.states)
    if phase.lagrange:
        yield "integral objective", phase.lagrange, False
    for kind, constraints in ((RESIDUAL, phase.residuals), (PATH, phase.path), (INTEGRAL, phase.integral)):
        yield from ((constraint_named(phase.name, kind, c.name), c.function, False) for c in constraints)
    if phase.mayer:
        yield "terminal objective", phase.mayer, True
    kind = CONDITION if phase.static else BOUNDARY
    yield from ((constraint_named(phase.name, kind, c.name), c.function, True) for c in phase.boundary)


def _functions_between(problem: Problem) -> Iterator[tuple[str, Function]]:
    """(whose, function) of all that asks for the ends of several phases."""
    yield from ((constraint_named(BETWEEN, kind_between(own), own.name), own.function) for own in problem.links)
    if problem.mayer:
        yield "terminal objective", problem.mayer


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
