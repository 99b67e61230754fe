"""The first mesh: solved from the problem's own start, and from others where that fails or is doubtful."""

from __future__ import annotations

import time
from dataclasses import replace

from ..problems.problem import Problem
from .attempts.attempt import Attempt, better
from .attempts.lasting import from_lasting, told_of_lasting
from .attempts.others import from_others
from .attempts.segments import CRAWLING, OF_THE_MESH, may_crawl, of_the_mesh, on_more_segments
from .engines.outcome import Status
from .engines.watch import Limit, Watch
from .failure.unlimited import told_of_shrinking
from .one_mesh import Found, Origin
from .schemes.mesh import Mesh
from .settings import Settings
from .solution.solution import Solution
from .starts.drawn import drawn_starts, told_of_starts
from .starts.other import without_effect
from .starts.worthless import worthless

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

CONTRADICTORY = (*OF_THE_MESH, Status.OVERDETERMINED)
"""Failures that constraints may be the reason of, if they are violated."""


def solve_first_mesh(
    problem: Problem, meshes: list[Mesh], tolerance: float, settings: Settings, start: Origin, watch: Watch
) -> Found:
    """Solve on the first mesh; more segments and other starts are tried where that is no good.

    A mesh that has no solution, or none within CRAWLING iterations, gives way to one of more segments with the same
    guess. Where a free duration shrank in a solve that failed, it is held longer first. A start that fails gives way to
    the first that does not. One at which a control has no effect is doubtful, whether it fails or not, and so is one
    from which a phase shrank to nothing, where no control has any effect either: of all that are solved, the solution
    with the best objective is kept; so it is of problems that are solved in milliseconds and may have several optima,
    where what is better has to be so on a mesh with twice the segments too. If none is solved, an elastic program finds
    a feasible trajectory to start from, or else what would have to give way. The solution's notes say what was done,
    and, from any start, which controls have no effect along the solution. Its last mesh is the one that was solved.

    problem, meshes, tolerance, settings, start, watch: as of `solve_mesh`.
    """
    attempt = Attempt(problem, meshes, tolerance, settings, start, watch)
    if settings.starts and start.guess is None:
        return _doubted(_of_many(attempt))
    began = time.process_time()
    cut = CRAWLING if may_crawl(attempt) else None
    best = attempt.own(cut)
    if settings.engine != "ipopt" or best[0].status is Status.INTERRUPTED or _shrank_away(best[0]):
        return _doubted(best)
    first = time.process_time() - began
    seconds = max(SECONDS, TIMES * first)
    away = not best[0].status.usable and _ran_away(best[0])
    limit = Limit(max(ONCE_AWAY, first) if away else seconds, watch.stop, time.process_time)
    if start.guess is None and not away and (found := from_lasting(attempt, best, None, limit)):
        return _doubted((replace(found[0], notes=(*found[0].notes, told_of_lasting(best[0]))), found[1]))
    if of_the_mesh(attempt, best[0]) and (found := on_more_segments(attempt, best, limit)):
        return _doubted(found)
    explained = False
    if cut and best[0].status is Status.MAX_ITERATIONS and not away:
        best, explained = _explained(attempt, best, seconds)
        if not explained or not (best[0].status.usable or best[0].relief):
            best = attempt.own()
    if start.guess is None and best[0].status not in NOT_OF_THE_START and not best[0].relief:
        best = from_others(attempt, best, limit)
    if not explained:
        best, _ = _explained(attempt, best, seconds)
    return _doubted(best)


def _of_many(attempt: Attempt) -> Found:
    """The best solution from the problem's own start and from drawn ones; which optima there are is its note."""
    best, settings, sense = attempt.own(), attempt.settings, attempt.problem.sense
    objectives = [best[0].objective if best[0].status.usable else None]
    unlimited = Limit(None, attempt.watch.stop)
    for guesses in drawn_starts(attempt.problem, settings.starts, settings.seed):
        if unlimited.reached():
            break
        found = attempt.run(guesses, unlimited)
        objectives.append(found[0].objective if found[0].status.usable else None)
        one, other = (found, best) if better(found[0], best[0], sense) else (best, found)
        records = (*one[0].meshes[:-1], one[0].meshes[-1].after(other[0].meshes[-1]))  # the work of all starts
        best = replace(one[0], meshes=records), one[1]
    return replace(best[0], notes=(*best[0].notes, told_of_starts(objectives, sense))), best[1]


def _ran_away(failed: Solution) -> bool:
    """Whether the objective has fallen without limit, or far together with something that has a name."""
    from .failure.runaway import FALLEN_THROUGH, fallen  # loaded when there is a failure

    if failed.cause_is_known:
        return fallen(failed.outcome, FALLEN_THROUGH)
    return failed.status is Status.DIVERGING and fallen(failed.outcome)


def _shrank_away(failed: Solution) -> bool:
    """Whether a duration went to zero for what no other start mends."""
    return not failed.status.usable and bool(told_of_shrinking(failed.trajectories))


def _may_contradict(failed: Solution, settings: Settings) -> bool:
    """Whether constraints may be the reason of a failure: not if the user cut it short, or something has run away."""
    if failed.status not in CONTRADICTORY or not failed.violations:
        return False
    return failed.status is not Status.MAX_ITERATIONS or ("max_iter" not in settings.options and not failed.trouble)


def _explained(attempt: Attempt, best: Found, seconds: float) -> tuple[Found, bool]:
    """The solution from a feasible trajectory if there is one, else the failed one and what would have to give way;
    and whether that could be told."""
    failed, limit = best[0], Limit(seconds, attempt.watch.stop, time.process_time)
    if not _may_contradict(failed, attempt.settings):
        return best, False
    from .failure.relax import explain  # loaded when there is a failure

    explanation = explain(attempt.problem, attempt.meshes, attempt.start.guess, stop=limit.reached)
    if not explanation.settled:
        return best, False
    if not explanation.feasible:
        return (failed.contradictory(explanation.relief), best[1]), True
    solution, solved = attempt.run(explanation.curves, limit)
    if solution.status.usable:
        note = f"the start of the file failed ({failed.status.message}); this is the solution from a trajectory"
        note += " that violates nothing, found without the objective"
        return (replace(solution, notes=(*solution.notes, note)), solved), True
    note = "the constraints can all hold, but the solve from a trajectory that violates none failed, too"
    return (replace(failed, notes=(*failed.notes, note)), best[1]), True


def _doubted(found: Found) -> Found:
    """With a note on what had no effect along the solution: that may be stationary without being an optimum."""
    solution, solved = found
    if not solution.status.usable:
        return found
    what = "has no effect along this solution (df/du = 0)"
    names = without_effect(solution.problem, solution.trajectories)
    if not names:
        what = "does nothing along this solution (the Hamiltonian is the same whatever it is)"
        names = worthless(solution.problem, solution.trajectories, solution.objective)
    if not names:
        return found
    idle = ", ".join(names)
    note = f"{idle} {what}, so it may be stationary and no optimum; give another guess of {idle}"
    return replace(solution, notes=(*solution.notes, note)), solved
