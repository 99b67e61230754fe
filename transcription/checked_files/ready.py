"""Problem files -> all that solving them needs, from the cache where they have been read before.

What was read from the cache has been checked when it was kept: neither the schema nor pydantic is loaded for it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING, Any

from ...problems.errors import Mistake
from ...problems.lean.records import dataclass
from ...problems.problem import Curves, Problem
from ..cache.kept import keep, load_kept, name_of_kept
from ..engines.table import check_engine_options
from ..loading import build_checked, load_all, load_yaml
from ..settings import Settings, Step

if TYPE_CHECKING:  # pydantic; and the solver, which is loaded when there is something to solve
    from ...problems.schema.spec import Spec
    from ..solution.solution import Solution


@dataclass(frozen=True)
class Ready:
    """A problem file without mistakes.

    name: of the problem. file, text: as it was given. given: overrides, "PATH=VALUE" each. overrides: the same by path.
    full: the problem with every default, JSON. warnings: what is odd in it. problems: one for each entry of the
    schedule. direct: whether nothing is to be solved on the way to it. loaded: its spec, where there is one at hand.
    """

    name: str
    file: str
    text: str
    given: tuple[str, ...]
    overrides: Mapping[str, Any]
    full: str
    warnings: tuple[Mistake, ...]
    problems: list[Problem]
    schedule: list[tuple[Step, ...]]
    settings: Settings
    direct: bool
    loaded: Spec | None = None

    def spec(self) -> Spec:
        """The spec of the file, read again where it came from the cache."""
        return self.loaded or load_yaml(self.text, self.given, self.file)

    def solve(
        self,
        *,
        guess: Sequence[Curves] | None = None,
        progress: Callable[[int, dict], None] | None = None,
        stop: Callable[[], bool] | None = None,
    ) -> Solution:
        """The solution, as of `continuation.solve_spec`.

        guess, progress, stop: as that takes them.
        """
        from ..solve import solve

        if not self.direct and guess is None:
            from ..continuation import solve_spec

            return solve_spec(self.spec(), self.problems, progress=progress, stop=stop)
        began = perf_counter()
        solution = solve(self.problems, self.schedule, self.settings, guess=guess, progress=progress, stop=stop)
        return solution.since(began)


def ready_all(files: Sequence[str], given: Sequence[str] = (), stdin: str | None = None) -> list[Ready]:
    """Several files, checked and ready to be solved.

    files, stdin: as `loading.load_all` takes them.
    given: overrides of all of them.

    Raises SpecError with the mistakes of all files, or the FileError of the first that cannot be read.
    """
    known = [_known(file, tuple(given)) for file in files] if stdin is None else [None]
    found = [own for own in known if own is not None]
    if len(found) == len(files):
        return found
    from ...problems.tables.columns import opened_table

    before = opened_table()
    specs = load_all(files, given, stdin)
    made = [ready(spec, problems, given) for spec, problems in zip(specs, build_checked(specs), strict=True)]
    if stdin is None and opened_table() == before:  # a CSV file may be another the next time
        for own in made:
            if own.direct:
                keep(_name(own.file, own.text, own.given), replace(own, loaded=None))
    return made


def ready(spec: Spec, problems: list[Problem], given: Sequence[str] = ()) -> Ready:
    """A spec that is checked, and its problems, as what is ready to be solved.

    spec: without mistakes.
    problems: one for each entry of its mesh schedule.
    given: the overrides in it.
    """
    from ..continuation import is_direct
    from ..settings import schedule_of, settings_of

    return Ready(
        spec.name,
        spec.file,
        spec.text,
        tuple(given),
        spec.overrides,
        spec.model_dump_json(),
        tuple(spec.warnings),
        problems,
        schedule_of(spec),
        settings_of(spec),
        is_direct(spec),
        spec,
    )


def _name(file: str, text: str, given: tuple[str, ...]) -> str | None:
    return name_of_kept("problem file", (file, text, given))


def _known(file: str, given: tuple[str, ...]) -> Ready | None:
    """What is known of a file from the cache; None for what is to be read as if for the first time.

    The engine is asked about its options again: which it takes depends on what is installed beside it.
    """
    from ...problems.catalog import find_problem

    path = find_problem(file)
    if not path.is_file():
        return None
    try:
        text = path.read_bytes().decode()
    except (OSError, UnicodeDecodeError):
        return None  # which `load_all` tells as it should be told
    found: Ready | None = load_kept(_name(str(path), text, given))
    if found is None or check_engine_options(found.settings.engine, found.settings.options):
        return None
    return found
