"""Whether the solution of a mesh is to be believed, and whether a finer mesh can help."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...problems.quantities import TOLERATED_EXCESS
from ..solution.solution import MeshRecord, Solution

IN_VAIN, GROWN = 2, 1.5
"""Meshes on which nothing gets better, and how many times as many segments they have."""

UNTRUE = 10.0
"""Times the error of the mesh before: with as much on a finer one, a better objective is not believed."""

FARTHER, EXCEEDED = 5.0, 10.0
"""Times both error bars: they are estimates, and on coarse meshes one may be too small by half. Another optimum is
farther away. EXCEEDED: where the mesh before exceeds a bound between its points, and the finer one less. That made it
better than it may be, by more than multipliers of the few points that hold the bound tell."""

MANY, MOST = 300, 20_000
"""Segments from which on a mesh is asked how many more it would take, and as many as are worth a try."""

STANDING = 0.8
"""An error bar or an error stands if it is more than that of the one before."""


def left_basin(before: Solution, after: Solution, accuracy: float = 0.0) -> bool:
    """Whether the objective of a finer mesh has moved by far more than both error bars, and not for the better.

    Then it belongs to another optimum: on one and the same, both bars hold the exact value. A gain is none where the
    error of the dynamics has grown with it: the scheme's equations have solutions that follow no dynamics. The wide
    bar that the finer mesh then has is of the other optimum, and excuses nothing.

    before: the solution on the mesh before.
    after: that on the finer mesh.
    accuracy: that is asked for, relative to 1 + |J|; a move by less is none.
    """
    if not after.status.usable or not (before.objective_error.applies and after.objective_error.applies):
        return False
    loss = before.problem.sense * (after.objective - before.objective)
    untrue = after.meshes[-1].relative_error > UNTRUE * before.meshes[-1].relative_error
    exceeded = _exceeded(before)
    times = EXCEEDED if exceeded > max(TOLERATED_EXCESS, _exceeded(after)) else FARTHER
    bar, finer = before.objective_error.bar, after.objective_error.bar
    bars = bar + (min(bar, finer) if untrue else finer)
    return (abs(loss) if untrue else loss) > max(times * bars, accuracy * (1 + abs(before.objective)))


def nearer(before: Solution, after: Solution, *, by_bar: bool) -> bool:
    """Whether the solution of a mesh is more exact than that of a later one.

    Its error bar is smaller, and the two agree within their bars: else one of these is wrong, and the finer mesh knows
    better.

    before: the solution on a mesh.
    after: that on one after it.
    by_bar: whether the bar is all that is asked for; where it is not, the error of the dynamics is not to be larger.
    """
    old, new = before.objective_error, after.objective_error
    if not (old.applies and new.applies) or old.bar >= new.bar:
        return False
    agree = abs(before.objective - after.objective) <= old.bar + new.bar
    return agree and (by_bar or before.meshes[-1].relative_error <= after.meshes[-1].relative_error)


def _exceeded(solution: Solution) -> float:
    """The largest excess over bounds and path constraints between the points, times its segment's share of its phase:
    what refinement holds to TOLERATED_EXCESS."""
    pairs = zip(solution.trajectories, solution.errors, strict=True)
    return max(float(np.max(error.largest_excess * own.mesh.widths, initial=0.0)) for own, error in pairs)


def in_vain(meshes: Sequence[MeshRecord], tolerance: float, objective: float | None) -> str:
    """Why no finer mesh would help, or "".

    meshes: those of refinement so far.
    tolerance: of the relative error, that is asked for.
    objective: accuracy of the objective that is asked for, relative to 1 + |J|, if any.
    """
    asked, errors = tolerance, [mesh.relative_error for mesh in meshes]
    if objective:
        asked, errors = objective, [mesh.objective_error / (1 + abs(mesh.objective)) for mesh in meshes]
    return stalled(meshes, tolerance) or out_of_reach([mesh.segments for mesh in meshes], errors, asked)


def stalled(meshes: Sequence[MeshRecord], tolerance: float) -> str:
    """Why a mesh still finer would be of no use, or "": on the last two neither the error bar nor the error has fallen.

    meshes: those of refinement so far.
    tolerance: of the error; one below it need not fall.
    """
    if len(meshes) < IN_VAIN + 1:
        return ""
    first, last = meshes[-1 - IN_VAIN], meshes[-1]
    if last.segments < GROWN * first.segments or not last.objective_error > STANDING * first.objective_error:
        return ""
    if last.relative_error > tolerance and not last.relative_error > STANDING * first.relative_error:
        return ""
    return f"{last.segments} segments are no better than {first.segments}: the error bar does not fall with the mesh"


def out_of_reach(segments: Sequence[int], errors: Sequence[float], asked: float) -> str:
    """Why an accuracy cannot be had, or "": an error that falls with a power of the number of segments would take too
    many of them.

    segments: of the meshes of refinement so far.
    errors: of each, relative.
    asked: to what they are to fall.
    """
    if len(segments) < 2 or segments[-1] < max(MANY, GROWN * segments[-2]) or not errors[-1] > asked:
        return ""
    power = float(np.log(errors[-2] / errors[-1]) / np.log(segments[-1] / segments[-2]))
    if power <= 0:
        return ""  # see `stalled`
    wanted = segments[-1] * (errors[-1] / asked) ** (1 / power)
    if not wanted > MOST:
        return ""
    falls = f"from {segments[-2]} to {segments[-1]} segments it fell from {errors[-2]:.1e} to {errors[-1]:.1e}"
    return f"an accuracy of {asked:.1e} would take some {wanted:.0e} segments ({falls}): ask for fewer digits"


def unmeasurable(solution: Solution) -> str:
    """Why no refinement can help: residuals that do not determine the rates leave no error to measure; or ""."""
    implicit = [e for t, e in zip(solution.trajectories, solution.errors, strict=True) if t.phase.algebraic]
    if any(not np.isfinite(error.relative).any() for error in implicit):
        return "the residuals do not determine the rates (index above 1), so the error cannot be estimated"
    return ""
