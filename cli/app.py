"""All commands of trajopt."""

from __future__ import annotations

import logging
from typing import Annotated

import typer

from .problem_files.check import check
from .problem_files.explain import explain
from .problem_files.export import export
from .problem_files.init import init
from .problem_files.listing import list_
from .problem_files.methods import methods
from .problem_files.schema import schema
from .result_files.animate import animate
from .result_files.compare import compare
from .result_files.plot import plot
from .result_files.report import report
from .result_files.show import show
from .result_files.table import table
from .result_files.verify import verify
from .solving.doctor import doctor
from .solving.reproduce import reproduce
from .solving.solve import solve
from .solving.sweep import sweep

logging.getLogger("matplotlib").setLevel(logging.ERROR)  # that it made itself a cache folder, if the home is no place

app = typer.Typer(
    name="trajopt",
    help="Trajectory optimization from a problem file: direct collocation, Pyomo, IPOPT, HDF5.",
    epilog="Exit codes: 0 solved; 1 not solved (the result is still written); 2 mistake in the file or on the "
    "command line; 3 a file cannot be read or written; 130 or 143 interrupted (the last "
    "iterate is written).",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)

for function in (
    solve, sweep, check, explain, show, verify, compare, plot, table, animate, report, reproduce, list_, methods,
    schema, export, init, doctor,
):  # fmt: skip
    app.command(name=function.__name__.rstrip("_"))(function)


def _print_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        print(f"trajopt {version('trajopt')}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    pass
