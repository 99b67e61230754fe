"""Other starts: where the problem's own failed or is doubtful, and where other optima cost little to look for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product

from ...problems.problem import Problem
from ..engines.watch import Limit
from ..one_mesh import Found
from ..solution.solution import Solution
from ..starts.drawn import chosen_parameters, other_parameters
from ..starts.other import OtherStart, both_sides, other_starts, without_effect
from ..starts.worthless import worthless
from ..structure.several import may_have_several
from ..transcribe import MORE_SEGMENTS, divided, may_be_divided
from .attempt import Attempt, better
from .lasting import run_lasting
from .segments import ITERATIONS, of_the_mesh

MANY = "the problem may have other optima than that near its guess"
"""What is doubtful of a solution that cost little, of a problem that is not known to be convex (`may_have_several`)."""

MORE, FEW = 8, 4
"""Starts with other static parameters: of a problem without time, and of others."""


def from_others(attempt: Attempt, first: Found, limit: Limit) -> Found:
    """The best of the first solution and those from other starts, as far as they are worth a try.

    attempt: the solve that led to the first.
    first: a solution, or none.
    limit: of all that is tried.
    """
    problem, own = attempt.problem, first[0]
    idle = without_effect(problem, [phase.guess for phase in problem.phases])
    doubt = _had_no_effect(idle) or (_stationary(own) or _one_of_many(attempt, first) if own.status.usable else "")
    if (own.status.usable and not doubt) or own.cause_is_known:
        return first
    best, words, tried = first, "", 0
    for other in _others(problem, own.status.usable, doubt == MANY):
        if limit.reached():
            break
        tried += 1
        found = run_lasting(attempt, other.guesses, limit)
        if better(found[0], best[0], problem.sense) and (doubt != MANY or _stays_better(attempt, found, best, limit)):
            best, words = found, other.words
            if not doubt:
                break
    if not best[0].status.usable and (finer := _on_more_segments(attempt, first, limit)):
        return finer
    if doubt == MANY and not words:  # it is so of every such problem
        return first
    return replace(best[0], notes=(*best[0].notes, _told(own, idle, doubt, words, tried))), best[1]


def _on_more_segments(attempt: Attempt, failed: Found, limit: Limit) -> Found | None:
    """The solution from other controls on more segments, where refinement follows; None if there is none.

    What is simulated satisfies the dynamics, but few segments may not hold it: where growth ends at once, say.
    """
    problem, few = attempt.problem, sum(mesh.segments for mesh in attempt.meshes)
    if not attempt.settings.refine or not of_the_mesh(attempt, failed[0]):
        return None
    for times, other in product(MORE_SEGMENTS, both_sides(problem, exactly=True)):
        if limit.reached() or not may_be_divided(problem, attempt.meshes, times):
            return None
        solution, solved = attempt.run(other.guesses, limit, times=times, iterations=ITERATIONS)
        if solution.status.usable:
            told = f"the start of the file failed on {few} segments and on more ({failed[0].status.message})"
            many = sum(mesh.segments for mesh in divided(problem, attempt.meshes, times))
            told += f"; this is the solution from another on {many}: {other.words}"
            return replace(solution, notes=(*solution.notes, told)), solved
    return None


def _others(problem: Problem, usable: bool, many: bool) -> Iterator[OtherStart]:
    """What else to start from; usable: whether the problem's own start led to a solution; many: to one of many."""
    if many and chosen_parameters(problem):
        timeless = all(phase.static for phase in problem.phases)
        return other_parameters(problem, MORE if timeless else FEW)
    return both_sides(problem, exactly=False) if many else other_starts(problem, doubtful=usable)


def _one_of_many(attempt: Attempt, found: Found) -> str:
    """Why a solution is doubtful that cost little and may be one of many; "" if it is not."""
    solution, solved = found
    if not may_have_several(solution, solved.nlp):
        return ""
    timeless = all(phase.static for phase in attempt.problem.phases)
    return MANY if timeless or may_be_divided(attempt.problem, attempt.meshes, 2) else ""


def _stays_better(attempt: Attempt, new: Found, old: Found, limit: Limit) -> bool:
    """Whether a solution is better than another with twice the segments too: on few points it may be so by what they
    do not see."""
    if all(phase.static for phase in attempt.problem.phases):
        return True
    finer = [attempt.run(found[0].trajectories, limit, times=2)[0] for found in (new, old)]
    return finer[0].status.usable and better(finer[0], finer[1], attempt.problem.sense)


def _had_no_effect(idle: Sequence[str]) -> str:
    """Why a start is doubtful at which these controls do nothing; "" for none."""
    return f"{', '.join(idle)} had no effect at the start of the file" if idle else ""


def _stationary(own: Solution) -> str:
    """Why a solution is doubtful that no control moves in first order, or some do not; "" if it is not."""
    if shrunk := _shrunk(own):
        return shrunk
    names = worthless(own.problem, own.trajectories, own.objective)
    return f"{', '.join(names)} did nothing along the solution from the start of the file" if names else ""


def _shrunk(solution: Solution) -> str:
    """Why a solution is doubtful in which a phase of free duration has next to none; "" if there is no such phase."""
    names = [
        trajectory.phase.name
        for trajectory in solution.trajectories
        if not (trajectory.phase.exact or trajectory.lasts)
    ]
    which = f"phase{'s' * (len(names) > 1)} {', '.join(names)}" if len(solution.trajectories) > 1 else "the time"
    return f"{which} shrank to nothing from the start of the file" if names else ""


def _told(own: Solution, idle: list[str], doubt: str, words: str, tried: int) -> str:
    """What was done, and what the user can do; words: of the start that was kept, "" for the problem's own."""
    advice = f"; give a guess of {', '.join(idle)} at which it acts" if idle else ""
    if not own.status.usable:
        others = f"{tried} other start{'s' if tried != 1 else ''} failed too"
        outcome = f"this is the solution from another: {words}" if words else others
        return f"the start of the file failed ({own.status.message}); {outcome}{advice}"
    if words:
        more = "; --starts 50 looks for better ones" if doubt == MANY else ""
        return f"{doubt}, which led to {own.objective:.6g}; this is the solution from another: {words}{more}"
    return f"{doubt}; of {tried} other starts none led to a better solution{advice}"
