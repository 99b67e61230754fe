"""Problem files -> specs and problems, with every mistake of every file."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager

from ..problems.errors import Mistake, SpecError
from .streams import native_output


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
