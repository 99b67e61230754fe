"""States at earlier times in a guess: read off the guess of the state, and its history."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..problem import Guess, Phase

POINTS = 101
"""Of the guess of a phase with delays, at least: what is late has its kinks elsewhere."""


def with_delayed(phase: Phase) -> Phase:
    """The phase, with a guess of its states at earlier times.

    phase: with a guess of everything else.
    """
    guess = phase.guess
    if not phase.delayed:
        return phase
    duration = guess.final_time - guess.initial_time
    s = np.union1d(guess.s, np.linspace(0.0, 1.0, POINTS))
    given = {name: row for name, row in guess.values.items() if len(row) == len(guess.s)}
    values = Guess(0.0, 1.0, guess.s, given).samples(s)
    for own in phase.delayed:
        earlier = s - own.lag / duration
        past = own.before(guess.initial_time + earlier * duration)
        values[own.name] = np.where(earlier < 0, past, np.interp(earlier, s, values[own.state]))
    return replace(phase, guess=replace(guess, s=s, values=values))
