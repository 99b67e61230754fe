"""What a problem is made of: ranges, variables, and functions with bounds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field
from math import inf
from typing import Any, Protocol

import numpy as np

from .lean.records import dataclass
from .text import short_repr

MAX_DEGREE, MAX_SUBSTEPS = 60, 1000
"""Of a method: the degree on a segment, and the steps of a simulation on one."""

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


LARGEST_NUMBER = 1e300
"""What a value that results are compared with is below, so that differences are finite."""

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

    @property
    def own_ends(self) -> tuple[bool, bool]:
        """Whether the initial and the final value have a range of their own, and not just that of every time."""
        return self.initial not in (Range(), self.bounds), self.final not in (Range(), self.bounds)


@dataclass(frozen=True)
class Delayed(Variable):
    """A state at an earlier time, x(t - lag), as the functions of a phase ask for it.

    state: its name. lag: positive, in the phase's unit of time. history: the state before the initial time, a function
    of t.
    """

    state: str = field(kw_only=True)
    lag: float = field(kw_only=True)
    history: Function = field(kw_only=True)

    def before(self, t: np.ndarray) -> np.ndarray:
        """The history at times t of any shape."""
        values: np.ndarray = np.broadcast_to(self.history({"t": t}, np), np.shape(t))
        return values


@dataclass(frozen=True)
class Constraint:
    """lower <= function <= upper, at every time, at the boundary, or integrated over time."""

    name: str
    function: Function
    bounds: Range


@dataclass(frozen=True)
class Continuity(Constraint):
    """A link by which a state, or the time, goes on from one phase to another: its multiplier is a costate."""


@dataclass(frozen=True)
class EndConstraint(Constraint):
    """A boundary constraint at the top level of a file with phases: a link in all but what it is called."""


@dataclass(frozen=True)
class Duration(Constraint):
    """A phase does not end before it begins: trajopt's own, and no constraint of the file."""


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
    a common factor. spans: of a mean, (M, 2) from when to when; state: its integral so far, which
    the function then is.
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
    spans: np.ndarray | None = None
    state: str = ""

    @property
    def instants(self) -> np.ndarray:
        """The times at which the states are asked for: each is a knot."""
        return self.times if self.spans is None else self.spans.ravel()

    def along(self, values: Callable[[np.ndarray], Mapping[str, Numeric]]) -> np.ndarray:
        """What is compared with the measurements, (M,).

        values: times (M,) -> what functions are called with there.
        """
        if self.spans is None:
            h = self.function(values(self.times), np)
        else:
            a, b = self.spans.T
            h = (self.function(values(b), np) - self.function(values(a), np)) / (b - a)
        found: np.ndarray = np.broadcast_to(h, self.times.shape)
        return found

    @property
    def weights(self) -> np.ndarray:
        """w = 1 / deviation^2: w (h - value)^2 is added to what is minimised."""
        return 1 / self.deviations**2
