"""Solving on one mesh: transcribe, compile, run the engine, read the solution back, measure its error."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ..problems.lean.records import dataclass
from ..problems.problem import Curves, Problem
from .dual.barrier import less_barrier
from .dual.multipliers import Multipliers
from .engines.outcome import Outcome, Start, Status
from .engines.table import engine_solve
from .engines.watch import Watch
from .failure.diagnose import diagnose
from .failure.unlimited import shrinks_away
from .layout import Transcription, bounded_start
from .measured.knots import measured_fractions, with_knots
from .program.contract import NonlinearProgram
from .refinement.chatter import UNDAMPED, Damping
from .refinement.unwound import unwound
from .scaling import Scaling, scale
from .schemes.mesh import Mesh
from .settings import Settings
from .solution.error import ErrorProfile, error_profile
from .solution.objective_error import ObjectiveError, objective_error
from .solution.solution import MeshRecord, Solution
from .solution.trajectory import trajectories
from .starts.extreme import extreme_sizes
from .starts.near import Near, solved_from
from .starts.settled import MOST, SETTLED, has_moving, moved, unsettled
from .starts.warm import Solved, warm_start
from .transcribe import program, with_costates

LARGE, COARSE = 400, 100
"""Points of a first mesh that starts from a coarse one, and points of that: measured over the shipped problems, three
methods and 1000 points, 0.53 of the time of a start from the guess on geometric average, 0.07 to 1.8 of it."""


Found = tuple[Solution, Solved]
"""A solution, and what the next solve starts from."""


@dataclass(frozen=True)
class Origin:
    """Where a solve starts: guess, one for each phase or None for the problem's own, and the solve before, if any.

    damping: of controls that chattered there. near: the guess is the solution of a neighbour, which leaves this.
    """

    guess: Sequence[Curves] | None
    solved: Solved | None
    damping: Damping = UNDAMPED
    near: Near | None = None


def solve_mesh(
    problem: Problem, meshes: Sequence[Mesh], tolerance: float, settings: Settings, start: Origin, watch: Watch
) -> Found:
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
    run = partial(_settled if has_moving(problem) else _run, problem, tolerance=tolerance, settings=settings)
    coarse = _coarse(problem, meshes) if settings.coarse_start and start.guess is None else None
    if not coarse:
        return run(meshes, start=start, watch=watch)
    solution, solved = run(coarse, settings=replace(settings, gap=None), start=start, watch=watch)
    history = solution.meshes
    if solution.status.usable:
        near = Origin(solution.trajectories, solved, start.damping)
        solution, solved = run(meshes, start=near, watch=watch.next(1))
        history += solution.meshes
    if not solution.status.usable and solution.status is not Status.INTERRUPTED:
        solution, solved = run(meshes, start=start, watch=watch.next(len(history)))
        history += solution.meshes
    return replace(solution, meshes=history), solved


def _coarse(problem: Problem, meshes: Sequence[Mesh]) -> list[Mesh] | None:
    """The coarse meshes of large ones; None for others, and where some cannot be made coarse."""
    if sum(len(mesh.fractions) for mesh in meshes) <= LARGE:
        return None
    coarse = [coarsened for mesh in meshes if (coarsened := mesh.coarsened(COARSE))]
    if len(coarse) < len(meshes):
        return None
    return [with_knots(mesh, measured_fractions(phase)) for mesh, phase in zip(coarse, problem.phases, strict=True)]


def _settled(
    problem: Problem, meshes: Sequence[Mesh], *, tolerance: float, settings: Settings, start: Origin, watch: Watch
) -> Found:
    """As `_run`, again until the times for which states at earlier times are read are those that are found."""
    again = partial(_run, problem, meshes, tolerance=tolerance, settings=settings)
    found = again(start=start, watch=watch)
    before: Sequence[Curves] = start.guess or [phase.guess for phase in problem.phases]
    for number in range(1, MOST):
        solution, solved = found
        if not solution.status.usable or moved(problem, before, solution.trajectories) <= SETTLED:
            return found
        before = solution.trajectories
        found = in_place(found, again(start=Origin(before, solved, start.damping), watch=watch.next(number)))
    shift = moved(problem, before, found[0].trajectories)
    return found if shift <= SETTLED else (replace(found[0], notes=(*found[0].notes, unsettled(shift))), found[1])


@np.errstate(all="ignore")  # what is not finite is told by the status, not by warnings of NumPy's
def _run(
    problem: Problem, meshes: Sequence[Mesh], *, tolerance: float, settings: Settings, start: Origin, watch: Watch
) -> Found:
    clock = [time.perf_counter()]
    transcription, nlp, built = program(problem, meshes, start.guess)
    clock += [built, time.perf_counter()]
    z, lower, upper = bounded_start(transcription)
    before = start.solved
    multipliers = warm_start(before, transcription, nlp) if before and before.has_densities(transcription) else None
    options = {"tol": tolerance, **settings.options}
    engine = engine_of(transcription, nlp, (lower, upper), start.damping, settings, watch)
    run = partial(engine, z)
    if start.near and settings.engine == "ipopt" and start.near.fits(transcription, nlp):
        outcome, more = solved_from(start.near, run, nlp, z, lower, upper, options)
    else:
        outcome, more = run(options, multipliers), 0
    if settings.gap is not None:
        own, gap = Multipliers(transcription, nlp, outcome), settings.gap * (1 + abs(outcome.objective))
        if better := less_barrier(own, gap, tolerance, settings, partial(engine, outcome.z)):
            outcome, more = better, more + outcome.count
    clock.append(time.perf_counter())
    solution, solved = measured(transcription, nlp, outcome, start.damping, tolerance, clock)
    (record,) = solution.meshes
    return replace(solution, meshes=(replace(record, iterations=record.iterations + more),)), solved


def engine_of(
    transcription: Transcription,
    nlp: NonlinearProgram,
    bounds: tuple[np.ndarray, np.ndarray],
    damping: Damping,
    settings: Settings,
    watch: Watch,
) -> Callable[[np.ndarray, Mapping[str, object], Start | None], Outcome]:
    """The engine that solves a program from a point z (n,), with some options and multipliers.

    transcription, nlp: of one problem.
    bounds: lower and upper ones of the unknowns, (n,) each.
    damping: of its controls.
    settings: which engine it is, and the scaling.
    watch: who looks on.
    """
    damped, solve = damping.of(nlp, transcription), engine_solve(settings.engine)
    looks: dict[str, Callable | None] = watch.callbacks()
    if settings.engine == "ipopt":
        looks["away"] = partial(shrinks_away, transcription)

    def run(z: np.ndarray, options: Mapping[str, object], multipliers: Start | None) -> Outcome:
        scaling = _scaling_of(transcription, nlp, z, settings)
        return solve(damped or nlp, z, *bounds, options, start=multipliers, scaling=scaling, **looks)

    return run


def _scaling_of(
    transcription: Transcription, nlp: NonlinearProgram, z: np.ndarray, settings: Settings
) -> Scaling | None:
    """The scaling of a solve: that of the settings; with none, that of unknowns too small or too large for IPOPT.

    transcription, nlp: of one problem.
    z: (n,) where the solve starts.
    settings: of the solve.
    """
    sizes = settings.scaling
    if sizes is None and settings.engine == "ipopt" and "nlp_scaling_method" not in settings.options:
        sizes = extreme_sizes(transcription, z)
    return None if sizes is None else scale(transcription, nlp, z, sizes)


def measured(
    transcription: Transcription,
    nlp: NonlinearProgram,
    outcome: Outcome,
    damping: Damping,
    tolerance: float,
    clock: list[float],
) -> Found:
    """The solution of an outcome.

    transcription, nlp: of one problem.
    outcome: of the engine.
    damping: of its controls. The objective is that of the problem itself; what damping is worth is in the error bar.
    tolerance: of the engine.
    clock: as of `_seconds`, but for the last time.
    """
    if worth := damping.worth(nlp, transcription, outcome.z):
        outcome = replace(outcome, objective=outcome.objective - worth)
    if outcome.status.usable:
        outcome = replace(outcome, z=unwound(transcription, nlp, outcome.z))
    problem, grids = transcription.problem, tuple(layout.mesh for layout in transcription.phases)
    read = trajectories(transcription, outcome.z)
    if outcome.status.usable and any(own.leaps for own in read):
        outcome = replace(outcome, status=Status.DIVERGING)
    errors = tuple(map(error_profile, read))
    phases = with_costates(transcription, nlp, outcome, read)
    violations, trouble = diagnose(transcription, nlp, outcome)
    bar = objective_error(transcription, nlp, outcome, phases)
    if bar.applies:
        size = 1 + abs(outcome.objective)
        errors = tuple(replace(own, worth=shares / size) for own, shares in zip(errors, bar.shares, strict=True))
    bar = replace(bar, bar=bar.bar + worth)
    clock.append(time.perf_counter())
    objective, seconds = problem.sense * outcome.objective, _seconds(clock, nlp)
    record = _record(grids, tolerance, objective, bar, errors, nlp, outcome, seconds)
    solution = Solution(
        problem,
        outcome.status,
        objective,
        phases,
        errors,
        (record,),
        outcome,
        bar,
        violations,
        str(trouble),
        trouble.involved,
    )
    return solution, Solved(transcription, nlp, outcome, phases, damping, worth)


def in_place(first: Found, second: Found, *notes: str) -> Found:
    """The second solution of a mesh, with the work of both and the notes of the first.

    first, second: one after the other.
    notes: what else there is to tell.
    """
    records = (*first[0].meshes[:-1], second[0].meshes[-1].after(first[0].meshes[-1]))
    return replace(second[0], meshes=records, notes=(*first[0].notes, *notes)), second[1]


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
    grids: tuple[Mesh, ...],
    tolerance: float,
    objective: float,
    bar: ObjectiveError,
    errors: Sequence[ErrorProfile],
    nlp: NonlinearProgram,
    outcome: Outcome,
    seconds: Mapping[str, float],
) -> MeshRecord:
    return MeshRecord(
        grids=grids,
        tolerance=tolerance,
        status=outcome.status,
        objective=objective,
        objective_error=bar.bar,
        objective_corrected=objective + bar.correction,
        max_eta=max(error.max_eta for error in errors),
        relative_error=max(float(error.relative.max()) for error in errors),
        iterations=outcome.count,
        unknowns=nlp.n,
        constraints=nlp.m,
        seconds=seconds,
    )
