"""A guess that meets the dynamics: integrated, or stepped, forward from the initial values, under given controls."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from ..names.symbols import Symbols
from ..problem import Phase
from ..quantities import Function
from ..schema.spec import Spec

POINTS = 101
"""Equally spaced ones of a simulated guess, beside those of the integrator."""

LARGEST = 1e8
"""Times 1 + its initial size: a simulated state beyond it says nothing about an optimum."""

MOST_EVALUATIONS = 100_000
ACCURACY = 1e-6


class RunawayError(ValueError):
    """A simulation without an end: phase, what is wrong, and when, in the unit of time."""

    def __init__(self, phase: str, what: str, when: float):
        self.phase, self.what, self.when = phase, what, when
        super().__init__(f"{what} at t = {when:.4g}")


def simulated(phase: Phase, spec: Spec, symbols: Symbols, start: Mapping[str, float]) -> Phase:
    """The phase with the guess that its file wants simulated.

    phase: with the guess that it has otherwise: its times, static parameters, and the controls that are not given.
    spec, symbols: of this phase, without mistakes; abs, min and max are these functions themselves.
    start: name -> initial value of states that another phase ends with; the others start where the guess does.

    Raises RunawayError.
    """
    guess, names = phase.guess, [state.name for state in phase.states]
    given = {name: symbols.function(e) for name, e in (spec.guess.simulate or {}).items()}
    x0 = np.array([start.get(state.name, state.initial.clip(guess.values[state.name][0])) for state in phase.states])
    if guess.final_time <= guess.initial_time:
        return phase
    rates = _Rates(phase, symbols, given, x0)
    with np.errstate(all="ignore"):
        t, x = _stepped(phase, rates, x0) if phase.steps else _integrated(phase, rates, x0)
        s = (t - guess.initial_time) / (guess.final_time - guess.initial_time)
        values = guess.samples(s) | dict(zip(names, x, strict=True))
        values |= rates.controls(t, values)
    return replace(phase, guess=replace(guess, s=s, values=values))


def _stepped(phase: Phase, rates: _Rates, x0: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The times (K,) and the states (n_x, K) there of x[k + 1] = f(t_k, x[k], u[k]); rates: f."""
    t, x = phase.guess.initial_time + np.arange(phase.steps + 1.0), [x0]
    for now in t[:-1]:
        x.append(rates(now, x[-1]))
    return t, np.transpose(x)


def _integrated(phase: Phase, rates: _Rates, x0: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The times (K,) and the states (n_x, K) there of dx/dt = f(t, x, u); rates: f."""
    from scipy.integrate import solve_ivp  # it takes longer to import than a small problem to solve

    ends = phase.guess.initial_time, phase.guess.final_time
    absolute = ACCURACY * (1e-3 + np.abs(x0))
    found = solve_ivp(rates, ends, x0, method="LSODA", dense_output=True, rtol=ACCURACY, atol=absolute)
    if not found.success:
        raise RunawayError(phase.name, "the integration does not go on", found.t[-1])
    t = np.union1d(np.linspace(*ends, POINTS), found.t)
    return t, found.sol(t)


class _Rates:
    """dx/dt, or x at the next step, (n_x,) at a time t and states x (n_x,), under the controls of a guess and those
    that are given."""

    def __init__(self, phase: Phase, symbols: Symbols, given: Mapping[str, Function], x0: np.ndarray):
        self.phase, self.given, self.evaluations = phase, given, 0
        self.largest = LARGEST * (1 + np.abs(x0))
        self.bounds = {control.name: control.bounds for control in phase.controls}
        self.functions: list[Function] = [symbols.function(own.rate) for own in symbols.states]

    def controls(self, t: np.ndarray, values: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """The controls that are given, kept within their bounds; arrays of the shape of t."""
        own = {"t": t, **self.phase.guess.parameters, **values}
        return {
            name: np.clip(np.broadcast_to(f(own, np), np.shape(t)), self.bounds[name].lower, self.bounds[name].upper)
            for name, f in self.given.items()
        }

    def __call__(self, t: float, x: np.ndarray) -> np.ndarray:
        guess, states = self.phase.guess, self.phase.states
        self.evaluations += 1
        s = (t - guess.initial_time) / (guess.final_time - guess.initial_time)
        inputs = {own.name: np.interp(s, guess.s, guess.values[own.name]) for own in self.phase.inputs}
        values = {**inputs, **dict(zip((state.name for state in states), x, strict=True))}
        values |= self.controls(np.asarray(t), values)
        own = {"t": t, **guess.parameters, **values}
        f = np.array([float(rate(own, np)) for rate in self.functions])
        if not np.isfinite(f).all():
            name = states[int(np.argmin(np.isfinite(f)))].name
            raise RunawayError(self.phase.name, f"the rate of {name} has no finite value", t)
        if (np.abs(x) > self.largest).any():
            i = int(np.argmax(np.abs(x) / self.largest))
            raise RunawayError(self.phase.name, f"{states[i].name} runs away: it is {x[i]:.2g}", t)
        if self.evaluations > MOST_EVALUATIONS:
            raise RunawayError(self.phase.name, "the integration takes too many steps", t)
        return f
