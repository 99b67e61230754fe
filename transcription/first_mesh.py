"""The first mesh: solved from the problem's own start, and from others where that fails or is doubtful."""

from __future__ import annotations

import time
from dataclasses import replace

from ..problems.problem import Problem
from .engines.outcome import Status
from .one_mesh import Origin, Watch, solve_mesh
from .schemes.mesh import Mesh
from .settings import Settings
from .solution.solution import Solution
from .starts import other_starts, without_effect
from .warm import Solved

SECONDS, TIMES = 5.0, 3.0
"""Other starts may take this long together, or this many times as long as the first, whichever is more."""

NOT_OF_THE_START = (
    Status.INTERRUPTED, Status.MAX_CPU_TIME, Status.MAX_WALL_TIME, Status.OVERDETERMINED, Status.INVALID_PROBLEM,
    Status.INVALID_OPTION, Status.NO_MEMORY,
)  # fmt: skip
"""Failures that no other start can mend."""


def solve_first_mesh(
    problem: Problem, meshes: list[Mesh], tolerance: float, settings: Settings, start: Origin, watch: Watch
) -> tuple[Solution, Solved]:
    """As `solve_mesh`; without a guess but the problem's own, other starts are tried where that one is no good.

    problem: its sense says which of two objectives is better.
    meshes: one for each phase.
    tolerance: of the engine.
    settings: other starts are tried with the engine ipopt only.
    start: with a guess, no other is tried.
    watch: its `stop` ends the other starts too; these also have a time limit of their own, see SECONDS and TIMES.

    A start that fails gives way to the first that does not. One at which a control has no effect is doubtful, whether
    it fails or not: of all that are solved, the solution with the best objective is kept. The solution's notes say what
    was done, and, from any start, which controls have no effect along the solution.
    """
    began = time.monotonic()
    first = solve_mesh(problem, meshes, tolerance, settings, start, watch)
    own = first[0]
    if start.guess is not None or settings.engine != "ipopt" or own.status in NOT_OF_THE_START:
        return _doubted(first)
    idle = without_effect(problem, [phase.guess for phase in problem.phases])
    if own.status.usable and not idle:
        return _doubted(first)
    now = time.monotonic()
    end = now + max(SECONDS, TIMES * (now - began))
    limited = replace(watch, stop=lambda: time.monotonic() > end or bool(watch.stop and watch.stop()))
    best, words, tried = first, "", 0
    for other in other_starts(problem, doubtful=own.status.usable):
        if limited.stop and limited.stop():
            break
        tried += 1
        found = solve_mesh(problem, meshes, tolerance, settings, replace(start, guess=other.guesses), limited)
        if _better(found[0], best[0], problem.sense):
            best, words = found, other.words
            if not idle:
                break
    return _doubted((replace(best[0], notes=(_told(own, idle, words, tried),)), best[1]))


def _doubted(found: tuple[Solution, Solved]) -> tuple[Solution, Solved]:
    """With a note on what had no effect along the solution: that may be stationary without being an optimum."""
    solution, solved = found
    idle = without_effect(solution.problem, solution.trajectories) if solution.status.usable else []
    if not idle:
        return found
    names = ", ".join(idle)
    what = f"{names} has no effect along this solution (df/du = 0), so it may be stationary and no optimum"
    return replace(solution, notes=(*solution.notes, f"{what}; give another guess of {names}")), solved


def _better(new: Solution, old: Solution, sense: int) -> bool:
    """Whether a solution is one where the other is none, or has the better objective by more than rounding."""
    if not new.status.usable or not old.status.usable:
        return new.status.usable and not old.status.usable
    gain = sense * (old.objective - new.objective)
    return gain > 1e-6 * (1 + abs(old.objective))


def _told(own: Solution, idle: list[str], words: str, tried: int) -> str:
    """What was done, and what the user can do; words: of the start that was kept, "" for the problem's own."""
    advice = f"; give a guess of {', '.join(idle)} at which it acts" if idle else ""
    if not own.status.usable:
        others = f"{tried} other start{'s' if tried != 1 else ''} failed too"
        outcome = f"this is the solution from another: {words}" if words else others
        return f"the start of the file failed ({own.status.message}); {outcome}{advice}"
    doubt = f"{', '.join(idle)} had no effect at the start of the file"
    if words:
        return f"{doubt}, which led to {own.objective:.6g}; this is the solution from another: {words}"
    return f"{doubt}; of {tried} other starts none led to a better solution{advice}"
