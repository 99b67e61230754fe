"""Velocities of a guess: the derivatives of the positions (paper, 2.10, 7.10, 8.7)."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import replace

import numpy as np

from ..problem import Phase


def differentiated(phase: Phase, given: Container[str]) -> Phase:
    """The phase; in its guess velocities that are not given are the derivatives of their positions.

    phase: with a guess.
    given: names that the file guesses. A position that is neither given nor moving says nothing of its velocity.
    """
    guess, moved = phase.guess, {}
    duration = guess.final_time - guess.initial_time
    for state in phase.states:
        row = guess.values.get(state.velocity_of)
        if row is None or state.name in given or duration <= 0:
            continue
        if state.velocity_of in given or np.ptp(row) > 0:
            moved[state.name] = np.clip(np.gradient(row, guess.s) / duration, state.bounds.lower, state.bounds.upper)
    return replace(phase, guess=replace(guess, values={**guess.values, **moved})) if moved else phase
