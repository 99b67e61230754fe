"""Solving on one mesh: transcribe, compile, run the engine, read the solution back, measure its error."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..problems.problem import Curves, Problem
from .engines.outcome import Outcome, Status
from .engines.table import engine_solve
from .layout import bounded_start
from .program.alone import building
from .program.contract import NonlinearProgram
from .scaling import scale
from .schemes.mesh import Mesh
from .settings import Settings
from .solution.diagnose import diagnose
from .solution.error import ErrorProfile, error_profile
from .solution.objective_error import ObjectiveError, objective_error
from .solution.solution import MeshRecord, Solution
from .solution.trajectory import trajectories
from .transcribe import compiled, transcribe, with_costates
from .warm import Solved, warm_start

LARGE, COARSE = 400, 100
"""Points of a first mesh that starts from a coarse one, and points of that: measured over the shipped problems, three
methods and 1000 points, 0.53 of the time of a start from the guess on geometric average, 0.07 to 1.8 of it."""


@dataclass(frozen=True)
class Watch:
    """Who looks on: `progress` and `stop` of `solve`, and the number of the solve that progress is told."""

    progress: Callable[[int, dict], None] | None
    stop: Callable[[], bool] | None
    number: int

    def next(self, more: int) -> Watch:
        return replace(self, number=self.number + more)

    def callbacks(self) -> dict[str, Callable | None]:
        return {"progress": self.progress and partial(self.progress, self.number), "stop": self.stop}


@dataclass(frozen=True)
class Origin:
    """Where a solve starts: guess, one for each phase or None for the problem's own, and the solve before, if any."""

    guess: Sequence[Curves] | None
    solved: Solved | None


def solve_mesh(
    problem: Problem, meshes: Sequence[Mesh], tolerance: float, settings: Settings, start: Origin, watch: Watch
) -> tuple[Solution, Solved]:
    """Solve on one mesh for each phase; also gives what the next solve starts from.

    problem: one that no method refuses on these meshes.
    meshes: one for each phase.
    tolerance: of the engine; an option `tol` of the settings goes before it.
    settings: the engine, its options, scaling and coarse_start; refinement is not done here.
    start: the guess and the solve before.
    watch: who is told of the iterations, and who may end the solve.

    A large mesh with no guess but the problem's own starts from the solution on a coarse one; or from the guess after
    all if that leads to none. The solution's history tells of every solve.
    """
    run = partial(_run, problem, tolerance=tolerance, settings=settings)
    coarse = _coarse(meshes) if settings.coarse_start and start.guess is None else None
    if not coarse:
        return run(meshes, start=start, watch=watch)
    solution, solved = run(coarse, start=start, watch=watch)
    history = solution.meshes
    if solution.status.usable:
        near = Origin(solution.trajectories, solved)
        solution, solved = run(meshes, start=near, watch=watch.next(1))
        history += solution.meshes
    if not solution.status.usable and solution.status is not Status.INTERRUPTED:
        solution, solved = run(meshes, start=start, watch=watch.next(len(history)))
        history += solution.meshes
    return replace(solution, meshes=history), solved


def _coarse(meshes: Sequence[Mesh]) -> list[Mesh] | None:
    """The coarse meshes of large ones; None for others, and where some cannot be made coarse."""
    if sum(len(mesh.fractions) for mesh in meshes) <= LARGE:
        return None
    coarse = [coarsened for mesh in meshes if (coarsened := mesh.coarsened(COARSE))]
    return coarse if len(coarse) == len(meshes) else None


@np.errstate(all="ignore")  # what is not finite is told by the status, not by warnings of NumPy's
def _run(
    problem: Problem, meshes: Sequence[Mesh], *, tolerance: float, settings: Settings, start: Origin, watch: Watch
) -> tuple[Solution, Solved]:
    clock = [time.perf_counter()]
    with building():
        transcription = transcribe(problem, meshes, start.guess)
        clock.append(time.perf_counter())
        nlp = compiled(transcription)
        clock.append(time.perf_counter())
        z, lower, upper = bounded_start(transcription)
    before = start.solved
    multipliers = warm_start(before, transcription, nlp) if before and before.has_densities(transcription) else None
    options = {"tol": tolerance, **settings.options}
    scaling = None if settings.scaling is None else scale(transcription, nlp, z, settings.scaling)
    outcome = engine_solve(settings.engine)(
        nlp, z, lower, upper, options, start=multipliers, scaling=scaling, **watch.callbacks()
    )
    clock.append(time.perf_counter())
    read = trajectories(transcription, outcome.z)
    errors = tuple(map(error_profile, read))
    phases = with_costates(transcription, nlp, outcome, read)
    violations, trouble = diagnose(transcription, nlp, outcome)
    bar = objective_error(transcription, nlp, outcome, phases)
    clock.append(time.perf_counter())
    objective, seconds = problem.sense * outcome.objective, _seconds(clock, nlp)
    record = _record(meshes[0], tolerance, objective, bar, errors, nlp, outcome, seconds)
    solution = Solution(
        problem, outcome.status, objective, phases, errors, (record,), outcome, bar, violations, trouble
    )
    return solution, Solved(transcription, nlp, outcome, phases)


def _seconds(clock: Sequence[float], nlp: NonlinearProgram) -> dict[str, float]:
    """Seconds by part, from the times at which building began and ended, the program was ready, the engine ended, and
    the solution was measured.
    """
    build, prepare, run, measure = np.diff(clock).tolist()
    parts = nlp.seconds
    return {
        "build": build,
        "differentiate": parts["differentiate"],
        "compile": parts["compile"],
        "assemble": prepare - parts["differentiate"] - parts["compile"],
        "evaluate": parts["evaluate"],
        "linear algebra": run - parts["evaluate"],
        "error": measure,
    }


def _record(
    mesh: Mesh,
    tolerance: float,
    objective: float,
    bar: ObjectiveError,
    errors: Sequence[ErrorProfile],
    nlp: NonlinearProgram,
    outcome: Outcome,
    seconds: Mapping[str, float],
) -> MeshRecord:
    return MeshRecord(
        mesh=mesh,
        tolerance=tolerance,
        status=outcome.status,
        objective=objective,
        objective_error=bar.bar,
        objective_corrected=objective + bar.correction,
        max_eta=max(error.max_eta for error in errors),
        relative_error=max(float(error.relative.max()) for error in errors),
        iterations=max(len(outcome.iterations["iteration"]) - 1, 0),
        unknowns=nlp.n,
        constraints=nlp.m,
        seconds=seconds,
    )
