"""`trajopt show`, `list`, `methods`, `schema`: what there is."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from .common import NOT_SOLVED, command, print_table

Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on one line for each result.")]


@command
def show(
    results: Annotated[list[Path], typer.Argument(metavar="RESULT...", help="Result files of 'trajopt solve'.")],
    json_: Json = False,
) -> None:
    """Print what a result file holds. Exit code 1 if the result is not a solution.

    Example: trajopt show cartpole.h5 --json
    """
    from ..results.summary import summarize

    summaries = [summarize(path) for path in results]
    for summary in summaries:
        if json_:
            print(json.dumps(summary))
        else:
            from .table import print_details, print_summary

            print_summary(summary)
            print_details(summary)
    if not all(summary["solved"] for summary in summaries):
        raise typer.Exit(NOT_SOLVED)


@command
def list_() -> None:
    """List the problems that ship with trajopt; each can be solved by its name.

    Example: trajopt list
    """
    from ..problems.catalog import shipped
    from ..problems.load import load

    rows = []
    for name, path in shipped().items():
        spec = load(path)
        reference = "" if spec.reference is None else f"{spec.reference.objective:.10g}"
        rows.append((name, spec.name, reference, spec.source))
    print_table(("name", "problem", "reference", "source"), rows)


@command
def methods() -> None:
    """List the collocation methods a mesh entry may name.

    Example: trajopt methods
    """
    from ..transcription.schemes import TABLE

    rows = [(s.name, s.family, str(s.order), s.state_interpolant, s.control_interpolant, s.source) for s in TABLE.values()]
    print_table(("method", "family", "order", "state", "control", "source"), rows)


@command
def schema() -> None:
    """Print the JSON Schema of problem files, for editors and validators.

    Example: trajopt schema > trajopt.schema.json
    """
    from ..problems.spec import schema as json_schema
    from ..transcription.schemes import TABLE

    print(json.dumps(json_schema(tuple(TABLE)), indent=2))
