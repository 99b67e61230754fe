"""What every command shares: errors to sentences and exit codes, and tables."""

from __future__ import annotations

import os
import shutil
import sys
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import wraps

import typer

from ..problems.errors import FileError, Mistake, SpecError, TrajoptError

NOT_SOLVED, USER_MISTAKE, FILE_TROUBLE, INTERRUPTED = 1, 2, 3, 130
ENDLESS = 100_000  # letters: the width of what is no terminal
WORDS = 12  # letters that a column of words can do with


SHORT_FORMS = {
    "mesh.*.method": "--method",
    "mesh.-1.segments": "--segments",
    "mesh.-1.tolerance": "--tol",
    "refine.tolerance": "--refine",
}
"""Options that stand for an override, by its path; messages name the option."""


def exit_code(error: TrajoptError) -> int:
    return {SpecError: USER_MISTAKE, FileError: FILE_TROUBLE}[type(error)]


def report(error: TrajoptError) -> None:
    """One sentence for each mistake, on standard error."""
    for mistake in error.mistakes:
        short = SHORT_FORMS.get(mistake.where.removeprefix("--set "), mistake.where)
        print(f"error: {one_line(str(replace(mistake, where=short)))}", file=sys.stderr)


def command(function: Callable) -> Callable:
    """Turn the errors that are the user's into sentences and exit codes; those that are ours keep their traceback."""

    @wraps(function)
    def run(*args, **kwargs):
        try:
            with _flushed_output():
                function(*args, **kwargs)
        except TrajoptError as error:
            report(error)
            raise typer.Exit(exit_code(error)) from None
        except KeyboardInterrupt:
            print("interrupted; nothing was written", file=sys.stderr)
            raise typer.Exit(INTERRUPTED) from None

    return run


@contextmanager
def _flushed_output() -> Iterator[None]:
    """Write standard output while errors can still be told. A reader that has gone, as in `| head -1`, is none."""
    try:
        try:
            yield
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        _discard_output()
        raise typer.Exit(0) from None
    except OSError as error:
        _discard_output()
        what = f"it cannot be written ({error.strerror})"
        raise FileError(Mistake("standard output", what, "send it elsewhere")) from error


def _discard_output() -> None:
    """What is still in the buffer must not fail again when Python ends."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


@contextmanager
def native_output(descriptor: int) -> Iterator[None]:
    """What libraries in C (IPOPT) print on standard output goes to another descriptor: ours carries results only."""
    import ctypes

    flush = ctypes.CDLL(None).fflush
    sys.stdout.flush()
    flush(None)
    saved = os.dup(1)
    os.dup2(descriptor, 1)
    try:
        yield
    finally:
        flush(None)
        os.dup2(saved, 1)
        os.close(saved)


def load_all(files: Sequence[str], overrides: Sequence[str] = ()) -> list:
    """Load every problem, by file or by shipped name, and check its methods and solver options.

    Raises SpecError with the mistakes of all files, or the FileError of the first that cannot be read.
    """
    from ..problems.catalog import find
    from ..problems.load import load
    from ..transcription.schemes import METHODS

    specs, mistakes = [], []
    for name in files:
        try:
            spec = load(find(name), overrides, tuple(METHODS), _check_options)
            mistakes += spec.locate(_check_meshes(spec.mesh))
            specs.append(spec)
        except SpecError as error:
            mistakes += error.mistakes
    if mistakes:
        raise SpecError(dict.fromkeys(mistakes))  # a wrong override is wrong for every file, and told once
    return specs


@contextmanager
def located(spec) -> Iterator[None]:
    """Mistakes that only the solution of a problem finds, at their place in its file."""
    try:
        yield
    except SpecError as error:
        raise SpecError(spec.locate(error.mistakes)) from error


def _check_meshes(schedule) -> list[Mistake]:
    """What only the methods know: the degrees, forms, substeps and controls they have."""
    from ..transcription.schemes import find

    mistakes = []
    for number, entry in enumerate(schedule):
        for degree in set(entry.degree) if isinstance(entry.degree, tuple) else {entry.degree}:
            try:
                find(entry.method, degree, entry.form, entry.substeps, entry.control)
            except SpecError as error:
                mistakes += [_in_entry(mistake, number) for mistake in error.mistakes]
    return mistakes


def _in_entry(mistake: Mistake, number: int) -> Mistake:
    """A mistake of the methods at its place in the schedule."""
    key = mistake.where.removeprefix("mesh.")
    return replace(mistake, where=f"mesh.{number}.{key if key in ('substeps', 'control') else 'degree'}")


def _check_options(engine: str, options: Mapping) -> list[Mistake]:
    if not options:
        return []
    if engine == "newton":
        from ..transcription.newton import check_options

        return check_options(options)
    from ..transcription.ipopt import check_options

    with open(os.devnull, "w") as nowhere, native_output(nowhere.fileno()):  # IPOPT complains too, less clearly
        return check_options(options)


def print_table(columns: Sequence[str], rows: Sequence[Sequence[str]], right: Sequence[str] = ()) -> None:
    """A table on standard output; the columns named in `right` hold numbers.

    On a terminal that is wide enough, texts of several words go on below themselves. Elsewhere a row is one line, whole
    and plain, for grep and awk.
    """
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = Console(force_terminal=sys.stdout.isatty())
    table, needed = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style=""), 0
    for column, *cells in zip(columns, *rows, strict=True):
        words = any(" " in cell for cell in (column, *cells))
        needed += WORDS if words else 2 + max(map(len, (column, *cells)))
        side = "right" if column in right else "left"
        table.add_column(Text.assemble((one_line(column), "bold")), justify=side, no_wrap=not words, overflow="fold")
    for row in rows:
        table.add_row(*(Text(one_line(cell)) for cell in row))
    if not console.is_terminal or needed > console.width:
        console.width = ENDLESS
    with console.capture() as drawn:
        console.print(table)
    print("\n".join(line.rstrip() for line in drawn.get().rstrip("\n").split("\n")))


def print_field(name: str, text: str) -> None:
    """One line "name  text"; longer than a terminal is wide, it goes on below the text."""
    lines = [one_line(text)]
    if sys.stdout.isatty():
        lines = textwrap.wrap(lines[0], max(_width() - 12, 20), break_long_words=False, break_on_hyphens=False)
    print(f"{name:<12}" + "\n            ".join(lines))


def one_line(text: str) -> str:
    """The text without line breaks or characters that would steer a terminal."""
    return "".join(" " if c.isspace() else c if c.isprintable() else "?" for c in text.strip())


def plural(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}{'es' if noun.endswith('sh') else 's'}"


def _width() -> int:
    return shutil.get_terminal_size().columns
