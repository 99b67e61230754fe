"""States at earlier times in a guess: read off the guess of the state, and its history."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..problem import Guess, Phase
from ..quantities import Delayed

POINTS = 101
"""Of the guess of a phase with delays, at least: what is late has its kinks elsewhere."""


def with_delayed(phases: Sequence[Phase]) -> list[Phase]:
    """The phases, with guesses of their states at earlier times.

    phases: with guesses of everything else.
    """
    by_name = {phase.name: phase for phase in phases}
    return [_with_delayed(phase, by_name) for phase in phases]


def _with_delayed(phase: Phase, by_name: dict[str, Phase]) -> Phase:
    if not phase.delayed:
        return phase
    guess = phase.guess
    s = np.union1d(guess.s, np.linspace(0.0, 1.0, POINTS))
    t = guess.initial_time + s * (guess.final_time - guess.initial_time)
    given = {name: row for name, row in guess.values.items() if len(row) == len(guess.s)}
    values = Guess(0.0, 1.0, guess.s, given).samples(s)
    values |= {own.name: _guessed(own, phase, by_name, t - own.lag) for own in phase.delayed}
    return replace(phase, guess=replace(guess, s=s, values=values))


def _guessed(own: Delayed, phase: Phase, by_name: dict[str, Phase], t: np.ndarray) -> np.ndarray:
    """The guess of a state at times t (M,), in a phase or before it."""
    guess, before = phase.guess, by_name.get(phase.before)
    times = guess.initial_time + guess.s * (guess.final_time - guess.initial_time)
    values: np.ndarray = np.interp(t, times, guess.values[own.state])
    past = t < guess.initial_time
    if past.any():
        goes_on = before is not None and any(state.name == own.state for state in before.states)
        values[past] = _guessed(own, before, by_name, t[past]) if before and goes_on else own.before(t[past])
    return values
