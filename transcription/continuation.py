"""Getting to a hard problem through easier ones: a schedule of values, each solved from the solution before it.

The last values are those of the file. Where a solve fails, the step is halved; after two that do not, it is doubled
up to a whole step of the schedule (Kelly 2017, section 5.1 and 5.5: solve an easier problem first). On the way the
first mesh is enough; the problem of the file itself is solved as the file asks.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import ceil, floor
from time import perf_counter
from typing import Any

import numpy as np

from ..problems.build import build_all
from ..problems.errors import SpecError
from ..problems.lean.records import dataclass
from ..problems.load import load_text
from ..problems.problem import Curves, Problem
from ..problems.schema.spec import Spec
from ..problems.text import did_you_mean, shorten
from ..problems.yaml.locations import Finding
from .engines.outcome import Status
from .engines.watch import Limit
from .settings import Settings, schedule_of, settings_of
from .solution.solution import ContinuationStep, Solution
from .solve import solve
from .starts.near import Near, what_is_left

SMALLEST = 1 / 64
"""Of a step of the schedule: where it would be smaller, the way ends."""

RELAX = "relax"
"""The key of a complementarity that is walked through."""

SECTIONS = ("parameters", "time", "states", "controls", "algebraic", "optimize", "constraints", "links", "phases")
"""What has numbers that are looked at for a path that leads to none."""

CUT_SHORT = (Status.INTERRUPTED, Status.TIME_LIMIT)

Progress = Callable[[int, dict], None] | None
Stop = Callable[[], bool] | None


def solve_spec(
    spec: Spec,
    problems: Sequence[Problem],
    *,
    guess: Sequence[Curves] | None = None,
    near: Near | None = None,
    progress: Progress = None,
    stop: Stop = None,
) -> Solution:
    """Solve the problem of a file, through the problems of its `continuation:` if it has one.

    spec: of the file.
    problems: one for each entry of its mesh schedule.
    guess, near, progress, stop: as of `solve.solve`; with a guess there is no continuation.

    Raises SpecError as `solve.solve` does.
    """
    began = perf_counter()
    if guess is not None or is_direct(spec):
        how = schedule_of(spec), settings_of(spec)
        solution = solve(problems, *how, guess=guess, near=near, progress=progress, stop=stop)
    else:
        solution = _Way(spec, problems, progress, stop).walked()
    return solution.since(began)


def is_direct(spec: Spec) -> bool:
    """Whether no other problem is solved on the way to that of the file."""
    return not (spec.continuation or any(_relaxed(spec)))


def way_of(spec: Spec) -> dict[str, list[float]]:
    """Path -> the values to go through, the file's own the last; empty if there is nothing on the way.

    What complementarity is relaxed to goes down beside what `continuation:` names, whichever is longer.

    Raises SpecError if a path leads to no number, or the problem with a value on the way has mistakes.
    """
    data = json.loads(spec.model_dump_json()) if spec.continuation else {}
    way, own, wrong = {}, {}, []
    for given, values in spec.continuation.items():
        path = re.sub(r"^waypoints\.(\d+)\.(?!(?:states|time|name)\b)", r"waypoints.\1.states.", given)  # long form
        number = _number_at(data, path)
        if number is None:
            what = f"{path} is no number in this file, so there is nothing to go through"
            wrong.append(Finding(("continuation", path), what, _meant(path, data)))
        else:
            way[path], own[path] = list(values), number
    if any(values[-1] != own[path] for path, values in way.items()):
        as_long = len({len(values) for values in way.values()}) == 1  # then a file's own value at the end stands twice
        way = {p: values if values[-1] == own[p] and not as_long else [*values, own[p]] for p, values in way.items()}
    if not wrong and len({len(values) for values in way.values()}) > 1:
        what = "the lists of values do not have one length, the values of the file counted"
        wrong.append(Finding(("continuation",), what, "give all of them the same number of values"))
    for k in range(0 if wrong or not way else len(next(iter(way.values()))) - 1):
        try:
            _at(spec, {path: values[k] for path, values in way.items()})
        except SpecError as error:
            told = "; ".join(f"{m.what}" for m in error.mistakes[:2])
            wrong.append(
                Finding(("continuation",), f"with the values {k + 1} of the lists: {told}", "change these values")
            )
    if wrong:
        raise SpecError(spec.locate_findings(wrong))
    way |= _relaxed(spec)
    longest = max(map(len, way.values()), default=0)
    return {path: [*values, *values[-1:] * (longest - len(values))] for path, values in way.items()}


def _relaxed(spec: Spec) -> dict[str, list[float]]:
    """What each complementarity that is relaxed step by step goes through."""
    owners = {"": spec.complementarity}
    owners |= {f"phases.{name}.": phase.complementarity for name, phase in spec.phases.items()}
    return {
        f"{where}complementarity.{i}.{RELAX}": list(pair.relax)
        for where, pairs in owners.items()
        for i, pair in enumerate(pairs)
        if len(pair.relax) > 1
    }


def _node_at(data: Any, path: str) -> Any:
    for step in path.split("."):
        if isinstance(data, list):
            data = data[int(step)] if step.isdigit() and int(step) < len(data) else None
        else:
            data = data.get(step) if isinstance(data, dict) else None
    return data


def _number_at(data: Any, path: str) -> float | None:
    data = _node_at(data, path)
    data = data.get("value") if isinstance(data, dict) else data
    return float(data) if isinstance(data, int | float) and not isinstance(data, bool) else None


def _meant(path: str, data: Mapping[str, Any]) -> str:
    """The remedy for a path that leads to no number: the numbers of the file that have its steps in theirs."""
    known = list(_numbers(data))
    close = [own for own in known if f".{path}." in f".{own}."]
    if not close:
        example = next((own for own in known if own.startswith("parameters.")), known[0] if known else "")
        other = f"name a number, such as {example}" if example else "make one a parameter, parameters: {g: 9.81}"
        return did_you_mean(path, known, other)
    return f"write {close[0]}" if len(close) == 1 else f"name one number: {shorten(', '.join(close), 120)}"


def _numbers(data: Mapping[str, Any]) -> Iterator[str]:
    """The paths of the numbers of a file that say something of its problem."""
    for section in SECTIONS:
        inside = [section]
        while inside:
            path = inside.pop()
            if _number_at(data, path) is not None:
                yield path
                continue
            node = _node_at(data, path)
            keys = node if isinstance(node, dict) else range(len(node)) if isinstance(node, list) else ()
            inside += [f"{path}.{key}" for key in reversed(list(keys))]


def _at(spec: Spec, values: Mapping[str, float]) -> Spec:
    """The file with other values, solved on its first mesh only."""
    return load_text(spec.model_dump_json(), spec.file, [f"{path}={value!r}" for path, value in values.items()])


def _between(low: float, high: float, share: float, relaxed: bool) -> float:
    """A value between two of the schedule; of a relaxation, which spans orders of magnitude, a geometric mean."""
    return low ** (1 - share) * high**share if relaxed else low + share * (high - low)


@dataclass
class _Way:
    """spec, problems: of the file. steps: those that are done."""

    spec: Spec
    problems: Sequence[Problem]
    progress: Progress
    stop: Stop

    def __post_init__(self) -> None:
        self.values = way_of(self.spec)
        self.last = len(next(iter(self.values.values()))) - 1
        self.steps: list[ContinuationStep] = []
        self.limit = Limit(settings_of(self.spec).seconds, self.stop)

    def walked(self) -> Solution:
        """The solution of the file's problem, or that of the first step that cannot be made."""
        at, step, failed = 0.0, 1.0, False
        first = solution = self._solved(0.0, None)
        while solution.status.usable and at < self.last:
            target = min(at + step, floor(at) + 1.0)
            following = self._solved(target, solution)
            if following.status.usable:
                at, solution = target, following
                step, failed = step if failed else min(2 * step, 1.0), False
                continue
            step, failed = step / 2, True
            if step < SMALLEST or following.status in CUT_SHORT:
                solution = following
        told = () if self._at_the_end else (self._ended(),)
        drawn = first.notes if settings_of(self.spec).starts and solution is not first else ()
        notes = (*(f"of the first problem on the way: {note}" for note in drawn), *solution.notes, *told)
        return replace(solution, continuation=tuple(self.steps), notes=notes)

    @property
    def _at_the_end(self) -> bool:
        """Whether the last problem that was solved, or tried, is that of the file."""
        return all(self.steps[-1].values[path] == own[-1] for path, own in self.values.items())

    def _ended(self) -> str:
        """What is told where the way ends before the problem of the file."""
        values = ", ".join(f"{path} = {value:g}" for path, value in self.steps[-1].values.items())
        which = "the first problem" if len(self.steps) == 1 else "a problem"
        return (
            f"all this is of {which} of continuation:, {values}, which is not solved; that of the file was not reached"
        )

    def _settings(self) -> Settings:
        """Those of the file, with the time that is left of its limit."""
        settings = settings_of(self.spec)
        return settings if settings.seconds is None else replace(settings, seconds=max(self.limit.left(), 0.0))

    def _solved(self, at: float, before: Solution | None) -> Solution:
        """The solution at a place of the schedule, 0 for its first values, from the one before."""
        low, high = floor(at), ceil(at)
        relaxed, share = _relaxed(self.spec), at - low
        values = {path: _between(own[low], own[high], share, path in relaxed) for path, own in self.values.items()}
        if at == self.last:
            problems, schedule, settings = list(self.problems), schedule_of(self.spec), self._settings()
        else:
            spec = _at(self.spec, values)
            problems, schedule = build_all(spec)[:1], schedule_of(spec)[:1]
            own = self._settings()
            settings = replace(own, refine=None, starts=0 if before else own.starts)
        guess, left = (before.trajectories, what_is_left(before)) if before else (None, None)
        solution = solve(problems, schedule, settings, guess=guess, near=left, progress=self.progress, stop=self.stop)
        iterations = sum(mesh.iterations for mesh in solution.meshes)
        objective = solution.objective if solution.status.usable else np.nan
        self.steps.append(ContinuationStep(values, solution.status, objective, iterations))
        return solution
