"""The loop: transcribe, compile, solve, measure the error, and start the next mesh from there."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from itertools import count

import numpy as np

from ..problems.errors import SpecError
from ..problems.problem import Problem
from .compiler import CompiledNLP
from .costate import costates
from .diagnose import Violation, diagnose
from .error import ErrorProfile, error_profile
from .mesh import Mesh
from .outcome import Outcome, Status
from .refine import MERGING_MESHES, refine
from .runge_kutta import Shooting
from .scaling import scale
from .scheme import Scheme
from .settings import DEFAULT, Settings, Step
from .trajectory import Trajectory, trajectories
from .transcribe import Transcription, compiled, refused, transcribe
from .warm import Solved, warm_start

LARGE, COARSE = 400, 100
"""Points of a first mesh that starts from a coarse one, and points of that: measured over the shipped problems, three
methods and 1000 points, 0.58 of the time of a start from the guess on geometric average, 0.06 to 2.2 of it."""

LOOSE = 1e-5
"""Tolerance of the engine on a mesh that refinement does not expect to be the last."""


@dataclass(frozen=True)
class MeshRecord:
    """How the solve on one mesh went; objective as the user wrote it, error as in `refine`, seconds by part."""

    mesh: Mesh
    tolerance: float
    status: Status
    objective: float
    max_eta: float
    relative_error: float
    iterations: int
    unknowns: int
    constraints: int
    seconds: Mapping[str, float]


@dataclass(frozen=True)
class Solution:
    """What `solve` gives back, solved or not: the last mesh's trajectories and errors, and the history of meshes.

    unmet: the segments that refinement left above its tolerance, in words, the worst first.
    """

    problem: Problem
    status: Status
    objective: float
    trajectories: tuple[Trajectory, ...]
    errors: tuple[ErrorProfile, ...]
    meshes: tuple[MeshRecord, ...]
    outcome: Outcome
    violations: tuple[Violation, ...] = ()
    trouble: str = ""
    accept: Status = Status.SOLVED
    unmet: tuple[str, ...] = ()

    @property
    def solved(self) -> bool:
        """Whether the last mesh ended with an optimal point, or with one as good as `accept` asks for."""
        return self.status in (Status.SOLVED, Status.FEASIBLE, self.accept)

    @property
    def max_eta(self) -> float:
        return max(error.max_eta for error in self.errors)


def planned(problem: Problem | Sequence[Problem], schedule: Sequence[Step]) -> list[tuple[Problem, list[Mesh], float]]:
    """The problem, the mesh of each phase and the tolerance of each solve.

    Raises SpecError with all that cannot be transcribed, at its entry of the schedule, before anything is solved.
    """
    problems = [problem] * len(schedule) if isinstance(problem, Problem) else problem
    steps = [(p, [step.mesh() for _ in p.phases], step.tolerance) for p, step in zip(problems, schedule, strict=True)]
    mistakes = [
        replace(mistake, where=mistake.where.replace("mesh", f"mesh.{number}", 1))
        for number, (own, meshes, _) in enumerate(steps)
        for mistake in refused(own, meshes)
    ]
    if mistakes:
        raise SpecError(mistakes)
    return steps


def solve(
    problem: Problem | Sequence[Problem],
    schedule: Sequence[Step],
    settings: Settings = DEFAULT,
    *,
    guess: Sequence | None = None,
    progress: Callable[[int, dict], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> Solution:
    """Solve a problem on each mesh of the schedule in turn, each from the solution on the one before.

    problem: one, or one for each mesh where they differ, as under a smoothing schedule. guess: one for each phase, over
    the problem's own. progress: called with the number of the solve and the engine's record of each iteration. stop:
    asked at each iteration; true ends the solve and keeps the last iterate. A failed solve ends the schedule and is
    told by the status. The history tells of every mesh solved, a coarse one before a large first one too.
    """
    steps, history, solved, unmet = planned(problem, schedule), [], None, ()
    for number in count():
        problem, meshes, tolerance = steps[number]
        run = _solve_large if _starts_coarse(meshes, settings, guess) else _solve_mesh
        watch = _Watch(progress, stop, len(history))
        solution, solved = run(problem, meshes, tolerance, settings, guess, solved, watch)
        history.extend(solution.meshes)
        if not solution.status.usable:
            break
        guess = solution.trajectories
        if number + 1 >= len(schedule) and settings.refine:
            how = partial(refine, tolerance=settings.refine.tolerance, merge=number - len(schedule) < MERGING_MESHES)
            refined = list(map(how, solution.trajectories, solution.errors))
            unmet = tuple(segment for refinement in refined for segment in refinement.unmet)
            left, exact = len(schedule) + settings.refine.max_meshes - len(steps), schedule[-1].tolerance
            if unmet and left > 0:
                last = left == 1 or all(refinement.enough for refinement in refined)
                meshes = [refinement.mesh for refinement in refined]
                steps.append((problem, meshes, exact if last else max(exact, LOOSE)))
            elif tolerance > exact:
                steps.append((problem, meshes, exact))
        if number + 1 == len(steps):
            break
    return replace(solution, meshes=tuple(history), accept=settings.accept, unmet=unmet)


@dataclass(frozen=True)
class _Watch:
    """Who looks on: `progress` and `stop` of `solve`, and the number of the solve that progress is told."""

    progress: Callable[[int, dict], None] | None
    stop: Callable[[], bool] | None
    number: int

    def next(self, more: int) -> _Watch:
        return replace(self, number=self.number + more)

    def callbacks(self) -> dict[str, Callable | None]:
        return {"progress": self.progress and partial(self.progress, self.number), "stop": self.stop}


def _starts_coarse(meshes: Sequence[Mesh], settings: Settings, guess) -> bool:
    """Whether a mesh, with no guess but the problem's own, is large and can be made coarse."""
    points = sum(len(mesh.fractions) for mesh in meshes)
    return settings.coarse_start and guess is None and points > LARGE and all(m.coarsened(COARSE) for m in meshes)


