"""Controls that do nothing along a solution: the Hamiltonian is the same whatever they are.

A slew about one axis is stationary, as the costates of the other two vanish all along it: their torques are worth
nothing in first order. It takes longer than one that uses all three, to which another start may lead.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...problems.expressions.expression import together
from ...problems.probe import depends_on, derivatives
from ...problems.problem import Phase, Problem
from ...problems.quantities import Variable
from ..solution.trajectory import Trajectory

NOTHING = 1e-6
"""Of 1 + |J|: what a control changes the integral of H by, at most, going from one of its bounds to the other."""


def worthless(problem: Problem, found: Sequence[Trajectory], objective: float) -> list[str]:
    """The bounded controls, in words, that H does not depend on along a solution; none where costates are not known.

    problem: that was solved.
    found: the trajectories of its phases.
    objective: of the solution.
    """
    several, size = len(problem.phases) > 1, NOTHING * (1 + abs(objective))
    return [
        f"{control.name} of phase {own.phase.name}" if several else control.name
        for own in found
        for control in _worthless(own, problem.sense, size)
    ]


def _worthless(trajectory: Trajectory, sense: int, size: float) -> list[Variable]:
    phase = trajectory.phase
    if trajectory.costate is None or phase.exact or phase.algebraic:
        return []
    left = [own for own in phase.controls if 0 < own.bounds.upper - own.bounds.lower < np.inf]  # not what is given
    left = [own for own in left if not _is_held(phase, own)]
    for level in ("own", "lower", "upper"):
        if left:
            left = _without_slope(trajectory, left, level, sense, size)
    return left


def _is_held(phase: Phase, control: Variable) -> bool:
    """Whether a constraint depends on a control: then H does not tell what it is for, as of slack variables."""
    return any(depends_on(own.function, {control.name}) for own in (*phase.path, *phase.integral))


def _without_slope(
    trajectory: Trajectory, controls: list[Variable], level: str, sense: int, size: float
) -> list[Variable]:
    """Those of the controls that H does not depend on in first order where each has its own values or is at a bound."""
    phase, points = trajectory.phase, trajectory.mesh.collocated
    values = dict(trajectory.at_collocated)
    if level != "own":
        values |= {own.name: np.full(len(points), getattr(own.bounds, level)) for own in controls}
    functions = [*(state.rate for state in phase.states), *([phase.lagrange] if phase.lagrange else [])]
    slopes = derivatives(together(functions), values, [own.name for own in controls])
    weights = np.ones((len(functions), 1, len(points)))
    weights[: len(phase.states), 0] = sense * trajectory.point_costate[:, points]
    worth = np.abs((weights * slopes).sum(axis=0)).max(axis=1) * float(np.ptp(trajectory.t))
    return [own for own, w in zip(controls, worth, strict=True) if w * (own.bounds.upper - own.bounds.lower) < size]
