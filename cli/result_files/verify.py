"""`trajopt verify`: is a result what it says?"""

from __future__ import annotations

from math import inf
from typing import Annotated

import typer

from ...problems.errors import Mistake, SpecError
from ..errors import NOT_SOLVED, command
from ..options import Json, Quiet, Results
from ..output.printing import cell, print_json, print_table
from ..output.progress import live_text


@command
def verify(
    results: Results,
    *,
    tol: Annotated[float, typer.Option("--tol", min=0, help="Largest relative error that passes.")] = 5e-2,
    sample_hold: Annotated[
        float | None, typer.Option("--sample-hold", metavar="DT", help="Also hold the control for DT between samples.")
    ] = None,
    json_: Json = False,
    quiet: Quiet = False,
) -> None:
    """Simulate the found control, check optimality and bounds.

    Path constraints are checked too, and the objective against the reference of the problem file. Exit code 1 if a
    check fails.

    Example: trajopt verify cartpole.h5 --tol 1e-3
    """
    from ...results.verify import verify as run

    if sample_hold is not None and not 0 < sample_hold < inf:
        what = f"the interval {sample_hold:g} is no positive number"
        raise SpecError(Mistake("--sample-hold", what, "write one in the unit of time, such as 0.01"))
    passed = True
    for path in results:
        with live_text(f"verifying {path}", not quiet):
            checks = run(path, tol, sample_hold)
        passed &= all(check.passed for check in checks)
        if json_:
            lines = [{**vars(check), "passed": check.passed} for check in checks]
            print_json({"file": str(path), "passed": all(check.passed for check in checks), "checks": lines})
            continue
        if quiet:
            continue
        rows = [
            ("pass" if c.passed else "FAIL", c.name, cell(c.value, ".2e"), cell(c.limit, ".1e"), c.where)
            for c in checks
        ]
        print_table((str(path), "check", "value", "limit", "where"), rows, right=("value", "limit"))
    if not passed:
        raise typer.Exit(NOT_SOLVED)
