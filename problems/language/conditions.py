"""Conditions as people write them, `norm(r) >= r_min`, written out as an expression and its bounds.

A side that parameters and numbers make is a bound of the other; else the difference of both is bounded by zero. This is
done after templates are written out, and before vectors are.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from ..text import SIDES, compared

_TURNED = {"upper": "lower", "lower": "upper", "equals": "equals"}
_NAME = re.compile(r"(?<![\w.])[A-Za-z_][\w.]*(?!\w*\s*\()")
_BOUNDS = ("lower", "upper", "equals")


def write_conditions(data: Mapping[str, Any], static: bool) -> None:
    """Write the conditions of a file out, in its data.

    data: plain, without templates.
    static: whether it is without time, and its constraints a list.
    """
    shared = _fixed(data)
    phases = data.get("phases")
    for own in (data, *(phases.values() if isinstance(phases, dict) else ())):
        for items in _lists(own, static) if isinstance(own, dict) else ():
            for i, item in enumerate(items):
                items[i] = _written_out(item, shared | _fixed(own))


def _fixed(data: Mapping[str, Any]) -> set[str]:
    """The names that a bound may have in it."""
    parameters = data.get("parameters")
    return {"pi", *(parameters if isinstance(parameters, dict) else ())}


def _lists(data: Mapping[str, Any], static: bool) -> Iterator[list[Any]]:
    """The lists of conditions of a file, or of a phase."""
    constraints = data.get("constraints")
    kinds = constraints.values() if isinstance(constraints, dict) else (constraints,) if static else ()
    for own in (*kinds, data.get("links")):
        if isinstance(own, list):
            yield own


def _written_out(item: Any, fixed: set[str]) -> Any:
    """A condition by its parts; anything else as it is."""
    given = item.get("expression") if isinstance(item, dict) and not item.keys() & {*_BOUNDS} else item
    parts = _parts(given, fixed) if isinstance(given, str) else None
    if parts is None:
        return item
    return {**item, **parts} if isinstance(item, dict) else parts


def _parts(text: str, fixed: set[str]) -> dict[str, Any] | None:
    """The expression and the bounds of a text; None if it is no condition."""
    sides, signs = compared(text)
    known = [not {*_NAME.findall(side)} - fixed for side in sides]
    if not all(sides) or len(signs) not in (1, 2):
        return None
    if len(signs) == 1:
        (left, right), side = sides, SIDES[signs[0]]
        if known[1]:
            return {"expression": left, side: right}
        if known[0]:
            return {"expression": right, _TURNED[side]: left}
        return {"expression": f"{left} - ({right})", side: 0}
    first, second = (SIDES[sign] for sign in signs)
    if first != second or first == "equals" or known != [True, False, True]:
        return None
    return {"expression": sides[1], _TURNED[first]: sides[0], second: sides[2]}
