"""How the optimal objective changes with the numbers of the problem.

With the Lagrangian of the nonlinear program, f its objective and g its rows,

    L = f + y . (g - c) + z_U . (z - u) - z_L . (z - l),

the derivative of the optimal objective by any number p is that of L at the solution, z and the multipliers held fixed,

    dJ/dp = dL/dp,

where y and z are the multipliers, c, l and u the bounds that act. So a bound counts by its multiplier, and a parameter
by the sum over all equations and bounds in which it stands. Where a value is given (l = u) the derivative by it is that
of f + y . g by the unknown.

It holds where the multipliers are unique: where the constraints that act do not depend on each other. A bound that is
touched without being pressed against has a multiplier of zero: then the slope is right, but changes at once on the one
side.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import field
from functools import partial
from math import isfinite, isnan, nan
from typing import Any, NamedTuple

import numpy as np

from ...problems.expressions.expression import Expression
from ...problems.lean.records import dataclass
from ...problems.names.given import EPSILON, Given, difference
from ...problems.problem import Problem
from ...problems.quantities import Range
from ...problems.text import short_repr
from ..engines.outcome import Outcome, Status
from ..layout import BETWEEN, Layout, Transcription, range_of_rows
from ..method_kind import DataNumber, Numbers
from ..program.contract import NonlinearProgram, NotFinite

TOUCHED = 1e-4
"""A bound is touched at a slack below this, relative to 1 + |bound|, and not pressed against if its multipliers times
that size are less than this, relative to 1 + |J|: the barrier leaves 1e-5 of both where one begins to act."""

TOUCHES = "touched, not pressed against: moved inwards, it begins to act"
NOT_SOLVED = "the problem is not solved: only at an optimum do the multipliers tell how it changes"
NO_MULTIPLIERS = "the problem has as many equations as unknowns: nothing is optimised, and there are no multipliers"
DELAYED = "not known: it moves what a state at an earlier time is, or where that is read"
LITERAL = "not known: it stands under abs, min or max, in a model, or as a width of nonsmooth, and is compiled in"
MEASURED = "not known: when something is measured depends on it"
CORNER = "not known: the functions of the problem have no derivative by it there"


@short_repr
@dataclass(frozen=True)
class Sensitivity:
    """The derivative of the optimal objective by one number of the file.

    path: of the number, as "parameters.m" or "states.x.upper".
    value: the number; unit: its own.
    derivative: of the objective as the file writes it, per unit of the number; NaN where there is none.
    note: why there is none, or what to know of it, or "".
    """

    path: str
    value: float
    unit: str
    derivative: float
    note: str = ""


class Sensitivities(NamedTuple):
    """all: by every number of the file, in the order of their first use. why_not: why there are none, or ""."""

    all: tuple[Sensitivity, ...] = ()
    why_not: str = ""


@dataclass
class _Sums:
    """By path: derivative of the minimised objective, the numbers, notes."""

    totals: dict[str, float] = field(default_factory=dict)
    numbers: dict[str, Given] = field(default_factory=dict)
    notes: dict[str, str] = field(default_factory=dict)

    def add(self, number: float, derivative: float, note: str = "") -> None:
        """A derivative by a number counts for all that it is made of."""
        if not isinstance(number, Given):
            return
        for path, (own, slope) in number.sources.items():
            self.numbers[path] = own
            self.totals[path] = self.totals.get(path, 0.0) + (derivative * slope if slope else 0.0)
            if isnan(self.totals[path]):
                self.notes[path] = note or self.notes.get(path, CORNER)
            elif note and own is number:
                self.notes[path] = note


def sensitivities(
    transcription: Transcription,
    nlp: NonlinearProgram,
    outcome: Outcome,
    numbers: Callable[[Transcription, NonlinearProgram], Numbers],
) -> Sensitivities:
    """The derivative of the objective by every parameter of the file, and by every bound and given value.

    transcription: of the problem.
    nlp: its program.
    outcome: its solution, with multipliers.
    numbers: gives what the program reads beside its unknowns.
    """
    if not outcome.status.usable:
        return Sensitivities(why_not=NOT_SOLVED)
    if outcome.status is Status.FEASIBLE:
        return Sensitivities(why_not=NO_MULTIPLIERS)
    with np.errstate(all="ignore"):  # what is not finite is told
        return Sensitivities(_Program(transcription, nlp, outcome, numbers(transcription, nlp)).found())


class _Program:
    def __init__(self, transcription: Transcription, nlp: NonlinearProgram, outcome: Outcome, numbers: Numbers) -> None:
        self.transcription, self.nlp, self.outcome, self.numbers = transcription, nlp, outcome, numbers
        self.problem, self.sums = transcription.problem, _Sums()
        rows, columns = nlp.jacobianstructure()
        terms = outcome.y[rows] * nlp.jacobian(outcome.z)
        self.gradient = nlp.gradient(outcome.z) + np.bincount(columns, terms, nlp.n)
        self.rounding = EPSILON * (abs(outcome.objective) + float(np.abs(terms * outcome.z[columns]).sum()))

    def found(self) -> tuple[Sensitivity, ...]:
        for number in _written(self.problem):
            self.sums.add(number, 0.0)
        self._of_functions()
        self._of_unknowns()
        self._of_rows()
        sums, sense = self.sums, self.problem.sense
        return tuple(
            Sensitivity(path, float(own), own.unit, sense * sums.totals[path], sums.notes.get(path, ""))
            for path, own in sums.numbers.items()
        )

    def _of_functions(self) -> None:
        """Parameters in the functions of the problem, and given times."""
        for number in self.numbers.values():
            self.sums.add(number.value, difference(partial(self._lagrangian, number), number.value, self.rounding))
        for phase, function in _functions(self.problem):
            for name in function.constants:
                if (phase, name) not in self.numbers:
                    self.sums.add(function.parameters[name], nan, LITERAL)
        for literal in self.problem.literal:
            self.sums.add(literal, nan, LITERAL)
        for measured in (phase for phase in self.problem.phases if phase.measured):
            for bounds in (measured.initial_time, measured.final_time):
                self.sums.add(bounds.lower, nan, MEASURED)
        for late in _of_delays(self.problem):
            self.sums.add(late, nan, DELAYED)
        for layout in self.transcription.phases:
            self._of_measurements(layout)

    def _of_measurements(self, layout: Layout) -> None:
        """Parameters in what is compared with measurements: these are no part of the program's own objective."""
        p = dict(zip((own.name for own in self.problem.parameters), self.outcome.z[self.transcription.parameters],
                     strict=True))  # fmt: skip
        for own in layout.phase.measured:
            function = own.function
            if not isinstance(function, Expression):
                continue
            for name in function.constants:
                from ..measured.residuals import squares_with  # it loads Pyomo, which a result is read without

                squares = partial(squares_with, layout, own, self.outcome.z, p, name)
                number = function.parameters[name]
                self.sums.add(number, difference(squares, number, self.rounding))

    def _lagrangian(self, number: DataNumber, value: float) -> float:
        """f + y . g with another number."""
        nlp, z, y = number.replaced(value), self.outcome.z, self.outcome.y
        try:
            return nlp.objective(z) + float(y @ nlp.constraints_unchecked(z))
        except NotFinite:
            return nan

    def _of_unknowns(self) -> None:
        o = self.outcome
        for bounds, places in self._bounded():
            at = places[places >= 0]
            if not at.size:
                continue
            if bounds.fixed:
                self.sums.add(bounds.lower, float(self.gradient[at].sum()))
                continue
            self._of_end(bounds.lower, o.z_lower[at], o.z[at] - bounds.lower)
            self._of_end(bounds.upper, -o.z_upper[at], bounds.upper - o.z[at])

    def _bounded(self) -> Iterator[tuple[Range, np.ndarray]]:
        """The range of some unknowns, and where they stand."""
        t = self.transcription
        for layout in t.phases:
            phase = layout.phase
            for state, places in zip(phase.states, layout.x, strict=True):
                yield state.bounds, places[1:-1]
                yield state.initial, places[:1]
                yield state.final, places[-1:]
            yield from ((own.bounds, places) for own, places in zip(phase.inputs, layout.u, strict=True))
            yield phase.initial_time, layout.t[:1]
            yield phase.final_time, layout.t[1:]
        yield from ((own.bounds, t.parameters[[i]]) for i, own in enumerate(self.problem.parameters))

    def _of_rows(self) -> None:
        g = self.nlp.constraints_unchecked(self.outcome.z)
        for family in self.transcription.families:
            bounds, rows = range_of_rows(self.problem, family), family.rows(self.nlp)
            y = self.outcome.y[rows]
            if bounds.fixed:
                self.sums.add(bounds.lower, -float(y.sum()))
                continue
            self._of_end(bounds.lower, -np.minimum(y, 0.0), g[rows] - bounds.lower)
            self._of_end(bounds.upper, -np.maximum(y, 0.0), bounds.upper - g[rows])

    def _of_end(self, bound: float, derivatives: np.ndarray, slack: np.ndarray) -> None:
        """One end of a range, with the derivative by it and its slack at each place, (K,)."""
        if not isfinite(bound):
            return
        size = 1 + abs(bound)
        total = float(derivatives.sum())
        pressed = abs(total) * size > TOUCHED * (1 + abs(self.outcome.objective))
        self.sums.add(bound, total, TOUCHES if (slack < TOUCHED * size).any() and not pressed else "")


def _of_delays(problem: Problem) -> Iterator[float]:
    """The numbers that say what states at earlier times are: delays, histories, and the times of their phase."""
    for phase in problem.phases:
        for own in phase.delayed:
            constants = getattr(own.history, "constants", ())
            yield from (own.lag, *(getattr(own.history, "parameters", {})[name] for name in constants))
            yield from (phase.initial_time.lower, phase.final_time.lower)


def _written(problem: Problem) -> Iterator[float]:
    """All parameters of the file, as far as a function could use them."""
    seen: set[int] = set()
    measured = [("", own.function) for phase in problem.phases for own in phase.measured]
    for _, function in [*_functions(problem), *measured]:
        if id(function.parameters) not in seen:
            seen.add(id(function.parameters))
            yield from function.parameters.values()


def _functions(problem: Problem) -> Iterator[tuple[str, Any]]:
    """(phase, function) of each that the problem needs and that has parameters."""
    own = [(phase.name, f) for phase in problem.phases for f in (*phase.over_time, *phase.at_ends)]
    return ((phase, f) for phase, f in [*own, *((BETWEEN, f) for f in problem.between)] if hasattr(f, "constants"))
