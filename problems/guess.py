"""Initial trajectories: straight lines, constants, formulas, keyframes, columns of data, simulations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import inf, isfinite

import numpy as np

from .guesses.conditions import conditioned, known_ends
from .guesses.observed import observed_rows
from .guesses.rates import differentiated, integrated
from .guesses.rows import GuessRow, GuessSpan, combined, rows_of
from .guesses.simulated import POINTS, simulated
from .names.symbols import Symbols
from .problem import Guess, Phase
from .quantities import Constraint, Function, Range, State, Variable
from .schema.fields import Bounded
from .schema.spec import Spec


def initial_guess(
    spec: Spec,
    symbols: Symbols,
    states: tuple[State, ...],
    inputs: tuple[Variable, ...],
    *,
    times: tuple[Range, Range],
    boundary: Sequence[Constraint] = (),
    slack: Sequence[Variable] = (),
) -> Guess:
    """The guess that the file asks for, but for what needs the dynamics or other phases (see `finished`).

    spec, symbols: the file without mistakes, its names and values.
    states: of the problem, with their ranges at both ends; each gets a straight line, what was measured of it, or what
        the file gives.
    inputs: the controls, then the algebraic variables; each is zero, as near as its bounds allow, or what the file
        gives.
    times: ranges of the initial and of the final time, in the unit of time of the file.
    boundary: constraints on both ends; one on a single value is about that end of the state.
    slack: static parameters that the file does not name. Like slack controls they start at zero (paper, 8.5).
    """
    first = middle(times[0], symbols.number(spec.time.initial.guess, inf))
    last = middle(times[1], symbols.number(spec.time.final.guess, inf))
    parameters = {
        name: middle(symbols.range(static), symbols.number(static.guess, inf)) for name, static in spec.optimize.items()
    }
    both = np.array([0.0, 1.0])
    known = {**parameters, **known_ends(states), "t[initial]": first, "t[final]": last}
    asked = asked_ends(symbols, conditioned(boundary, known))
    rows = {state.name: GuessRow(both, np.array(ends(state, *asked[state.name]))) for state in states}
    rows |= {variable.name: GuessRow(both, np.full(2, variable.bounds.clip(0.0))) for variable in inputs}
    span = GuessSpan(first, last, times[0].fixed and times[1].fixed)
    rows |= observed_rows(spec, symbols, rows.keys(), span, asked)
    rows |= {name: GuessRow(both, np.full(2, symbols.number(v, 0.0))) for name, v in spec.guess.constants.items()}
    rows |= {name: _formula(symbols.function(e), first, last, parameters) for name, e in spec.guess.formulas.items()}
    given = rows_of(spec.guess, symbols.number, span)
    rows |= {name: row for name, row in given.items() if name in rows}  # a file may have columns of something else
    s, values = combined(rows, both)
    return Guess(
        initial_time=first,
        final_time=last,
        s=s,
        values=values,
        parameters=parameters | {parameter.name: parameter.bounds.clip(0.0) for parameter in slack},
    )


def asked_ends(symbols: Symbols, conditions: Mapping[str, Range]) -> dict[str, tuple[Range, Range]]:
    """Name of each state -> what the file asks for at its ends, without its bounds.

    symbols: of the phase.
    conditions: on values at its ends, as of `conditioned`.
    """

    def of(name: str, entry: Bounded | None, end: str) -> Range:
        asked = symbols.range(entry)
        both = asked.intersection(conditions.get(f"{name}[{end}]", Range()))
        return both if both.lower <= both.upper else asked

    return {
        s.name: (of(s.name, s.entry.initial, "initial"), of(s.name, s.entry.final, "final")) for s in symbols.states
    }


def _formula(function: Function, first: float, last: float, parameters: dict[str, float]) -> GuessRow:
    """The row of an expression of t and static parameters."""
    s = np.linspace(0.0, 1.0, POINTS)
    with np.errstate(all="ignore"):
        values = function({"t": first + s * (last - first), **parameters}, np)
    return GuessRow(s, np.array(np.broadcast_to(values, s.shape), float))


def finished(
    phases: Sequence[Phase],
    specs: Mapping[str, Spec],
    symbols: Mapping[str, Symbols],
    before: Mapping[str, tuple[str, frozenset[str]]],
    shared: frozenset[str],
) -> list[Phase]:
    """The phases with guesses in which velocities are those of their positions, integrals those of the rest, and
    what is to be simulated is.

    phases: in order, with the guesses that they have otherwise.
    specs, symbols: of each phase.
    before: phase -> the phase that it goes on from, and the states that do not go on.
    shared: names that the guess of the whole trajectory gives.

    Raises `guesses.simulated.RunawayError`.
    """
    done: dict[str, Phase] = {}
    for phase in phases:
        spec = specs[phase.name]
        own = integrated(differentiated(phase, shared | spec.guess.named.keys()), spec.integrals.keys())
        if spec.guess.simulate is not None:
            source, left_out = before.get(phase.name, ("", frozenset()))
            ends = done[source].guess.values if source else {}
            start = {name: float(row[-1]) for name, row in ends.items() if name not in left_out}
            own = simulated(own, spec, symbols[phase.name], start)
        done[phase.name] = own
    return list(done.values())


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
