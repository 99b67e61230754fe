"""One machine-readable object for a result file: what `solve` and `show` print and `--json` gives."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ...problems.errors import FileError, Mistake
from ...problems.quantities import LARGEST_NUMBER
from ..declared.layout import MESH
from .arrays import NO_BAR_YET, accuracy_of, bar_of, stored_meshes, unit_of
from .door import DAMAGED, open_result, stored_problem
from .json_values import for_json

OLDER = "an older version of trajopt wrote this result, which is to be solved again"
"""Why there are no sensitivities in a result that has no place for them."""

OF_ONE = re.compile(r"(the \w+ (?:value|bound)) of (\w+)( .*|)")
"""What is demanded of one variable: the kind, the variable, and when or of which phase."""

STATIC, DISCRETE, CONTINUOUS = "static", "discrete", "continuous"
"""What time is in a phase; discrete time is called like its method."""

NEGLIGIBLE = 1e-6
"""Of 1 + |objective|: a number is not listed if doubling it, or adding 1, changes the objective by less; it is what the
barrier of the engine leaves of bounds that do not act."""


def summarize(path: Path) -> dict[str, Any]:
    """Read a result file; plain numbers, strings, lists and dictionaries only, NaN and infinity as None.

    Raises FileError if the file cannot be read or is no result of trajopt.
    """
    with open_result(path) as file:
        return for_json(_summary(path, file))


def causes(trouble: str, violations: Sequence[object], involved: Sequence[str] = ()) -> list[str]:
    """Why a solve failed, as far as is known: first what explains it, then the worst violations.

    trouble: what explains it.
    violations: the worst first.
    involved: names in the trouble: all are told, those of a kind together.
    """
    trouble = trouble.replace(", ".join(involved), ", ".join(_together(involved))) if involved else trouble
    return [*filter(None, [trouble]), *map(str, violations[:3])]


def _together(names: Sequence[str]) -> list[str]:
    """Names of constraints, of which those that differ by a variable only are one: the final values of x, v."""
    groups: dict[tuple[str, ...], list[str]] = {}
    for name in names:
        before, variable, after = match.groups() if (match := OF_ONE.fullmatch(name)) else (name, "", "")
        groups.setdefault((before, after), []).append(variable)
    return [
        f"{before}{'s' if len(own) > 1 else ''}{' of ' if own[0] else ''}{', '.join(own)}{after}"
        for (before, after), own in groups.items()
    ]


def _summary(path: Path, file: h5py.File) -> dict[str, Any]:
    head = {key: file.attrs[key] for key in (
        "problem", "status", "solved", "message", "remedy", "trouble", "objective", "sense",
        "created", "command", "trajopt_version", "pyomo_version", "ipopt_version",
    )}  # fmt: skip
    head |= bar_of(file.attrs)
    head["objective_error_missing"] = file.attrs.get("objective_error_missing", NO_BAR_YET)
    solver = file["solver"].attrs
    seconds = {key.removeprefix("seconds_"): value for key, value in solver.items() if key.startswith("seconds_")}
    meshes = [{"mesh": k + 1, **_attributes(file["mesh"][str(k)])} for k in range(len(file["mesh"]))]
    return {
        "file": str(path),
        **head,
        "parameters": {name: value[()] for name, value in file["spec"].get("parameter", {}).items()},
        "overrides": _overrides(file["spec"].attrs),
        "optimizes": _optimizes(file),
        "reference": _reference(file),
        "violations": list(solver["violations"]),
        "involved": list(solver.get("involved", ())),
        "unmet": list(solver["unmet"]),
        "unmet_count": solver["unmet_count"],
        "stopped": solver["stopped"],
        "program": solver.get("program", ""),
        "notes": list(solver.get("notes", ())),  # results of older versions have none
        "relief": list(solver.get("relief", ())),
        "continuation": list(solver.get("continuation", ())),
        "discarded": list(solver.get("discarded", ())),
        "inaccurate": accuracy_of(file),
        "iterations": sum(mesh["iterations"] for mesh in meshes) + int(solver.get("discarded_iterations", 0)),
        "error": _error(file),
        "overshoot": _overshoot(file),
        "sensitivities": _sensitivities(file),
        "phases": _phases(file),
        "prices": _prices(file),
        "estimates": _estimates(file),
        "meshes": meshes,
        "seconds": {**seconds, "total": sum(seconds.values())},
    }


def _overrides(told: Mapping[str, Any]) -> dict[str, Any]:
    """Path that the command line changed -> its value; None in results of older versions, which have no values."""
    paths, values = list(told["overrides"]), list(told.get("override_values", ()))
    return dict(zip(paths, map(_value, values) if values else [None] * len(paths), strict=False))


def _value(text: str) -> Any:
    """A value of JSON; foreign text that is none stays what it is."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text


