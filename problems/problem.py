"""The continuous optimal control problem: nothing discrete and nothing of YAML in it.

    minimise   sum over phases of  M(t0, x(t0), u(t0), tF, x(tF), u(tF), p) + integral of w(t, x, u, p) dt
               + M(the ends of all phases, p) + sum over measurements of  ((h(t_m, x(t_m), p) - y_m) / deviation)^2
    subject to dx/dt = f(t, x, u, z, p),  0 = r(t, x, u, z, p)   at every time      (dynamics, residuals),
               lower <= g(t, x, u, p) <= upper               at every time      (path),
               lower <= b(t0, x(t0), ..., tF, x(tF), p) <= upper                (boundary),
               lower <= integral of g(t, x, u, p) dt <= upper                   (integral),
               lower <= l(the ends of all phases, p) <= upper                   (links),
               bounds on x, u, p, t0, tF, x(t0), x(tF).

This is problem (1.1)-(1.7) of the paper with static parameters p and algebraic variables z added. There are as many
residuals r as algebraic variables; they make the dynamics implicit. Where a symbol u stands for an array, its rows are
the inputs of the dynamics: the controls, then the algebraic variables.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import inf
from typing import Any, Protocol

import numpy as np

from .text import short_repr, shorten

Numeric = Any
"""A number, a NumPy array or a Pyomo expression: functions of a problem are written once, for all of them."""


class Function(Protocol):
    """A scalar function of named values.

    Called with `values`, which maps the names t, the states, the inputs and the static parameters (or, at the
    boundary, "t[initial]", "q1[final]", ..., and in links "boost.q1[final]") to numbers, NumPy arrays of one shape, or
    Pyomo expressions, and with the module that holds sin, cos, exp, ... for values of that kind: `numpy` or
    `pyomo.core`.
    """

    def __call__(self, values: Mapping[str, Numeric], functions: Any, /) -> Numeric: ...


MAX_LINES = 5  # of what is shown of a problem

TOLERATED_EXCESS = 1e-4
"""Of a curve over a bound, as of `Range.excess`: refinement and figures let less than this pass."""


@dataclass(frozen=True)
class Range:
    """Closed interval; a fixed value where both ends are equal."""

    lower: float = -inf
    upper: float = inf

    def __str__(self) -> str:
        return f"{self.lower:g}" if self.fixed else f"{self.lower:g} to {self.upper:g}"

    @property
    def fixed(self) -> bool:
        return self.lower == self.upper

    def intersection(self, other: Range) -> Range:
        """What two ranges have in common; its lower end is above its upper one if that is nothing.

        Its ends are those of the ranges themselves, which may know more than their values; a fixed value stays whole.
        """
        if other.fixed and self.lower <= other.lower <= self.upper:
            return other
        return Range(max(self.lower, other.lower), min(self.upper, other.upper))

    def clip(self, value: float) -> float:
        return float(min(max(value, self.lower), self.upper))

    def excess(self, values: np.ndarray) -> np.ndarray:
        """How far values are outside, relative to 1 + |bound|; zero inside."""
        ends = ((self.lower, self.lower - values), (self.upper, values - self.upper))
        beyond = [gap / (1 + abs(end)) for end, gap in ends if abs(end) < inf]
        excess: np.ndarray = np.max([*beyond, np.zeros_like(values)], axis=0)
        return excess

    def beyond(self, values: np.ndarray) -> np.ndarray:
        """How far values are outside, in their own unit; zero inside."""
        beyond: np.ndarray = np.maximum(np.maximum(self.lower - values, values - self.upper), 0.0)
        return beyond


@dataclass(frozen=True)
class Variable:
    """A control, an algebraic variable or a static parameter."""

    name: str
    unit: str = ""
    bounds: Range = Range()


@dataclass(frozen=True)
class State(Variable):
    """A differential state: its rate f_i(t, x, u, p) and its ranges at both ends (inside `bounds`).

    velocity_of: the state whose rate this one is, if the problem states second-order dynamics; its own rate is then
    the acceleration.
    """

    rate: Function = field(kw_only=True)
    initial: Range = Range()
    final: Range = Range()
    velocity_of: str = ""


@dataclass(frozen=True)
class Constraint:
    """lower <= function <= upper, at every time, at the boundary, or integrated over time."""

    name: str
    function: Function
    bounds: Range


@dataclass(frozen=True)
class Complementarity:
    """a >= 0, b >= 0 and a*b = 0 at every time, relaxed to a*b <= allowed.

    name: also that of the path constraint on the product.
    """

    name: str
    product: Function
    allowed: float


@dataclass(frozen=True)
class Output:
    """A function over time, and its unit."""

    function: Function
    unit: str = ""


@short_repr
@dataclass(frozen=True)
class Measured:
    """A quantity of a phase that was measured: h(t, x, p), and its values at some times.

    name: in results. column: of the data. function, expression: h, and as it is written. times: (M,) within the phase,
    which do not fall. values, deviations: (M,) standard deviations. exact: whether these are known; else they are up to
    a common factor.
    """

    name: str
    column: str
    function: Function
    expression: str
    unit: str
    times: np.ndarray
    values: np.ndarray
    deviations: np.ndarray
    exact: bool

    @property
    def weights(self) -> np.ndarray:
        """w = 1 / deviation^2: w (h - value)^2 is added to what is minimised."""
        return 1 / self.deviations**2


class Curves(Protocol):
    """States and inputs over time, as a solve may start from: a `Guess`, or a solved trajectory.

    initial_time, final_time: in `Phase.time_unit`. parameters: name of each static parameter -> its value.
    """

    @property
    def initial_time(self) -> float: ...
    @property
    def final_time(self) -> float: ...
    @property
    def parameters(self) -> Mapping[str, float]: ...
    def samples(self, s: np.ndarray) -> dict[str, np.ndarray]:
        """Name of each state and input -> its values at normalised times s, any shape."""
        ...


@short_repr
@dataclass(frozen=True)
class Guess:
    """A piecewise linear initial trajectory.

    s: (K,) increasing, 0 at the initial and 1 at the final time. values: name of each state and input -> (K,).
    initial_time, final_time: in `Phase.time_unit`. parameters: name of each static parameter -> its value.
    """

    initial_time: float
    final_time: float
    s: np.ndarray
    values: Mapping[str, np.ndarray]
    parameters: Mapping[str, float] = field(default_factory=dict)

    def samples(self, s: np.ndarray) -> dict[str, np.ndarray]:
        """Name of each state and input -> its values at normalised times s, any shape."""
        return {name: np.interp(s, self.s, values) for name, values in self.values.items()}


@dataclass(frozen=True)
class Phase:
    """One phase: its own time, states, controls and constraints.

    time_unit: the unit of time. complementarity: what path constraints among the others are relaxed to.
    outputs: name -> what no equation of the problem needs, for those who look at a solution.
    measured: what is compared with data; both times of such a phase are fixed.
    time_parameters: name -> "initial" or "final", of static parameters that a boundary constraint makes that time.
    """

    name: str
    initial_time: Range
    final_time: Range
    states: tuple[State, ...]
    controls: tuple[Variable, ...]
    guess: Guess
    algebraic: tuple[Variable, ...] = ()
    residuals: tuple[Constraint, ...] = ()
    path: tuple[Constraint, ...] = ()
    complementarity: tuple[Complementarity, ...] = ()
    boundary: tuple[Constraint, ...] = ()
    integral: tuple[Constraint, ...] = ()
    lagrange: Function | None = None
    mayer: Function | None = None
    time_unit: str = "s"
    outputs: Mapping[str, Output] = field(default_factory=dict)
    measured: tuple[Measured, ...] = ()
    time_parameters: Mapping[str, str] = field(default_factory=dict)

    def times_in(self, curves: Curves) -> dict[str, float]:
        """The values of the parameters that are times of this phase, for curves that a solve may start from."""
        return {name: getattr(curves, f"{end}_time") for name, end in self.time_parameters.items()}

    @property
    def inputs(self) -> tuple[Variable, ...]:
        """The controls, then the algebraic variables: the rows of every array u."""
        return self.controls + self.algebraic

    def __repr__(self) -> str:
        """One line: the time, and the names of what varies in it."""
        kinds = {"states": self.states, "controls": self.controls, "algebraic": self.algebraic}
        named = [f"{kind} {_named(variables)}" for kind, variables in kinds.items() if variables]
        time = f"initial time {self.initial_time}, final time {self.final_time} {self.time_unit}".rstrip()
        return f"<Phase {self.name}: {'; '.join([time, *named])}>"

    @property
    def over_time(self) -> tuple[Function, ...]:
        """Every function of the values at one time that the problem needs."""
        constraints = (*self.residuals, *self.path, *self.integral)
        rates = (state.rate for state in self.states)
        return (*rates, *(c.function for c in constraints), *([self.lagrange] if self.lagrange else []))

    @property
    def at_ends(self) -> tuple[Function, ...]:
        """Every function of the values at both ends that the problem needs."""
        return (*(c.function for c in self.boundary), *([self.mayer] if self.mayer else []))

    def arguments(self, t: np.ndarray, x: np.ndarray, u: np.ndarray, p: Mapping[str, float]) -> dict[str, Any]:
        """What this phase's functions are called with: names -> arrays of shape (...).

        t: times, shape (...), in `time_unit`.
        x: states, shape (n_x, ...), each in its unit.
        u: inputs, shape (n_u, ...): the controls, then the algebraic variables.
        p: name of each static parameter -> its value.
        """
        states = {state.name: row for state, row in zip(self.states, x, strict=True)}
        inputs = {variable.name: row for variable, row in zip(self.inputs, u, strict=True)}
        return {"t": t, **states, **inputs, **p}

    def dynamics(self, t: np.ndarray, x: np.ndarray, u: np.ndarray, p: Mapping[str, float]) -> np.ndarray:
        """f(t, x, u, p), shape (n_x, ...): the rates of the states per `time_unit`; arguments as of `arguments`."""
        values = self.arguments(t, x, u, p)
        with np.errstate(all="ignore"):
            return np.stack([np.broadcast_to(state.rate(values, np), np.shape(t)) for state in self.states])


@dataclass(frozen=True)
class Problem:
    """The whole problem.

    sense: +1 to minimise, -1 to maximise. parameters: those to optimise, the same in all phases. links: constraints on
    the ends of several phases, whose functions ask for "boost.q1[final]". mayer: the part of the objective that does.
    """

    name: str
    sense: int
    phases: tuple[Phase, ...]
    parameters: tuple[Variable, ...] = ()
    links: tuple[Constraint, ...] = ()
    mayer: Function | None = None

    def start_of_parameters(self, guess: Sequence[Curves]) -> dict[str, float]:
        """Name of each static parameter -> its value at the start. guess: one for each phase."""
        values = dict(guess[0].parameters)
        for phase, own in zip(self.phases, guess, strict=True):
            values |= phase.times_in(own)
        return values

    def __repr__(self) -> str:
        """A line for the problem and one for each phase, as far as they are few."""
        sense = "minimize" if self.sense > 0 else "maximize"
        parameters = f", parameters {_named(self.parameters)}" if self.parameters else ""
        lines = [f"<Problem {shorten(self.name)}: {sense}{parameters}", *map(repr, self.phases)]
        if len(lines) > MAX_LINES:
            lines[MAX_LINES - 1 :] = [f"and {len(lines) - MAX_LINES + 1} phases more"]
        return "\n  ".join(lines) + ">"


def _named(variables: tuple[Variable, ...]) -> str:
    """Names for people to read, on less than a line however many there are."""
    return shorten(", ".join(variable.name for variable in variables))
