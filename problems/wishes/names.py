"""Names that are declared nowhere: words of other tools, and what they are here."""

from __future__ import annotations

import re
from collections.abc import Collection

from ..yaml.document import Path
from .values import ENDLESS, leave_out

_WORDS = {
    "write t[final] for the final time": "tf t_f T_f tF t_F t_final tfinal t_end tend T_final final_time",
    "write t[initial] for the initial time": "t0 t_0 ti t_i t_initial t_start initial_time",
    "write t for the time": "time",
    "write t[duration], which is t[final] - t[initial]": "duration",
    "angles are in radians: write pi/180 in its place": "deg degs degree degrees",
    "write exp(...) for a power of e": "e",
}
_REMEDIES = {word: remedy for remedy, words in _WORDS.items() for word in words.split()}
_NOTHING = "no none None null Null false False off nil nan NaN NA free Free open any unspecified"
_GIVEN = "yes Yes YES on On ON true True TRUE fixed Fixed given"
_AT_END = (
    (re.compile(r"(\w+?)_?(?:f|F|final|end|T|tf)"), "final"),
    (re.compile(r"(\w+?)_?(?:0|i|initial|start|t0)"), "initial"),
    (re.compile(r"(?:final|end)_(\w+)"), "final"),
    (re.compile(r"(?:initial|start)_(\w+)"), "initial"),
)
_RATE = re.compile(r"(\w+?)_?(?:ddot|dot|prime)|d(\w+?)(?:_?dt)?|(\w+)_d")


def name_wish(name: str, path: Path, varying: Collection[str], states: Collection[str]) -> str | None:
    """The remedy for a name that nothing declares; None where nothing is known of it.

    name: as it stands in the expression.
    path: of the expression.
    varying: the names that have a value at every time.
    states: those of them that have a rate.
    """
    if name in _NOTHING.split() and path[0] not in ("parameters", "expressions"):
        return leave_out(path)
    key = path[-2] if path[-1] == "value" else path[-1]
    if name in _GIVEN.split() and path[0] not in ("parameters", "expressions") and key in ("initial", "final"):
        return f"write its value, such as {key}: 1"
    if name in ENDLESS:
        ended = path[-1] in ("lower", "upper", "initial", "final", "value")
        return leave_out(path) if ended and path[0] != "parameters" else "write a large number, such as 1e6"
    if path[0] == "time" and name in _REMEDIES:
        return leave_out(path)
    return (
        _REMEDIES.get(name)
        or _of_an_attribute(name, varying)
        or _at_an_end(name, path, varying)
        or _a_rate(name, states)
    )


def _of_an_attribute(name: str, varying: Collection[str]) -> str | None:
    """x.final."""
    whole, _, end = name.partition(".")
    if whole not in varying or end not in ("initial", "final", "end", "start"):
        return None
    return f"write {whole}[{'final' if end in ('final', 'end') else 'initial'}]"


def _at_an_end(name: str, path: Path, varying: Collection[str]) -> str | None:
    """x_f, xf and final_x, where an expression is about the ends."""
    if path[-1] != "terminal" and path[:2] != ("constraints", "boundary"):
        return None
    for pattern, end in _AT_END:
        found = pattern.fullmatch(name)
        if found and found[1] in varying:
            return f"write {found[1]}[{end}] for {found[1]} at the {end} time"
    return None


def _a_rate(name: str, states: Collection[str]) -> str | None:
    found = _RATE.fullmatch(name)
    state = next((part for part in found.groups() if part in states), None) if found else None
    if state is None:
        return None
    return f"write the rate of {state} as an expression, or name it under expressions: and use it there and here"
