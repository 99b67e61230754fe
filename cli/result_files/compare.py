"""`trajopt compare`: results side by side."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

from ..errors import command
from ..options import Json, Results
from ..output.printing import cell, one_line, print_json, print_table

COLUMNS: dict[str, Any] = {
    "file": str, "method": str, "segments": "d", "unknowns": "d", "objective": ".10g", "objective_error": ".1e",
    "difference": ".2e",
    "state_difference": ".2e", "max_eta": ".2e", "iterations": "d", "seconds": ".3f",
}  # fmt: skip
MAX_TOLD = 4  # differences between two problems


@command
def compare(results: Results, *, json_: Json = False) -> None:
    """Compare results with the first one, on any mesh or method.

    Results of different problems are compared in what they have in common, with a note that says how they differ.

    Example: trajopt compare fine.h5 coarse.h5 trapezoid.h5
    """
    from ...results.compare import compare as run

    rows = run(results)
    for row in filter(lambda row: row["other_problem"], rows):
        pair = f"{rows[0]['file']} and {row['file']} are results of different problems"
        print("note:", one_line(f"{pair}: {_told(row['other_problem'])}"), file=sys.stderr)
    if json_:
        for row in rows:
            print_json(row)
        return
    cells = [[row[name] if form is str else cell(row[name], form) for name, form in COLUMNS.items()] for row in rows]
    right = [name.replace("_", " ") for name, form in COLUMNS.items() if form is not str]
    print_table([name.replace("_", " ") for name in COLUMNS], cells, right=right)


def _told(differences: Mapping[str, tuple]) -> str:
    """Such as "parameters.m1 is 1 and 2"."""
    texts = [f"{path} is {_value(a)} and {_value(b)}" for path, (a, b) in differences.items()]
    more = [f"{len(texts) - MAX_TOLD} more"] if len(texts) > MAX_TOLD else []
    return "; ".join(texts[:MAX_TOLD] + more)


def _value(value: object) -> str:
    if value is None:
        return "not given"
    return f"{value:g}" if isinstance(value, float) else str(value)
