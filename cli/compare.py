"""`trajopt compare`: results side by side."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from .common import command, print_table

COLUMNS = {
    "file": str, "method": str, "segments": "d", "unknowns": "d", "objective": ".10g", "difference": ".2e",
    "state_difference": ".2e", "max_eta": ".2e", "iterations": "d", "seconds": ".3f",
}  # fmt: skip


@command
def compare(
    results: Annotated[list[Path], typer.Argument(metavar="RESULT...", help="Result files of 'trajopt solve'.")],
    json_: Annotated[bool, typer.Option("--json", help="Print one JSON object on one line for each result.")] = False,
) -> None:
    """Compare results on different meshes and methods with the first one.

    Example: trajopt compare fine.h5 coarse.h5 trapezoid.h5
    """
    from ..results.compare import compare as run

    rows = run(results)
    if json_:
        for row in rows:
            print(json.dumps(row))
        return
    cells = [[_cell(row[name], form) for name, form in COLUMNS.items()] for row in rows]
    right = [name.replace("_", " ") for name, form in COLUMNS.items() if form is not str]
    print_table([name.replace("_", " ") for name in COLUMNS], cells, right=right)


def _cell(value, form) -> str:
    if value is None:
        return ""
    return value if form is str else f"{value:{form}}"
