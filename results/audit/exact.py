"""What can be told of a phase that no method approximates: in discrete time, or without time.

Steps         The control applied step by step, from the stored initial state.
Multipliers   With H_k = w + lambda[k + 1] f + nu g, f the change in a step, dH_k/du = 0 as in `optimality`, and

                  lambda[k] = lambda[k + 1] + dH_k/dx            (the costate equation of discrete time)

              to which x(t - m) adds dH_{k + m}/dx(t - m),
              and lambda goes on from each step to the next, but for the multipliers of bounds of the states between.

              Without time, L = f + y g has no slope in any static parameter, but for the multipliers of its bounds. No
              inequality has a multiplier of the wrong sign, or one beside a slack.
Second order  On the tangent of all that acts, the second derivatives of L have no negative eigenvalue. They are those
              of the whole nonlinear program, which is the problem; of a large one they are not looked at.

Pontryagin's minimum of H over all controls is no necessary condition in discrete time, and is not asked for.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...transcription.dual.multipliers import ACTS, Multipliers
from ...transcription.solution.trajectory import Trajectory
from ..file.reload import Reloaded
from .check import ENGINE, Check, at
from .optimality import COMPLEX_STEP, Hamiltonian, stationarity
from .trajectory import ranges

LARGEST_PROGRAM = 500
"""Unknowns of a program whose second derivatives are looked at."""

SHARP = 1e-5
"""Relative: what passes where nothing but the engine's tolerance is between the result and the truth."""

RANK = 1e-9
"""Of the largest singular value: below it a row depends on others."""


def step_checks(trajectory: Trajectory, allowed: float, tolerance: float) -> Iterator[Check]:
    """Each step by itself, and all of them one after the other.

    trajectory: of a phase in discrete time.
    allowed: what a step may be missed by, relative to 1 + the size of a state: what the engine's tolerance leaves.
    tolerance: of the deviation at the end, relative to the range of each state.
    """
    phase, t, u, p = trajectory.phase, trajectory.times, trajectory.u, trajectory.parameters
    x = trajectory.x
    size = 1 + np.abs(x).max(axis=1, keepdims=True)
    after = x[:, :-1] + phase.dynamics(t[:-1], x[:, :-1], u[:, :-1], p)
    missed = np.nan_to_num(np.abs(after - x[:, 1:]) / size, nan=np.inf)
    i, k = map(int, np.unravel_index(np.argmax(missed), missed.shape))
    yield Check("each step, relative", float(missed[i, k]), allowed, f"{phase.states[i].name}, {at(trajectory, t[k])}")
    own = np.empty_like(x)
    own[:, 0] = x[:, 0]
    for k in range(len(t) - 1):
        own[:, k + 1] = own[:, k] + phase.dynamics(t[[k]], own[:, [k]], u[:, [k]], p)[:, 0]
    for i, state in enumerate(phase.states):
        deviation = np.nan_to_num(np.abs(own[i] - x[i]) / ranges(trajectory)[i], nan=np.inf)
        k = int(np.argmax(deviation))
        yield Check(
            f"simulated {state.name}, relative to its range", float(deviation[k]), tolerance, at(trajectory, t[k])
        )


def discrete_optimality(result: Reloaded, number: int, claimed: float, tolerance: float) -> Iterator[Check]:
    """The costate equation, and dH/du = 0 for each input.

    result: read back, with multipliers.
    number: of the phase, from 0.
    claimed: how far the objective may be from the optimum.
    tolerance: the largest value of each measure that passes, all of them relative.
    """
    hamiltonian = Hamiltonian(result, number)
    trajectory, values, sense = hamiltonian.trajectory, hamiltonian.values(), result.problem.sense
    assert trajectory.costate is not None
    mesh = trajectory.mesh
    slopes = np.stack(
        [hamiltonian.derivative(hamiltonian.lagrangian, values, x.name) for x in hamiltonian.phase.states]
    )
    slopes += _asked_later(hamiltonian, values)
    before, after = (sense * trajectory.costate[:, mesh.offset + k] for k in (0, 1))
    scale = float(np.abs([before, after]).max()) or 1.0
    left = ENGINE * result.records[-1].tolerance
    apart = np.maximum(np.abs(before - after - slopes) - left, 0.0) / scale
    places = result.transcription.phases[number].x[:, mesh.knots[1:-1]]
    bounds = np.where(places >= 0, result.outcome.z_upper[places] - result.outcome.z_lower[places], 0.0)
    jumps = np.maximum(np.abs(after[:, :-1] - before[:, 1:] - bounds) - left, 0.0) / scale
    apart[:, 1:] = np.maximum(apart[:, 1:], jumps)
    k = int(np.argmax(apart.max(axis=0)))
    yield Check("costate equation, relative", float(apart[:, k].max()), SHARP, at(trajectory, values["t"][k]))
    yield from stationarity(result, hamiltonian, values, 0 * slopes, claimed, tolerance)


