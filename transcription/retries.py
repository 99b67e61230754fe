"""A first solve that went wrong, or whose guess hides a control from the solver -> the best of solves from other starts.

Nothing is tried where the user gave a trajectory to start from. What is tried, and what came of it, is told in words.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ..problems.problem import Problem
from .engines.outcome import Status
from .one_mesh import Origin, Watch, coarse_meshes, solve_mesh
from .schemes.mesh import Mesh
from .settings import Settings
from .solution.solution import Solution
from .starts import other_starts, without_effect
from .warm import Solved

WORTH_IT = (Status.INFEASIBLE, Status.RESTORATION_FAILED, Status.STEP_FAILED, Status.STALLED)
"""Failures that another start can cure; the others have a limit, an option or a function without a value behind them."""

ITERATIONS, OF_ONE = 600, 300
"""Iterations that all retries may take, and one of them: not seconds, so that the same file gives the same result."""

BETTER = 1e-6
"""A start is better if its objective is, by this much relative to 1 + the objective: less is the engine's tolerance."""

GUESS_POINTS = 51  # at which a guess is looked at

Found = tuple[Solution, Solved]


def with_other_starts(
    planned: tuple[Problem, Sequence[Mesh], float],
    settings: Settings,
    first: Found,
    stop: Callable[[], bool] | None,
) -> Found:
    """The first solve, or a better one from another start; its `note` says what was tried, if anything was.

    planned: the problem, the meshes and the tolerance of the first solve. The history of what replaces the first solve
    begins with that of the first.
    """
    problem, solution = planned[0], first[0]
    if settings.engine != "ipopt" or not (reason := _reason(problem, solution)):
        return first
    found, left, tried, words = None, ITERATIONS, 0, ""
    for told, guess in other_starts(problem):
        if left <= 0 or (stop and stop()):
            break
        trial = _tried(planned, settings, guess, min(left, OF_ONE), stop)
        left, tried = left - sum(mesh.iterations for mesh in trial[0].meshes), tried + 1
        if _better(problem, trial[0], found[0] if found else solution):
            found, words = trial, told
    if not found:
        return replace(solution, note=f"{reason}; none of {tried} other starts led to a better solution"), first[1]
    kept = f"{reason}; of {tried} other starts, the best is kept: {words}"
    return replace(found[0], meshes=solution.meshes + found[0].meshes, note=kept), found[1]


def stationary(solution: Solution) -> str:
    """A warning, if a control has no first-order effect on the dynamics all along a result, or ""."""
    names = [
        name
        for trajectory in solution.trajectories
        for name in without_effect(trajectory.phase, trajectory, trajectory.parameters, *_at(trajectory))
    ]
    if not names:
        return ""
    named = ", ".join(names)
    return f"df/d({named}) = 0 along the result, so nothing moves {named} from its guess: change the guess of {named}"


def _at(trajectory) -> tuple[np.ndarray, np.ndarray]:
    s = np.linspace(0.0, 1.0, GUESS_POINTS)
    return trajectory.initial_time + s * (trajectory.final_time - trajectory.initial_time), s


def _reason(problem: Problem, solution: Solution) -> str:
    """Why other starts are worth trying, or ""."""
    if solution.status in WORTH_IT:
        return f"from the guess: {solution.status.message}"
    if not solution.status.usable:
        return ""
    hidden = [
        name
        for phase in problem.phases
        for name in without_effect(phase, phase.guess, phase.guess.parameters, *_at(phase.guess))
    ]
    return f"{', '.join(hidden)} has no first-order effect along the guess" if hidden else ""


def _tried(planned, settings: Settings, guess: Sequence, iterations: int, stop: Callable[[], bool] | None) -> Found:
    """A solve from another start, on a coarse mesh first where the mesh is large."""
    problem, meshes, tolerance = planned
    limit = {**settings.options, "max_iter": min(int(settings.options.get("max_iter", iterations)), iterations)}
    limited, watch = replace(settings, options=limit), Watch(None, stop, 0)
    coarse = coarse_meshes(meshes)
    found = solve_mesh(problem, coarse or meshes, tolerance, limited, Origin(guess, None), watch)
    if not coarse or not found[0].status.usable:
        return found
    solution, solved = solve_mesh(problem, meshes, tolerance, limited, Origin(found[0].trajectories, found[1]), watch)
    return replace(solution, meshes=found[0].meshes + solution.meshes), solved


def _better(problem: Problem, new: Solution, old: Solution) -> bool:
    if not new.status.usable or not np.isfinite(new.objective):
        return False
    gain = problem.sense * (old.objective - new.objective)
    return not old.status.usable or gain > BETTER * (1 + abs(old.objective))
