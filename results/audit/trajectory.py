"""Whether the stored control does what the stored states say, and whether bounds hold between the points."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache, partial
from itertools import pairwise

import numpy as np

from ...transcription.solution.error import ErrorProfile, exactness, excesses
from ...transcription.solution.implicit import consistent_inputs
from ...transcription.solution.trajectory import Trajectory
from .check import Check, at
from .jumps import control_shares
from .steps import Past

RELAXED = 1.1
"""Times what a product may be, which the engine holds to its tolerance."""

RTOL, ATOL = 1e-10, 1e-12
MOST_EVALUATIONS = 10_000
"""Of the dynamics in one segment; the library takes 290 at most, a singularity any number."""

CLAIMED, UNSTABLE = 10.0, 1e3
"""CLAIMED: what a simulated segment may deviate by, in eta as the result claims it, times the growth of errors in it.
UNSTABLE: times as much as all eta together, a deviation over the horizon is the dynamics' own doing."""

ROUNDING = 1e-8
"""Of 1 + the size of a state: what a segment may deviate by however small eta is."""

PERTURBED = 1e-6
"""Of the size of a state: an error that is small, and far above that of the integration."""

CONSTANT = 1e-6
"""Of 1 + its size: a state that varies by less is constant, and what it varies by is rounding."""


def simulation(trajectory: Trajectory, error: ErrorProfile, tolerance: float) -> Iterator[Check]:
    """The control integrated over each segment by itself, and over the whole horizon, against the stored states.

    trajectory: of one phase.
    error: of the trajectory, what the result claims.
    tolerance: of the deviation over the horizon, relative to the range of each state.

    Over the horizon unstable dynamics make of a small error any large one. If every segment keeps what it claims, and
    the deviation at the end is far more than all errors together, it is told and does not count.
    """
    knots, size = trajectory.x[:, trajectory.mesh.knots], 1 + np.abs(trajectory.dense.x).max(axis=1, keepdims=True)
    apart = np.abs(_segments(trajectory) - knots[:, 1:])
    claimed = (error.eta / size).max(axis=0)  # of any state: an error of one becomes one of the others
    over_claim = apart / size / (CLAIMED * claimed + ROUNDING)
    for segment in np.flatnonzero(
        (over_claim > 1).any(axis=0)
    ).tolist():  # perhaps the dynamics amplify the error within it
        over_claim[:, segment] /= _amplification(trajectory, segment, size[:, 0])
    i, k = map(int, np.unravel_index(np.argmax(np.nan_to_num(over_claim, nan=np.inf)), apart.shape))
    name = trajectory.phase.states[i].name
    kept = Check(
        "each segment simulated, over its claimed error", float(over_claim[i, k]), 1.0,
        f"{name}, {at(trajectory, trajectory.knots[k])}",
    )  # fmt: skip
    yield kept
    whole, scale = np.abs(simulate(trajectory) - knots), ranges(trajectory)
    for i, state in enumerate(trajectory.phase.states):
        deviation = whole[i] / scale[i]
        k = int(np.argmax(np.nan_to_num(deviation, nan=np.inf)))
        where, value = at(trajectory, trajectory.knots[k]), float(deviation[k])
        if not np.isfinite(value):
            where = f"the simulation fails before {where}: the dynamics have no finite value, or run away"
        if kept.passed and not value <= tolerance and not whole[i, k] <= UNSTABLE * (error.eta.sum() + ROUNDING):
            where, value = f"not counted: the dynamics are unstable, and deviate by {value:.1e} at {where}", 0.0
        yield Check(f"simulated {state.name}, relative to its range", value, tolerance, where)


def ranges(trajectory: Trajectory) -> np.ndarray:
    """What deviations of each state are relative to, shape (n_x,): its range, or its size if it is constant."""
    x = trajectory.dense.x
    size, span = 1 + np.abs(x).max(axis=1), np.ptp(x, axis=1)
    return np.where(span <= CONSTANT * size, size, span)


def held_control(trajectory: Trajectory, hold: float, tolerance: float) -> Iterator[Check]:
    """The states that the control gives if it is sampled and held until the next sample.

    trajectory: of one phase.
    hold: the time between two samples, in the phase's unit of time.
    tolerance: of the deviation at the knots, relative to the range of each state.
    """
    apart, scale = np.abs(_held(trajectory, hold) - trajectory.x[:, trajectory.mesh.knots]), ranges(trajectory)
    for i, state in enumerate(trajectory.phase.states):
        deviation = apart[i] / scale[i]
        k = int(np.argmax(np.nan_to_num(deviation, nan=np.inf)))
        name = f"{state.name} under the control held for {hold:g} {trajectory.phase.time_unit}"
        yield Check(name, float(deviation[k]), tolerance, at(trajectory, trajectory.knots[k]))


