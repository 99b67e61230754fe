"""The ends of time: what is given there must not contradict what holds at every time, nor lack what comes before.

Path constraints have to hold there; states at earlier times need a history.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite

import numpy as np

from ..conserved.conserved import conserved
from ..names.occurrences import constraints
from ..names.symbols import Symbols
from ..quantities import Range
from ..schema.spec import Spec
from ..yaml.locations import UNUSED, Finding

ROUNDING = 1e-9
"""Of 1 + |bound|: by less than this a constraint may be missed, since values are computed."""


def impossible_at_ends(spec: Spec, symbols: Symbols) -> Iterator[Finding]:
    """Path constraints that cannot hold at an end where all that they depend on is given; spec: without mistakes."""
    for end in ("initial", "final"):
        given = dict(_given(spec, symbols, end))
        for path, constraint in constraints(spec):
            function = symbols.function(constraint.expression)
            if path[1] != "path" or not function.names or not function.names <= given.keys():
                continue
            bounds = symbols.range(constraint)
            with np.errstate(all="ignore"):
                value = np.array(float(function({name: np.float64(own) for name, own in given.items()}, np)))
            if np.isfinite(value) and bounds.excess(value) > ROUNDING:
                what = f"this cannot hold at the {end} time: it is {value:.6g} there, and {_asked(bounds)} is asked"
                names = ", ".join(f"{name}[{end}]" for name in sorted(function.names))
                yield Finding((*path, "expression"), what, f"change the constraint, or what is given for {names}")


def contradictory_ends(spec: Spec, symbols: Symbols) -> Iterator[Finding]:
    """Final values that no control leads to, as the dynamics keep what differs at both ends; spec: without mistakes."""
    if spec.discrete or spec.algebraic or spec.residuals or symbols.delayed or spec.nonsmooth:
        return
    both = [dict(_given(spec, symbols, end)) for end in ("initial", "final")]
    states = [own for own in symbols.states if not own.implicit and all(own.name in given for given in both)]
    first, last = ([given[own.name] for own in states] for given in both)
    rates = [symbols.function(own.rate) for own in states]
    found = conserved([own.name for own in states], rates, first, last)
    if found and (wrong := found.contradicted):
        values = f"{wrong.initial:.7g} at the initial and {wrong.final:.7g} at the final time"
        what = f"the final values cannot be reached: the dynamics keep {wrong.function}, which is {values}"
        remedy = "leave out one of the final values in it, or give values that agree to 6 digits"
        last_one = next(own for own in states if own.name == wrong.state)
        yield Finding((*last_one.path, "final"), what, remedy)


def _given(spec: Spec, symbols: Symbols, end: str) -> Iterator[tuple[str, float]]:
    """The values that are fixed at one end, by name."""
    times = symbols.range(getattr(spec.time, end))
    if times.fixed:
        yield "t", times.lower
    for state in symbols.states:
        asked = symbols.range(getattr(state.entry, end))
        if asked.fixed:
            yield state.name, asked.lower


def _asked(bounds: Range) -> str:
    if bounds.fixed:
        return f"{bounds.lower:.6g}"
    if not isfinite(bounds.upper):
        return f"at least {bounds.lower:.6g}"
    return str(bounds) if isfinite(bounds.lower) else f"at most {bounds.upper:.6g}"


def delay_mistakes(spec: Spec, symbols: Symbols) -> Iterator[Finding]:
    """Why states of a phase cannot be taken at earlier times.

    spec: of the phase.
    symbols: its names.
    """
    delays = list(symbols.delayed.values())
    if not delays:
        return
    first = delays[0]
    states = {state.name: state for state in symbols.states}
    for name in dict.fromkeys(own.state for own in delays):
        if states[name].entry.history is None:
            asked = next(own.name for own in delays if own.state == name)
            what = f"{asked} needs {name} before the initial time, and {name} has no history"
            remedy = f"add history: to {name}, a number or an expression of t, such as history: 1"
            yield Finding(states[name].path, what, remedy)
    for own in delays:
        if spec.discrete and own.lag % 1:
            what = f"{own.name}: in discrete time a state has values at whole steps, and the delay is {own.lag:g}"
            yield Finding(own.path, what, f"make it {max(round(own.lag), 1)}, or another whole number")
    if spec.guess.simulate is not None:
        what = f"a guess is not simulated with states at earlier times, as {first.name}"
        yield Finding(("guess", "simulate"), what, "give keyframes:, constants: or formulas: instead")


def idle_histories(symbols: Symbols) -> Iterator[Finding]:
    """A warning for each history that no expression asks for."""
    asked = {own.state for own in symbols.delayed.values()}
    for state in symbols.states:
        if state.entry.history is not None and state.name not in asked:
            what = f"the history of {state.name} is used nowhere"
            yield Finding(
                (*state.path, "history"), what, f"remove it, or write {state.name}(t - tau) in an expression", UNUSED
            )
