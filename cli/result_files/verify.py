"""`trajopt verify`: is a result what it says?"""

from __future__ import annotations

from typing import Annotated

import typer

from ..errors import NOT_SOLVED, command
from ..options import Json, Results
from ..output.printing import cell, print_json, print_table


@command
def verify(
    results: Results,
    *,
    tol: Annotated[float, typer.Option("--tol", min=0, help="Largest relative error that passes.")] = 5e-2,
    json_: Json = False,
) -> None:
    """Simulate the found control, check optimality and bounds.

    Path constraints are checked too, and the objective against the reference of the problem file. Exit code 1 if a
    check fails.

    Example: trajopt verify cartpole.h5 --tol 1e-3
    """
    from ...results.verify import verify as run

    passed = True
    for path in results:
        checks = run(path, tol)
        passed &= all(check.passed for check in checks)
        if json_:
            lines = [{**vars(check), "passed": check.passed} for check in checks]
            print_json({"file": str(path), "passed": all(check.passed for check in checks), "checks": lines})
            continue
        rows = [
            ("pass" if c.passed else "FAIL", c.name, cell(c.value, ".2e"), cell(c.limit, ".1e"), c.where)
            for c in checks
        ]
        print_table((str(path), "check", "value", "limit", "where"), rows, right=("value", "limit"))
    if not passed:
        raise typer.Exit(NOT_SOLVED)
