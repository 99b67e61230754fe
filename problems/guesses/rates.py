"""Velocities of a guess: the derivatives of the positions (paper, 2.10, 7.10, 8.7); and its integrals."""

from __future__ import annotations

from collections.abc import Collection, Container
from dataclasses import replace

import numpy as np

from ..problem import Phase

SAMPLES = 51
"""Of a guess, beside its own points, for its integrals."""


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


def integrated(phase: Phase, names: Collection[str]) -> Phase:
    """The phase; in its guess the states that are integrals are those of the rest of the guess.

    phase: with a guess of all that varies.
    names: of the states that are integrals. One whose integrand has no finite value on the way stays zero.
    """
    if not names:
        return phase
    guess = phase.guess
    s = np.union1d(guess.s, np.linspace(0.0, 1.0, SAMPLES))
    values, duration = guess.samples(s), guess.final_time - guess.initial_time
    arguments = {"t": guess.initial_time + s * duration, **values, **guess.parameters}
    for state in phase.states:
        if state.name in names:
            with np.errstate(all="ignore"):
                rate = np.broadcast_to(state.rate(arguments, np), s.shape)
            mean = (rate[1:] + rate[:-1]) / 2
            total = np.concatenate([[0.0], np.cumsum(mean * np.diff(s)) * duration])
            if np.isfinite(total).all():
                values[state.name] = total
    return replace(phase, guess=replace(guess, s=s, values=values))
