"""Whether controls that were fixed on bounds want to be there: what it would be worth to move them off.

By Pontryagin's principle no other value of the control gives a lower H at any time. To first order the objective falls

    by the integral of  max(0, H(bound) - H(u))  over t

if the control moves to the best other value u; of an arc that should be on a bound, that is nothing. The slack
variables of abs, min and max follow: of |y| = s1 + s2 with y = s1 - s2 one is y or -y, the other one zero. Where both
are zero, y stays at its kink, and controls inside their bounds may want to leave that.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

import numpy as np

from ...problems.problem import Phase
from ...problems.quantities import Constraint, Range
from ...transcription.solution.implicit import consistent_inputs
from ...transcription.solution.trajectory import Trajectory

SHARES = np.array([0.01, 0.5, 1.0])
"""Of the way to the other bound: the values that are tried. The first is what a curved H would take."""

KEPT = 1e-6
"""Of 1 + |bound|: what exceeds a path constraint by more is not allowed, and a state that is nearer is on its bound."""


def worth_of_leaving(
    trajectory: Trajectory, fixed: Mapping[str, str], bounds: Mapping[str, Range], sense: int
) -> float:
    """What it would be worth to move each of some controls off its bound, the largest of all; infinite if not known.

    trajectory: a solved phase.
    fixed: name of each control that is fixed -> "lower" or "upper"; slack variables too.
    bounds: name -> the range that it has.
    sense: +1 if the objective is minimised, -1 if it is maximised.
    """
    if trajectory.costate is None:
        return np.inf
    phase, mesh = trajectory.phase, trajectory.mesh
    points = mesh.collocated
    t, x, u = trajectory.times[points], trajectory.x[:, points], trajectory.u[:, points]
    costate = sense * trajectory.point_costate[:, points]
    weights = mesh.weights[points] * (trajectory.final_time - trajectory.initial_time)
    there = _hamiltonian(trajectory, t, x, u, costate, sense)
    pairs, worst = _slack(phase), 0.0
    slack = {i for _, *pair in pairs for i in pair}
    names = [control.name for control in phase.controls]
    at_kink = any(names[plus] in fixed and names[minus] in fixed for _, plus, minus in pairs)
    for i, name in enumerate(names):
        if i in slack or not (name in fixed or at_kink):
            continue
        others: Iterable[np.ndarray]
        others = _others(bounds[name], fixed[name]) if name in fixed else _beside(bounds[name], u[i])
        for value in others:
            moved = u.copy()
            moved[i] = value
            moved = consistent_inputs(phase, t, x, moved, trajectory.parameters)
            for constraint, plus, minus in pairs:
                y = constraint.function(phase.arguments(t, x, moved, trajectory.parameters), np)
                y = y + moved[plus] - moved[minus]
                moved[plus], moved[minus] = np.maximum(y, 0.0), np.maximum(-y, 0.0)
            gain = there - _hamiltonian(trajectory, t, x, moved, costate, sense)
            gain[~(_allowed(trajectory, t, x, moved) & np.isfinite(gain))] = 0.0
            worst = max(worst, float((weights * np.maximum(gain, 0.0)).sum()))
    return worst


def _others(bounds: Range, on: str) -> np.ndarray:
    """Other values of a control that is on a bound."""
    bound, other = (bounds.lower, bounds.upper) if on == "lower" else (bounds.upper, bounds.lower)
    if not np.isfinite(other):
        other = bound + np.sign(other) * (1 + abs(bound))
    return bound + SHARES * (other - bound)


def _beside(bounds: Range, own: np.ndarray) -> Iterator[np.ndarray]:
    """Other values of a control inside its bounds, on both sides of its own, (N,)."""
    for bound, away in ((bounds.lower, -1.0), (bounds.upper, 1.0)):
        other = bound if np.isfinite(bound) else own + away * (1 + np.abs(own))
        yield from (own + share * (other - own) for share in SHARES)


def _slack(phase: Phase) -> list[tuple[Constraint, int, int]]:
    """The constraints y - s1 + s2 = 0 of slack variables, each after those that its y stands on, and the rows of s1 and
    s2 among the controls; they have the names that `nonsmooth.rewrite` gives them."""
    row = {control.name: i for i, control in enumerate(phase.controls)}
    named = [(c, row.get(f"{c.name}_plus"), row.get(f"{c.name}_minus")) for c in phase.path]
    return [(c, plus, minus) for c, plus, minus in named if plus is not None and minus is not None]


def _hamiltonian(
    trajectory: Trajectory, t: np.ndarray, x: np.ndarray, u: np.ndarray, costate: np.ndarray, sense: int
) -> np.ndarray:
    """H = w + lambda f of the minimised objective."""
    phase, p = trajectory.phase, trajectory.parameters
    H: np.ndarray = (costate * phase.dynamics(t, x, u, p)).sum(axis=0)
    return H + sense * phase.lagrange(phase.arguments(t, x, u, p), np) if phase.lagrange else H


def _allowed(trajectory: Trajectory, t: np.ndarray, x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Where all path constraints hold, and no state that is on a bound leaves it."""
    phase, p = trajectory.phase, trajectory.parameters
    values, holds = phase.arguments(t, x, u, p), np.ones(t.shape, bool)
    for c in phase.path:
        holds &= c.bounds.excess(np.asarray(c.function(values, np))) <= KEPT
    for state, own, rate in zip(phase.states, x, phase.dynamics(t, x, u, p), strict=True):
        for bound, outwards in ((state.bounds.lower, -rate), (state.bounds.upper, rate)):
            holds &= ~((np.abs(own - bound) <= KEPT * (1 + abs(bound))) & (outwards > 0) & np.isfinite(bound))
    return holds
