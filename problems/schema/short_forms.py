"""What a file without time, or in discrete time, says in short: written out before the schema looks at it.

without time (a file with optimize:, but neither time: nor anything that varies in it)

    objective: {minimize: x1**2}                objective: {minimize: {terminal: x1**2}}
    (no objective: a system of equations)       objective: {minimize: {terminal: 0}}
    constraints: [{expression: ...}]            constraints: {boundary: [{expression: ...}]}

in discrete time (some state is given by next:)

    objective: {minimize: {sum: u**2}}          objective: {minimize: {integral: u**2}}
    constraints: {sum: [...]}                   constraints: {integral: [...]}
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from ..text import nearest
from ..yaml.document import Path
from ..yaml.locations import Finding
from .solving import DEFAULT_METHOD, DEFAULT_SEGMENTS
from .spec import Spec

VARYING = frozenset({"time", "states", "controls", "algebraic", "residuals", "model", "phases", "waypoints"})
"""Sections that only a problem with time has."""

EXACT_MESH = {"method": "explicit-euler", "segments": 1}
"""The mesh of what needs none: its tolerance is the engine's."""

STEP = "step"
"""The unit of discrete time, if the file gives none."""


def is_static(data: dict[str, Any]) -> bool:
    """Whether a file is about static parameters alone; a misspelt section is not taken for a missing one."""
    misspelt = any(nearest(key, VARYING) for key in data if key not in Spec.model_fields)
    given = {key: data.get(key) for key in VARYING}
    if isinstance(given["time"], dict) and not given["time"].keys() & {"initial", "final"}:
        del given["time"]
    return bool(data.get("optimize")) and not any(given.values()) and not misspelt


def is_discrete(data: dict[str, Any]) -> bool:
    """Whether the time of a file is discrete: some state is given by its next value."""
    states = data.get("states")
    return isinstance(states, dict) and any(
        isinstance(own, dict) and own.get("next") is not None for own in states.values()
    )


def write_out(data: dict[str, Any]) -> dict[Path, Path]:
    """Write the short forms of a file out.

    data: of the file, overrides applied; it is changed.

    Returns the path of each, written out -> as it stands in the file.
    """
    static, discrete = is_static(data), is_discrete(data)
    short: dict[Path, Path] = {}
    if static:
        short |= _static_constraints(data)
        data.setdefault("objective", {"minimize": {"terminal": 0}})
    if discrete and isinstance(data.get("time"), dict):
        data["time"].setdefault("unit", STEP)
    objective = data.get("objective")
    for sense in ("minimize", "maximize"):
        terms = objective.get(sense) if isinstance(objective, dict) else None
        if static and isinstance(objective, dict) and terms is not None and not isinstance(terms, dict):
            objective[sense] = {"terminal": terms}
            short["objective", sense, "terminal"] = ("objective", sense)
        if discrete:
            short |= _sum(terms, ("objective", sense))
    return short | _sum(data.get("constraints"), ("constraints",)) if discrete else short


def _static_constraints(data: dict[str, Any]) -> dict[Path, Path]:
    constraints = data.get("constraints")
    if not isinstance(constraints, list):
        return {}
    data["constraints"] = {"boundary": constraints}
    return {("constraints", "boundary"): ("constraints",)}


def _sum(section: Any, path: Path) -> dict[Path, Path]:
    if not isinstance(section, dict) or "sum" not in section or "integral" in section:
        return {}
    section["integral"] = section.pop("sum")
    return {(*path, "integral"): (*path, "sum")}


def exact_mesh(data: dict[str, Any], given: Iterable[Path], overridden: Iterable[Path]) -> list[Finding]:
    """Give a problem that needs no mesh one all the same; what is asked of a mesh there is wrong, but its tolerance.

    data: of the file; its mesh is changed.
    given: sections that the file gives.
    overridden: paths that the command line gives, and those above them.
    """
    why = "a problem without time" if is_static(data) else "discrete time"
    written = data["mesh"][0] if isinstance(data["mesh"], list) and len(data["mesh"]) == 1 else {}
    own = isinstance(written, dict) and written.items() >= EXACT_MESH.items()  # the full form of such a file
    wrong = [path for path in given if path[0] in ("mesh", "refine") and not own]
    wrong += [path for path in overridden if (path[0], len(path)) in (("mesh", 3), ("refine", 2))]
    kept = data["mesh"][0] if isinstance(data["mesh"], list) and data["mesh"] else {}
    tolerance = {"tolerance": kept["tolerance"]} if isinstance(kept, dict) and "tolerance" in kept else {}
    data["mesh"] = [EXACT_MESH | tolerance]
    data.pop("refine", None)
    what = f"{why} has no mesh to choose or to refine: nothing in it is approximated"
    return [Finding(path, what, "leave it out") for path in wrong if path[-1] != "tolerance" or path[0] == "refine"]


def default_mesh() -> list[dict[str, Any]]:
    """The mesh of a file that gives none, and may not need one."""
    return [{"method": DEFAULT_METHOD, "segments": DEFAULT_SEGMENTS}]
