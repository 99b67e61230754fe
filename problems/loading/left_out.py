"""What a file leaves out: what is missing, and what takes the place of the rest."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from ..names.symbols import UNKNOWN
from ..schema import messages
from ..schema.declarations import Time
from ..schema.spec import Spec
from ..text import brief
from ..wishes.keys import meant
from ..yaml.document import Path as Place
from ..yaml.locations import Finding


def missing_times(data: dict[str, Any]) -> list[Finding]:
    """The times that a file without phases does not give; something that no check says anything of takes their place.

    With phases these may stand in the first and in the last of them.
    """
    if data.get("time") is None:
        data["time"] = {"initial": UNKNOWN, "final": UNKNOWN}
        if is_misspelt("time", data, Spec.model_fields):
            return []
        return [Finding(("time",), "time is missing", f"add {messages.how_written(('time',))}")]
    found = []
    time = data.get("time")
    if not isinstance(time, dict):
        return []
    given = dict(time)
    for end in ("initial", "final"):
        if time.get(end) is not None:
            continue
        time[end] = UNKNOWN
        if not is_misspelt(end, given, Time.model_fields, ("time",)):
            remedy = f"add {messages.how_written(('time', end))}"
            found.append(Finding(("time", end), f"{end} is missing", remedy))
    return found


def is_misspelt(key: str, given: Mapping[str, Any], known: Mapping[str, Any], path: Place = ()) -> bool:
    """Whether a key that is none, with a value, is a misspelt one that is missing.

    key: that is missing.
    given: what there is beside it.
    known: the keys that may stand there.
    path: of what holds them.
    """
    others = (other for other, value in given.items() if other not in known and value is not None)
    return any(meant((*path, other), known) == key for other in others)


def empty_bounds(data: Any, path: Place = ()) -> Iterator[Finding]:
    """Bounds and ends without a value, which count as left out."""
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in items:
        if value is None and key in ("lower", "upper", "equals", "initial", "final") and len(path) > 1:
            yield Finding((*path, key), f"{key}: is empty, and counts as left out", f"write a value, or remove {key}:")
        if isinstance(value, dict | list):
            yield from empty_bounds(value, (*path, key))


def measured_objective(data: dict[str, Any]) -> None:
    """With measurements, their residuals are an objective by themselves."""
    phases = data.get("phases")
    owners = [data, *(phases.values() if isinstance(phases, dict) else ())]
    owners = [own for own in owners if isinstance(own, dict)]
    if any(own.get("measurements") for own in owners) and not any(own.get("objective") for own in owners):
        data["objective"] = {"minimize": {}}


def shared_objective(data: dict[str, Any]) -> None:
    """An objective that stands in phases alone: the file's is of the same sense, without terms."""
    phases = data.get("phases")
    if data.get("objective") is not None or not isinstance(phases, dict):
        return
    for own in phases.values():
        objective = own.get("objective") if isinstance(own, dict) else None
        for sense in ("minimize", "maximize"):
            if isinstance(objective, dict) and sense in objective:
                data["objective"] = {sense: {}}
                return


def meshes_of_phases(data: dict[str, Any]) -> bool:
    """Whether a phase says what its mesh is."""
    phases = data.get("phases")
    return isinstance(phases, dict) and any(isinstance(own, dict) and own.get("mesh") for own in phases.values())


def default_tolerance(data: dict[str, Any]) -> list[Finding]:
    """Without `mesh:`, `solver: {tol: ...}` is the tolerance of the mesh that a file gets; what is wrong with it."""
    solver = data.get("solver")
    if not isinstance(solver, dict) or "tol" not in solver:
        return []
    data["solver"] = {name: value for name, value in solver.items() if name != "tol"}
    tolerance = solver["tol"]
    if isinstance(tolerance, bool) or not isinstance(tolerance, int | float) or not 0 < tolerance < 1:
        what = f"the tolerance of the solver is {brief(tolerance)}"
        return [Finding(("solver", "tol"), what, "write a number between 0 and 1, such as 1.0e-8")]
    data["mesh"][0]["tolerance"] = tolerance
    return []
