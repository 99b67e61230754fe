"""What comes after the solution of a mesh, by the accuracy that is asked for: the next mesh, and how it is solved."""

from __future__ import annotations

from functools import partial

from ..refinement.goal import Goal
from ..refinement.refine import refine
from ..settings import Refine
from ..solution.solution import Solution
from ..transcribe import Planned

LOOSE, LOOSENESS = 1e-5, 0.01
"""Tolerance of the engine on a mesh that refinement does not expect to be the last: LOOSE, or LOOSENESS times the error
on the mesh before, if that is less; with more the engine takes the interpolated start, which is smooth, for good."""

ENGINE_SHARE, FINEST = 0.01, 1e-11
"""Of the error bar that is asked for, and at least: the engine's tolerance on the last mesh."""

FIRST = Refine().tolerance
"""Of the error of each segment: what comes before a finer goal for the error bar."""

GAP_SHARE = 1e-3
"""Of the accuracy that is asked for, relative to 1 + |J|: what the engine's barrier may leave."""


def asked_of_engine(refine: Refine) -> float:
    """The engine's tolerance on the last mesh, as far as refinement has a say: what it leaves is part of the bar."""
    return refine.tolerance if refine.objective is None else max(ENGINE_SHARE * refine.objective, FINEST)


def allowed_gap(refine: Refine | None) -> float:
    """What the barrier may leave of the objective, relative to 1 + |J|: a part of the accuracy that is asked for, or
    that is the default."""
    return GAP_SHARE * accuracy(refine)


def accuracy(refine: Refine | None) -> float:
    """The accuracy that is asked for, or that is the default."""
    asked = refine or Refine()
    return asked.objective or asked.tolerance


def meets_first(solution: Solution) -> bool:
    """Whether all segments meet FIRST, so that a finer goal for the error bar can be gone for.

    Until then the mesh closes in on switches; refined for the goal at once, it has many segments everywhere, and finds
    the switches no more.
    """
    pairs = zip(solution.trajectories, solution.errors, strict=True)
    return not any(refine(*own, FIRST, merge=False).unmet for own in pairs)


def next_solve(
    step: Planned,
    solution: Solution,
    settings: Refine,
    tolerance: float,
    merge: bool,
    left: int,
    goal: Goal | None,
) -> tuple[tuple[str, ...], list[Planned]]:
    """The segments that are not good enough, in words, and the solve to come after, if any.

    step: that led to the solution.
    solution: measured.
    settings: of refinement.
    tolerance: of the engine, on the last mesh.
    merge: as of `refine`.
    left: the number of meshes that may still come.
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
