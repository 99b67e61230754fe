"""One phase made several: the arcs of a solution, each with its own time, and what is on a bound fixed there.

What a file of one phase says at its top level means the same with phases (see `merge`): ends and the terminal objective
are those of the whole trajectory; the integral of the objective counts in every phase. Path constraints are written
into each phase, as one that is active holds with equality there. An integral constraint is of one phase alone, so that
it becomes a state, with the integrand as its rate.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import Any

from pydantic import BaseModel

from ..expressions.smooth import SLACK
from ..lean.records import dataclass
from ..names.occurrences import HISTORY, TRAJECTORY, constraint_names, constraints, uses
from ..names.variables import free_name
from ..schema.declarations import TimeEnd
from ..schema.spec import Spec
from .merge import phases_as_written

OF_TIMES = re.compile(r"\bt\[(initial|final|duration)\]")


@dataclass(frozen=True)
class PhasePart:
    """One arc: when it ends, in the unit of time, and what is on which bound, "lower" or "upper", in all of it.

    fixed: controls. held: states, and path constraints by name, that hold with equality. freed: states that are on a
    bound because of controls that are fixed -> which bound, and a number beyond it to take its place: the bound itself
    would have a multiplier that nothing determines.
    """

    end: float
    fixed: Mapping[str, str] = field(default_factory=dict)
    held: Mapping[str, str] = field(default_factory=dict)
    freed: Mapping[str, tuple[str, float]] = field(default_factory=dict)


def why_not(spec: Spec) -> str:
    """Why a problem cannot be split into phases, or into more of them; "" if it can."""
    phases = phases_as_written(spec).values()
    if has_slack(spec) and len(phases) > 1:
        return "abs, min and max have slack variables in it, which are of one phase"
    return next(filter(None, map(_why_not, phases)), "")


def has_slack(spec: Spec) -> bool:
    """Whether a file has slack variables in place of abs, min and max."""
    return spec.nonsmooth is not None and spec.nonsmooth.treatment == SLACK


def _why_not(spec: Spec) -> str:
    """The same of one phase."""
    own = list(uses(spec))
    reasons = {
        "it has no continuous time": spec.static or spec.discrete,
        "one of two things is zero in it (complementarity), which has no smooth arcs": spec.complementarity,
        "states at earlier times are of one phase": any(use.context == HISTORY for use in own),
        "measurements are of one phase": spec.measurements,
        "its equations depend on t[initial], t[final] or t[duration], which would be those of a phase": any(
            use.context == TRAJECTORY and OF_TIMES.search(use.expression.text) for use in own
        ),
        "its equations depend on an integral so far, which begins anew in every phase": any(
            use.context == TRAJECTORY and any(leaf.name in spec.integrals for leaf in use.expression.leaves)
            for use in own
        ),
    }
    return next((why for why, so in reasons.items() if so), "")


def split_alone(spec: Spec, parts: Sequence[PhasePart]) -> dict[str, Any]:
    """A problem file in which every part is a phase, as data without a mesh.

    spec: of one phase, see `why_not`.
    parts: in order, two or more.
    """
    data = plain_file(spec)
    for state, (rate, bounds) in integral_states(spec).items():
        data["states"][state] = {"rate": rate, "initial": 0, "final": bounds}
    for kind in ("integral", "path"):
        data.get("constraints", {}).pop(kind, [])
    named = named_paths(spec)
    phases = {f"arc{number}": arc(spec, part, named) for number, part in enumerate(parts, start=1)}
    for own, part in zip(list(phases.values())[:-1], parts, strict=False):
        own["time"] = {"final": bounds_of_time(spec) | {"guess": part.end}}
    final = data["time"].get("final")
    if isinstance(final, dict) and "value" not in final:
        final["guess"] = parts[-1].end
    return data | {"phases": phases}


def named_paths(spec: Spec) -> dict[str, dict[str, Any]]:
    """The path constraints of a phase as data, by name; spec: of the phase."""
    path = _entries(spec, "path")
    return {name: {**entry, "name": name} for name, entry in zip(_names(spec, "path"), path, strict=True)}


def bounds_of_time(spec: Spec) -> dict[str, str]:
    """Between which times a phase is, as the file writes them, as far as they have bounds; spec: of the phase."""
    ends = {"lower": _end(spec.time.initial, "lower"), "upper": _end(spec.time.final, "upper")}
    return {key: value for key, value in ends.items() if value is not None}


def arc(spec: Spec, part: PhasePart, constraints: Mapping[str, dict[str, Any]]) -> dict[str, Any]:
    """What an arc has of its own.

    spec: of the phase that it is a part of.
    part: of it.
    constraints: its path constraints, as of `named_paths`.
    """
    states: dict[str, dict[str, Any]] = {
        name: {on: beyond} for name, (on, beyond) in part.freed.items() if name in spec.states
    }
    path, resting = [], []
    for name, entry in constraints.items():
        on, expression = part.held.get(name), entry["expression"].strip()
        if on is not None and expression in spec.states:
            states[expression] = _fixed(entry[on])
            resting.append(expression)
        elif on is not None:
            path.append({"name": name, "expression": expression, "equals": entry[on]})
        else:
            path.append(dict(entry))
    for name, on in part.held.items():
        if name in spec.states and (bound := getattr(spec.states[name], on)) is not None:
            states[name] = _fixed(bound.text)
            resting.append(name)
    controls = {name: _fixed(getattr(spec.controls[name], on).text) for name, on in part.fixed.items()}
    boundary = [entry for name in resting for entry in _at_rest(spec, name)]
    constraints = filled({"path": path, "boundary": boundary})
    return filled({"controls": controls, "states": states, "constraints": constraints})


def plain_file(spec: Spec) -> dict[str, Any]:
    """The file as data as it stands, without what is of its own guess and mesh, or of an objective that overrides
    changed; a chain of links is the states and equations that it stands for.

    spec: of the file.
    """
    data = data_of(spec)
    left_out = {"guess", "continuation", "sweep", "model", *(["reference"] if spec.overrides else [])}
    data = {key: value for key, value in data.items() if key not in left_out}
    if spec.nonsmooth and spec.nonsmooth.widths:
        data["nonsmooth"] = {spec.nonsmooth.treatment: spec.nonsmooth.widths[-1].text}
    if "solver" in data:
        data["solver"] = {key: value for key, value in data["solver"].items() if key not in ("starts", "seed")}
    return {"trajopt": 1, "name": spec.name, **data}


def _end(time: TimeEnd, key: str) -> str | None:
    """A bound of a time, or its value, as the file writes it; None where it has none."""
    known = time.value or getattr(time, key)
    return None if known is None else known.text


def _fixed(value: str) -> dict[str, str]:
    return {"lower": value, "upper": value}


def _at_rest(spec: Spec, name: str) -> list[dict[str, Any]]:
    """What is zero when a state comes to a bound on which it stays: its velocity, the velocity of that, and so on, as
    far as they are states themselves."""
    slopes: dict[str, str] = {}
    for own, state in spec.states.items():
        if state.second_order:
            velocity = state.velocity_of(own)
            slopes |= {own: velocity, velocity: state.accel.text if state.accel else ""}
        else:
            slopes[own] = state.rate.text if state.rate else ""
    found, seen = [], {name}
    while (name := slopes.get(name, "").strip()) in slopes and name not in seen:
        seen.add(name)
        found.append({"name": f"{name} on the bound", "expression": f"{name}[initial]", "equals": 0})
    return found


def integral_states(spec: Spec, phase: str = "") -> dict[str, tuple[str, dict[str, str]]]:
    """A state in the place of each integral constraint: its name -> its rate, and its range at the end.

    spec: of the phase.
    phase: its name, of several.
    """
    found: dict[str, tuple[str, dict[str, str]]] = {}
    for number, entry in enumerate(_entries(spec, "integral"), start=1):
        state = free_name(f"integral{number}" + (f"_of_{phase}" if phase else ""), spec, found)
        equal = {key: entry["equals"] for key in ("lower", "upper") if "equals" in entry}
        found[state] = entry["expression"], equal or {key: entry[key] for key in ("lower", "upper") if key in entry}
    return found


def _entries(spec: Spec, kind: str) -> list[dict[str, Any]]:
    """The constraints of a kind, as data."""
    return [data_of(entry) for entry in getattr(spec.constraints, kind)]


def data_of(entry: BaseModel) -> dict[str, Any]:
    """What is given in a part of a file, as data."""
    found: dict[str, Any] = filled(json.loads(entry.model_dump_json(exclude_defaults=True)))
    return found


def _names(spec: Spec, kind: str) -> list[str]:
    """The names of the constraints of a kind."""
    return [name for (path, _), name in zip(constraints(spec), constraint_names(spec), strict=True) if path[1] == kind]


def filled(data: Mapping[str, Any]) -> dict[str, Any]:
    """Without what is empty.

    data: part of a file.
    """
    return {key: value for key, value in data.items() if value not in ({}, [], None, "")}
