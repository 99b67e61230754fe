"""Solving a mesh once more, from what its solution shows: whole turns, what the barrier leaves, a lower Hamiltonian."""

from __future__ import annotations

from ..attempts.attempt import better
from ..engines.outcome import Status
from ..engines.watch import Watch
from ..one_mesh import Found, Origin, in_place, solve_mesh
from ..pontryagin.needles import Lower
from ..refinement.angles import short_turns
from ..refinement.basin import left_basin
from ..refinement.chatter import Damping
from ..settings import Settings
from ..transcribe import Planned
from .tightened import tightened

SLOW = 200
"""Iterations of a finer mesh after which it is solved without the multipliers of the one before."""

MOST = 800
"""Iterations of a mesh that refinement has added, at most: no shipped problem takes more than 409 on all its meshes
together, and the solution of the mesh before is there."""

OF_BARRIER, SHARPER = 0.2, 0.01
"""Of the error bar: with more of the barrier in it the mesh is not to blame, and what is to be left of that."""


def from_coarser(step: Planned, settings: Settings, start: Origin, watch: Watch, *, asked: bool) -> Found:
    """The solution of a mesh from that on the one before; where its multipliers make the solve crawl, without them.

    With them IPOPT starts close to the bounds, and from points that a finer mesh moves far it has no way to go but
    along them. If it is not solved without them either, it is with as many iterations as it takes, or MOST.

    step, settings: of the solve.
    start: the solution before.
    watch: who looks on.
    asked: whether the mesh is of the schedule, and refinement has not added it.
    """
    few = settings.within(SLOW)
    found = solve_mesh(*step, few, start, watch)
    if few is settings or start.solved is None or found[0].status is not Status.MAX_ITERATIONS:
        return found
    cold = solve_mesh(*step, settings.within(2 * SLOW), Origin(start.guess, None, start.damping), watch)
    if cold[0].status.usable:
        return in_place(found, cold)
    return in_place(found, solve_mesh(*step, settings if asked else settings.within(MOST), start, watch))


def with_short_turns(step: Planned, settings: Settings, found: Found, damping: Damping, watch: Watch) -> Found:
    """The solution whose angles, among the controls, go the short way; as it is where they do, or where the solve from
    there leads to a worse one.

    step, settings: of the solve.
    found: what it led to.
    damping: of its controls.
    watch: who looks on.
    """
    solution = found[0]
    curves, names = short_turns(solution.trajectories) if solution.status.usable else ([], [])
    if not names:
        return found
    again = solve_mesh(*step, settings, Origin(curves, None, damping), watch)
    if not again[0].status.may_replace(solution.status) or left_basin(solution, again[0]):
        return found
    told = f"{', '.join(names)} had jumped by whole turns from point to point, and was made continuous"
    return in_place(found, again, told)


def with_damping(step: Planned, settings: Settings, found: Found, damping: Damping, watch: Watch) -> Found | None:
    """The solution with damped controls; None if it has none that is as good.

    It is solved anew, and else from the multipliers of the undamped one, which is slower where they chatter, and stays
    nearer.

    step, settings: of the solve.
    found: what it led to.
    damping: of its controls.
    watch: who looks on.
    """
    solution, solved = found
    for before in (None, solved):
        calm = solve_mesh(*step, settings, Origin(solution.trajectories, before, damping), watch)
        if calm[0].status.may_replace(solution.status) and not left_basin(solution, calm[0]):
            return in_place(found, calm)
    return None


def sharpened(found: Found, settings: Settings, accuracy: float, watch: Watch) -> Found:
    """The solution without what the barrier leaves, where that is most of an error bar that is too large: no finer mesh
    mends that, it has more bounds.

    found: a solution.
    settings: of its solve.
    accuracy: of the objective, that is asked for, relative to 1 + |J|.
    watch: who looks on.
    """
    solution, bar = found[0], found[0].objective_error
    asked = accuracy * (1 + abs(solution.objective))
    if not bar.applies or bar.bar <= asked or bar.gap <= OF_BARRIER * bar.bar:
        return found
    return tightened(found, settings, SHARPER * bar.bar, watch)


def from_lower(step: Planned, settings: Settings, found: Found, lower: Lower, watch: Watch) -> Found | None:
    """The solution from controls with a lower Hamiltonian; None if it is no better.

    step, settings: of the solve.
    found: the solution with the other controls.
    lower: those that it is to start from.
    watch: who looks on.
    """
    again = solve_mesh(*step, settings, Origin(lower.guesses, None), watch)
    if not better(again[0], found[0], found[0].problem.sense):
        return None
    return in_place(found, again)
