"""Whether a problem may well have other optima than the one found, as far as a look at its solution tells."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...problems.quantities import Variable
from ..solution.solution import Solution
from ..solution.trajectory import Trajectory
from ..starts.drawn import chosen_parameters
from .convexity import kind_of_program

WORK = 10_000
"""Unknowns times iterations of a solve that costs next to nothing: up to 0.1 s of the processor."""

SWITCHING, AT_BOUND = 0.8, 1e-2
"""Share of the collocation points at which controls that only switch are at a bound, and how near, of their range."""


def may_have_several(solution: Solution, nlp: Any) -> bool:
    """Whether other starts are worth a try though one was solved.

    So they are where the solve costs next to nothing and there are static parameters to choose, or where the final time
    is free and all controls only switch between their bounds: the number and order of switches is a discrete choice,
    and the solver stays with that of its guess. A problem without time always costs little. One whose equations are
    linear and whose objective is convex has one optimum.

    solution: a usable one on the first mesh.
    nlp: its program.
    """
    phases = solution.problem.phases
    if all(phase.static for phase in phases):
        return not kind_of_program(nlp, solution.outcome.z).has_one_optimum
    if any(phase.exact for phase in phases) or nlp.n * solution.meshes[-1].iterations > WORK:
        return False
    if not chosen_parameters(solution.problem) and not _switches(solution):
        return False
    return not kind_of_program(nlp, solution.outcome.z).has_one_optimum


def _switches(solution: Solution) -> bool:
    """Whether a final time is free, and every control is at a bound nearly always."""
    free = any(not phase.final_time.fixed for phase in solution.problem.phases)
    shares = [share for own in solution.trajectories for share in _shares_at_bounds(own)]
    return free and bool(shares) and min(shares) >= SWITCHING


def _shares_at_bounds(trajectory: Trajectory) -> list[float]:
    """The share of collocation points at which each control is at a bound."""
    at = trajectory.mesh.collocated
    controls = trajectory.phase.controls
    return [_share(control, values[at]) for control, values in zip(controls, trajectory.u, strict=False)]


def _share(control: Variable, values: np.ndarray) -> float:
    lower, upper = control.bounds.lower, control.bounds.upper
    if not np.isfinite(upper - lower):
        return 0.0
    return float(np.mean(np.minimum(values - lower, upper - values) <= AT_BOUND * (upper - lower)))
