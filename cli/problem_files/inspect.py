"""`trajopt show`, `list`, `methods`, `schema`: what there is."""

from __future__ import annotations

import json

import typer

from ..common import NOT_SOLVED, command
from ..options import Json, Results
from ..output.printing import print_json, print_table


@command
def show(results: Results, *, json_: Json = False) -> None:
    """Print what result files hold.

    Example: trajopt show cartpole.h5 --json

    The exit code is 1 if a result is no solution.
    """
    from ...results.file.summary import summarize
    from ..output.table import print_details, print_summary

    summaries = [summarize(path) for path in results]
    for number, summary in enumerate(summaries):
        if json_:
            print_json(summary)
        else:
            if number:
                print()
            print_summary(summary)
            print_details(summary)
    if not all(summary["solved"] for summary in summaries):
        raise typer.Exit(NOT_SOLVED)


@command
def list_() -> None:
    """List the shipped problems; each can be solved by its name.

    Example: trajopt list
    """
    from ...problems.catalog import shipped
    from ...problems.load import load

    rows = []
    for name, path in shipped().items():
        spec = load(path)
        reference = "" if spec.reference is None else f"{spec.reference.objective:.10g}"
        rows.append((name, spec.name, reference, spec.source))
    print_table(("name", "problem", "reference", "source"), rows)


@command
def methods() -> None:
    """List the methods that a mesh may name.

    Example: trajopt methods
    """
    from ...transcription.schemes.table import METHODS

    rows = [(m.name, m.family, m.order, m.ends, m.state, m.control, m.source) for m in METHODS.values()]
    print_table(("method", "family", "order", "ends", "state", "control", "source"), rows)
    print(
        "\nn: the degree. order: of states at the knots and of integrals. state, control: degrees of the interpolants."
    )
    for method in METHODS.values():
        if method.note:
            print(f"{method.name}: {method.note}")


@command
def schema() -> None:
    """Print the JSON Schema of problem files.

    Example: trajopt schema > trajopt.schema.json

    Editors and validators use it to complete and check a file while it is written.
    """
    from ...problems.schema.spec import schema as json_schema
    from ...transcription.schemes.table import METHODS

    print(json.dumps(json_schema(tuple(METHODS)), indent=2))
