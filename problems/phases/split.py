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

import yaml

from ..lean.records import dataclass
from ..names.occurrences import HISTORY, TRAJECTORY, constraint_names, constraints, uses
from ..schema.declarations import TimeEnd
from ..schema.spec import Spec

METHOD = {"method": "radau", "segments": 2, "degree": 8}
"""The first mesh of an arc, on which the solution is smooth."""

MOST_MESHES = 6
"""After the first one: an arc that is smooth needs fewer."""

OF_TIMES = re.compile(r"\bt\[(initial|final|duration)\]")


_VARIABLES = ("states", "controls", "algebraic", "parameters", "expressions", "optimize", "integrals")


@dataclass(frozen=True)
class Part:
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
    """Why a problem cannot be split into phases; "" if it can."""
    own = list(uses(spec))
    reasons = {
        "it has phases already": spec.phases or spec.waypoints,
        "it has no continuous time": spec.static or spec.discrete,
        "a chain of links writes its states and equations itself": spec.model.kind,
        "one of two things is zero in it (complementarity), which has no smooth arcs": spec.complementarity,
        "abs, min and max are not smooth within an arc": spec.nonsmooth,
        "states at earlier times are of one phase": any(use.context == HISTORY for use in own),
        "measurements are of one phase": spec.measurements,
        "its equations depend on t[initial], t[final] or t[duration], which would be those of a phase": any(
            use.context == TRAJECTORY and OF_TIMES.search(use.expression.text) for use in own
        ),
    }
    return next((why for why, so in reasons.items() if so), "")


def split(spec: Spec, parts: Sequence[Part], tolerance: float, refine: float) -> str:
    """A problem file in which every part is a phase, as text.

    spec: of one phase, see `why_not`.
    parts: in order, two or more.
    tolerance: of the engine.
    refine: the relative error to which the meshes are refined.
    """
    data = _plain(spec)
    data |= {"mesh": [METHOD | {"tolerance": tolerance}], "refine": {"tolerance": refine, "max_meshes": MOST_MESHES}}
    _integrals_as_states(data, spec)
    path = data.get("constraints", {}).pop("path", [])
    named = {name: {**entry, "name": name} for name, entry in zip(_names(spec, "path"), path, strict=True)}
    phases = {f"arc{number}": _phase(spec, part, named) for number, part in enumerate(parts, start=1)}
    ends = {"lower": _end(spec.time.initial, "lower"), "upper": _end(spec.time.final, "upper")}
    within = {key: value for key, value in ends.items() if value is not None}
    for own, part in zip(list(phases.values())[:-1], parts, strict=False):
        own["time"] = {"final": within | {"guess": part.end}}
    final = data["time"].get("final")
    if isinstance(final, dict) and "value" not in final:
        final["guess"] = parts[-1].end
    return yaml.safe_dump(data | {"phases": phases}, sort_keys=False, allow_unicode=True, width=118)


def _phase(spec: Spec, part: Part, constraints: Mapping[str, dict[str, Any]]) -> dict[str, Any]:
    """What an arc has of its own. constraints: the path constraints of the file, by name."""
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
    constraints = _filled({"path": path, "boundary": boundary})
    return _filled({"controls": controls, "states": states, "constraints": constraints})


def _plain(spec: Spec) -> dict[str, Any]:
    """The file as it stands, without what is of its own guess and mesh, or of an objective that overrides changed."""
    data: dict[str, Any] = _filled(json.loads(spec.model_dump_json(exclude_defaults=True)))
    left_out = {"guess", "continuation", "sweep", *(["reference"] if spec.overrides else [])}
    data = {key: value for key, value in data.items() if key not in left_out}
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


def _integrals_as_states(data: dict[str, Any], spec: Spec) -> None:
    """Put a state and a condition on its end in the place of each integral constraint."""
    integrals = data.get("constraints", {}).pop("integral", [])
    taken = {name for group in _VARIABLES for name in getattr(spec, group)}
    for number, (entry, name) in enumerate(zip(integrals, _names(spec, "integral"), strict=True), start=1):
        state = f"integral{number}"
        while state in taken:
            state += "_"
        data["states"][state] = {"rate": entry["expression"], "initial": 0}
        bounds = {key: entry[key] for key in ("lower", "upper", "equals") if key in entry}
        own = {"name": name, "expression": f"{state}[final]", **bounds}
        data["constraints"].setdefault("boundary", []).append(own)


def _names(spec: Spec, kind: str) -> list[str]:
    """The names of the constraints of a kind."""
    return [name for (path, _), name in zip(constraints(spec), constraint_names(spec), strict=True) if path[1] == kind]


def _filled(data: Mapping[str, Any]) -> dict[str, Any]:
    """Without what is empty."""
    return {key: value for key, value in data.items() if value not in ({}, [], None, "")}
