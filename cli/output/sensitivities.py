"""The table of `show --sensitivities`: how the objective changes with the numbers of the file."""

from __future__ import annotations

from typing import Any

from ...results.file.summary import telling
from .printing import cell, plural, print_field, print_table


def print_sensitivities(summary: dict[str, Any]) -> None:
    """What counts, the largest effect first; how many numbers do not; or why there is nothing to tell."""
    found = summary["sensitivities"]
    if found["missing"]:
        print_field("sensitivity", f"none: {found['missing']}")
        return
    listed = telling(summary)
    columns = ("number", "value", "unit", "change of the objective", "", "note")
    print()
    print_table(columns, [_row(path, found["numbers"][path]) for path in listed], right=columns[1:4:2])
    rest = len(found["numbers"]) - len(listed)
    if rest:
        print(f"{plural(rest, 'other number')} of the file {'changes' if rest == 1 else 'change'} nothing")


def _row(path: str, own: dict[str, Any]) -> tuple[str, ...]:
    per = f"per {own['unit']}" if own["unit"] else "per 1"
    return path, f"{own['value']:.6g}", own["unit"], cell(own["derivative"], ".6g"), per, own["note"]
