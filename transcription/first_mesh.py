"""The first mesh: solved from the problem's own start, and from others where that fails or is doubtful."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import islice
from typing import Protocol

from ..problems.problem import Curves, Problem
from .engines.outcome import Status
from .engines.watch import Limit, Watch
from .one_mesh import Found, Origin, solve_mesh
from .schemes.mesh import Mesh
from .settings import Settings
from .solution.solution import Solution
from .starts.drawn import chosen_parameters, drawn_starts, other_parameters, told_of_starts
from .starts.other import OtherStart, other_starts, without_effect
from .structure.several import may_have_several
from .transcribe import refused

SECONDS, TIMES = 5.0, 3.0
"""Other starts may take this long together, or this many times as long as the first, whichever is more; so may the
search for what would have to give way. Of the processor: what is found does not depend on who else is at work."""

ONCE_AWAY = 1.0
"""Seconds in place of SECONDS, and once the first in place of TIMES, where the objective ran away: the start is seldom
why, but a constraint without a slope at the guess lets it go, too."""

NOT_OF_THE_START = (
    Status.INTERRUPTED, Status.MAX_CPU_TIME, Status.MAX_WALL_TIME, Status.OVERDETERMINED, Status.INVALID_PROBLEM,
    Status.INVALID_OPTION, Status.NO_MEMORY,
)  # fmt: skip
"""Failures that no other start can mend."""

CONTRADICTORY = (
    Status.INFEASIBLE, Status.RESTORATION_FAILED, Status.OVERDETERMINED, Status.MAX_ITERATIONS, Status.STALLED,
    Status.STEP_FAILED,
)  # fmt: skip
"""Failures that constraints may be the reason of, if they are violated."""

MANY = "the problem may have other optima than that near its guess"
"""What is doubtful of a solution that cost little, of a problem that is not known to be convex (`may_have_several`)."""

MORE, FEW = 8, 4
"""Starts with other static parameters: of a problem without time, and of others."""

BOTH_SIDES = 2
"""Of the other starts: controls above, and below, the middle of their bounds."""


class FirstMeshSolve(Protocol):
    """A solve on the first mesh, or a finer one with twice its segments, from other trajectories, within a limit."""

    def __call__(self, guess: Sequence[Curves], limit: Limit, *, finer: bool = False) -> Found: ...


def solve_first_mesh(
    problem: Problem, meshes: list[Mesh], tolerance: float, settings: Settings, start: Origin, watch: Watch
) -> Found:
    """Solve on the first mesh; other starts are tried where the problem's own is no good.

    A start that fails gives way to the first that does not. One at which a control has no effect is doubtful, whether
    it fails or not, and so is one from which a phase shrank to nothing, where no control has any effect either: of all
    that are solved, the solution with the best objective is kept; so it is of problems that are
    solved in milliseconds and may have several optima, where what is better has to be so on a mesh with twice the
    segments too. If none is solved, an elastic program finds a feasible trajectory to start from, or else what would
    have to give way. The solution's notes say what was done, and, from any start, which controls have no effect along
    the solution.

    problem, meshes, tolerance, settings, start, watch: as of `solve_mesh`.
    """
    if settings.starts and start.guess is None:
        return _doubted(_of_many(problem, meshes, tolerance, settings, start, watch))
    began = time.process_time()
    best = solve_mesh(problem, meshes, tolerance, settings, start, watch)
    if settings.engine != "ipopt" or best[0].status is Status.INTERRUPTED:
        return _doubted(best)
    first = time.process_time() - began
    seconds = max(SECONDS, TIMES * first)

    def run(guess: Sequence[Curves], limit: Limit, *, finer: bool = False) -> Found:
        own, limited = [mesh.halved() for mesh in meshes] if finer else meshes, replace(watch, stop=limit.reached)
        return solve_mesh(problem, own, tolerance, settings, replace(start, guess=guess, near=None), limited)

    if start.guess is None and best[0].status not in NOT_OF_THE_START:
        others = max(ONCE_AWAY, first) if _ran_away(best[0]) else seconds
        best = _from_others(problem, best, run, Limit(others, watch.stop, time.process_time))
    if _may_contradict(best[0], settings):
        best = _explained(problem, meshes, best, run, Limit(seconds, watch.stop, time.process_time), start.guess)
    return _doubted(best)


def _of_many(
    problem: Problem, meshes: list[Mesh], tolerance: float, settings: Settings, start: Origin, watch: Watch
) -> Found:
    """The best solution from the problem's own start and from drawn ones; which optima there are is its note."""
    best = solve_mesh(problem, meshes, tolerance, settings, start, watch)
    objectives = [best[0].objective if best[0].status.usable else None]
    for guesses in drawn_starts(problem, settings.starts, settings.seed):
        if watch.stop and watch.stop():
            break
        found = solve_mesh(problem, meshes, tolerance, settings, replace(start, guess=guesses), watch)
        objectives.append(found[0].objective if found[0].status.usable else None)
        one, other = (found, best) if better(found[0], best[0], problem.sense) else (best, found)
        records = (*one[0].meshes[:-1], one[0].meshes[-1].after(other[0].meshes[-1]))  # the work of all starts
        best = replace(one[0], meshes=records), one[1]
    return replace(best[0], notes=(*best[0].notes, told_of_starts(objectives, problem.sense))), best[1]


def _ran_away(failed: Solution) -> bool:
    """Whether the objective has fallen without limit."""
    if failed.status is not Status.DIVERGING:
        return False
    from .failure.runaway import fallen  # loaded when there is a failure

    return fallen(failed.outcome)