def _asked_later(hamiltonian: Hamiltonian, values: dict[str, np.ndarray]) -> np.ndarray:
    """dH_{k + m}/dx(t - m), shape (n, N): what the state at step k is worth to the step m later that asks for it."""
    names = [state.name for state in hamiltonian.phase.states]
    found = np.zeros((len(names), len(values["t"])))
    for own in hamiltonian.phase.delayed:
        m = min(round(own.lag), found.shape[1])
        slope = hamiltonian.derivative(hamiltonian.lagrangian, values, own.name)
        found[names.index(own.state), : found.shape[1] - m] += slope[m:]
    return found


def static_optimality(result: Reloaded, number: int) -> Iterator[Check]:
    """dL/dp = 0 for each static parameter of a problem without time.

    result: read back, with multipliers.
    number: of the phase, from 0.
    """
    phase, p, outcome = result.problem.phases[number], result.trajectories[number].parameters, result.outcome
    bodies = {c.name: c.function for c in phase.boundary}
    terms = [(float(result.problem.sense), phase.mayer)] if phase.mayer else []
    for family in result.transcription.families:
        terms.append((float(outcome.y[family.rows(result.nlp)][0]), bodies[family.name]))
    left = ENGINE * result.records[-1].tolerance
    for place, name in zip(result.transcription.parameters, p, strict=True):
        values = {**p, name: p[name] + COMPLEX_STEP * 1j}
        slopes = [weight * float(np.imag(function(values, np))) / COMPLEX_STEP for weight, function in terms]
        slopes += [-float(outcome.z_lower[place]), float(outcome.z_upper[place])]
        scale = max(map(abs, slopes)) or 1.0
        value = max(abs(sum(slopes)) - left, 0.0) / scale
        yield Check(f"stationarity dL/d{name}, relative", value, SHARP)


def whole_program(result: Reloaded) -> Iterator[Check]:
    """Signs of multipliers and second order, of a result all of whose phases are exact.

    result: read back, with multipliers.
    """
    own, nlp, outcome = Multipliers(result.transcription, result.nlp, result.outcome), result.nlp, result.outcome
    size = float(np.abs(outcome.y).max(initial=0.0)) or 1.0
    wrong = np.where(outcome.y > 0, ~np.isfinite(nlp.cu), ~np.isfinite(nlp.cl)) & ~own.equations
    idle = np.minimum(np.abs(outcome.y) / size, np.abs(own.sides[2][1]) / (1 + np.abs(own.sides[2][2])))
    value = np.where(wrong, np.abs(outcome.y) / size, np.where(own.equations, 0.0, idle))
    yield Check("multipliers of inequalities, relative", float(value.max(initial=0.0)), SHARP)
    if nlp.n <= LARGEST_PROGRAM:
        yield Check("d2L/dz2 without negative eigenvalues, relative", _lowest(own), SHARP)


def _lowest(own: Multipliers) -> float:
    """The lowest eigenvalue of the second derivatives of L on the tangent of what acts, if negative, relative."""
    nlp, outcome = own.nlp, own.outcome
    (lower, below, low), (upper, above, high), (y, slack, bound) = own.sides
    held = (own.acting(lower, below, low) > ACTS) & (lower > 0) | (own.acting(upper, above, high) > ACTS) & (upper > 0)
    held |= own.bounds[0] == own.bounds[1]
    rows = own.equations | ((own.acting(y, slack, bound) > ACTS) & (np.abs(outcome.y) > 0))
    H, A = np.zeros((nlp.n, nlp.n)), np.zeros((nlp.m, nlp.n))
    np.add.at(H, nlp.hessianstructure(), nlp.hessian(outcome.z, outcome.y, 1.0))
    np.add.at(A, nlp.jacobianstructure(), nlp.jacobian(outcome.z))
    H = (H + np.tril(H, -1).T)[np.ix_(~held, ~held)]
    A = A[np.ix_(rows, ~held)]
    scale = float(np.abs(H).max(initial=0.0)) or 1.0
    _, sizes, directions = np.linalg.svd(A)
    free = directions[np.count_nonzero(sizes > RANK * sizes.max(initial=0.0)) :]
    return float(max(-np.linalg.eigvalsh(free @ H @ free.T).min(initial=0.0), 0.0) / scale) + 0.0
