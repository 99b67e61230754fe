"""Initial trajectories: a straight line from the initial to the final state, constants, keyframes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf, isfinite

import numpy as np

from .names.symbols import Symbols
from .problem import Guess, Range, State, Variable
from .schema.spec import Spec


def initial_guess(
    spec: Spec,
    symbols: Symbols,
    states: tuple[State, ...],
    inputs: tuple[Variable, ...],
    *,
    times: tuple[Range, Range],
    slack: Sequence[Variable] = (),
) -> Guess:
    """The guess that the file asks for.

    spec, symbols: the file without mistakes, its names and values.
    states: of the problem, with their ranges at both ends; each gets a straight line, or what the file gives.
    inputs: the controls, then the algebraic variables; each is zero, as near as its bounds allow, or what the file
        gives.
    times: ranges of the initial and of the final time, in the unit of time of the file.
    slack: static parameters that the file does not name. Like slack controls they start at zero (paper, 8.5).
    """
    keyframes = {name: np.array([symbols.number(v, 0.0) for v in row]) for name, row in spec.guess.keyframes.items()}
    s = keyframe_positions(keyframes)
    asked = {s.name: (symbols.range(s.entry.initial), symbols.range(s.entry.final)) for s in symbols.states}
    values = {state.name: np.interp(s, [0.0, 1.0], ends(state, *asked[state.name])) for state in states}
    values |= {variable.name: np.full(len(s), variable.bounds.clip(0.0)) for variable in inputs}
    values |= {name: np.full(len(s), symbols.number(v, 0.0)) for name, v in spec.guess.constants.items()}
    values |= {name: row for name, row in keyframes.items() if name != "time"}
    return Guess(
        initial_time=middle(times[0], symbols.number(spec.time.initial.guess, inf)),
        final_time=middle(times[1], symbols.number(spec.time.final.guess, inf)),
        s=s,
        values=values,
        parameters={
            name: middle(symbols.range(static), symbols.number(static.guess, inf))
            for name, static in spec.optimize.items()
        }
        | {parameter.name: parameter.bounds.clip(0.0) for parameter in slack},
    )


def keyframe_positions(keyframes: Mapping[str, np.ndarray]) -> np.ndarray:
    """Normalised times s of the keyframes, shape (K,): 0 and 1 where there are none, evenly spaced without `time`."""
    if "time" in keyframes:
        time = keyframes["time"]
        s: np.ndarray = (time - time[0]) / (time[-1] - time[0])
        return s
    return np.linspace(0.0, 1.0, len(next(iter(keyframes.values()), (0, 1))))


def ends(state: State, initial: Range, final: Range) -> tuple[float, float]:
    """Initial and final value of the straight line of a state, in its unit.

    An end takes its value, or the middle of its range; one that is free takes the value of the other, else 0. All are
    clipped into the bounds.

    state: its ranges at both ends lie inside its bounds.
    initial: what the file asks for at the initial time, without the bounds.
    final: what it asks for at the final time.
    """
    known = [middle(r, inf) if isfinite(r.lower) and isfinite(r.upper) else None for r in (initial, final)]
    first = next((value for value in known if value is not None), 0.0)
    last = next((value for value in reversed(known) if value is not None), 0.0)
    return state.initial.clip(first), state.final.clip(last)


def middle(bounds: Range, guess: float) -> float:
    """The guess where one is given (finite); else the middle of the range, or 0 as near as an open range allows."""
    if isfinite(guess):
        return guess
    if isfinite(bounds.lower) and isfinite(bounds.upper):
        return bounds.lower + (bounds.upper - bounds.lower) / 2
    return bounds.clip(0.0)