def _attributes(mesh: h5py.Group) -> dict[str, Any]:
    plain = {key: value for key, value in mesh.attrs.items() if key in MESH.attributes}
    seconds = {key.removeprefix("seconds_"): v for key, v in mesh.attrs.items() if key.startswith("seconds_")}
    methods = ", ".join(dict.fromkeys(own.attrs["method"] for own in stored_meshes(mesh)))  # one for each phase
    return {**plain, "method": methods, **bar_of(mesh.attrs), "seconds": seconds}


def _reference(file: h5py.File) -> dict[str, Any] | None:
    """The file's reference value beside ours; None where the problem file gives none.

    It belongs to the file as it stands: a command line that changed the problem or the mesh leaves `agrees` open.
    """
    reference = stored_problem(file).get("reference")
    if not reference:
        return None
    if not isinstance(reference, dict) or not all(_is_number(reference.get(key)) for key in ("objective", "tolerance")):
        raise FileError(Mistake(f"{file.filename}: /spec/full", "its reference is none", DAMAGED))
    difference = float(file.attrs["objective"]) - reference["objective"]
    overrides = list(file["spec"].attrs["overrides"])
    agrees = None if overrides else abs(difference) <= reference["tolerance"]
    return {**reference, "difference": difference, "agrees": agrees, "overrides": overrides}


def _optimizes(file: h5py.File) -> bool:
    """Whether there is an objective: a system of equations has none but a constant."""
    objective = stored_problem(file).get("objective")
    terms = next(iter(objective.values()), None) if isinstance(objective, dict) else None
    return terms != {"terminal": 0}


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and abs(value) < LARGEST_NUMBER


def _error(file: h5py.File) -> dict[str, Any]:
    """The largest eta and where it is: phase, state, segment (the first is 1) and the segment's times."""
    worst: dict[str, Any] = {"max_eta": -np.inf}
    for name, phase in file["phase"].items():
        eta = phase["error/eta"][:]
        if not eta.size:  # no time, no states
            continue
        segment, state = np.unravel_index(np.nanargmax(np.nan_to_num(eta, nan=np.inf)), eta.shape)
        if not eta[segment, state] <= worst["max_eta"]:
            worst = {
                "max_eta": eta[segment, state],
                "phase": name,
                "state": phase["error/state"].asstr()[state],
                "segment": segment + 1,
                "start": phase["knots"][segment],
                "end": phase["knots"][segment + 1],
            }
    return worst


def _overshoot(file: h5py.File) -> dict[str, Any] | None:
    """What exceeds its bounds most between the points, by its share of its range; None if nothing has bounds."""
    found, prefix = [], "overshoot_"
    for name, phase in file["phase"].items():
        told = {k.removeprefix(prefix): v for k, v in phase["error"].attrs.items() if k.startswith(prefix)}
        if told:
            found.append({"phase": name, "lasts": None, **told})
    return max(found, key=lambda own: own["share"], default=None)


def _sensitivities(file: h5py.File) -> dict[str, Any]:
    """The derivative of the objective by each number of the file, by path; missing: why there are none, or ""."""
    if "sensitivity" not in file:
        return {"missing": OLDER, "numbers": {}}
    group = file["sensitivity"]
    columns = {key: group[key][:] for key in ("value", "derivative")}
    columns |= {key: group[key].asstr()[:] for key in ("unit", "note")}
    paths = group["number"].asstr()[:]
    numbers = {path: {key: column[k] for key, column in columns.items()} for k, path in enumerate(paths)}
    return {"missing": group.attrs["missing"], "numbers": numbers}


def telling(summary: dict[str, Any]) -> list[str]:
    """The numbers of the file that the objective hangs on, or that there is something to know of, the largest effect
    first. summary: as `summarize` gives it."""
    numbers, scale = summary["sensitivities"]["numbers"], 1 + abs(summary["objective"] or 0.0)
    effects = {path: _effect(own) for path, own in numbers.items()}
    listed = [path for path, effect in effects.items() if effect > NEGLIGIBLE * scale or numbers[path]["note"]]
    return sorted(listed, key=lambda path: -effects[path])