def _held(trajectory: Trajectory, hold: float) -> np.ndarray:
    """States at the knots, shape (n_x, N + 1), under the held control; NaN where the simulation has failed."""
    t0, tF = trajectory.t
    samples = t0 + hold * np.arange(int(np.ceil((tF - t0) / hold)))
    u = trajectory.at((samples - t0) / (tF - t0)).u
    x = np.full((len(trajectory.phase.states), trajectory.mesh.segments + 1), np.nan)
    x[:, 0] = state = trajectory.x[:, 0]
    past = Past(trajectory, remembers=True)
    times = np.union1d(samples, trajectory.knots)
    for start, end in pairwise(times):
        own = u[:, np.searchsorted(samples, start, side="right") - 1]
        after = _step(trajectory, (start, end), state, partial(_constant, own), past)
        if after is None:
            break
        state = after
        x[:, trajectory.knots == end] = state[:, None]
    return x


def _segments(trajectory: Trajectory) -> np.ndarray:
    """States at the end of each segment, shape (n_x, N), integrated from the stored ones at its start."""
    x = np.full((len(trajectory.phase.states), trajectory.mesh.segments), np.nan)
    for segment, start in enumerate(trajectory.x[:, trajectory.mesh.knots[:-1]].T):
        end = _integrated(trajectory, segment, start)
        if end is not None:
            x[:, segment] = end
    return x


def _amplification(trajectory: Trajectory, segment: int, size: np.ndarray) -> float:
    """By how much a segment makes small errors of the state larger, at least 1; size: of the states, shape (n_x,)."""
    start = trajectory.x[:, trajectory.mesh.knots[segment]]
    end, growth = _integrated(trajectory, segment, start), 1.0
    for i, step in enumerate(PERTURBED * size):
        moved = _integrated(trajectory, segment, start + np.eye(len(start))[i] * step)
        if end is not None and moved is not None:
            growth = max(growth, float(np.max(np.abs(moved - end) / size)) / PERTURBED)
    return growth


class _NoDynamicsError(ArithmeticError):
    """The dynamics have no finite value where the simulation has come to."""


def simulate(trajectory: Trajectory) -> np.ndarray:
    """States at the knots, shape (n_x, N + 1), by integrating the trajectory's control from its initial state.

    NaN from the knot on at which the integration fails.
    """
    x = np.full((len(trajectory.phase.states), trajectory.mesh.segments + 1), np.nan)
    x[:, 0] = trajectory.x[:, 0]
    past = Past(trajectory, remembers=True)
    for segment in range(trajectory.mesh.segments):
        end = _integrated(trajectory, segment, x[:, segment], past)
        if end is None:
            break
        x[:, segment + 1] = end
    return x


def _integrated(trajectory: Trajectory, segment: int, x: np.ndarray, past: Past | None = None) -> np.ndarray | None:
    """The state at the end of a segment, from x, shape (n_x,), at its start; None if the integration fails.

    past: of a simulation that has come to here; None for states at earlier times as the trajectory has them.
    """
    past = past or Past(trajectory, remembers=False)
    (start, end), inputs = trajectory.knots[segment : segment + 2], trajectory.inputs_of(segment)
    return _step(trajectory, (start, end), x, lambda t: inputs((t - start) / (end - start)), past)


def _step(
    trajectory: Trajectory,
    times: tuple[float, float],
    x: np.ndarray,
    inputs: Callable[[float], np.ndarray],
    past: Past,
) -> np.ndarray | None:
    """The state after two times, from x, shape (n_x,), under inputs(t), shape (n_u,); None if the integration fails."""
    from scipy.integrate import solve_ivp

    phase, p, evaluations = trajectory.phase, trajectory.parameters, [0]

    def rate(t: float, x: np.ndarray) -> np.ndarray:
        time, state, u = np.array([t]), x[:, None], past.filled(t, inputs(t))[:, None]
        evaluations[0] += 1
        f: np.ndarray = phase.dynamics(time, state, consistent_inputs(phase, time, state, u, p), p)[:, 0]
        if not np.isfinite(f).all() or evaluations[0] > MOST_EVALUATIONS:
            raise _NoDynamicsError
        return f

    for span in pairwise(past.steps(*times)):
        try:
            step = solve_ivp(rate, span, x, method="DOP853", rtol=RTOL, atol=ATOL, dense_output=past.remembers)
        except _NoDynamicsError:  # SciPy would make its steps ever smaller, for ever; so it does near a singularity
            return None
        x = step.y[:, -1]
        if not (step.success and np.isfinite(x).all()):
            return None
        past.remember(span[0], step.sol)
    return x


