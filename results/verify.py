"""An independent look at a result: does the control really do what the trajectory says, and is it optimal?

Dynamics      The stored control is integrated forward from the stored initial state (SciPy's DOP853, restarted at every
              knot), and compared with the stored states; and from the state at each knot to the next one, where the
              difference may not exceed what the result claims as its error.
Optimality    With lambda the costate and nu, kappa the multiplier functions of path constraints and residuals,

                  L = w + lambda f + nu g + kappa r                        (B.7), extended

              has dL/du = 0 where u is inside its bounds, points into the bound where it is on one, and H = w + lambda f
              changes along the trajectory only as dH/dt = the partial derivative by t: constant if nothing depends on
              t. d2L/du2 has no negative eigenvalue for the controls inside their bounds, on the tangent of the
              constraints that act (Legendre's condition): a point that is stationary but no minimum fails here.
Pontryagin    No other control within bounds and path constraints gives H a lower value, at any point: sampled, and the
              best improved. What H is above the least, integrated, is within the claimed error of the objective.
Starts        Solved anew from other starts, the problem has no better objective. An extremal may meet every condition
              above and be the lesser of two optima; where the file's reference means that one, it does not count.
Phases        Links hold, and H is the same on both sides of a passage whose time is free.
Stored        The arrays that people read are those of the solver's point, which meets the constraints at the points,
              and the error bar of the objective is small.
Exact         What is in discrete time, or without time, is its own nonlinear program: the steps, the costate equation,
              the signs of multipliers and second derivatives are looked at in place of the above (see `audit.exact`).
Constraints   Bounds and path constraints, on a grid between the collocation points; less strictly within a jump of a
              control, where no mesh makes them hold.
Reference     The objective beside the problem file's own reference, unless the command line changed the problem.

Along the trajectory derivatives are taken by the complex step, so these checks share no code with the derivatives that
the solver used. Pontryagin's check and the error bar share the Lagrangian of `objective_error`, and Starts is a solve.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..transcription.program.contract import NotFinite
from ..transcription.solution.error import error_profile
from ..transcription.solution.objective_error import NOT_UNIQUE, ObjectiveError, objective_error
from ..transcription.solution.trajectory import Trajectory
from .audit.check import ENGINE, Check
from .audit.exact import discrete_optimality, static_optimality, step_checks, whole_program
from .audit.junctions import junctions, links
from .audit.measured import jumps_of_costates
from .audit.optimality import optimality
from .audit.pontryagin import pontryagin
from .audit.starts import starts
from .audit.stored import MISSED, stored
from .audit.trajectory import between_points, complementary, held_control, simulation
from .file.reload import Reloaded, reload

LINKED = 1e-6
"""Relative to 1 + the bound: what a link may be missed by, as any constraint at the points."""
VALUES = "the solver's point and its objective are finite"


@np.errstate(all="ignore")  # a result without finite values fails its checks, and needs no warnings beside
def verify(path: Path, tolerance: float = 5e-2, hold: float | None = None, anew: bool = True) -> list[Check]:
    """All checks of a result file.

    path: of the result file.
    tolerance: the relative error that passes.
    hold: also simulate the control sampled at this interval and held, in the unit of time; None for not.
    anew: whether it is solved again from other starts, which takes most of the time.

    Raises FileError for another file.
    """
    result = reload(path)
    checks = [Check("solver status", 0.0 if result.solved else 1.0, 0.0, result.outcome.status.message)]
    if not _has_values(result):
        return [*checks, Check(VALUES, np.nan, 0.0, "nothing else can be looked at")]
    checks += stored(path, result)
    estimate = objective_error(result.transcription, result.nlp, result.outcome, result.trajectories)
    claimed = _claimed(result, estimate, tolerance)
    checks += links(result, LINKED)
    for number, trajectory in enumerate(result.trajectories):
        checks += _told(result, trajectory, _along(result, number, claimed, tolerance, hold))
    checks += junctions(result, claimed, tolerance)
    if estimate.applies:
        relative = estimate.bar / (1 + abs(result.objective))
        checks.append(Check("error bar of the objective, relative", relative, tolerance))
    for trajectory, check in pontryagin(result, claimed):
        checks += _told(result, trajectory, [check])
    if all(phase.exact for phase in result.problem.phases):
        checks += whole_program(result)
    if anew:
        checks += starts(result, estimate, tolerance)
    if (reference := result.spec.reference) and not result.overrides:
        difference = abs(result.objective - reference.objective)
        checks.append(
            Check("objective, difference from the reference", difference, reference.tolerance, reference.source)
        )
    return checks


def _has_values(result: Reloaded) -> bool:
    """Whether the solver's point, and the objective there, are finite numbers."""
    try:
        result.nlp.objective(result.outcome.z)
    except NotFinite:
        return False
    return bool(np.isfinite(result.outcome.z).all())


def _along(result: Reloaded, number: int, claimed: float, tolerance: float, hold: float | None) -> Iterator[Check]:
    """The checks of one phase."""
    trajectory = result.trajectories[number]
    if trajectory.phase.exact:
        yield from _exact(result, number, claimed, tolerance)
        return
    yield from simulation(trajectory, error_profile(trajectory), tolerance)
    if hold is not None:
        yield from held_control(trajectory, hold, tolerance)
    yield from between_points(trajectory, tolerance)
    yield from complementary(trajectory)
    if trajectory.phase.complementarity:
        yield Check("optimality", 0.0, 0.0, f"not looked at: {NOT_UNIQUE}")
    elif not trajectory.lasts:
        yield Check("optimality", 0.0, 0.0, "not looked at: the phase takes no time")
    elif trajectory.costate is not None:
        yield from optimality(result, number, claimed, tolerance)
        yield from jumps_of_costates(result, number, tolerance)
    else:
        yield Check("optimality", 0.0, 0.0, "not looked at: this method gives no costates")


def _exact(result: Reloaded, number: int, claimed: float, tolerance: float) -> Iterator[Check]:
    """The checks of a phase in discrete time, or without time."""
    trajectory = result.trajectories[number]
    if trajectory.phase.static:
        yield from static_optimality(result, number)
        return
    yield from step_checks(trajectory, max(MISSED, ENGINE * result.records[-1].tolerance), tolerance)
    yield from between_points(trajectory, tolerance)
    yield from discrete_optimality(result, number, claimed, tolerance)


def _told(result: Reloaded, trajectory: Trajectory, checks: Iterable[Check]) -> Iterator[Check]:
    """Checks of a phase, which say so where there are several."""
    several = len(result.trajectories) > 1
    return (replace(c, name=f"{trajectory.phase.name}: {c.name}") if several else c for c in checks)


def _claimed(result: Reloaded, estimate: ObjectiveError, tolerance: float) -> float:
    """How far the objective may be from the optimum, as the result says: by its error bar, by its relative error where
    there is none; at least by what the engine's tolerance leaves, and no more than what passes."""
    size, last = 1 + abs(result.objective), result.records[-1]
    own = estimate.bar if estimate.applies else last.relative_error * size
    return min(max(own, ENGINE * last.tolerance * size), tolerance * size)
