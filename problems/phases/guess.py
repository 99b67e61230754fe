"""The guess of what goes on through several phases.

Keyframes of the top level are about the whole trajectory: each phase has its part. A state without them is linear from
each known value to the next; known are the values that are asked for at the ends, and those that phases guess, or
measure.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import replace
from math import isfinite
from typing import NamedTuple

import numpy as np

from ..guess import asked_ends, middle
from ..guesses.conditions import ENDS, conditioned, known_ends
from ..guesses.rows import GuessRow, GuessSpan, combined, rows_of
from ..names.symbols import Symbols
from ..problem import Phase
from ..quantities import Constraint, Range
from ..schema.spec import Spec
from .order import Passage, goes_on_in_time, passages


def through_phases(
    spec: Spec,
    own: Mapping[str, Spec],
    symbols: Mapping[str, Symbols],
    phases: Sequence[Phase],
    links: Sequence[Constraint],
) -> list[Phase]:
    """The phases, guesses of what goes on through them made one, where phases give none of their own.

    spec: of the file, its functions written out.
    own: the spec of each phase.
    symbols: of each phase.
    phases: with the guess that each would have by itself.
    links: conditions on the ends of several; one on a single value is about that end of the state.
    """
    if len(phases) == 1:
        return list(phases)
    by_name = {phase.name: phase for phase in phases}
    guessed = {name: entry.guess.named.keys() for name, entry in own.items()}
    settled = {phase.name: {*guessed[phase.name], *(m.expression for m in phase.measured)} for phase in phases}
    ways = [passage for passage in passages(spec) if goes_on_in_time(spec, passage)]
    framed, between = shared_names(spec), conditioned(links, phases[0].guess.parameters)
    asked = {
        phase.name: asked_ends(
            symbols[phase.name], _of_phase(between, phase) | conditioned(phase.boundary, _known(phase))
        )
        for phase in phases
    }
    before: dict[str, float] = {}
    for phase in phases:
        jumps = _of_phase(conditioned(links, {**phases[0].guess.parameters, **before}), phase)
        for state in phase.states:
            chain = [by_name[link] for link in _chain(state.name, phase.name, by_name, ways)]
            if chain and state.name not in framed:
                known = [state.name in settled[link.name] for link in chain]
                wanted = [asked[link.name][state.name] for link in chain]
                wanted[0] = _after_jump(wanted[0], jumps.get(f"{state.name}[{ENDS[0]}]"))
                for name, ends in _lines(state.name, chain, wanted, known):
                    if state.name not in settled[name]:
                        by_name[name] = _with_line(by_name[name], state.name, ends)
        before |= _guessed_ends(by_name[phase.name])
    first, last = phases[0], phases[-1]
    fixed = first.initial_time.fixed and last.final_time.fixed
    whole = GuessSpan(first.guess.initial_time, last.guess.final_time, fixed)
    rows = rows_of(spec.guess, next(iter(symbols.values())).number, whole)
    return [_with_part(phase, rows, whole, guessed[phase.name]) for phase in by_name.values()]


def _after_jump(asked: tuple[Range, Range], jump: Range | None) -> tuple[Range, Range]:
    """What is asked for at the ends of a phase, its initial value what a condition makes of phases before it."""
    both = asked[0].intersection(jump or Range())
    return (both, asked[1]) if both.lower <= both.upper else asked


def _guessed_ends(phase: Phase) -> dict[str, float]:
    """Name of each value at an end of a phase, as conditions on several ask for it -> its guess."""
    rows = {state.name: phase.guess.values[state.name] for state in phase.states}
    ends = zip(ENDS, (0, -1), strict=True)
    return {f"{phase.name}.{name}[{end}]": float(rows[name][place]) for end, place in ends for name in rows}


def _known(phase: Phase) -> dict[str, float]:
    """What conditions on the ends of a phase may ask for besides the value that they are about (see `conditioned`)."""
    times = {"t[initial]": phase.guess.initial_time, "t[final]": phase.guess.final_time}
    return {**phase.guess.parameters, **known_ends(phase.states), **times}


def shared_names(spec: Spec) -> frozenset[str]:
    """The names that the guess of the whole trajectory gives: its keyframes and its data."""
    return frozenset({*spec.guess.keyframes, *spec.guess.data} - {"time"})


def _chain(state: str, first: str, phases: Mapping[str, Phase], ways: Sequence[Passage]) -> list[str]:
    """The phases through which a state goes on from the first; none if it comes from another one itself."""
    if any(way.target == first and _carries(way, state, phases) for way in ways):
        return []
    chain = [first]
    while following := next((w for w in ways if w.source == chain[-1] and _carries(w, state, phases)), None):
        chain.append(following.target)
    return chain


def _carries(way: Passage, state: str, phases: Mapping[str, Phase]) -> bool:
    ends = (phases[way.source], phases[way.target])
    return state not in way.left_out and all(state in (own.name for own in phase.states) for phase in ends)


class _Knot(NamedTuple):
    """A time at which phases meet, and the value that is known there, if any."""

    time: float
    value: float | None


def _lines(
    state: str, chain: Sequence[Phase], wanted: Sequence[tuple[Range, Range]], guessed: Sequence[bool]
) -> Iterator[tuple[str, tuple[float, float]]]:
    """(phase, its initial and final value) along a chain: known values, and straight lines over time between them."""
    knots = list(_knots(state, chain, wanted, guessed))
    known = [(knot.time, knot.value) for knot in knots if knot.value is not None]
    if not known:
        return
    values = np.interp([knot.time for knot in knots], *np.array(known).T)
    for phase, start, end in zip(chain, values, values[1:], strict=False):
        yield phase.name, (float(start), float(end))


def _knots(
    state: str, chain: Sequence[Phase], wanted: Sequence[tuple[Range, Range]], guessed: Sequence[bool]
) -> Iterator[_Knot]:
    asked = []
    for phase, ends, own in zip(chain, wanted, guessed, strict=True):
        row = phase.guess.values[state]
        asked.append((float(row[0]), float(row[-1])) if own else tuple(map(_value, ends)))
    yield _Knot(chain[0].guess.initial_time, asked[0][0])
    for phase, (_, final), following in zip(chain, asked, [*asked[1:], (None, None)], strict=True):
        yield _Knot(phase.guess.final_time, following[0] if final is None else final)


def _of_phase(conditions: Mapping[str, Range], phase: Phase) -> dict[str, Range]:
    """The conditions on values of one phase, named as in the phase."""
    of = f"{phase.name}."
    return {name.removeprefix(of): own for name, own in conditions.items() if name.startswith(of)}


def _value(asked: Range) -> float | None:
    """The middle of a range with two ends: its width says where the state is."""
    return middle(asked, np.inf) if isfinite(asked.lower) and isfinite(asked.upper) else None


def _with_line(phase: Phase, name: str, ends: tuple[float, float]) -> Phase:
    state = next(own for own in phase.states if own.name == name)
    line = np.interp(phase.guess.s, [0.0, 1.0], [state.initial.clip(ends[0]), state.final.clip(ends[1])])
    return replace(phase, guess=replace(phase.guess, values={**phase.guess.values, name: line}))


def _with_part(phase: Phase, rows: Mapping[str, GuessRow], whole: GuessSpan, guessed: Container[str]) -> Phase:
    """The phase with its part of the rows of the whole trajectory."""
    guess = phase.guess
    own = [variable.name for variable in (*phase.states, *phase.inputs) if variable.name not in guessed]
    duration = guess.final_time - guess.initial_time
    if duration <= 0:
        return phase
    known = {name: GuessRow(guess.s, values) for name, values in guess.values.items()}
    for name in set(own) & rows.keys():
        times = whole.initial + rows[name].s * (whole.final - whole.initial)
        known[name] = GuessRow((times - guess.initial_time) / duration, rows[name].values)
    s, values = combined(known, guess.s)
    return replace(phase, guess=replace(guess, s=s, values=values))
