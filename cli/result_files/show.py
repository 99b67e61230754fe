"""`trajopt show`: what result files hold."""

from __future__ import annotations

from typing import Annotated

import typer

from ..errors import NOT_SOLVED, command
from ..options import Json, Results
from ..output.printing import print_json


@command
def show(
    results: Results,
    *,
    sensitivities: Annotated[
        bool, typer.Option("--sensitivities", help="Print how the objective changes with each number of the file.")
    ] = False,
    json_: Json = False,
) -> None:
    """Print what result files hold.

    Example: trajopt show cartpole.h5 --sensitivities

    The exit code is 1 if a result is no solution.
    """
    from ...results.file.summary import summarize
    from ..output.sensitivities import print_sensitivities
    from ..output.table import print_details, print_summary

    summaries = [summarize(path) for path in results]
    for number, summary in enumerate(summaries):
        if json_:
            print_json(summary)
        else:
            if number:
                print()
            print_summary(summary)
            if sensitivities:
                print_sensitivities(summary)
            else:
                print_details(summary)
    if not all(summary["solved"] for summary in summaries):
        raise typer.Exit(NOT_SOLVED)
