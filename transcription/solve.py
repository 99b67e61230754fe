"""The door to a solve: the loop over meshes, and once more on more segments where it ends at no trajectory."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from math import isinf

from ..problems.problem import Curves, Problem
from .again.loop import Loop
from .again.no_trajectory import from_more_segments, wants_more_segments
from .engines.watch import Limit
from .first_mesh import SECONDS, TIMES
from .one_mesh import Origin
from .settings import DEFAULT, Settings
from .solution.solution import Solution
from .starts.near import Near
from .transcribe import Planned, Schedule, planned


def solve(
    problem: Problem | Sequence[Problem],
    schedule: Schedule,
    settings: Settings = DEFAULT,
    *,
    guess: Sequence[Curves] | None = None,
    near: Near | None = None,
    progress: Callable[[int, dict], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> Solution:
    """Solve a problem on each mesh of the schedule in turn, each from the solution on the one before.

    problem: one, or one for each mesh where they differ, as under a smoothing schedule.
    schedule: the meshes to solve on, and the method of each, for all phases or for each; refined ones come after them.
    settings: the engine and its options, refinement, scaling, time limit.
    guess: one for each phase, over the problem's own; None for that.
    near: what the neighbour leaves whose solution is the guess; used where it fits the first mesh.
    progress: called with the number of the solve and the engine's record of each iteration.
    stop: asked at each iteration; true ends the solve and keeps the last iterate.

    A failed solve ends the schedule and is told by the status; one on a refined mesh ends refinement, and the solution
    before it is kept. So it is when a later mesh of the same problem is interrupted or runs out of time, and when the
    last ones end at acceptable points only, unless `accept` asks for no more. Where the last mesh misses what is asked
    for, and one before it is more exact (see `nearer`), that one is given back. The history tells of every mesh solved,
    a coarse one before a large first one too. A solution that is no trajectory at all gives way to one from more
    segments, see `no_trajectory`.

    Raises SpecError, before anything is solved, if the problem cannot be transcribed on a mesh of the schedule; and if
    the engine cannot take its program.
    """
    steps, limit, began = planned(problem, schedule), Limit(settings.seconds, stop), time.process_time()
    solution = Loop(steps, settings, progress, limit).run(Origin(guess, None, near=near))
    if guess is not None or limit.reached() or not wants_more_segments(steps, settings, solution):
        return solution
    seconds = max(SECONDS, TIMES * (time.process_time() - began))
    more = Limit(seconds, stop, time.process_time) if isinf(limit.left()) else Limit(min(seconds, limit.left()), stop)

    def again(finer: list[Planned]) -> Solution:
        return Loop(finer, settings, progress, more).run(Origin(None, None))

    return from_more_segments(steps, solution, again, more)
