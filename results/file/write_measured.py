"""Measurements in a result file, beside the solution there; the estimated parameters, and the sensitivities."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from .arrays import array_of, group_of, scale_of, tell, texts

if TYPE_CHECKING:
    from ...problems.problem import Problem
    from ...transcription.measured.estimated import Estimates
    from ...transcription.solution.sensitivity import Sensitivities
    from ...transcription.solution.trajectory import Trajectory


def write_measured(group: h5py.Group, trajectory: Trajectory) -> None:
    """Write the measurements of a phase, quantity by quantity.

    group: of the measurements of the phase, empty.
    trajectory: the solved phase.
    """
    phase = trajectory.phase
    states = [state.name for state in phase.states]

    def values(t: np.ndarray) -> dict[str, Any]:
        x = trajectory.at(phase.fractions_of(t)).x
        return {"t": t, **dict(zip(states, x, strict=True)), **trajectory.parameters}

    for own in phase.measured:
        with np.errstate(all="ignore"):
            model = own.along(values)
        one = group_of(group, own.name)
        number = scale_of(one, "measurement", np.arange(len(own.times)), "number of the measurement")
        array_of(one, "time", own.times, [number], "time of the measurement", unit=phase.time_unit)
        array_of(one, "value", own.values, [number], f"measured {own.column}", unit=own.unit)
        known = "standard deviation" if own.exact else "standard deviation, up to a factor that all have"
        array_of(one, "deviation", own.deviations, [number], known, unit=own.unit)
        array_of(one, "model", model, [number], f"{own.expression} of the solution", unit=own.unit)
        tell(one, {"expression": own.expression})


def write_estimates(group: h5py.Group, problem: Problem, found: Estimates) -> None:
    """Write estimated parameters and how exact they are.

    group: empty.
    problem: says the units of the parameters.
    found: of the solution.
    """
    names = scale_of(group, "parameter", list(found.names), "estimated parameter")
    array_of(group, "value", found.values, [names], "estimate")
    array_of(group, "standard_error", found.deviations, [names], "standard error; none for a parameter on its bound")
    other = scale_of(group, "other", list(found.names), "estimated parameter")
    array_of(group, "correlation", found.correlation, [names, other], "correlation of the estimates")
    tell(
        group,
        {
            "residuals": found.residuals,
            "measurements": found.measurements,
            "free": found.free,
            "scale": found.scale,
            "given": found.given,
            "missing": found.why_not,
        },
    )


def write_sensitivities(group: h5py.Group, found: Sensitivities) -> None:
    """Write what the objective changes by with the numbers of the file.

    group: empty.
    found: path by path.
    """
    tell(group, {"missing": found.why_not})
    number = scale_of(group, "number", texts(own.path for own in found.all), "number of the problem file, by its path")
    for name, long_name in (("value", "the number"), ("derivative", "derivative of the objective by the number")):
        array_of(group, name, [getattr(own, name) for own in found.all], [number], long_name)
    for name, long_name in (("unit", "unit of the number"), ("note", "why there is no derivative, or what to know")):
        array_of(group, name, texts(getattr(own, name) for own in found.all), [number], long_name)
