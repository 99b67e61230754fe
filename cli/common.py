"""What every command shares: errors to sentences and exit codes, and the consoles."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from functools import wraps

import typer

from ..problems.errors import FileError, SpecError, TrajoptError

NOT_SOLVED, USER_MISTAKE, FILE_TROUBLE, INTERRUPTED = 1, 2, 3, 130


def exit_code(error: TrajoptError) -> int:
    return {SpecError: USER_MISTAKE, FileError: FILE_TROUBLE}[type(error)]


def report(error: TrajoptError) -> None:
    """One sentence for each mistake, on standard error."""
    for mistake in error.mistakes:
        print(f"error: {mistake}", file=sys.stderr)


def command(function: Callable) -> Callable:
    """Turn the errors that are the user's into sentences and exit codes; those that are ours keep their traceback."""

    @wraps(function)
    def run(*args, **kwargs):
        try:
            function(*args, **kwargs)
        except TrajoptError as error:
            report(error)
            raise typer.Exit(exit_code(error)) from None
        except KeyboardInterrupt:
            print("interrupted before there was anything to store", file=sys.stderr)
            raise typer.Exit(INTERRUPTED) from None
        except BrokenPipeError:  # the reader of our output has gone, as in `trajopt show x.h5 | head -1`
            sys.stderr.close()
            raise typer.Exit(0) from None

    return run


def load_all(files: Sequence[str], overrides: Sequence[str] = ()) -> list:
    """Load every problem, by file or by shipped name, and check its methods and solver options.

    Raises SpecError with the mistakes of all files, or the FileError of the first that cannot be read.
    """
    from ..problems.catalog import find
    from ..problems.load import load
    from ..transcription.ipopt import check_options
    from ..transcription.schemes import TABLE

    specs, mistakes = [], []
    for name in files:
        try:
            spec = load(find(name), overrides, tuple(TABLE))
            mistakes += spec.locate(check_options(spec.solver.options))
            specs.append(spec)
        except SpecError as error:
            mistakes += error.mistakes
    if mistakes:
        raise SpecError(mistakes)
    return specs


def print_table(columns: Sequence[str], rows: Sequence[Sequence[str]], right: Sequence[str] = ()) -> None:
    """A plain table on standard output; the columns named in `right` hold numbers.

    It is fitted to a terminal; where there is none, lines are as long as they are, for grep and awk.
    """
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    terminal = sys.stdout.isatty()
    table = Table(box=None, pad_edge=False, header_style="bold", padding=(0, 2, 0, 0))
    for column in columns:
        table.add_column(column, justify="right" if column in right else "left", no_wrap=not terminal)
    for row in rows:
        table.add_row(*map(Text, row))
    console = Console(width=None if terminal else 10_000)
    with console.capture() as lines:
        console.print(table)
    print("\n".join(line.rstrip() for line in lines.get().splitlines()))


def plural(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}{'es' if noun.endswith('sh') else 's'}"
