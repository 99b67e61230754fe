"""All commands of trajopt."""

from __future__ import annotations

import logging
from importlib import import_module
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from .words import as_typed

logging.getLogger("matplotlib").setLevel(logging.ERROR)  # that it made itself a cache folder, if the home is no place

COMMANDS = {
    "solve": "solving.solve",
    "sweep": "solving.sweep",
    "check": "problem_files.check",
    "explain": "problem_files.explain",
    "show": "result_files.show",
    "verify": "result_files.verify",
    "compare": "result_files.compare",
    "plot": "result_files.plot",
    "table": "result_files.table",
    "animate": "result_files.animate",
    "report": "result_files.report",
    "reproduce": "solving.reproduce",
    "list": "problem_files.listing",
    "methods": "problem_files.methods",
    "schema": "problem_files.schema",
    "export": "problem_files.export",
    "init": "problem_files.init",
    "doctor": "solving.doctor",
    "cache": "solving.cache",
}
"""The module of each command, in the order of `--help`. Its function has the command's name; of `list`, `list_`."""


class Command(TyperCommand):
    """One command, whose words are taken as they were typed."""

    def get_params(self, ctx: Any) -> list[Any]:
        return as_typed(super().get_params(ctx))


class Commands(TyperGroup):
    """The commands; each is imported when it is asked for: modules and options of all take longer than a solve."""

    def get_params(self, ctx: Any) -> list[Any]:
        return as_typed(super().get_params(ctx))

    def list_commands(self, ctx: typer.Context) -> list[str]:  # type: ignore[override]  # typer's own, not click's
        return list(COMMANDS)

    def get_command(self, ctx: typer.Context, cmd_name: str):  # type: ignore[no-untyped-def, override]  # likewise
        for name in [cmd_name] if cmd_name in COMMANDS else COMMANDS:  # all, to suggest one like the unknown one
            if name not in self.commands:
                self.commands[name] = _loaded(name)
        return self.commands.get(cmd_name)


def _loaded(name: str):  # type: ignore[no-untyped-def]
    module = import_module(f".{COMMANDS[name]}", __package__)
    alone = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)
    alone.command(name=name, cls=Command)(getattr(module, "list_" if name == "list" else name))
    return typer.main.get_command(alone)


app = typer.Typer(
    name="trajopt",
    cls=Commands,
    help="Trajectory optimization from a problem file: direct collocation, Pyomo, IPOPT, HDF5.",
    epilog="Exit codes: 0 solved; 1 not solved (the result is still written); 2 mistake in the file or on the "
    "command line; 3 a file cannot be read or written; 4 solved, but not as accurate as was asked; 129, 130 or 143 "
    "interrupted (the last mesh that was solved is written, or the last iterate).",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _print_version(wanted: bool) -> None:
    if wanted:
        from ..problems.lean.versions import version

        print(f"trajopt {version('trajopt')}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    pass
