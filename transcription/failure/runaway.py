"""Unbounded problems: what runs away, to which side, and through which division if it is one.

An objective without a lower limit lets the engine follow a state, a control, a parameter or a time to infinity; or a
denominator to zero, beyond which the quotient has the other sign.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import inf
from typing import Any

import numpy as np
import symengine as se

from ...problems.problem import Phase
from ...problems.quantities import Function
from ...problems.tables.table import Table
from ...problems.text import shorten
from ..engines.outcome import Outcome
from ..layout import Transcription
from ..solution.trajectory import Trajectory, trajectories
from ..solution.violation import of_phase

LARGE = 1e10  # no unit makes an honest value as large
LONGER = 1e5  # times than its guess: a free time that nothing has stopped
LONG = 1e3  # the same, where the objective has fallen through with it
FALLEN = 1e6  # of 1 + the first objective: an objective that has fallen by more runs away
FALLEN_THROUGH = 1e3  # the same, where a denominator is at zero as well
NEAR_ZERO = 1e-3  # of its largest size, of a denominator that an objective runs away through

ROUNDS, CLOSER, GROWN = 4, 1000, 10.0
"""Times to come closer to a pole, each time by so much, and what a function has grown by then: it should by 1e6."""

REMEDY = "give it bounds, or check the sign of the objective"


def runaway(transcription: Transcription, outcome: Outcome) -> str:
    """What has run away at the end of a solve, or "".

    transcription: what stands where.
    outcome: of a failed solve, or one whose objective cannot be meant so.
    """
    found = list(trajectories(transcription, outcome.z))
    sizes = [item for own in found for item in _values(own)]
    size, text = max(sizes) if sizes else (0.0, "")
    if leap := next(filter(None, map(_leap, found)), f"{text}: {REMEDY}" if size > LARGE else ""):
        return leap
    if not fallen(outcome, FALLEN_THROUGH):
        return ""
    division = next((text for own in found for text in _divisions(own)), "")
    if division:
        return division
    if longer := next((text for own in found for text in _longer(own)), ""):
        return f"{longer}: {REMEDY}"
    if not fallen(outcome):
        return ""
    return f"the objective runs to {transcription.problem.sense * outcome.objective:.3g}; {text}: {REMEDY}"


def divided(found: Iterable[Trajectory]) -> str:
    """What is divided by that changes its sign along the trajectories, or "".

    found: of a solve that failed, or is not as accurate as was asked.
    """
    return next((text for own in found for text in _divisions(own, crossed=True)), "")


def fallen(outcome: Outcome, by: float = FALLEN) -> bool:
    """Whether the minimised objective has fallen as far as no honest one does; by: of 1 + the first one."""
    history = outcome.iterations.get("objective")
    if history is None or not len(history) or not np.isfinite(outcome.objective):
        return False
    return bool(outcome.objective < -by * (1 + abs(float(history[0]))))


def _values(trajectory: Trajectory) -> Iterator[tuple[float, str]]:
    """(size, words) of the largest value of everything that is unknown."""
    phase = trajectory.phase
    names = [variable.name for variable in (*phase.states, *phase.inputs)]
    for name, values in zip(names, np.nan_to_num(np.vstack([trajectory.x, trajectory.u])), strict=True):
        k = int(np.argmax(np.abs(values)))
        when = f" at t = {trajectory.times[k]:.6g}" if abs(trajectory.times[k]) < LARGE else ""
        yield float(abs(values[k])), f"{name}{of_phase(phase.name)} runs to {values[k]:.3g}{when}"
    ranges = (phase.initial_time, phase.final_time)
    for end, bounds, value in zip(("initial", "final"), ranges, trajectory.t.tolist(), strict=True):
        if not bounds.fixed:
            yield abs(value), f"the {end} time{of_phase(phase.name)} runs to {value:.3g}"
    for name, value in trajectory.parameters.items():
        yield abs(value), f"{name} runs to {value:.3g}"


def _leap(trajectory: Trajectory) -> str:
    """A phase that has come to take no time, and what its inputs are then; "" for another."""
    if not trajectory.leaps:
        return ""
    phase = trajectory.phase
    largest = np.abs(np.nan_to_num(trajectory.u)).max(axis=1, initial=0.0)
    found = [(size, own.name) for size, own in zip(largest, phase.inputs, strict=True) if size > LARGE]
    name = max(found, default=(0.0, ""))[1]
    grown = f", while {name} runs to {max(found)[0]:.3g}" if name else ""
    bounds = f"give {name} bounds, or the time" if name else "give the time"
    return f"the duration{of_phase(phase.name)} runs to zero{grown}: {bounds} a lower bound above zero"


def _longer(trajectory: Trajectory) -> Iterator[str]:
    """The final time, if it is free without an upper bound and far longer than its guess."""
    phase = trajectory.phase
    if phase.final_time.upper == inf and trajectory.final_time > LONG * _meant(phase):
        yield f"the final time{of_phase(phase.name)} runs to {trajectory.final_time:.3g}"


def _meant(phase: Phase) -> float:
    """The size of the final time as it is guessed, or of the duration, at least 1."""
    return max(1.0, abs(phase.guess.final_time), abs(phase.guess.final_time - phase.guess.initial_time))


def _divisions(trajectory: Trajectory, crossed: bool = False) -> Iterator[str]:
    """Denominators in the objective and the rates at zero, or on both sides of it; crossed: only the latter."""
    phase = trajectory.phase
    values = trajectory.at_collocated
    owners: list[tuple[str, Function]] = [("the objective", phase.lagrange)] if phase.lagrange else []
    owners += [(f"the rate of {state.name}", state.rate) for state in phase.states]
    for owner, function in owners:
        symbolic = _Symbolic(values)
        for base in _denominators(se.sympify(function(symbolic.symbols, symbolic))):
            names = symbolic.names(base)
            if not names:
                continue
            den, points = symbolic.numbers(base)
            at = int(np.argmin(np.abs(den)))
            both = den.min() < 0 < den.max() and (not crossed or _is_pole(function, base, symbolic.values))
            if both or (not crossed and abs(den[at]) <= NEAR_ZERO * np.abs(den).max()):
                text, where = shorten(str(base)), f"{names[0]} = {points[at, 0]:.3g}, t = {values['t'][at]:.6g}"
                does = "changes its sign" if crossed else "runs to zero"
                what = f"{owner}{of_phase(phase.name)} divides by {text}, which {does} ({where})"
                so = "" if crossed else ", so there is no limit to it"
                yield f"{what}{so}: give {names[0]} a bound that keeps {text} away from zero"


def _is_pole(function: Function, base: Any, values: Mapping[str, Any]) -> bool:
    """Whether a function has no limit where a denominator in it changes its sign: sin(x)/x has one, where x does.

    function: of the values. base: the denominator. values: name -> at the points, (K,), or at all; between the points a
    straight line is followed to the first change of sign, ever closer.
    """
    sizes = []
    for _ in range(ROUNDS):
        den, _points = _Symbolic(values).numbers(base)
        at = int(np.argmax(den[:-1] * den[1:] <= 0))
        ends = {name: np.broadcast_to(own, den.shape)[at : at + 2] for name, own in values.items()}
        with np.errstate(all="ignore"):
            sizes.append(float(np.nan_to_num(np.abs(function(ends, np)), posinf=inf).max()))
        values = {name: np.linspace(first, last, CLOSER + 1) for name, (first, last) in ends.items()}
    return sizes[-1] == inf or sizes[-1] > GROWN * sizes[1]


class _Symbolic:
    """SymEngine, which has no tables of data: what one gives is a symbol of its own, called as the table is called.

    values: name of each symbol -> its values at points, (K,). symbols: the symbols by these names.
    """

    def __init__(self, values: Mapping[str, Any]) -> None:
        self.values, self.symbols = dict(values), {name: se.Symbol(name) for name in values}

    def __getattr__(self, name: str) -> Any:
        return getattr(se, name)

    def table_value(self, table: Table, operands: Sequence[Any]) -> se.Symbol:
        arguments = [se.sympify(operand) for operand in operands]
        name = f"{table.name}({', '.join(map(str, arguments))})"
        if name not in self.symbols:
            self.values[name] = table(*(self.numbers(argument)[0] for argument in arguments))
            self.symbols[name] = se.Symbol(name)
        return self.symbols[name]

    def names(self, expression: se.Basic) -> list[str]:
        return [name for name, symbol in self.symbols.items() if symbol in expression.free_symbols]

    def numbers(self, expression: se.Basic) -> tuple[np.ndarray, np.ndarray]:
        """The values of an expression, (K,), and those of the names in it, (K, names); K is 1 where there are none."""
        names = self.names(expression)
        if not names:
            return np.array([float(expression)]), np.zeros((1, 0))
        points = np.stack(np.broadcast_arrays(*(np.asarray(self.values[name], float) for name in names)), axis=-1)
        code = se.Lambdify([self.symbols[name] for name in names], [expression])
        return np.asarray(code(np.atleast_2d(points))).ravel(), points


def _denominators(expression: Any) -> Iterator[Any]:
    """The bases of powers with a negative exponent."""
    if isinstance(expression, se.Pow) and expression.args[1].is_Number and float(expression.args[1]) < 0:
        yield expression.args[0]
    for argument in expression.args:
        yield from _denominators(argument)


def runaway_times(trajectories: Sequence[Trajectory]) -> Iterator[str]:
    """What is told of free final times without an upper bound that have grown beyond all that was meant."""
    for trajectory in trajectories:
        phase = trajectory.phase
        if phase.final_time.upper == inf and trajectory.final_time > LONGER * _meant(phase):
            end = f"{trajectory.final_time:.3g} {phase.time_unit}".rstrip()
            told = f"the final time{of_phase(phase.name)} has run away to {end}"
            yield f"{told}: nothing limits it, so this is no optimum; give time: final: an upper bound"
