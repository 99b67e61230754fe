"""One case, in the process that solves it: a task in, an answer out, both plain data that pickle.

Nothing is written here: the process that started the sweep does that, so that a worker may be killed at any moment,
and may run where the folder is not.
"""

from __future__ import annotations

import json
import re
import time
from collections.abc import Mapping
from dataclasses import field, replace
from hashlib import sha256
from typing import Any

import numpy as np

from ...problems.errors import SpecError
from ...problems.lean.records import dataclass
from ...problems.problem import Guess, Problem
from ...problems.schema.spec import Spec
from ...problems.text import short_repr
from ...transcription.continuation import solve_spec
from ...transcription.loading import build_checked, load_yaml, located
from ...transcription.solution.solution import Solution
from ...transcription.starts.near import Near, further, what_is_left
from ..file.guess import adapted
from ..file.json_values import for_json
from ..file.summary import causes
from ..file.write import image_of
from .check import in_case

INTERRUPTED, MISTAKE, ERROR, WORKER_DIED = "interrupted", "mistake", "error", "worker died"
"""What can become of a case besides the statuses of the engine."""

KEY = "[0-9a-f]{20}"
"""What the names of cases look like."""

NUMBERS = ("objective", "objective_error", "final_time")
"""Of a record; None where there is none."""

Curves = Mapping[str, Guess]
"""Name of a phase -> its curves."""


@short_repr
@dataclass(frozen=True)
class Left:
    """What a solved case leaves for its neighbours; near: where its multipliers are known."""

    curves: Curves
    near: Near | None = None

    def ahead(self, earlier: Left, share: float) -> Left:
        """What to start the next case from: it is foretold by the line through this one and an earlier one.

        earlier: the one that this one was started from.
        share: the step to the next case, as a part of that from the earlier to this one.

        This one itself, where the two are not of the same points and names.
        """
        pairs = [(own, earlier.curves.get(name)) for name, own in self.curves.items()]
        if self.near is None or earlier.near is None or not self.near.is_like(earlier.near):
            return self
        if any(before is None or _named(own) != _named(before) for own, before in pairs):
            return self
        curves = {name: _ahead(own, earlier.curves[name], share) for name, own in self.curves.items()}
        if any(own.final_time <= own.initial_time for own in curves.values()):
            return self
        return Left(curves, self.near.ahead(earlier.near, share))


def _named(curves: Guess) -> tuple[list[str], list[str]]:
    return list(curves.values), list(curves.parameters)


def _ahead(own: Guess, earlier: Guess, share: float) -> Guess:
    """Curves a step on from two at the same points, as of `Left.ahead`."""
    t0 = further(own.initial_time, earlier.initial_time, share)
    tF = further(own.final_time, earlier.final_time, share)
    values = {name: further(curve, earlier.values[name], share) for name, curve in own.values.items()}
    parameters = {name: further(value, earlier.parameters[name], share) for name, value in own.parameters.items()}
    return Guess(t0, tF, own.s, values, parameters)


@short_repr
@dataclass(frozen=True)
class Task:
    """One case to be solved.

    number: of the case. values: path -> value, as YAML, of what is swept. text, file: the problem file. overrides:
    those of the command line, for every case. origin: the case to start from and what it leaves; None for the guess of
    the file. line: what the case before that one left, and the step to this one, see `Left.ahead`; None where they are
    on no line. chain: whether others may start from it. full: whether the image of the result file is wanted. command:
    that it tells.
    """

    number: int
    values: Mapping[str, str]
    text: str
    file: str
    overrides: tuple[str, ...]
    origin: tuple[int, Left] | None = None
    line: tuple[Left, float] | None = None
    chain: bool = False
    full: bool = False
    command: str = ""


@short_repr
@dataclass(frozen=True)
class Answer:
    """What became of a case: a record that JSON can hold, see `record_of`; what it leaves for others; its result file
    if asked."""

    record: dict[str, Any]
    left: Left = field(default_factory=lambda: Left({}))
    image: bytes | None = None


_watched: list[Any] = []


def watch(flag: Any) -> None:
    """From now on the solves of this process end when `flag.value` is not zero; None for no flag."""
    _watched[:] = [] if flag is None else [flag]


def _stop() -> bool:
    return any(flag.value for flag in _watched)


def solve_case(task: Task) -> Answer:
    """Solve one case. A mistake in it, or a bug of ours, is a record as well: neither ends a sweep."""
    began = time.perf_counter()
    try:
        answer = _solved(task)
    except SpecError as error:
        told = " ".join(str(in_case(mistake, task.values)) for mistake in error.mistakes)
        answer = Answer(failed(task.number, task.values, MISTAKE, told))
    except Exception as error:
        told = f"{type(error).__name__}: {error}"
        answer = Answer(failed(task.number, task.values, ERROR, told))
    return replace(answer, record={**answer.record, "seconds": time.perf_counter() - began})


