"""Solving, and reading back what was saved; nothing is printed, and a failed solve is data."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from math import nan
from pathlib import Path
from typing import Any

from ...problems.build import build_all
from ...problems.problem import Guess
from ...transcription.continuation import solve_spec
from ...transcription.loading import located
from ...transcription.solution.solution import MeshRecord, Solution
from ...transcription.solution.trajectory import Trajectory
from ..file.guess import guess_from
from ..file.reload import reload
from ..file.summary import causes, summarize
from ..file.write import image_of
from .messages import python_words, remedy_in_python
from .problem import LoadedProblem
from .solution import ErrorEstimate, Estimate, PhaseView, SensitivitiesView, SolutionView

COMMAND = "trajopt.solve(...)"
"""What a result file tells as the command."""


def solve(
    problem: LoadedProblem,
    *,
    guess: SolutionView | str | Path | None = None,
    progress: Callable[[int, dict[str, float]], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> SolutionView:
    """Solve a problem on each mesh of its schedule, and on refined ones if it asks for them.

    problem: of `trajopt.load`.
    guess: an earlier solution, or its file, whose curves are the start; what it lacks starts from the problem's own
        guess. None for the problem's own.
    progress: called in each iteration with the number of the solve, from 0, and the engine's record: name -> number,
        such as "iteration", "objective", "primal_infeasibility".
    stop: asked in each iteration; true ends the solve, and the last iterate is the result.

    A solve that fails is a result like any other: look at `solved` before you use it. Raises SpecError if the guess
    has none of the states, or if the engine cannot take the problem; FileError if the guess is no result file.
    """
    if not isinstance(problem, LoadedProblem):
        raise TypeError(f"solve takes what trajopt.load gives, not {type(problem).__name__}")
    spec, stages = problem.spec, list(problem.stages)
    with python_words():
        start = _start(guess, problem)
        with located(spec):
            solution = solve_spec(spec, stages, guess=start, progress=progress, stop=stop)
    return SolutionView(
        problem=problem,
        solved=solution.solved,
        status=solution.status.name.lower(),
        message=solution.status.message,
        remedy=remedy_in_python(solution.remedy),
        causes=tuple(causes(solution.trouble, solution.violations, solution.involved)),
        notes=tuple(solution.notes),
        objective=solution.objective,
        error=_error(solution.meshes, solution.objective_error.bar),
        meshes=solution.meshes,
        phases=_phases(solution.trajectories),
        _make_image=partial(image_of, solution, spec.text, spec.model_dump_json(), COMMAND, spec.overrides),
        _make_sensitivities=partial(_sensitivities, solution),
        estimates=_estimates(solution),
    )


def read(path: str | Path) -> SolutionView:
    """Read a result file, written by `save` or by the command line.

    It gives what `solve` gave: the same numbers, and functions of time by the same interpolants. Raises FileError if
    it cannot be read, is no result, or holds a problem that this version of trajopt cannot read.
    """
    source = Path(path)
    with python_words():
        again, summary = reload(source), summarize(source)
    bar = summary["objective_error"]
    return SolutionView(
        problem=LoadedProblem(again.spec, tuple(build_all(again.spec))),
        solved=again.solved,
        status=again.outcome.status.name.lower(),
        message=summary["message"],
        remedy=remedy_in_python(summary["remedy"]),
        causes=tuple(causes(summary["trouble"], summary["violations"], summary["involved"])),
        notes=tuple(summary["notes"]),
        objective=again.objective,
        error=_error(again.records, nan if bar is None else bar),
        meshes=again.records,
        phases=_phases(again.trajectories),
        _make_image=partial(bytes, source.read_bytes()),
        _make_sensitivities=partial(_stored_sensitivities, summary["sensitivities"]),
        estimates=_stored_estimates(summary["estimates"]),
    )


def _error(meshes: Sequence[MeshRecord], objective: float) -> ErrorEstimate:
    return ErrorEstimate(meshes[-1].max_eta, meshes[-1].relative_error, objective)


def _estimates(solution: Solution) -> dict[str, Estimate]:
    found = solution.estimates
    if found is None:
        return {}
    rows = zip(found.names, found.values.tolist(), found.deviations.tolist(), strict=True)
    return {name: Estimate(value, error) for name, value, error in rows}


def _stored_estimates(stored: dict[str, Any] | None) -> dict[str, Estimate]:
    parameters = stored["parameters"] if stored else {}
    return {name: Estimate(*(nan if own[key] is None else own[key] for key in Estimate._fields))
            for name, own in parameters.items()}  # fmt: skip


def _sensitivities(solution: Solution) -> SensitivitiesView:
    found, why_not = solution.sensitivities
    derivatives, notes = ({own.path: getattr(own, name) for own in found} for name in ("derivative", "note"))
    return SensitivitiesView(derivatives, {path: note for path, note in notes.items() if note}, why_not)


def _stored_sensitivities(stored: dict[str, Any]) -> SensitivitiesView:
    numbers = stored["numbers"].items()
    derivatives = {path: nan if own["derivative"] is None else own["derivative"] for path, own in numbers}
    return SensitivitiesView(
        derivatives, {path: own["note"] for path, own in numbers if own["note"]}, stored["missing"]
    )


def _start(guess: SolutionView | str | Path | None, problem: LoadedProblem) -> list[Guess] | None:
    if guess is None:
        return None
    return guess_from(guess.image if isinstance(guess, SolutionView) else Path(guess), problem.stages[0])


def _phases(trajectories: Sequence[Trajectory]) -> dict[str, PhaseView]:
    return {trajectory.phase.name: PhaseView(trajectory) for trajectory in trajectories}