def _solve_large(problem: Problem, meshes: Sequence[Mesh], tolerance, settings, guess, solved, watch: _Watch):
    """As `_solve_mesh`, from the solution on a coarse mesh; or from the guess after all if that leads to none."""
    coarse = [mesh.coarsened(COARSE) for mesh in meshes]
    first, start = _solve_mesh(problem, coarse, tolerance, settings, guess, solved, watch)
    history = first.meshes
    if first.status.usable:
        first, start = _solve_mesh(problem, meshes, tolerance, settings, first.trajectories, start, watch.next(1))
        history += first.meshes
    if not first.status.usable and first.status is not Status.INTERRUPTED:
        first, start = _solve_mesh(problem, meshes, tolerance, settings, guess, solved, watch.next(len(history)))
        history += first.meshes
    return replace(first, meshes=history), start


@np.errstate(all="ignore")  # what is not finite is told by the status, not by warnings of NumPy's
def _solve_mesh(
    problem: Problem,
    meshes: Sequence[Mesh],
    tolerance: float,
    settings: Settings,
    guess,
    solved: Solved | None,
    watch: _Watch,
) -> tuple[Solution, Solved]:
    began = time.perf_counter()
    with _no_garbage_collection():
        transcription = transcribe(problem, meshes, guess)
        built = time.perf_counter()
        nlp = compiled(transcription)
        ready = time.perf_counter()
        z, lower, upper = bounded_start(transcription)
    start = warm_start(solved, transcription, nlp) if solved and solved.has_costates(transcription) else None
    options = {"tol": tolerance, **settings.options}
    scaling = None if settings.scaling is None else scale(transcription, nlp, z, settings.scaling)
    outcome = settings.run()(nlp, z, lower, upper, options, start=start, scaling=scaling, **watch.callbacks())
    ended = time.perf_counter()
    phases = trajectories(transcription, outcome.z)
    errors = tuple(map(error_profile, phases))
    if all(isinstance(scheme, Scheme | Shooting) for phase in phases for scheme in phase.mesh.schemes):
        lambdas = costates(transcription, nlp, outcome)
        phases = tuple(replace(phase, costate=costate) for phase, costate in zip(phases, lambdas, strict=True))
    solution = Solution(
        problem, outcome.status, problem.sense * outcome.objective, phases, errors, (), outcome,
        *diagnose(transcription, nlp, outcome),
    )  # fmt: skip
    seconds = {
        "build": built - began,
        "differentiate": nlp.seconds["differentiate"],
        "compile": nlp.seconds["compile"],
        "assemble": ready - built - nlp.seconds["differentiate"] - nlp.seconds["compile"],
        "evaluate": nlp.seconds["evaluate"],
        "linear algebra": ended - ready - nlp.seconds["evaluate"],
        "error": time.perf_counter() - ended,
    }
    solution = replace(solution, meshes=(_record(tolerance, solution, nlp, seconds),))
    return solution, Solved(transcription, nlp, outcome, phases)


@contextmanager
def _no_garbage_collection() -> Iterator[None]:
    """Building makes a hundred thousand objects and no garbage; looking for some takes a third of its time."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def bounded_start(transcription: Transcription) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The initial values of the unknowns and their bounds, each shape (n,); infinite where there is no bound."""
    table = [(v.value, *v.bounds) for v in transcription.variables]
    z, lower, upper = (np.array(column, float) for column in zip(*table, strict=True))
    return z, np.where(np.isnan(lower), -np.inf, lower), np.where(np.isnan(upper), np.inf, upper)


def _record(tolerance: float, solution: Solution, nlp: CompiledNLP, seconds: Mapping[str, float]) -> MeshRecord:
    return MeshRecord(
        mesh=solution.trajectories[0].mesh,
        tolerance=tolerance,
        status=solution.status,
        objective=solution.objective,
        max_eta=solution.max_eta,
        relative_error=max(float(error.relative.max()) for error in solution.errors),
        iterations=max(len(solution.outcome.iterations["iteration"]) - 1, 0),
        unknowns=nlp.n,
        constraints=nlp.m,
        seconds=seconds,
    )
