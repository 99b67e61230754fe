"""`trajopt compare`: results side by side."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import Any

from ..errors import command
from ..options import Json, Results
from ..output.printing import cell, one_line, print_json, print_table

COLUMNS: dict[str, Any] = {
    "method": str, "segments": "d", "unknowns": "d", "objective": ".10g", "objective_error": ".1e",
    "difference": ".2e",
    "state_difference": ".2e", "max_eta": ".2e", "iterations": "d", "seconds": ".3f",
}  # fmt: skip
MAX_TOLD = 4  # differences between two problems


@command
def compare(results: Results, *, json_: Json = False) -> None:
    """Compare results with the first one, on any mesh or method.

    Results of different problems are compared in what they have in common, with a note that says how they differ. A
    table of one problem has columns for what differs, one of problems of different names has these.

    Example: trajopt compare fine.h5 coarse.h5 trapezoid.h5
    """
    from ...results.compare import compare as run

    rows = run(results)
    differing = list(dict.fromkeys(path for row in rows for path in row["other_problem"]))
    if differing:
        told = f"these are results of different problems, which differ in {_listed(differing)}"
        print("note:", one_line(told), file=sys.stderr)
    rows = _sorted(rows, differing)
    if json_:
        for row in rows:
            print_json(row)
        return
    other_names = len({row["problem"] for row in rows}) > 1  # of such, single values tell nothing
    shown = [] if other_names else differing[:MAX_TOLD]
    cells = [
        [
            row["file"],
            *([row["problem"]] if other_names else []),
            *(_value(row["values"][path]) for path in shown),
            *(row[name] if form is str else cell(row[name], form) for name, form in COLUMNS.items()),
        ]
        for row in rows
    ]
    right = [*shown, *(name.replace("_", " ") for name, form in COLUMNS.items() if form is not str)]
    head = ["file", *(["problem"] if other_names else []), *shown]
    print_table([*head, *(name.replace("_", " ") for name in COLUMNS)], cells, right=right)


def _sorted(rows: Sequence[dict[str, Any]], differing: Sequence[str]) -> list[dict[str, Any]]:
    """The rows in the order of what differs, numbers by their size; segments last, of one method.

    Those of one problem by several methods stay as they were given.

    Each gets `values`: path of what differs -> its value here.
    """
    for row in rows:
        first = {path: pair[0] for own in rows for path, pair in own["other_problem"].items()}
        row["values"] = {path: row["other_problem"].get(path, (None, first.get(path)))[1] for path in differing}
    one_method = len({row["method"] for row in rows}) == 1
    found = [([_order(row["values"][path]) for path in differing], row["segments"] * one_method) for row in rows]
    return [row for _, row in sorted(zip(found, rows, strict=True), key=lambda pair: pair[0])]


def _order(value: object) -> tuple[int, float, str]:
    """Nothing first, then numbers, then texts."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return 1, float(value), ""
    return (0, 0.0, "") if value is None else (2, 0.0, str(value))


def _listed(paths: Sequence[str]) -> str:
    more = [f"{len(paths) - MAX_TOLD} more"] if len(paths) > MAX_TOLD else []
    return ", ".join([*paths[:MAX_TOLD], *more])


def _value(value: object) -> str:
    if value is None:
        return "not given"
    return f"{value:g}" if isinstance(value, float) else str(value)
