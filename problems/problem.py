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
the inputs of the dynamics: the controls, the states at earlier times, x(t - tau), then the algebraic variables.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from .expressions.expression import Together, together
from .lean.records import dataclass, only_fields
from .quantities import Complementarity, Constraint, Delayed, Function, Measured, Output, Range, State, Variable
from .text import short_repr, shorten

MAX_LINES = 5  # of what is shown of a problem


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
    delayed: the states that are asked for at earlier times. before: the phase whose time goes on in this one,
    in which they are read before its initial time; else there is their history.
    steps: in discrete time the number of steps, each of duration 1; 0 where time is continuous. The rate of a state is
    then its change in a step, x[k + 1] - x[k], and the integral of w the sum of w over all points but the last.
    outputs: name -> what no equation of the problem needs, for those who look at a solution.
    measured: what is compared with data; both times of such a phase are fixed, or it is all at one that is.
    time_parameters: name -> "initial" or "final", of static parameters that a boundary constraint makes that time.
    kept: names of path equalities that the dynamics keep, which are asked for once and not among `path`.
    follows: names of states whose final values follow from others by what the dynamics keep, and are held nearly.
    implied: name -> the names of what it follows from, of constraints that are held nearly.
    """

    name: str
    initial_time: Range
    final_time: Range
    states: tuple[State, ...]
    controls: tuple[Variable, ...]
    guess: Guess
    algebraic: tuple[Variable, ...] = ()
    delayed: tuple[Delayed, ...] = ()
    before: str = ""
    residuals: tuple[Constraint, ...] = ()
    path: tuple[Constraint, ...] = ()
    complementarity: tuple[Complementarity, ...] = ()
    boundary: tuple[Constraint, ...] = ()
    integral: tuple[Constraint, ...] = ()
    lagrange: Function | None = None
    mayer: Function | None = None
    time_unit: str = "s"
    steps: int = 0
    outputs: Mapping[str, Output] = field(default_factory=dict)
    measured: tuple[Measured, ...] = ()
    time_parameters: Mapping[str, str] = field(default_factory=dict)
    kept: tuple[str, ...] = ()
    follows: tuple[str, ...] = ()
    implied: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    __getstate__ = only_fields

    def times_in(self, curves: Curves) -> dict[str, float]:
        """The values of the parameters that are times of this phase, for curves that a solve may start from."""
        return {name: getattr(curves, f"{end}_time") for name, end in self.time_parameters.items()}

    def fractions_of(self, t: np.ndarray) -> np.ndarray:
        """The normalised times of what is measured at t, of any shape; of a phase with one given end all is there."""
        start, end = self.initial_time, self.final_time
        if start.fixed and end.fixed:
            return (t - start.lower) / (end.lower - start.lower)
        return np.full(np.shape(t), 1.0 if end.fixed else 0.0)

    @property
    def static(self) -> bool:
        """Whether nothing in it varies: a phase of no duration, for what is about static parameters alone."""
        return not (self.states or self.inputs)

    @property
    def exact(self) -> bool:
        """Whether its nonlinear program is the problem itself: no method approximates anything in it."""
        return self.static or self.steps > 0

    @property
    def inputs(self) -> tuple[Variable, ...]:
        """The controls, the states at earlier times, then the algebraic variables: the rows of every array u."""
        return self.controls + self.delayed + self.algebraic

    @property
    def found(self) -> tuple[Variable, ...]:
        """The inputs that are no states at earlier times."""
        return self.controls + self.algebraic

    @property
    def rows_of_delayed(self) -> slice:
        """Which rows of u are states at earlier times."""
        return slice(len(self.controls), len(self.controls) + len(self.delayed))

    def __repr__(self) -> str:
        """One line: the time, and the names of what varies in it."""
        kinds = {"states": self.states, "controls": self.controls, "algebraic": self.algebraic}
        named = [f"{kind} {_named(variables)}" for kind, variables in kinds.items() if variables]
        time = f"initial time {self.initial_time}, final time {self.final_time} {self.time_unit}".rstrip()
        return f"<Phase {self.name}: {'; '.join([time, *named])}>"

    @cached_property
    def rates(self) -> Together:
        """The rates of the states, at once."""
        return together([state.rate for state in self.states])

    @cached_property
    def residuals_at_once(self) -> Together:
        return together([own.function for own in self.residuals])

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
        u: inputs, shape (n_u, ...), as of `inputs`.
        p: name of each static parameter -> its value.
        """
        states = {state.name: row for state, row in zip(self.states, x, strict=True)}
        inputs = {variable.name: row for variable, row in zip(self.inputs, u, strict=True)}
        return {"t": t, **states, **inputs, **p}

    def dynamics(self, t: np.ndarray, x: np.ndarray, u: np.ndarray, p: Mapping[str, float]) -> np.ndarray:
        """f(t, x, u, p), shape (n_x, ...): the rates of the states per `time_unit`.

        t, x, u, p: as of `arguments`.
        """
        values = self.arguments(t, x, u, p)
        with np.errstate(all="ignore"):
            rates = self.rates(values, np)
        f = np.empty((len(rates), *np.shape(t)), np.result_type(float, *rates))
        for row, rate in zip(f, rates, strict=True):
            row[...] = rate
        return f


@dataclass(frozen=True)
class Problem:
    """The whole problem.

    sense: +1 to minimise, -1 to maximise. parameters: those to optimise, the same in all phases. links: constraints on
    the ends of several phases, whose functions ask for "boost.q1[final]". mayer: the part of the objective that does.
    numbers: parameter that is given -> its number, for results to tell.
    literal: numbers of the file that functions are made of without having them among their parameters.
    """

    name: str
    sense: int
    phases: tuple[Phase, ...]
    parameters: tuple[Variable, ...] = ()
    links: tuple[Constraint, ...] = ()
    mayer: Function | None = None
    numbers: Mapping[str, float] = field(default_factory=dict)
    literal: tuple[float, ...] = ()

    @property
    def between(self) -> tuple[Function, ...]:
        """The functions of the ends of several phases."""
        return (*(link.function for link in self.links), *([self.mayer] if self.mayer else []))

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