def _may_contradict(failed: Solution, settings: Settings) -> bool:
    """Whether constraints may be the reason of a failure: not if the user cut it short, or something has run away."""
    if failed.status not in CONTRADICTORY or not failed.violations:
        return False
    return failed.status is not Status.MAX_ITERATIONS or ("max_iter" not in settings.options and not failed.trouble)


def _from_others(problem: Problem, first: Found, run: FirstMeshSolve, limit: Limit) -> Found:
    """The best of the first solution and those from other starts, as far as they are worth a try."""
    own, idle = first[0], without_effect(problem, [phase.guess for phase in problem.phases])
    doubt = _had_no_effect(idle) or (_shrunk(own) or _one_of_many(first) if own.status.usable else "")
    explained = own.status is Status.MAX_ITERATIONS and own.trouble  # no start mends what runs away, or has a kink
    if (own.status.usable and not doubt) or explained:
        return first
    best, words, tried = first, "", 0
    for other in _others(problem, own.status.usable, doubt == MANY):
        if limit.reached():
            break
        tried += 1
        found = run(other.guesses, limit)
        if better(found[0], best[0], problem.sense) and (doubt != MANY or _stays_better(found, best, run, limit)):
            best, words = found, other.words
            if not doubt:
                break
    if doubt == MANY and not words:  # it is so of every such problem
        return first
    return replace(best[0], notes=(*best[0].notes, _told(own, idle, doubt, words, tried))), best[1]


def _others(problem: Problem, usable: bool, many: bool) -> Iterator[OtherStart]:
    """What else to start from; usable: whether the problem's own start led to a solution; many: to one of many."""
    if many and chosen_parameters(problem):
        timeless = all(phase.static for phase in problem.phases)
        return other_parameters(problem, MORE if timeless else FEW)
    return islice(other_starts(problem, doubtful=usable), BOTH_SIDES if many else None)


def _one_of_many(found: Found) -> str:
    """Why a solution is doubtful that cost little and may be one of many; "" if it is not."""
    solution, solved = found
    if not may_have_several(solution, solved.nlp):
        return ""
    finer = [mesh.halved() for mesh in solution.meshes[-1].grids]
    timeless = all(phase.static for phase in solution.problem.phases)
    return MANY if timeless or not any(refused(solution.problem, finer)) else ""


def _stays_better(new: Found, old: Found, run: FirstMeshSolve, limit: Limit) -> bool:
    """Whether a solution is better than another with twice the segments too: on few points it may be so by what they
    do not see."""
    if all(phase.static for phase in new[0].problem.phases):
        return True
    finer = [run(found[0].trajectories, limit, finer=True)[0] for found in (new, old)]
    return finer[0].status.usable and better(finer[0], finer[1], new[0].problem.sense)


def _had_no_effect(idle: Sequence[str]) -> str:
    """Why a start is doubtful at which these controls do nothing; "" for none."""
    return f"{', '.join(idle)} had no effect at the start of the file" if idle else ""


def _shrunk(solution: Solution) -> str:
    """Why a solution is doubtful in which a phase of free duration has next to none; "" if there is no such phase."""
    names = [
        trajectory.phase.name
        for trajectory in solution.trajectories
        if not (trajectory.phase.exact or trajectory.lasts)
    ]
    which = f"phase{'s' * (len(names) > 1)} {', '.join(names)}" if len(solution.trajectories) > 1 else "the time"
    return f"{which} shrank to nothing from the start of the file" if names else ""


def _explained(
    problem: Problem,
    meshes: list[Mesh],
    best: Found,
    run: FirstMeshSolve,
    limit: Limit,
    guess: Sequence[Curves] | None,
) -> Found:
    """The solution from a feasible trajectory if there is one, else the failed one and what would have to give way."""
    from .failure.relax import explain  # loaded when there is a failure

    failed = best[0]
    explanation = explain(problem, meshes, guess, stop=limit.reached)
    if not explanation.settled:
        return best
    if not explanation.feasible:
        return replace(failed, relief=explanation.relief), best[1]
    solution, solved = run(explanation.curves, limit)
    if solution.status.usable:
        note = f"the start of the file failed ({failed.status.message}); this is the solution from a trajectory"
        note += " that violates nothing, found without the objective"
        return replace(solution, notes=(*solution.notes, note)), solved
    note = "the constraints can all hold, but the solve from a trajectory that violates none failed, too"
    return replace(failed, notes=(*failed.notes, note)), best[1]


def _doubted(found: Found) -> Found:
    """With a note on what had no effect along the solution: that may be stationary without being an optimum."""
    solution, solved = found
    idle = without_effect(solution.problem, solution.trajectories) if solution.status.usable else []
    if not idle:
        return found
    names = ", ".join(idle)
    what = f"{names} has no effect along this solution (df/du = 0), so it may be stationary and no optimum"
    return replace(solution, notes=(*solution.notes, f"{what}; give another guess of {names}")), solved


def better(new: Solution, old: Solution, sense: int) -> bool:
    """Whether a solution is one where the other is none, or has the better objective by more than rounding; an optimal
    point does not give way to an acceptable one.

    new, old: of one problem.
    sense: +1 where the least is the best, -1 where the largest is.
    """
    if not new.status.may_replace(old.status) or not old.status.usable:
        return new.status.usable and not old.status.usable
    gain = sense * (old.objective - new.objective)
    return gain > 1e-6 * (1 + abs(old.objective))


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
