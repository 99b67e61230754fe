"""A solution that is no trajectory of the dynamics at all: the start once more, on more segments.

A few segments may have a solution whose states leave the course of the dynamics between the points altogether, where
these are stiff or have poles. Refined meshes that start from it fail, or end at what is no better; a first mesh of more
segments has no such solution.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from ..attempts.segments import MANY
from ..engines.outcome import Status
from ..engines.watch import Limit
from ..settings import Settings
from ..solution.solution import Solution
from ..transcribe import MORE_SEGMENTS, Planned, divided, may_be_divided


def wants_more_segments(steps: Sequence[Planned], settings: Settings, solution: Solution) -> bool:
    """Whether a solution is no trajectory, and its first mesh had few segments, which were to be refined.

    steps: of the schedule.
    settings: of its solve.
    solution: from the problem's own guess.
    """
    if not settings.refine or settings.engine != "ipopt" or settings.starts or len(steps) > 1:
        return False
    few = sum(mesh.segments for mesh in steps[0][1]) < MANY
    return few and solution.status is Status.SOLVED and solution.is_no_trajectory


def from_more_segments(
    steps: Sequence[Planned], solution: Solution, again: Callable[[list[Planned]], Solution], limit: Limit
) -> Solution:
    """The solution from more segments; the one that is no trajectory if there is none.

    steps: the one of the schedule.
    solution: that is no trajectory.
    again: solves from the problem's own guess.
    limit: of all that is tried.
    """
    few, tried = sum(mesh.segments for mesh in steps[0][1]), solution.discarded
    problem, meshes, tolerance = steps[0]
    for times in MORE_SEGMENTS:
        if limit.reached() or not may_be_divided(problem, meshes, times):
            break
        finer = divided(problem, meshes, times)
        other = again([(problem, finer, tolerance)])
        if not other.status.usable or other.is_no_trajectory:
            tried = (*tried, *other.meshes, *other.discarded)
            continue
        many = sum(mesh.segments for mesh in finer)
        told = f"from {few} segments the solution was no trajectory of the dynamics; this is the one from {many}"
        discarded = (*solution.meshes, *tried, *other.discarded)
        return replace(other, notes=(*other.notes, told), discarded=discarded)
    return replace(solution, discarded=tried)
