"""Other first trajectories, for a start that leads nowhere, and what makes a start doubtful.

A start is doubtful where a control has no effect: df/du = 0 along it though f depends on u, as for v sin(theta) where
v = 0, or for u**3 where u = 0. There the first derivatives do not tell the solver what the control is for, and it may
stop at a stationary point that is no optimum.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from ...problems.expressions.expression import together
from ...problems.lean.records import dataclass
from ...problems.names.structure import form_of
from ...problems.probe import depends_on, derivatives
from ...problems.problem import Curves, Guess, Phase, Problem
from ...problems.quantities import State, Variable
from ..libraries.alone import building
from ..program.pointwise import compiled_values

POINTS = 101
"""Of a simulated trajectory."""

LONGER = 3.0
"""Times the guessed duration, for a free final time without an upper bound."""

LARGEST = 1e8
"""Of a simulated state: beyond it a simulation says nothing about an optimum."""

SAME, ABSOLUTE, EVALUATIONS = 1e-3, 1e-3, 5000
"""Relative to their sizes: how exact simulated states are, and what is nothing of them; evaluations of their rates."""

NO_SLOPE = 1e-6
"""Of a rate with a control: by less than this the control has no effect to speak of."""


Rates = Callable[[float, np.ndarray, np.ndarray], np.ndarray]
"""(t, x (n_x,), u (n_u,)) -> dx/dt (n_x,)."""


class OtherStart(NamedTuple):
    """A first trajectory for each phase, and what it is, in words."""

    words: str
    guesses: list[Guess]


@dataclass(frozen=True)
class _Change:
    """level: of the controls, -1 to 1 within their bounds, or their value if they have none; None leaves the guess.

    last: the level at the end, where it is another.
    """

    words: str
    level: float | None
    longer: bool
    last: float | None = None


CHANGES = (
    _Change("a longer final time", None, True),
    _Change("controls above the middle of their bounds, states simulated", 0.5, False),
    _Change("controls below the middle of their bounds, states simulated", -0.5, False),
    _Change("controls at the middle of their bounds, states simulated", 0.0, False),
    _Change("controls that fall from above the middle of their bounds, states simulated", 0.5, False, -0.5),
    _Change("controls that rise from below the middle of their bounds, states simulated", -0.5, False, 0.5),
    _Change("controls above the middle of their bounds, states simulated, a longer final time", 0.5, True),
)


def other_starts(problem: Problem, doubtful: bool, exactly: bool | None = None) -> Iterator[OtherStart]:
    """First trajectories that differ from the problem's own.

    problem: any.
    doubtful: whether the problem's own start is only doubtful; then just those whose controls differ are worth a try.
    exactly: whether an integrator simulates the states where equal steps do not hold them, which takes its time; None
        for so where the problem's own start has failed.
    """
    free = any(not phase.final_time.fixed for phase in problem.phases)
    for change in CHANGES:
        other_controls = change.level is not None and change.last is None
        if (change.longer and not free) or (doubtful and (not other_controls or change.longer)):
            continue
        exactly = not doubtful if exactly is None else exactly
        yield OtherStart(change.words, [_changed(phase, change, exactly) for phase in problem.phases])


def both_sides(problem: Problem, exactly: bool) -> Iterator[OtherStart]:
    """The first of the other starts: controls above, and below, the middle of their bounds.

    problem: any.
    exactly: as of `other_starts`.
    """
    return islice(other_starts(problem, True, exactly), 2)


def _changed(phase: Phase, change: _Change, exactly: bool) -> Guess:
    guess = phase.guess
    if change.longer and not phase.final_time.fixed:
        final = guess.initial_time + LONGER * (guess.final_time - guess.initial_time)
        guess = replace(guess, final_time=phase.final_time.clip(final))
    if change.level is None or not phase.controls:
        return guess
    last = change.level if change.last is None else change.last
    levels = {
        control.name: np.linspace(at_level(control, change.level), at_level(control, last), POINTS)
        for control in phase.controls
    }
    return under_controls(phase, guess, levels, exactly)


def under_controls(phase: Phase, guess: Guess, controls: Mapping[str, np.ndarray], exactly: bool = True) -> Guess:
    """A guess with other controls, and the states simulated under them unless there are algebraic variables.

    phase: one with controls.
    guess: its times and initial states are kept.
    controls: name of each -> its values at POINTS equally spaced times, shape (POINTS,).
    exactly: as of `other_starts`.
    """
    guess = replace(guess, parameters={**guess.parameters, **phase.times_in(guess)})
    s = np.linspace(0.0, 1.0, POINTS)
    values = guess.samples(s) | dict(controls)
    if not phase.algebraic:
        values |= _simulated(phase, guess, s, values, exactly)
    return replace(guess, s=s, values=values)


def at_level(control: Variable, level: float) -> float:
    """The value of a control at a level from -1 to 1 within its bounds; without two bounds, twice the level, clipped.

    control: with its bounds.
    level: 0 for the middle of the bounds.
    """
    lower, upper = control.bounds.lower, control.bounds.upper
    if isfinite(lower) and isfinite(upper):
        return (lower + upper) / 2 + level * (upper - lower) / 2
    return control.bounds.clip(2 * level)


def _simulated(
    phase: Phase, guess: Guess, s: np.ndarray, values: dict[str, np.ndarray], exactly: bool
) -> dict[str, np.ndarray]:
    """States simulated from their guessed initial values, bent to their given final ones; empty if they run away.

    s: (K,) normalised times. values: name of each state and input -> (K,).
    """
    duration = guess.final_time - guess.initial_time
    t = guess.initial_time + s * duration
    u = np.array([values[variable.name] for variable in phase.inputs])
    x0 = np.array([state.initial.clip(values[state.name][0]) for state in phase.states])
    with np.errstate(all="ignore"):
        x = (_course if exactly else _by_equal_steps)(_rates(phase, guess), t, x0, u)
    if not (np.abs(x) < LARGEST).all():
        return {}
    found = {}
    for state, curve in zip(phase.states, x, strict=True):
        missing = state.final.lower - curve[-1] if state.final.fixed else 0.0
        found[state.name] = np.clip(curve + s * missing, state.bounds.lower, state.bounds.upper)
    return found


def _rates(phase: Phase, guess: Guess) -> Rates:
    """dx/dt in machine code: evaluated point by point, NumPy would take most of the time of a failed solve."""
    functions = [state.rate for state in phase.states]
    data = form_of(functions).data
    names = ["t", *(own.name for own in (*phase.states, *phase.inputs)), *guess.parameters]
    with building():
        compiled = compiled_values(functions, names, list(data))
    n = 1 + len(phase.states) + len(phase.inputs)
    row = np.concatenate([np.zeros(n), [*guess.parameters.values(), *data.values()], np.zeros(len(functions))])

    def rates(t: float, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        row[0], row[1 : 1 + len(x)], row[1 + len(x) : n] = t, x, u
        f: np.ndarray = compiled(row)
        return f

    return rates


def _course(rates: Rates, t: np.ndarray, x0: np.ndarray, u: np.ndarray) -> np.ndarray:
    """The states at the times t (K,), shape (n_x, K), from x0 (n_x,), under controls u (n_u, K) there.

    Where twice the steps lead elsewhere, as with rates that are fast or have poles, an integrator chooses its own.
    """
    x, finer = _by_equal_steps(rates, t, x0, u), _stepped(rates, t, x0, u, 2)
    size = SAME * (np.abs(finer).max(axis=1) + np.abs(x0))
    return x if (np.abs(x - finer).max(axis=1) <= size).all() else _integrated(rates, t, x0, u)


def _by_equal_steps(rates: Rates, t: np.ndarray, x0: np.ndarray, u: np.ndarray) -> np.ndarray:
    """As `_course`, by a step from each time to the next, wherever that leads."""
    return _stepped(rates, t, x0, u, 1)


def _stepped(rates: Rates, t: np.ndarray, x0: np.ndarray, u: np.ndarray, steps: int) -> np.ndarray:
    """As `_course`, by so many equal steps from each time to the next."""
    x = np.empty((len(x0), len(t)))
    x[:, 0] = x0
    for k, h in enumerate(np.diff(t) / steps):
        x[:, k + 1] = x[:, k]
        for step in range(steps):
            x[:, k + 1] = _runge_kutta_step(rates, t[k] + step * h, h, x[:, k + 1], u[:, k])
    return x


def _integrated(rates: Rates, t: np.ndarray, x0: np.ndarray, u: np.ndarray) -> np.ndarray:
    """As `_course`, by LSODA; infinite where it does not come to the end."""
    from scipy.integrate import solve_ivp  # it takes longer to import than a small problem to solve

    left = iter(range(EVALUATIONS))

    def f(time: float, x: np.ndarray) -> np.ndarray:
        if next(left, None) is None or not (np.abs(x) < LARGEST).all():
            raise _RunsAwayError
        return rates(time, x, np.array([np.interp(time, t, own) for own in u]))

    absolute = SAME * ABSOLUTE * (1e-3 + np.abs(x0))
    try:
        found = solve_ivp(f, (t[0], t[-1]), x0, "LSODA", t_eval=t, rtol=SAME, atol=absolute)
    except _RunsAwayError:
        return np.full((len(x0), len(t)), np.inf)
    return found.y if found.success else np.full((len(x0), len(t)), np.inf)


class _RunsAwayError(Exception):
    """A simulation has no end."""


def _runge_kutta_step(rates: Rates, t: float, h: float, x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """x after a step h of the classical Runge-Kutta method, shape (n_x,), with constant controls u (n_u,)."""

    def f(time: float, state: np.ndarray) -> np.ndarray:
        return rates(time, state, u)

    k1 = f(t, x)
    k2 = f(t + h / 2, x + h / 2 * k1)
    k3 = f(t + h / 2, x + h / 2 * k2)
    k4 = f(t + h, x + h * k3)
    step: np.ndarray = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return step


def without_effect(problem: Problem, guesses: Sequence[Curves]) -> list[str]:
    """The controls, in words, that nothing depends on in first order along a first trajectory, though the dynamics do.

    guesses: one for each phase, or the trajectories of a solution.
    """
    several = len(problem.phases) > 1
    return [
        f"{control.name} of phase {phase.name}" if several else control.name
        for phase, guess in zip(problem.phases, guesses, strict=True)
        for control in phase.controls
        if not (phase.algebraic or control.bounds.fixed) and _without_effect(phase, guess, control.name)
    ]


def _without_effect(phase: Phase, guess: Curves, name: str) -> bool:
    found = slopes(phase, guess, name, [state for state in phase.states if depends_on(state.rate, {name})])
    return bool(found) and all((np.abs(slope) <= NO_SLOPE).all() for slope in found)


def slopes(phase: Phase, guess: Curves, name: str, states: Sequence[State]) -> list[np.ndarray]:
    """The derivatives of the rates of some states by an input or a parameter, at POINTS points along a trajectory.

    phase: of the states.
    guess: the trajectory.
    name: of the input or the parameter.
    states: whose rates have it.
    """
    s = np.linspace(0.0, 1.0, POINTS)
    values: dict[str, Any] = {**guess.samples(s), **guess.parameters}
    values["t"] = guess.initial_time + s * (guess.final_time - guess.initial_time)
    with np.errstate(all="ignore"):
        return list(derivatives(together([state.rate for state in states]), values, [name])[:, 0])
