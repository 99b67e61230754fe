"""The loop: solve on each mesh of the schedule, and on refined ones after it, each from the solution before."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import count
from math import inf

import numpy as np

from ..problems.errors import SpecError
from ..problems.problem import Curves, Problem
from .engines.outcome import Status
from .first_mesh import solve_first_mesh
from .one_mesh import Origin, Watch, solve_mesh, tightened
from .refinement.goal import Goal
from .refinement.refine import MERGING_MESHES, refine
from .schemes.mesh import Mesh
from .settings import DEFAULT, Refine, Settings, Step
from .solution.solution import MeshRecord, Solution
from .transcribe import refused
from .warm import Solved

LOOSE, LOOSENESS = 1e-5, 0.01
"""Tolerance of the engine on a mesh that refinement does not expect to be the last: LOOSE, or LOOSENESS times the error
on the mesh before, if that is less; with more the engine takes the interpolated start, which is smooth, for good."""

ENDED = {Status.INTERRUPTED: "was interrupted", Status.TIME_LIMIT: "was not solved within the time limit"}
"""Statuses of a solve that was told to end, and how a mesh is called that ended so."""

ENGINE_SHARE, FINEST = 0.01, 1e-11
"""Of the error bar that is asked for, and at least: the engine's tolerance on the last mesh."""

GAP_SHARE = 1e-3
"""Of the accuracy that is asked for, relative to 1 + |J|: the gap that the engine's barrier may leave."""

Planned = tuple[Problem, list[Mesh], float]
"""The problem, the mesh of each phase and the tolerance of a solve."""

Found = tuple[Solution, Solved]
"""A solution, and what the next solve starts from."""


