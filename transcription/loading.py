"""Problem files -> specs and problems that are ready to be solved, with every mistake of every file.

What `problems.load` cannot know is asked here of those who do: the methods of a mesh, the options of the engine, and
whether there is a nonlinear program at all.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ..problems.errors import Mistake, SpecError

if TYPE_CHECKING:  # `trajopt --help` imports this module; it needs no pydantic
    from ..problems.load import MoreChecks
    from ..problems.problem import Problem
    from ..problems.schema.spec import Spec

TEXT, STDIN = "text", "standard input"
"""The names, in messages, of problem files that are none: a text, and what was piped in."""


def load_file(name: str, overrides: Sequence[str] = (), units: bool = False) -> Spec:
    """The spec of one problem, its methods and the options of its engine checked.

    name: of a file, or of a shipped problem.
    overrides: "PATH=VALUE" each, as `problems.load.load` takes them.
    units: whether the units of its expressions are checked too, for which pint is imported.

    Raises FileError if there is no such file, and SpecError with all the mistakes in the problem and the overrides.
    """
    from ..problems.catalog import find_problem
    from ..problems.load import load
    from .engines.table import check_engine_options
    from .schemes.table import METHODS

    return _with_methods_checked(
        load(find_problem(name), overrides, tuple(METHODS), check_engine_options, _more(units))
    )


def _more(units: bool) -> MoreChecks | None:
    """The checks that only some ask for."""
    from ..problems.units.check import check_units

    return check_units if units else None


def load_yaml(text: str, overrides: Sequence[str] = (), file: str = TEXT, units: bool = False) -> Spec:
    """As `load_file`, from the text of a problem file.

    text: YAML.
    overrides: as of `load_file`.
    file: the name used in messages; without its suffix, the name of a problem that gives none. CSV files of tables are
        looked for in its folder, if it is the name of a file.
    units: as of `load_file`.
    """
    from ..problems.load import load_text
    from .engines.table import check_engine_options
    from .schemes.table import METHODS

    folder = None if file in (TEXT, STDIN) else Path(file).parent
    return _with_methods_checked(
        load_text(text, file, overrides, tuple(METHODS), check_engine_options, folder, _more(units))
    )


def _with_methods_checked(spec: Spec) -> Spec:
    from .schemes.table import check_schedule

    mistakes = check_schedule(spec.mesh)
    for name, own in spec.phases.items():
        mistakes += [replace(m, where=f"phases.{name}.{m.where}") for m in check_schedule(own.mesh or ())]
    if mistakes:
        raise SpecError(spec.locate(mistakes))
    return spec


def load_all(
    files: Sequence[str], overrides: Sequence[str] = (), stdin: str | None = None, units: bool = False
) -> list[Spec]:
    """Several specs as of `load_file`.

    files: names.
    overrides: of all of them.
    stdin: the text that the name "-" stands for; None if it is a name like any other.
    units: as of `load_file`.

    Raises SpecError with the mistakes of all files, or the FileError of the first that cannot be read.
    """
    specs: list[Spec] = []
    mistakes: list[Mistake] = []
    found: dict[str, tuple[Mistake, ...]] = {}
    for name in files:
        try:
            piped = name == "-" and stdin is not None
            text = stdin or ""
            specs.append(load_yaml(text, overrides, STDIN, units) if piped else load_file(name, overrides, units))
        except SpecError as error:
            found[name] = error.mistakes
    for name, own in found.items():
        mistakes += (_with_file(mistake, name) if _of_some(mistake, files, found) else mistake for mistake in own)
    if mistakes:
        raise SpecError(dict.fromkeys(mistakes))  # an override that is wrong for every file is told once
    return specs


def _of_some(mistake: Mistake, files: Sequence[str], found: Mapping[str, Sequence[Mistake]]) -> bool:
    """Whether an override is a mistake for some of the files only."""
    told = mistake.where, mistake.what
    everywhere = all(told in [(own.where, own.what) for own in found.get(name, ())] for name in files)
    return mistake.where.startswith("--set ") and not everywhere


def _with_file(mistake: Mistake, name: str) -> Mistake:
    return replace(mistake, where=f"{mistake.where} (in {name})")


def build_checked(specs: Sequence[Spec]) -> list[list[Problem]]:
    """The problems of each spec, one for each mesh; what only the methods know of them is asked before any is solved.

    Raises SpecError with all that cannot be transcribed, in any of the files.
    """
    from ..problems.build import build_all
    from .continuation import way_of
    from .settings import schedule_of
    from .transcribe import planned

    built: list[list[Problem]] = []
    mistakes: list[Mistake] = []
    for spec in specs:
        try:
            with located(spec):
                built.append(build_all(spec))
                planned(built[-1], schedule_of(spec))
            way_of(spec)
        except SpecError as error:
            mistakes += error.mistakes
    if mistakes:
        raise SpecError(dict.fromkeys(mistakes))
    return built


@contextmanager
def located(spec: Spec) -> Iterator[None]:
    """Mistakes that only the solution of a problem finds, at their place in its file."""
    try:
        yield
    except SpecError as error:
        raise SpecError(spec.locate(_at_home(spec, mistake) for mistake in error.mistakes)) from error


def _at_home(spec: Spec, mistake: Mistake) -> Mistake:
    """A mistake of a phase, at phases.NAME and a path in it, where the file says what is wrong."""
    from ..problems.phases.merge import home

    first, _, rest = mistake.where.partition(".")
    phase, _, path = rest.partition(".")
    if first != "phases" or not path:
        return mistake
    steps = tuple(int(step) if step.isdigit() else step for step in path.split("."))
    return replace(mistake, where=".".join(map(str, home(spec, phase, steps))))