def failed(number: int, values: Mapping[str, str], status: str, message: str) -> dict[str, Any]:
    """The record of a case that has no solution.

    number: of the case.
    values: path -> value of what is swept.
    status: one word.
    message: a sentence.
    """
    head = {"case": number, "key": "", "values": dict(values), "status": status, "solved": False, "message": message}
    numbers = {"objective": None, "objective_error": None, "iterations": 0, "seconds": 0.0, "final_time": None}
    return {**head, "inaccurate": "", "start": "", **numbers, "initial": {}, "final": {}, "parameters": {}}


def _solved(task: Task) -> Answer:
    overrides = [*task.overrides, *(f"{path}={value}" for path, value in task.values.items())]
    spec = load_yaml(task.text, overrides, task.file)
    (problems,) = build_checked([spec])
    with located(spec):
        solution, start = _tried(task, spec, problems)
    record = record_of(task, solution, start, _key(spec, overrides))
    if _stop() and not solution.solved:
        record["status"] = INTERRUPTED
    left = Left({})
    if solution.solved:
        left = Left(
            {t.phase.name: _as_guess(t) for t in solution.trajectories}, what_is_left(solution) if task.chain else None
        )
    image = image_of(solution, spec.text, spec.model_dump_json(), task.command, spec.overrides) if task.full else None
    return Answer(record, left, image)


def _tried(task: Task, spec: Spec, problems: list[Problem]) -> tuple[Solution, str]:
    """The solution, and what it was started from, in words: what is foretold, the neighbour as it is, else the guess of
    the file."""
    if task.origin:
        neighbour, left = task.origin
        ahead, phases = left.ahead(*task.line) if task.line else left, problems[0].phases
        for own in (left,) if ahead is left else (ahead, left):
            curves = own.curves
            guess = [adapted(curves[phase.name], phase) if phase.name in curves else phase.guess for phase in phases]
            solution = solve_spec(spec, problems, guess=guess, near=own.near, stop=_stop)
            if solution.solved or _stop():
                return solution, f"case {neighbour}"
    return solve_spec(spec, problems, stop=_stop), "guess"


def _key(spec: Spec, overrides: list[str]) -> str:
    """The name of a case: a hash of the problem with every default, and of what made it of the file."""
    resolved = [spec.model_dump(mode="json", exclude={"sweep"}), overrides]
    return sha256(json.dumps(resolved, sort_keys=True).encode()).hexdigest()[:20]


def _as_guess(trajectory: Any) -> Guess:
    """The solution at the points of its mesh, as a guess."""
    s = trajectory.mesh.fractions
    values = {name: np.nan_to_num(curve) for name, curve in trajectory.samples(s).items()}
    return Guess(trajectory.initial_time, trajectory.final_time, s, values, dict(trajectory.parameters))


def record_of(task: Task, solution: Solution, start: str, key: str) -> dict[str, Any]:
    """What the index, the table and the arrays hold of a case.

    task: the case.
    solution: solved or not.
    start: what it was started from.
    key: its name.
    """
    first, last = solution.trajectories[0], solution.trajectories[-1]
    why = causes(solution.trouble, solution.violations, solution.involved)[:1]
    record = {
        "case": task.number,
        "key": key,
        "values": dict(task.values),
        "status": solution.status.name.lower(),
        "solved": solution.solved,
        "message": "; ".join([solution.status.message, *why]),
        "inaccurate": solution.inaccurate if solution.solved else "",
        "start": start,
        "objective": solution.objective,
        "objective_error": solution.objective_error.bar,
        "iterations": sum(mesh.iterations for mesh in solution.meshes),
        "seconds": 0.0,
        "final_time": last.final_time,
        "initial": _ends(first, 0),
        "final": _ends(last, -1),
        "parameters": dict(last.parameters),
    }
    told: dict[str, Any] = for_json(record)
    return told


def is_record(told: Any) -> bool:
    """Whether plain data, as a file has them, are what `record_of` or `failed` gives."""
    return (
        isinstance(told, dict)
        and isinstance(told.get("case"), int)
        and isinstance(told.get("solved"), bool)
        and isinstance(told.get("values"), dict)
        and isinstance(told.get("key"), str)
        and bool(re.fullmatch(KEY if told["solved"] else f"({KEY})?", told["key"]))
        and all(isinstance(told.get(name), str) for name in ("status", "message", "inaccurate", "start"))
        and all(isinstance(told.get(name), int | float) for name in ("iterations", "seconds"))
        and all(isinstance(told.get(name, ""), int | float | None) for name in NUMBERS)
        and not (told["solved"] and told["objective"] is None)
        and all(_is_named(told.get(name)) for name in ("initial", "final", "parameters"))
    )


def _is_named(told: Any) -> bool:
    """Whether it is name -> number, or None for one that is not finite."""
    return isinstance(told, dict) and all(isinstance(value, int | float | None) for value in told.values())


def _ends(trajectory: Any, index: int) -> dict[str, float]:
    return {state.name: values[index] for state, values in zip(trajectory.phase.states, trajectory.x, strict=True)}
