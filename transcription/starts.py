"""Other first trajectories, for a problem that its own guess does not lead to a good solution of.

A guess is poor where it hides the controls from the solver: a control has no effect to first order (df/du = 0), so
nothing pulls it away, although it would have one further off. A straight line between the ends can also be so far from
any motion of the system that the solver ends where the constraints contradict each other.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from math import isfinite

import numpy as np

from ..problems.problem import Guess, Phase, Problem, Range, Variable

SAMPLES = 101  # of a guess, evenly spaced
LONGER = 2.0  # times the time of the problem's own guess, where it is free and that is inside its bounds
NEAR = 1e-4  # of the size of a control: the step of the difference that stands for df/du
NO_EFFECT = 1e-3  # df/du below this share of the effect of a step of the whole size is taken for zero

Start = tuple[str, list[Guess]]
"""What a start is, in words, and the guess for each phase."""


def other_starts(problem: Problem) -> Iterator[Start]:
    """Other guesses than the problem's own, in the order in which they are worth trying; the same at every call."""
    for share in (0.5, 0.75, 0.25):
        words = f"controls at {100 * share:g} % between their bounds, states simulated under them"
        yield words, [_simulated(phase, _held(phase, share)) for phase in problem.phases]
    yield "controls that swing about the guess, states simulated under them", [
        _simulated(phase, _swinging(phase)) for phase in problem.phases
    ]
    if any(_free(phase.final_time) for phase in problem.phases):
        words = "a longer time, states bent to the rates at their ends"
        yield words, [_bent(phase, _held(phase, 0.5)) for phase in problem.phases]


def without_effect(phase: Phase, guess, parameters: Mapping[str, float], t: np.ndarray, s: np.ndarray) -> list[str]:
    """The controls whose first-order effect on the rates is zero all along a trajectory, and is not further away.

    guess: with the method `samples` of `Guess`. t, s: times and normalised times (K,) at which to look.
    """
    values = guess.samples(s)
    x = np.array([values[state.name] for state in phase.states])
    u = np.array([values[variable.name] for variable in phase.inputs])

    def change(row: int, step: float) -> float:
        ends = []
        for sign in (1, -1):
            moved = u.copy()
            moved[row] += sign * step
            ends.append(phase.dynamics(t, x, moved, parameters))
        here = phase.dynamics(t, x, u, parameters)
        if step < size:  # a central difference, in which what is even about this point cancels
            return float(np.abs(ends[0] - ends[1]).max() / (2 * step))
        return float(np.nanmax(np.abs(np.array(ends) - here)) / step)

    found = []
    for row, control in enumerate(phase.controls):
        size = _size(control)
        slope, effect = change(row, NEAR * size), change(row, size)
        if isfinite(slope) and isfinite(effect) and slope <= NO_EFFECT * effect and effect > 0:
            found.append(control.name)
    return found


def _free(bounds: Range) -> bool:
    return bounds.lower < bounds.upper


def _size(variable: Variable) -> float:
    """Half the distance of the bounds, or 1 where one is missing; of a control that is fixed, 1 too."""
    half = (variable.bounds.upper - variable.bounds.lower) / 2
    return half if isfinite(half) and half > 0 else 1.0


def _held(phase: Phase, share: float) -> np.ndarray:
    """Inputs, shape (n_u, SAMPLES): controls at this share between their bounds, 1 inside open ones."""
    values = phase.guess.samples(np.linspace(0.0, 1.0, SAMPLES))
    rows = []
    for variable in phase.inputs:
        bounds = variable.bounds
        closed = isfinite(bounds.lower) and isfinite(bounds.upper)
        level = bounds.lower + share * (bounds.upper - bounds.lower) if closed else bounds.clip(4 * share - 1)
        rows.append(np.full(SAMPLES, level) if variable in phase.controls else values[variable.name])
    return np.array(rows).reshape(-1, SAMPLES)


def _swinging(phase: Phase) -> np.ndarray:
    """Inputs, shape (n_u, SAMPLES): the guess of each control plus a slow oscillation, each at its own rate."""
    s = np.linspace(0.0, 1.0, SAMPLES)
    values = phase.guess.samples(s)
    rows = []
    for number, variable in enumerate(phase.inputs):
        moved = values[variable.name] + 0.3 * _size(variable) * np.cos((number + 1.0) * np.pi * s)
        limits = variable.bounds
        rows.append(np.clip(moved, limits.lower, limits.upper) if variable in phase.controls else values[variable.name])
    return np.array(rows).reshape(-1, SAMPLES)


def _guess(phase: Phase, x: np.ndarray, u: np.ndarray, final: float) -> Guess:
    values = {state.name: row for state, row in zip(phase.states, x, strict=True)}
    values |= {variable.name: row for variable, row in zip(phase.inputs, u, strict=True)}
    return replace(phase.guess, final_time=final, s=np.linspace(0.0, 1.0, SAMPLES), values=values)


def _straight(phase: Phase) -> np.ndarray:
    """The states of the problem's own guess, shape (n_x, SAMPLES)."""
    values = phase.guess.samples(np.linspace(0.0, 1.0, SAMPLES))
    return np.array([values[state.name] for state in phase.states])


def _simulated(phase: Phase, u: np.ndarray) -> Guess:
    """States simulated from the start of the guess by Heun's method, kept inside their bounds; the guess's own where
    the simulation has no finite value.
    """
    guess, own = phase.guess, _straight(phase)
    t = np.linspace(guess.initial_time, guess.final_time, SAMPLES)
    limits = np.array([(state.bounds.lower, state.bounds.upper) for state in phase.states]).T
    x = own.copy()
    for k in range(SAMPLES - 1):
        h = t[k + 1] - t[k]
        here = phase.dynamics(t[k], x[:, k], u[:, k], guess.parameters)
        there = phase.dynamics(t[k + 1], x[:, k] + h * here, u[:, k + 1], guess.parameters)
        x[:, k + 1] = np.clip(x[:, k] + h * (here + there) / 2, *limits)
        if not np.isfinite(x[:, k + 1]).all():
            return _guess(phase, own, u, guess.final_time)
    return _guess(phase, x, u, guess.final_time)


def _bent(phase: Phase, u: np.ndarray) -> Guess:
    """Cubics between the ends of the guess, with the rates there, over a longer time where the time is free."""
    guess, own = phase.guess, _straight(phase)
    span = guess.final_time - guess.initial_time
    final = phase.final_time.clip(guess.initial_time + LONGER * span) if _free(phase.final_time) else guess.final_time
    ends, s = [0, -1], np.linspace(0.0, 1.0, SAMPLES)
    times = np.array([guess.initial_time, final])
    slopes = phase.dynamics(times, own[:, ends], u[:, ends], guess.parameters) * (final - guess.initial_time)
    a, b = own[:, :1], own[:, -1:]
    x = a + (b - a) * s**2 * (3 - 2 * s) + slopes[:, :1] * s * (1 - s) ** 2 - slopes[:, 1:] * s**2 * (1 - s)
    limits = np.array([(state.bounds.lower, state.bounds.upper) for state in phase.states])
    x = np.clip(x, limits[:, :1], limits[:, 1:])
    return _guess(phase, x if np.isfinite(x).all() else own, u, final)
