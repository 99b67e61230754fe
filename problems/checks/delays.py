"""What states at earlier times need: a history, given times, one phase."""

from __future__ import annotations

from collections.abc import Iterator

from ..names.symbols import Symbols
from ..schema.spec import Spec
from ..yaml.locations import Finding


def delay_mistakes(spec: Spec, symbols: Symbols, alone: bool) -> Iterator[Finding]:
    """Why states of a phase cannot be taken at earlier times.

    spec: of the phase.
    symbols: its names.
    alone: whether it is the only phase.
    """
    delays = list(symbols.delayed.values())
    if not delays:
        return
    first = delays[0]
    if not alone:
        what = f"{first.name}: with phases, states cannot be taken at earlier times: those are in the phase before"
        yield Finding(first.path, what, "write one phase, with what differs in time as a function of t, such as step")
        return
    states = {state.name: state for state in symbols.states}
    for name in dict.fromkeys(own.state for own in delays):
        if states[name].entry.history is None:
            asked = next(own.name for own in delays if own.state == name)
            what = f"{asked} needs {name} before the initial time, and {name} has no history"
            remedy = f"add history: to {name}, a number or an expression of t, such as history: 1"
            yield Finding(states[name].path, what, remedy)
    for end in ("initial", "final"):
        if getattr(spec.time, end).value is None:
            what = f"the {end} time is free, and {first.name} is interpolated on a mesh at given times"
            yield Finding(("time", end), what, "give it a value; sweep over it to see which is best")
    if spec.guess.simulate is not None:
        what = f"a guess is not simulated with states at earlier times, as {first.name}"
        yield Finding(("guess", "simulate"), what, "give keyframes:, constants: or formulas: instead")


def idle_histories(symbols: Symbols) -> Iterator[Finding]:
    """A warning for each history that no expression asks for."""
    asked = {own.state for own in symbols.delayed.values()}
    for state in symbols.states:
        if state.entry.history is not None and state.name not in asked:
            what = f"the history of {state.name} is used nowhere"
            yield Finding((*state.path, "history"), what, f"remove it, or write {state.name}(t - tau) in an expression")
