"""The table of `show --sensitivities`: how the objective changes with the numbers of the file."""

from __future__ import annotations

from typing import Any

from .printing import cell, plural, print_field, print_table

NEGLIGIBLE = 1e-6
"""Of 1 + |objective|: a number is not listed if doubling it, or adding 1, changes the objective by less; it is what the
barrier of the engine leaves of bounds that do not act."""


def print_sensitivities(summary: dict[str, Any]) -> None:
    """What counts, the largest effect first; how many numbers do not; or why there is nothing to tell."""
    found = summary["sensitivities"]
    if found["missing"]:
        print_field("sensitivity", f"none: {found['missing']}")
        return
    scale = 1 + abs(summary["objective"])
    effects = {path: _effect(own) for path, own in found["numbers"].items()}
    listed = [path for path, effect in effects.items() if effect > NEGLIGIBLE * scale or found["numbers"][path]["note"]]
    listed.sort(key=lambda path: -effects[path])
    columns = ("number", "value", "unit", "change of the objective", "", "note")
    print()
    print_table(columns, [_row(path, found["numbers"][path]) for path in listed], right=columns[1:4:2])
    rest = len(effects) - len(listed)
    if rest:
        print(f"{plural(rest, 'other number')} of the file {'changes' if rest == 1 else 'change'} nothing")


def _effect(own: dict[str, Any]) -> float:
    """What of the objective hangs on a number: its derivative times 1 + |the number|; 0 if it is not known."""
    return abs(own["derivative"]) * (1 + abs(own["value"])) if own["derivative"] is not None else 0.0


def _row(path: str, own: dict[str, Any]) -> tuple[str, ...]:
    per = f"per {own['unit']}" if own["unit"] else "per 1"
    return path, f"{own['value']:.6g}", own["unit"], cell(own["derivative"], ".6g"), per, own["note"]
