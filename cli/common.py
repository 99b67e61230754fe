"""What every command shares: errors to sentences and exit codes, and the loading of problem files."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import wraps

import typer

from ..problems.errors import FileError, Mistake, SpecError, TrajoptError
from .options import SHORT_FORMS
from .output.printing import one_line

NOT_SOLVED, USER_MISTAKE, FILE_TROUBLE, INTERRUPTED = 1, 2, 3, 130


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
    from ..problems.catalog import find_problem
    from ..problems.load import load
    from ..transcription.schemes.table import METHODS, check_schedule

    specs, mistakes = [], []
    for name in files:
        try:
            spec = load(find_problem(name), overrides, tuple(METHODS), _check_options)
            mistakes += spec.locate(check_schedule(spec.mesh))
            specs.append(spec)
        except SpecError as error:
            mistakes += error.mistakes
    if mistakes:
        raise SpecError(dict.fromkeys(mistakes))  # a wrong override is wrong for every file, and told once
    return specs


def build_checked(specs: Sequence) -> list[list]:
    """The problems of each spec, one for each mesh; what only the methods know of them is asked before any is solved.

    Raises SpecError with all that cannot be transcribed, in any of the files.
    """
    from ..problems.build import build_all
    from ..transcription.settings import steps
    from ..transcription.solve import planned

    built, mistakes = [], []
    for spec in specs:
        try:
            with located(spec):
                built.append(build_all(spec))
                planned(built[-1], steps(spec.mesh))
        except SpecError as error:
            mistakes += error.mistakes
    if mistakes:
        raise SpecError(dict.fromkeys(mistakes))
    return built


@contextmanager
def located(spec) -> Iterator[None]:
    """Mistakes that only the solution of a problem finds, at their place in its file."""
    try:
        yield
    except SpecError as error:
        raise SpecError(spec.locate(error.mistakes)) from error


def _check_options(engine: str, options: Mapping) -> list[Mistake]:
    if not options:
        return []
    if engine == "newton":
        from ..transcription.engines.newton import check_options

        return check_options(options)
    from ..transcription.engines.ipopt import check_options

    with open(os.devnull, "w") as nowhere, native_output(nowhere.fileno()):  # IPOPT complains too, less clearly
        return check_options(options)
