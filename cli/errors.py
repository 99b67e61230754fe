"""Errors that are the user's, as sentences and exit codes."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from typing import ParamSpec

import typer

from ..problems.errors import FileError, SpecError, TrajoptError
from .options import SHORT_FORMS
from .output.printing import one_line
from .streams import flushed_output

NOT_SOLVED, USER_MISTAKE, FILE_TROUBLE, TOLERANCE_MISSED = 1, 2, 3, 4

P = ParamSpec("P")


def exit_code(error: TrajoptError) -> int:
    return {SpecError: USER_MISTAKE, FileError: FILE_TROUBLE}[type(error)]


def tell_error(error: TrajoptError) -> None:
    """One sentence for each mistake, on standard error."""
    for mistake in error.mistakes:
        path = mistake.where.removeprefix("--set ")
        short = SHORT_FORMS.get(path, mistake.where)
        remedy = mistake.remedy.replace(f"--set {path}=", f"{short} ") if path in SHORT_FORMS else mistake.remedy
        print(f"error: {one_line(str(replace(mistake, where=short, remedy=remedy)))}", file=sys.stderr)


def command(function: Callable[P, None]) -> Callable[P, None]:
    """Turn the errors that are the user's into sentences and exit codes; those that are ours keep their traceback."""

    @wraps(function)
    def run(*args: P.args, **kwargs: P.kwargs) -> None:
        try:
            with flushed_output():
                function(*args, **kwargs)
        except TrajoptError as error:
            tell_error(error)
            raise typer.Exit(exit_code(error)) from None

    return run