def between_points(trajectory: Trajectory, tolerance: float) -> Iterator[Check]:
    """Bounds and path constraints on the dense grid, relative to 1 + |bound|.

    On a segment in which a control jumps, its polynomial overshoots by a share of the jump, however short the segment
    is: there the excess counts times the jump's share of the phase (see `jumps`), and is told. So is that of a control
    which might as well be held within its bounds: it counts by what that would do (see `_held_within`). An exact phase
    has nothing between its points, so these are looked at.
    """
    if trajectory.phase.exact:
        yield from _at_points(trajectory, tolerance)
        return
    weights, t, held_within = control_shares(trajectory)[:, None], trajectory.dense.t, cache(_held_within)
    for excess in excesses(trajectory):
        by_segment = np.nan_to_num(trajectory.by_segment(excess.values), nan=np.inf)
        peak, counted = by_segment.ravel(), (by_segment * weights).ravel()
        k, worst = int(np.argmax(counted)), int(np.argmax(peak))
        where = at(trajectory, t[k]) if counted[k] > 0 else ""
        if peak[worst] > tolerance >= counted[k]:
            where += f"; {peak[worst]:.1e} in a jump, {at(trajectory, t[worst])}"
        value = float(counted[k])
        if excess.control and value > tolerance:
            effect, on = held_within(trajectory)
            if effect <= tolerance:
                where, value = f"{value:.1e} {where}; held within its bounds it would move {on} by that", effect
        yield Check(f"{excess.name} between the points", value, tolerance, where)


def _at_points(trajectory: Trajectory, tolerance: float) -> Iterator[Check]:
    t = np.atleast_1d(trajectory.at_collocated["t"])
    for excess in excesses(trajectory):
        values = np.nan_to_num(excess.values, nan=np.inf)
        k = int(np.argmax(values))
        where = at(trajectory, t[k]) if values[k] > 0 else ""
        yield Check(f"{excess.name} at the points", float(values[k]), tolerance, where)


def _held_within(trajectory: Trajectory) -> tuple[float, str]:
    """What the controls would do if they were held within their bounds between the points, and on what most.

    That is the integral of |f(x, u) - f(x, u held)|, relative to the range of each state, or what a path constraint is
    then exceeded by, relative to 1 + |bound|; infinite where either has no finite value. What it gains in the objective
    is in its error bar.
    """
    phase, sample, p = trajectory.phase, trajectory.dense, trajectory.parameters
    held = sample.u.copy()
    for row, control in zip(held, phase.controls, strict=False):
        np.clip(row, control.bounds.lower, control.bounds.upper, out=row)

    def rates(u: np.ndarray) -> np.ndarray:
        return phase.dynamics(sample.t, sample.x, consistent_inputs(phase, sample.t, sample.x, u, p), p)

    moved = np.abs(rates(held) - rates(sample.u))
    shifts = [float(trajectory.by_segment(row).mean(axis=1) @ trajectory.h) for row in moved] / ranges(trajectory)
    effects = {state.name: shift for state, shift in zip(phase.states, shifts.tolist(), strict=True)}
    values = phase.arguments(sample.t, sample.x, held, p)
    for own in phase.path:
        excess = own.bounds.excess(np.broadcast_to(own.function(values, np), sample.t.shape))
        effects[f"path constraint '{own.name}'"] = float(excess.max())
    known = {name: effect if np.isfinite(effect) else np.inf for name, effect in effects.items()}
    worst = max(known, key=known.__getitem__, default="")
    return known.get(worst, np.inf), worst


def complementary(trajectory: Trajectory) -> Iterator[Check]:
    """That one of two things is zero at the points, up to what it was relaxed to."""
    for pair, product, time in exactness(trajectory):
        yield Check(f"{pair.name}: a*b of the pair", product, RELAXED * pair.allowed, at(trajectory, time))


def _constant(value: np.ndarray, t: float) -> np.ndarray:
    return value
