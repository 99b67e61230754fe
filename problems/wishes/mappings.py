"""The kinds of mappings of a problem file, by the places where they stand."""

from __future__ import annotations

from ..yaml.document import Path

_KINDS: tuple[tuple[tuple[object, ...], str], ...] = (
    ((), "file"),
    (("states", str), "state"),
    (("states", str, "velocity"), "state"),
    (("controls", str), "control"),
    (("algebraic", str), "control"),
    (("optimize", str), "static"),
    (("objective", "minimize"), "terms"),
    (("objective", "maximize"), "terms"),
    (("constraints", str, int), "constraint"),
    (("links", int), "link"),
    (("complementarity", int), "pair"),
    (("measurements", str), "measured"),
    (("states", str, "initial"), "end"),
    (("states", str, "final"), "end"),
    (("time", "initial"), "end"),
    (("time", "final"), "end"),
    (("mesh", int), "mesh"),
    (("tables", str), "table"),
    *(((section,), section) for section in ("time", "objective", "constraints", "refine", "guess")),
)
"""Where a mapping stands, with a type for any key of it, and its kind."""


def kind_of(path: Path) -> str:
    """The kind of the mapping at a path; "" for one whose keys nobody spells in another way."""
    if len(path) >= 2 and path[0] == "phases":
        path = path[2:]
    return next((kind for place, kind in _KINDS if len(place) == len(path) and _fits(place, path)), "")


def _fits(place: tuple[object, ...], path: Path) -> bool:
    return all(
        isinstance(key, wanted) if isinstance(wanted, type) else key == wanted
        for wanted, key in zip(place, path, strict=True)
    )
