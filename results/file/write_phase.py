"""One phase of a result file: its curves, its error, its optimised parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import h5py
import numpy as np

from .arrays import array_of, dimension_of, group_of, scale_of, tell, texts
from .write_measured import write_measured

if TYPE_CHECKING:
    from ...problems.problem import Phase, Problem
    from ...problems.quantities import Variable
    from ...transcription.arcs import Course
    from ...transcription.solution.error import ErrorProfile
    from ...transcription.solution.solution import Solution
    from ...transcription.solution.trajectory import Trajectory


def write_phase(group: h5py.Group, solution: Solution, number: int) -> None:
    """Write all of one phase.

    group: of the phase, empty.
    solution: solved or not.
    number: of the phase, from 0.
    """
    trajectory, objective = solution.trajectories[number], solution.objective_error
    _write_trajectory(group, trajectory, solution.errors[number])
    if objective.applies:
        long_name = "part of objective_error, in the objective's unit"
        array_of(group["error"], "objective", objective.shares[number], [group["error/segment"]], long_name)
    _write_parameters(group_of(group, "parameter"), solution.problem, trajectory.parameters)
    if solution.prices and solution.prices[number]:
        write_prices(group_of(group, "price"), solution.prices[number])
    if solution.arcs and solution.arcs[number]:
        _write_arcs(group_of(group, "arcs"), solution.arcs[number], trajectory.phase.time_unit)
    _write_exactness(group_of(group, "complementarity"), trajectory)
    if trajectory.phase.measured:
        write_measured(group_of(group, "measured"), trajectory)


def _write_trajectory(group: h5py.Group, trajectory: Trajectory, error: ErrorProfile) -> None:
    """The curves of one phase at the points and on the dense grid, and its errors by segment.

    group: of the phase, empty.
    trajectory: the solved phase; without costates none are written.
    error: of the trajectory.
    """
    phase, sample, p = trajectory.phase, trajectory.dense, trajectory.parameters
    knot = dimension_of(group, "knot", len(trajectory.knots))
    array_of(group, "knots", trajectory.knots, [knot], "time of the segments' edges", unit=phase.time_unit)
    points, dense, errors = (group_of(group, name) for name in ("points", "dense", "error"))
    costate = None if trajectory.costate is None else trajectory.point_costate
    _write_curves(points, phase, t=trajectory.times, x=trajectory.x, u=trajectory.u, costate=costate, parameters=p)
    time = _write_curves(dense, phase, t=sample.t, x=sample.x, u=sample.u, costate=sample.costate, parameters=p)
    profiles = group_of(dense, "epsilon")
    for state, epsilon in zip(phase.states, error.epsilon, strict=True):
        unit = f"{state.unit or '1'}/{phase.time_unit}"
        array_of(profiles, state.name, epsilon, [time], f"d{state.name}/dt - f between collocation points", unit=unit)
    segment = scale_of(errors, "segment", np.arange(trajectory.mesh.segments), "index of the segment, from 0")
    names = scale_of(errors, "state", texts(state.name for state in phase.states), "state")
    array_of(errors, "eta", error.eta.T, [segment, names], "integral of |epsilon| over a segment, in the state's unit")
    array_of(
        errors, "relative", error.relative, [segment], "largest eta relative to 1 + size of the state, or of integrals"
    )
    array_of(
        errors,
        "excess",
        error.largest_excess,
        [segment],
        "largest excess of bounds and path constraints over 1 + bound",
    )
    if worst := error.overshoot:
        told = {
            "name": worst.name,
            "amount": worst.amount,
            "unit": worst.unit,
            "time": worst.time,
            "share": worst.share,
            "lasts": worst.lasts,
        }
        tell(errors, {f"overshoot_{key}": value for key, value in told.items()})


def _write_parameters(group: h5py.Group, problem: Problem, values: Mapping[str, float]) -> None:
    """The values of the static parameters, each with its unit.

    group: of the parameters of one phase, empty.
    problem: says which parameters there are, and their units.
    values: name of each parameter -> its value.
    """
    for parameter in problem.parameters:
        array_of(group, parameter.name, values[parameter.name], [], f"parameter {parameter.name}", unit=parameter.unit)


def write_prices(group: h5py.Group, prices: Mapping[str, float]) -> None:
    """Write what constraints that hold once are worth, of one phase or between phases.

    group: of these prices, empty.
    prices: name -> dJ/d(bound), in objective per unit of the constraint.
    """
    for name, value in prices.items():
        array_of(group, name, value, [], f"change of the objective with the bound of {name}")


def _write_arcs(group: h5py.Group, arcs: Sequence[Course], unit: str) -> None:
    """When each bounded control, state and path constraint is on which bound: a row for each arc.

    group: of the arcs of one phase, empty.
    arcs: of the phase, of at least one quantity.
    unit: of time.
    """
    rows = [(course, arc) for course in arcs for arc in course.arcs]
    number = scale_of(group, "arc", np.arange(len(rows)), "number of the arc, from 0")
    for name, long_name in (("start", "time at which it starts"), ("end", "time at which it ends")):
        array_of(group, name, [getattr(arc, name) for _, arc in rows], [number], long_name, unit=unit)
    array_of(group, "bound", [course.bound(arc) for course, arc in rows], [number], "the bound, NaN inside of both")
    array_of(group, "name", texts(course.name for course, _ in rows), [number], "what it is an arc of")
    array_of(group, "kind", texts(course.kind for course, _ in rows), [number], "control, state or path")
    array_of(group, "on", texts(arc.on for _, arc in rows), [number], "lower, upper or inside")
    array_of(group, "by", texts(arc.by for _, arc in rows), [number], "what determines a control inside its bounds")


def _write_exactness(group: h5py.Group, trajectory: Trajectory) -> None:
    """How far both of each pair, of which one must be zero, are above it at the points that the solver holds.

    group: of the pairs of one phase, empty.
    trajectory: of the phase.
    """
    from ...transcription.solution.error import exactness

    for pair, product, time in exactness(trajectory):
        own = group_of(group, pair.name)
        array_of(own, "product", product, [], f"largest a*b of {pair.name} at the points of the mesh")
        array_of(own, "time", time, [], "time at which it is", unit=trajectory.phase.time_unit)
        array_of(own, "allowed", pair.allowed, [], "what the solver was allowed")


def _write_curves(
    group: h5py.Group,
    phase: Phase,
    *,
    t: np.ndarray,
    x: np.ndarray,
    u: np.ndarray,
    costate: np.ndarray | None,
    parameters: Mapping[str, float],
) -> h5py.Dataset:
    """The scale of times t, shape (K,), and all curves over it: x (n_x, K), u (n_u, K), costate (n_x, K) or none."""
    time = scale_of(group, "time", t, "time", phase.time_unit)
    n = len(phase.controls)
    _write_kind(group, "state", phase.states, x, time)
    _write_kind(group, "control", phase.controls, u[:n], time)
    _write_kind(group, "algebraic", phase.inputs[n:], u[n:], time)
    _write_functions(group, phase, phase.arguments(t, x, u, parameters), time)
    duals = group_of(group, "costate")  # no unit: the objective has none to begin with
    for state, values in zip(phase.states, () if costate is None else costate, strict=costate is not None):
        array_of(duals, state.name, values, [time], f"costate of {state.name}: objective per unit of {state.name}")
    return time


def _write_functions(group: h5py.Group, phase: Phase, values: Mapping[str, np.ndarray], time: h5py.Dataset) -> None:
    groups = {kind: group_of(group, kind) for kind in ("output", "path")}
    for kind, name, curve, unit in functions_over(phase, values, time.shape):
        title = f"output {name}" if kind == "output" else f"path constraint {name}"
        array_of(groups[kind], name, curve, [time], title, unit=unit)


def functions_over(
    phase: Phase, values: Mapping[str, np.ndarray], shape: tuple[int, ...]
) -> Iterator[tuple[str, str, np.ndarray, str]]:
    """Outputs, and path constraints over time; not those that are equations, or bounds of one name that is there.

    phase: says which.
    values: of its arguments, each (K,).
    shape: (K,).

    Yields "output" or "path", the name, the values (K,) and the unit.
    """
    with np.errstate(all="ignore"):
        for name, output in phase.outputs.items():
            yield "output", name, np.broadcast_to(output.function(values, np), shape), output.unit
        for constraint in phase.path:
            if not constraint.bounds.fixed and getattr(constraint.function, "text", "") not in values:
                yield "path", constraint.name, np.broadcast_to(constraint.function(values, np), shape), ""


def _write_kind(
    group: h5py.Group, kind: str, variables: Sequence[Variable], rows: np.ndarray, time: h5py.Dataset
) -> None:
    curves = group_of(group, kind)
    for variable, values in zip(variables, rows, strict=True):
        array_of(curves, variable.name, values, [time], f"{kind} {variable.name}", unit=variable.unit)
