"""A file with mistakes made readable, so that mistakes the schema cannot see are reported along with the others.

What the schema refuses is replaced by something harmless: an unknown value, about which no check says anything.
"""

from __future__ import annotations

import copy
from typing import Any

from pydantic import ValidationError

from .spec import Spec
from .symbols import UNKNOWN
from .yamltext import Path

_ROUNDS = 5  # removing one thing may show that another is missing
_SECTIONS = {"parameters", "expressions", "states", "controls", "optimize"}
_FORMULAS = {"rate", "value", "lower", "upper", "guess", "equals", "expression", "integral", "terminal"}

_MESH = [{"method": "any", "segments": 1}]
_OBJECTIVE = {"minimize": {"integral": UNKNOWN}}


def repair(data: dict[str, Any], error: ValidationError) -> Spec | None:
    """The spec that is left when everything in `error` is made harmless, or None if too little is left to check.

    Without a section of names, which names are unknown cannot be told: then the answer is None too.
    """
    data = copy.deepcopy(data)
    for _ in range(_ROUNDS):
        for mistake in error.errors(include_url=False, include_input=False):
            path, extra = mistake["loc"], mistake["type"] == "extra_forbidden"
            if len(path) <= 1 and (extra or not path or path[0] in _SECTIONS):
                return None
            _replace(data, path, extra)
        try:
            return Spec.model_validate(data)
        except ValidationError as remaining:
            error = remaining
    return None


def _replace(data: dict[str, Any], path: Path, extra: bool) -> None:
    """Put something harmless at a path, or at the value on the way that is no mapping, or take it away."""
    node: Any = data
    for depth, key in enumerate(path[:-1]):
        inner = node.get(key) if isinstance(node, dict) else node[key]
        if not isinstance(inner, dict | list):
            path = path[: depth + 1]
            break
        node = inner
    harmless = None if extra else _harmless(path)
    if path[0] == "mesh":
        data["mesh"] = _MESH
    elif harmless is None and isinstance(node, dict):
        node.pop(path[-1], None)
    else:
        node[path[-1]] = harmless


def _harmless(path: Path) -> Any:
    """A value about which no check says anything; None where the key is better left out."""
    match path:
        case ("trajopt",):
            return 1
        case ("objective", *_) if path[-1] not in _FORMULAS:
            return _OBJECTIVE if len(path) == 1 else _OBJECTIVE["minimize"]
        case ("time",):
            return {"initial": UNKNOWN, "final": UNKNOWN}
        case ("states", _):
            return {"rate": UNKNOWN}
        case ("controls" | "optimize", _):
            return {}
        case ("constraints", _, int()):
            return {"expression": UNKNOWN, "equals": UNKNOWN}
        case ("parameters" | "expressions", _) | (_, _, "initial" | "final") | ("time", "initial" | "final"):
            return UNKNOWN
        case ("guess", "constants", _) | ("guess", "keyframes", _, _):
            return UNKNOWN
    return UNKNOWN if path[-1] in _FORMULAS and len(path) > 1 else None