def _effect(own: dict[str, Any]) -> float:
    """What of the objective hangs on a number: its derivative times 1 + |the number|; 0 if it is not known."""
    return abs(own["derivative"]) * (1 + abs(own["value"])) if own["derivative"] is not None else 0.0


def _phases(file: h5py.File) -> dict[str, Any]:
    """The phases by name, with method and number of segments of the last mesh."""
    last = stored_meshes(file["mesh"][str(len(file["mesh"]) - 1)])
    return {
        name: {
            "method": mesh.attrs["method"],
            "segments": mesh.attrs["segments"],
            "kind": _kind(group, mesh.attrs["method"]),
            **_phase(group),
        }
        for (name, group), mesh in zip(file["phase"].items(), last, strict=True)
    }


def _kind(group: h5py.Group, method: str) -> str:
    """What time is in a phase: STATIC for none, DISCRETE, or CONTINUOUS."""
    if not len(group["error/state"]):
        return STATIC
    return DISCRETE if method == DISCRETE else CONTINUOUS


def _phase(group: h5py.Group) -> dict[str, Any]:
    points, time = group["points"], group["points/time"]
    worst = np.max(group["error/eta"][:], axis=0)
    eta = dict(zip(group["error/state"].asstr()[:], worst, strict=True))
    return {
        "time": {"initial": time[0], "final": time[-1], "unit": unit_of(time)},
        "relative_error": np.max(group["error/relative"][:]) if "relative" in group["error"] else np.nan,
        "states": {name: {**_curve(values), "max_eta": eta[name]} for name, values in points["state"].items()},
        "controls": {name: _curve(values) for name, values in points["control"].items()},
        "algebraic": {name: _curve(values) for name, values in points.get("algebraic", {}).items()},
        "outputs": {name: _curve(values) for name, values in points.get("output", {}).items()},
        "path": {name: _curve(values) for name, values in points.get("path", {}).items()},
        "parameters": {
            name: {"value": value[()], "unit": unit_of(value)} for name, value in group["parameter"].items()
        },
        "prices": _prices(group),
        "arcs": _arcs(group),
        "complementarity": {
            name: {key: own[key][()] for key in ("product", "time", "allowed")}
            for name, own in group.get("complementarity", {}).items()
        },
    }


def _prices(group: h5py.Group) -> dict[str, float]:
    """Of a phase, or of what holds between phases."""
    return {name: value[()] for name, value in group.get("price", {}).items()}


def _arcs(group: h5py.Group) -> list[dict[str, Any]]:
    """Each quantity that is on a bound somewhere, with its arcs one after the other."""
    if "arcs" not in group:
        return []
    own = group["arcs"]
    found: dict[tuple[str, str], dict[str, Any]] = {}
    numbers, words = ("start", "end", "bound"), ("on", "by")
    columns = {key: own[key][:] for key in numbers} | {key: own[key].asstr()[:] for key in (*words, "name", "kind")}
    for k, (kind, name) in enumerate(zip(columns["kind"], columns["name"], strict=True)):
        arcs = found.setdefault((kind, name), {"name": name, "kind": kind, "arcs": []})["arcs"]
        arcs.append({key: columns[key][k] for key in (*numbers, *words)})
    return list(found.values())


def _estimates(file: h5py.File) -> dict[str, Any] | None:
    """The estimated parameters with their standard errors and correlation; None where nothing was measured."""
    if "estimates" not in file:
        return None
    group = file["estimates"]
    names = list(group["parameter"].asstr()[:])
    units = {name: unit_of(value) for phase in file["phase"].values() for name, value in phase["parameter"].items()}
    rows = zip(names, group["value"][:], group["standard_error"][:], strict=True)
    return {
        "parameters": {
            name: {"value": value, "standard_error": error, "unit": units.get(name, "")} for name, value, error in rows
        },
        "correlation": {
            name: dict(zip(names, row, strict=True)) for name, row in zip(names, group["correlation"][:], strict=True)
        },
        **{key: group.attrs[key] for key in ("residuals", "measurements", "free", "scale", "given", "missing")},
    }


def _curve(dataset: h5py.Dataset) -> dict[str, Any]:
    values = dataset[:]
    return {
        "initial": values[0],
        "final": values[-1],
        "min": np.fmin.reduce(values),
        "max": np.fmax.reduce(values),
        "unit": unit_of(dataset),
    }