def planned(problem: Problem | Sequence[Problem], schedule: Sequence[Step]) -> list[Planned]:
    """The solves of a schedule.

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
    guess: Sequence[Curves] | None = None,
    progress: Callable[[int, dict], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> Solution:
    """Solve a problem on each mesh of the schedule in turn, each from the solution on the one before.

    problem: one, or one for each mesh where they differ, as under a smoothing schedule.
    schedule: the meshes to solve on, and the method of each; refined ones come after them.
    settings: the engine and its options, refinement, scaling, time limit.
    guess: one for each phase, over the problem's own; None for that.
    progress: called with the number of the solve and the engine's record of each iteration.
    stop: asked at each iteration; true ends the solve and keeps the last iterate.

    A failed solve ends the schedule and is told by the status; one on a refined mesh ends refinement, and the solution
    before it is kept. So it is when a later mesh of the same problem is interrupted or runs out of time. The history
    tells of every mesh solved, a coarse one before a large first one too.

    Raises SpecError, before anything is solved, if the problem cannot be transcribed on a mesh of the schedule; and if
    the engine cannot take its program.
    """
    steps, stopped = planned(problem, schedule), ""
    history: list[MeshRecord] = []
    unmet: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()
    start, good, limit = Origin(guess, None), None, _Limit(settings.seconds, stop)
    for number in count():
        own_solve, watch = solve_mesh if number else solve_first_mesh, Watch(progress, limit.reached, len(history))
        solution, solved = own_solve(*steps[number], settings, start, watch)
        notes += solution.notes
        solution = limit.told(solution)
        own = steps[number][0] is steps[number - 1][0]
        if good and not solution.status.usable and (number >= len(schedule) or (own and solution.status in ENDED)):
            stopped = _why_stopped(solution.meshes[-1])
            solution, solved = good
            break
        if good and own and number >= len(schedule) and left_basin(good[0], solution):
            (solution, solved), words = _again(steps[number], good, (solution, solved), settings, start, watch)
            notes += (words,)
            if solution is good[0]:
                stopped = words
                break
        history.extend(solution.meshes)
        if not solution.status.usable:
            unmet = ()  # they are of the mesh before
            break
        start = Origin(solution.trajectories, solved)
        good = solution, solved
        after = number + 1 - len(schedule)
        if after >= 0 and settings.refine:
            if stopped := _unmeasurable(solution):
                break
            merge, left = after <= MERGING_MESHES, len(schedule) + settings.refine.max_meshes - len(steps)
            exact = min(schedule[-1].tolerance, _asked(settings.refine))  # what is looser shows in the error
            goal = Goal(settings.refine.objective, solution) if settings.refine.objective else None
            unmet, more = _refined(steps[number], solution, settings.refine, exact, merge, left, goal)
            stopped = goal.unreachable if goal and not unmet and not more else ""
            if too_large := [mistake for step in more for mistake in refused(*step[:2])]:
                stopped = f"the next mesh cannot be solved: {too_large[0].what}"
                break
            steps += more
        if number + 1 == len(steps):
            break
        if limit.reached():
            stopped = (
                "interrupted before the next mesh" if stop and stop() else "the time limit came before the next mesh"
            )
            break
    gap = _gap(settings.refine, solution.objective)
    solution, _ = tightened((solution, solved), settings, gap, Watch(progress, limit.reached, len(history)))
    meshes = (*history[:-1], solution.meshes[-1])
    solution = replace(solution, meshes=meshes, unmet=unmet, stopped=stopped, notes=notes)
    return replace(solution, accept=settings.accept)


class _Limit:
    """When a solve has to end: at the time limit, in seconds from now, or when `stop` says so."""

    def __init__(self, seconds: float | None, stop: Callable[[], bool] | None) -> None:
        self.end, self.stop = inf if seconds is None else time.monotonic() + seconds, stop

    def reached(self) -> bool:
        return self._asked() or time.monotonic() > self.end

    def _asked(self) -> bool:
        return self.stop is not None and self.stop()

    def told(self, solution: Solution) -> Solution:
        """The solution, whose status tells the time limit from an interruption."""
        if solution.status is not Status.INTERRUPTED or self._asked():
            return solution
        meshes = (*solution.meshes[:-1], replace(solution.meshes[-1], status=Status.TIME_LIMIT))
        return replace(solution, status=Status.TIME_LIMIT, meshes=meshes)


def _why_stopped(mesh: MeshRecord) -> str:
    """Why a mesh that was not solved has no solution."""
    what = ENDED.get(mesh.status) or f"failed: {mesh.status.message}"
    return f"the next mesh, of {mesh.mesh.segments} segments, {what}"


def left_basin(before: Solution, after: Solution) -> bool:
    """Whether the objective of a finer mesh is worse than that of the mesh before by more than both error bars.

    Then it belongs to another optimum: on one and the same, both bars hold the exact value.
    """
    if not after.status.usable or not (before.objective_error.applies and after.objective_error.applies):
        return False
    worse = before.problem.sense * (after.objective - before.objective)
    return worse > before.objective_error.bar + after.objective_error.bar


def _again(
    step: Planned, before: Found, left: Found, settings: Settings, start: Origin, watch: Watch
) -> tuple[Found, str]:
    """A mesh whose solve left the basin, solved without the multipliers of the mesh before; and what was done.

    If that leads to no better point, what stood before is given back.
    """
    found = solve_mesh(*step, settings, Origin(start.guess, None), watch)
    segments = left[0].meshes[-1].mesh.segments
    told = f"the mesh of {segments} segments led to another optimum, {left[0].objective:.8g}"
    if found[0].status.usable and not left_basin(before[0], found[0]):
        return found, f"{told}; solved again without multipliers, it leads to {found[0].objective:.8g}"
    return before, f"{told}, which is worse than {before[0].objective:.8g} by more than both error bars"


def _unmeasurable(solution: Solution) -> str:
    """Why no refinement can help: residuals that do not determine the rates leave no error to measure; or ""."""
    implicit = [e for t, e in zip(solution.trajectories, solution.errors, strict=True) if t.phase.algebraic]
    if any(not np.isfinite(error.relative).any() for error in implicit):
        return "the residuals do not determine the rates (index above 1), so the error cannot be estimated"
    return ""


def _asked(refine: Refine) -> float:
    """The engine's tolerance on the last mesh, as far as refinement has a say: what it leaves is part of the bar."""
    return refine.tolerance if refine.objective is None else max(ENGINE_SHARE * refine.objective, FINEST)


def _gap(refine: Refine | None, objective: float) -> float:
    """What the barrier may leave of the objective: a part of the accuracy that is asked for, or that is the default."""
    asked = refine or Refine()
    return GAP_SHARE * (asked.objective or asked.tolerance) * (1 + abs(objective))


def _refined(
    step: Planned,
    solution: Solution,
    settings: Refine,
    tolerance: float,
    merge: bool,
    left: int,
    goal: Goal | None,
) -> tuple[tuple[str, ...], list[Planned]]:
    """The segments that are not good enough, in words, and the solve to come after, if any.

    tolerance: of the engine, on the last mesh. merge: as of `refine`. left: the number of meshes that may still come.
    goal: for the error bar of the objective, in place of the error of the segments.
    """
    problem, meshes, solved_to = step
    how = partial(refine, tolerance=goal.tolerance if goal else settings.tolerance, merge=merge)
    found = list(map(how, solution.trajectories, goal.errors if goal else solution.errors))
    unmet = tuple(segment for refinement in found for segment in refinement.unmet)
    if goal and goal.reached:
        unmet = ()
    if unmet and left > 0:
        last = left == 1 or all(refinement.enough for refinement in found)
        finer = [refinement.mesh for refinement in found]
        loose = min(LOOSE, LOOSENESS * solution.meshes[-1].relative_error)
        return unmet, [(problem, finer, tolerance if last else max(tolerance, loose))]
    return unmet, [(problem, meshes, tolerance)] if solved_to > tolerance else []
