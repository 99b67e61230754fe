"""What is wrong with a guess: names, lengths, times, formulas of what is not known, simulations that run away."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, pairwise

import numpy as np

from ..build import build
from ..guesses.simulated import RunawayError
from ..names.roles import with_article
from ..names.symbols import Symbols
from ..phases.merge import home, phase_specs
from ..quantities import Range
from ..schema.sections import GuessEntry
from ..schema.spec import Spec
from ..tables.series import TIME
from ..text import brief, did_you_mean, shorten
from ..yaml.document import Path
from ..yaml.locations import Finding

_DATA: Path = ("guess", "data")


def guess_mistakes(spec: Spec, symbols: Symbols, times: tuple[Range | None, Range | None]) -> Iterator[Finding]:
    """Every mistake in the guess of a phase, but for values without a number.

    spec, symbols: of the phase.
    times: ranges of its initial and its final time, None where mistaken.
    """
    guess = spec.guess
    known = [own.name for own in symbols.variables]
    yield from misnamed(guess, known, "a state or a control, nor an algebraic variable")
    yield from _twice(guess)
    yield from uneven(guess)
    if guess.data and all(own is not None and own.fixed for own in times):
        yield from _apart(guess, *(own.lower for own in times if own is not None))
    yield from _of_time(spec, symbols)
    yield from _simulation(spec, symbols)


def guess_warnings(guess: GuessEntry, known: Sequence[str]) -> Iterator[Finding]:
    """Columns of a file that are of nothing.

    guess: of a phase.
    known: names of its states, controls and algebraic variables.
    """
    others = [name for name in guess.data if name not in known and name != TIME]
    if others and guess.source:
        shown = shorten(", ".join(map(brief, others)))
        what = f"{guess.source} has columns that are no states or controls: {shown}"
        remedy = did_you_mean(others[0], known, "they count for nothing; call a column as the state that it is of")
        yield Finding(("guess", "file"), what, remedy)


def misnamed(guess: GuessEntry, known: Sequence[str], what: str) -> Iterator[Finding]:
    """Names in a guess that are not those of variables.

    guess: of a phase, or of the whole trajectory.
    known: those that are.
    what: they are, for the message.
    """
    for key in ("constants", "formulas", "keyframes"):
        for name in getattr(guess, key):
            if name not in known and (key, name) != ("keyframes", TIME):
                yield _unknown(("guess", key, name), name, known, what)
    columns = [name for name in guess.data if name != TIME]
    if guess.source and columns and not set(columns) & set(known):
        listed = shorten(", ".join(map(brief, columns)))
        what = f"no column of {guess.source} is a state or a control: they are {listed}"
        yield Finding(("guess", "file"), what, did_you_mean(columns[0], known, f"call them as {', '.join(known[:5])}"))
    elif not guess.source:
        yield from (_unknown((*_DATA, name), name, known, what) for name in columns if name not in known)


def _unknown(path: Path, name: str, known: Sequence[str], what: str) -> Finding:
    remedy = did_you_mean(name, known, "name a state, a control or an algebraic variable")
    return Finding(path, f"{brief(name)} is not {what}", remedy)


def _twice(guess: GuessEntry) -> Iterator[Finding]:
    """Names that are given in two ways."""
    words = {"constants": "a constant", "formulas": "a formula", "keyframes": "keyframes", "data": "data"}
    for key, other in combinations((*words, "simulate"), 2):
        for name in (getattr(guess, key) or {}).keys() & (getattr(guess, other) or {}).keys():
            if name != TIME:
                first, second = (key, other) if other in words else (other, key)
                yield Finding(("guess", first, name), f"{name} has {words[second]} as well", "keep one of the two")


def uneven(guess: GuessEntry) -> Iterator[Finding]:
    """Rows of keyframes that have not as many values as there are times."""
    frames = guess.keyframes
    for name, row in frames.items() if TIME in frames else ():
        if len(row) != len(frames[TIME]):
            what = f"{name} has {len(row)} keyframes, time has {len(frames[TIME])}"
            remedy = "give it the same number of values, or leave out time: for rows that are equally spaced"
            yield Finding(("guess", "keyframes", name), what, remedy)


def unordered(times: Sequence[float]) -> Iterator[Finding]:
    """Times of keyframes that do not increase."""
    if any(later <= earlier for earlier, later in pairwise(times)):
        remedy = "sort them, each larger than the one before"
        yield Finding(("guess", "keyframes", TIME), "the times do not increase", remedy)


def _apart(guess: GuessEntry, initial: float, final: float) -> Iterator[Finding]:
    """Data that are of no time of the phase."""
    first, last = guess.data[TIME][0] or 0.0, guess.data[TIME][-1] or 0.0
    if last < initial or first > final:
        what = f"the times of the data are {first:g} to {last:g}, those of the problem {initial:g} to {final:g}"
        path = ("guess", "file") if guess.source else (*_DATA, TIME)
        yield Finding(path, what, "give data of these times; check the unit of time")


def _of_time(spec: Spec, symbols: Symbols) -> Iterator[Finding]:
    """Formulas of anything but time and what is known before; simulated controls of anything but time and states."""
    states = {own.name for own in symbols.states}
    for key, allowed, words in (
        ("formulas", {"t"}, "t and parameters; one of states is for simulate:"),
        ("simulate", {"t"} | states, "t, states and parameters"),
    ):
        for name, expression in (getattr(spec.guess, key) or {}).items():
            path: Path = ("guess", key, name)
            if not symbols.sound(path, expression):
                continue
            for other in sorted(symbols.function(expression).names - allowed - symbols.static)[:1]:
                what = f"{other} is {with_article(symbols.roles.get(other, 'unknown'))}, which is not known here"
                yield Finding(path, what, f"write a formula of {words}")


def _simulation(spec: Spec, symbols: Symbols) -> Iterator[Finding]:
    guess = spec.guess
    if guess.simulate is None:
        return
    if symbols.algebraic:
        what = "the dynamics are implicit, and only explicit ones can be simulated for a guess"
        yield Finding(("guess", "simulate"), what, "write constants:, formulas: or keyframes: instead")
    controls = [control.name for control in symbols.controls]
    for name in guess.simulate:
        if name not in controls:
            remedy = did_you_mean(name, controls, f"the controls are {', '.join(controls)}" if controls else "write {}")
            yield Finding(("guess", "simulate", name), f"{brief(name)} is not a control", remedy)


def computed_guess(spec: Spec) -> Iterator[Finding]:
    """What goes wrong where a guess is computed: formulas without a value, simulations that run away.

    spec: of the file, without other mistakes.
    """
    own = phase_specs(spec)
    if not any(phase.guess.formulas or phase.guess.simulate is not None for phase in own.values()):
        return
    try:
        phases = build(spec).phases
    except RunawayError as error:
        path = home(spec, error.phase, ("guess", "simulate"))
        what = f"the dynamics cannot be simulated for a guess: {error}"
        yield Finding(path, what, "change the control or the initial values, or write constants: or keyframes:")
        return
    for phase in phases:
        for name in own[phase.name].guess.formulas:
            row = phase.guess.values[name]
            if not np.isfinite(row).all():
                span = phase.guess.final_time - phase.guess.initial_time
                at = phase.guess.initial_time + span * phase.guess.s[int(np.argmin(np.isfinite(row)))]
                what = f"the formula has no finite value at t = {at:.4g}"
                yield Finding(home(spec, phase.name, ("guess", "formulas", name)), what, "write one that has")


def values_of(guess: GuessEntry, numbers: Mapping[Path, float]) -> Iterator[tuple[Path, str, list[float]]]:
    """(path, name, values) of what a guess gives as numbers.

    guess: of a phase.
    numbers: path in the file -> value, if it has one.
    """
    for name in guess.constants:
        path: Path = ("guess", "constants", name)
        yield path, name, [numbers[path]] if path in numbers else []
    for name, frames in guess.keyframes.items():
        path = ("guess", "keyframes", name)
        yield path, name, [numbers[p] for i in range(len(frames)) if (p := (*path, i)) in numbers]
    for name, row in guess.data.items():
        if name != TIME:
            yield ("guess", "file") if guess.source else (*_DATA, name), name, [v for v in row if v is not None]
