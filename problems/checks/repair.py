"""A file with mistakes made readable, so that mistakes the schema cannot see are reported along with the others.

What the schema refuses is replaced by something harmless: an unknown value, about which no check says anything.
"""

from __future__ import annotations

import copy
from typing import Any

from pydantic import ValidationError

from ..names.symbols import UNKNOWN
from ..schema.fields import CALLED
from ..schema.model import is_chain
from ..schema.spec import Spec
from ..schema.tables import called_names
from ..wishes.keys import meant
from ..yaml.document import Path
from ..yaml.locations import MAX_FINDINGS

_ROUNDS = 5  # removing one thing may show that another is missing
_SECTIONS = {"parameters", "expressions", "states", "controls", "algebraic", "integrals", "optimize"}
_FORMULAS = {
    "rate",
    "next",
    "accel",
    "value",
    "lower",
    "upper",
    "guess",
    "equals",
    "expression",
    "integral",
    "terminal",
    "history",
}

_WHOLE = {
    "mesh": [{"method": "any", "segments": 1}],
    "nonsmooth": "slack",
    "links": [],
    "waypoints": None,
    "drawing": [],
}
_OBJECTIVE = {"minimize": {"integral": UNKNOWN}}


def repair(data: dict[str, Any], error: ValidationError) -> Spec | None:
    """The spec that is left when everything in `error` is made harmless, or None if too little is left to check.

    Without a section of names, which names are unknown cannot be told: then the answer is None too.
    """
    if error.error_count() > MAX_FINDINGS:
        return None
    data, called = copy.deepcopy(data), called_names(data)
    for _ in range(_ROUNDS):
        for mistake in error.errors(include_url=False, include_input=False):
            path, extra = mistake["loc"], mistake["type"] == "extra_forbidden"
            if path[:1] == ("model",) and is_chain(data["model"]):
                data["model"] = ""  # what it declares stands in the sections already
                continue
            if path[:1] == ("model",) or (len(path) <= 1 and (extra or not path or path[0] in _SECTIONS)):
                return None
            _replace(data, path, extra)
        try:
            return Spec.model_validate(data, context={CALLED: called})
        except ValidationError as remaining:
            error = remaining
    return None


def _replace(data: dict[str, Any], path: Path, extra: bool) -> None:
    """Put something harmless at a path, or at the value on the way that is no mapping, or take it away."""
    if path[0] == "tables":  # what looks a mistaken table up is unknown
        if len(path) > 1 and isinstance(data["tables"], dict):
            data["tables"].pop(path[1], None)
        else:
            del data["tables"]
        return
    if path[0] in _WHOLE:
        data[path[0]] = _WHOLE[path[0]]
        return
    if path[0] == "phases":
        _replace_in_phase(data, path, extra)
        return
    nodes: list[Any] = [data]
    while len(nodes) < len(path) and isinstance(inner := _below(nodes[-1], path[len(nodes) - 1]), dict | list):
        nodes.append(inner)
    if isinstance(nodes[-1], list) and not isinstance(path[len(nodes) - 1], int):
        # a list where one value should stand
        nodes.pop()
    path = path[: len(nodes)]
    if path[0] == "states" and _keeps_dynamics(nodes[-1], path, extra):
        return
    harmless = None if extra else _harmless(path)
    if harmless is None and isinstance(nodes[-1], dict):
        nodes[-1].pop(path[-1], None)
    else:
        nodes[-1][path[-1]] = harmless


def _replace_in_phase(data: dict[str, Any], path: Path, extra: bool) -> None:
    """The same below a phase; a phase that is no mapping becomes one that says nothing."""
    phases = data["phases"] if isinstance(data["phases"], dict) else {}
    data["phases"] = phases
    if len(path) < 3 or not isinstance(phases.get(path[1]), dict):
        if len(path) > 1:
            phases[path[1]] = {}
        return
    if len(path) == 3:
        phases[path[1]].pop(path[2], None)
        return
    _replace(phases[path[1]], path[2:], extra)


def _keeps_dynamics(node: dict[str, Any], path: Path, extra: bool) -> bool:
    """Mend a state without taking its dynamics, or the name of its velocity, away; whether that was the mistake."""
    key = str(path[-1])
    entry = node.get(key)
    if extra and meant(path, ("rate", "next", "accel")):
        node["rate" if "velocity" not in node else "accel"] = UNKNOWN
        del node[key]
        return True
    if isinstance(entry, dict) and "rate" in entry and entry.keys() & {"accel", "velocity"}:
        del entry["rate"]
        entry.setdefault("accel", UNKNOWN)
        return True
    return False


def _below(node: Any, key: str | int) -> Any:
    if isinstance(node, dict):
        return node.get(key)
    return node[key] if isinstance(key, int) and key < len(node) else None


def _harmless(path: Path) -> Any:
    """A value about which no check says anything; None where the key is better left out."""
    known: Any = UNKNOWN if path[-1] in _FORMULAS and len(path) > 1 else None
    match path:
        case ("trajopt",):
            known = 1
        case ("objective",):
            known = _OBJECTIVE
        case ("objective", _):
            known = _OBJECTIVE["minimize"]
        case ("time",):
            known = {"initial": UNKNOWN, "final": UNKNOWN}
        case ("states", _):
            known = {"rate": UNKNOWN}
        case ("controls" | "optimize" | "algebraic", _) | ("states", _, "velocity"):
            known = {}
        case ("complementarity" | "constraints", *_, int()):
            known = dict.fromkeys(("a", "b") if path[0] == "complementarity" else ("expression", "equals"), UNKNOWN)
        case ("parameters" | "expressions" | "integrals" | "residuals", _) | (*_, "initial" | "final"):
            known = UNKNOWN
        case ("guess", "constants", _) | ("guess", "keyframes", _, _):
            known = UNKNOWN
    return known
