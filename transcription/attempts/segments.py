"""More segments, where the first mesh fails or crawls: few of them may have no solution near that of the problem."""

from __future__ import annotations

from dataclasses import replace

from ..engines.outcome import Status
from ..engines.watch import Limit
from ..one_mesh import Found
from ..solution.solution import Solution
from ..transcribe import MORE_SEGMENTS, divided, may_be_divided
from .attempt import Attempt

CRAWLING = 800
"""Iterations of a first mesh after which more segments are tried: nine in ten of the shipped problems take 100."""

ITERATIONS = 400
"""Of each try on more segments."""

MANY = 100
"""Segments of a mesh that are not too few: what fails on so many does not for want of them."""

OF_THE_MESH = (
    Status.INFEASIBLE, Status.RESTORATION_FAILED, Status.MAX_ITERATIONS, Status.STALLED, Status.STEP_FAILED,
)  # fmt: skip
"""Failures that more segments may mend."""


def may_crawl(attempt: Attempt) -> bool:
    """Whether a first mesh is given up after CRAWLING iterations: not where the user has chosen it, or how many.

    attempt: the first.
    """
    settings = attempt.settings
    own = settings.refine is None or settings.engine != "ipopt" or "max_iter" in settings.options
    return _may_be_coarse(attempt) and not own


def of_the_mesh(attempt: Attempt, failed: Solution) -> bool:
    """Whether more segments may mend a failure: not if something runs away, or has a kink.

    attempt: the solve that failed.
    failed: what it led to, on the first mesh.
    """
    return _may_be_coarse(attempt) and failed.status in OF_THE_MESH and not failed.cause_is_known


def _may_be_coarse(attempt: Attempt) -> bool:
    """Whether there are few segments, and no guess was given: from such a one nothing else is tried either."""
    return attempt.start.guess is None and sum(mesh.segments for mesh in attempt.meshes) < MANY


def on_more_segments(attempt: Attempt, failed: Found, limit: Limit) -> Found | None:
    """The solution from the same guess on more segments; None if there is none either.

    Where no refinement follows, the mesh is to stay: then it is solved from there.

    attempt: the solve that failed.
    failed: what it led to.
    limit: of all that is tried.
    """
    few = sum(mesh.segments for mesh in attempt.meshes)
    why = "it crawled" if failed[0].status is Status.MAX_ITERATIONS else failed[0].status.message
    told = f"{few} segments from the start of the file led to no solution ({why})"
    for times in MORE_SEGMENTS:
        if limit.reached() or not may_be_divided(attempt.problem, attempt.meshes, times):
            break
        solution, solved = attempt.run(attempt.start.guess, limit, times=times, iterations=ITERATIONS)
        if not solution.status.usable:
            continue
        many = sum(mesh.segments for mesh in divided(attempt.problem, attempt.meshes, times))
        if attempt.settings.refine:
            return replace(solution, notes=(*solution.notes, f"{told}; {many} did")), solved
        back = attempt.run(solution.trajectories, limit)
        if back[0].status.usable:
            return replace(back[0], notes=(*back[0].notes, f"{told}; this is the one from that on {many}")), back[1]
        return replace(failed[0], notes=(*failed[0].notes, f"{told}, {many} did: take as many")), failed[1]
    return None
