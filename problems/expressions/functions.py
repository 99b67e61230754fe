"""The functions of the expression language, one row each. A new function is a new row and nothing else.

Whoever needs to know something of a function asks its row: the reader of expressions its name and its arguments, an
evaluation its value, the analysis of signs how sign and slope follow from those of the argument, SymEngine and the
formulas of `trajopt export` what it is called there. SymEngine differentiates by itself; tests hold its derivative,
the one of the row and differences of the values against each other.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import Enum, auto
from functools import partial, reduce
from typing import Any, NamedTuple

import numpy as np

from ..lean.records import dataclass
from . import composed

Signs = frozenset[int]
"""+1 if a value may be positive, -1 if it may be negative; zero is in either. Empty: it has no effect."""
POSITIVE, NEGATIVE, EITHER = frozenset({1}), frozenset({-1}), frozenset({1, -1})

SignRule = Callable[[Sequence[Signs]], Signs]
"""The signs of the operands -> those of the value."""
SlopeRule = Callable[[Signs], Signs]
"""The signs of an operand -> those of the derivative by it."""

MAX_ARGUMENTS = 20


class OfUnits(Enum):
    """What a function makes of the units of its operands.

    NUMBER and ANGLE (in radians) follow from an operand that is a pure number or in radians. The others take operands
    of one unit, whichever it is: they keep it, take its root, or make of them a pure number (RATIO) or an angle
    (DIRECTION).
    """

    NUMBER = auto()
    ANGLE = auto()
    KEPT = auto()
    ROOT = auto()
    RATIO = auto()
    DIRECTION = auto()


def always(signs: Signs) -> Callable[[Any], Signs]:
    """The rule for what does not depend on the operands."""
    return lambda _: signs


unknown = always(EITHER)


def sign_kept(signs: Sequence[Signs]) -> Signs:
    """The rule for odd functions that rise: the value has the sign of its operand."""
    return signs[0]


def with_operand(signs: Signs) -> Signs:
    """The rule for even functions that rise away from zero: the slope has the sign of the operand."""
    return signs


class Width(NamedTuple):
    """What is said of a function that is smooth over a width only, where the width is left out.

    why: what the function does without it. formula: other means, for an operand {0}.
    """

    why: str
    formula: str


@dataclass(frozen=True)
class FunctionRow:
    """A function of the expression language.

    name: in expressions. NumPy, Pyomo and SymEngine have a function of that name unless `composed` is given.
    derivative: by its operand x, an expression; "" where there are several operands.
    latex: the command that prints it; "" for what is printed as what it is made of, or as what stands in for it.
    sign, slope: rules for the analysis of signs; EITHER is never wrong.
    composed: (functions, operands) -> value, for what the libraries have under no name: made of functions that they
        have, which are what is then differentiated and printed.
    arguments: the least and the largest number of operands.
    in_abs: +1 or -1 if the function is made of |y|, which then has that sign in it: such a function is not consistent
        (paper, section 5.5) unless y is constant. 0 for smooth functions.
    width: given if the last operand is a width, which must be positive.
    units: what it makes of the units of its operands.
    minus_infinity, not_a_number: what is wrong where the value is that.
    """

    name: str
    derivative: str
    latex: str = ""
    sign: SignRule = unknown
    slope: SlopeRule = unknown
    composed: Callable[[Any, Sequence[Any]], Any] | None = None
    arguments: tuple[int, int] = (1, 1)
    in_abs: int = 0
    width: Width | None = None
    units: OfUnits = OfUnits.NUMBER
    minus_infinity: str = "is too large a number"
    not_a_number: str = "is not a real number"

    def evaluate(self, functions: Any, operands: Sequence[Any]) -> Any:
        """The value. functions: `numpy` or `pyomo.core`. operands: of a kind that this module takes."""
        if self.composed is not None:
            return self.composed(functions, operands)
        return getattr(functions, self.name)(*operands)

    def slopes(self, signs: Sequence[Signs]) -> list[Signs]:
        """The signs of the slope by each operand."""
        found = [self.slope(operand) for operand in signs]
        return found if self.width is None else [*found[:-1], EITHER]

    def from_abs(self, operands: Sequence[Any], absolute: Callable[[Any], Any]) -> Any:
        """abs, min or max of the operands by means of a function |y|, from the left.

        min(a, b) = (a + b - |a - b|)/2 and max(a, b) = (a + b + |a - b|)/2.
        """
        if self.arguments == (1, 1):
            return absolute(operands[0])
        return reduce(lambda a, b: (a + b + self.in_abs * absolute(a - b)) / 2, operands)


def _of_max(signs: Sequence[Signs]) -> Signs:
    return POSITIVE if POSITIVE in signs else EITHER


def _of_min(signs: Sequence[Signs]) -> Signs:
    return NEGATIVE if NEGATIVE in signs else EITHER


def _exact(function: Callable[[Any, Any], Any], functions: Any, operands: Sequence[Any]) -> Any:
    return reduce(function, operands)


_TWO, _ANY = (2, 2), (2, MAX_ARGUMENTS)
_RISING = _POSITIVE = always(POSITIVE)
_FALLING = always(NEGATIVE)

_LOG_OF_ZERO = "is the logarithm of zero"
_CUT = "has no value on the cut (y = 0 and x <= 0: the angle jumps from pi to -pi)"
_JUMPS = "it jumps where its operand is zero, and a solver that trusts its gradient stalls there"
_BENDS = "its slope jumps where its operand is zero, and a solver that trusts it stalls there"
_OF_SIGN, _OF_STEP = Width(_JUMPS, "tanh({0}/eps)"), Width(_JUMPS, "(1 + tanh({0}/eps))/2")
_OF_ABS = Width(_BENDS, "abs of it with nonsmooth:")

_ROWS = (
    FunctionRow("sin", "cos(x)", r"\sin"),
    FunctionRow("cos", "-sin(x)", r"\cos"),
    FunctionRow("tan", "1 + tan(x)**2", r"\tan"),  # rises between its poles, and falls over them
    FunctionRow("asin", "1/sqrt(1 - x**2)", r"\arcsin", sign_kept, _RISING, units=OfUnits.ANGLE),
    FunctionRow("acos", "-1/sqrt(1 - x**2)", r"\arccos", _POSITIVE, _FALLING, units=OfUnits.ANGLE),
    FunctionRow("atan", "1/(1 + x**2)", r"\arctan", sign_kept, _RISING, units=OfUnits.ANGLE),
    FunctionRow("sinh", "cosh(x)", r"\sinh", sign_kept, _RISING),
    FunctionRow("cosh", "sinh(x)", r"\cosh", _POSITIVE, with_operand),
    FunctionRow("tanh", "1 - tanh(x)**2", r"\tanh", sign_kept, _RISING),
    FunctionRow("exp", "exp(x)", r"\exp", _POSITIVE, _RISING),
    FunctionRow("log", "1/x", r"\log", slope=_RISING, minus_infinity=_LOG_OF_ZERO),
    FunctionRow("sqrt", "1/(2*sqrt(x))", r"\sqrt", _POSITIVE, _RISING, units=OfUnits.ROOT),
    FunctionRow("log10", "1/(x*log(10))", slope=_RISING, composed=composed.log10, minus_infinity=_LOG_OF_ZERO),
    FunctionRow("cot", "-1 - cot(x)**2", composed=composed.cot),  # falls between its poles, and rises over them
    FunctionRow("sec", "sec(x)*tan(x)", composed=composed.sec),
    FunctionRow("csc", "-csc(x)*cot(x)", composed=composed.csc),
    FunctionRow("erf", "2/sqrt(pi)*exp(-x**2)", "", sign_kept, _RISING, composed.erf),
    FunctionRow(
        "atan2", "", sign=sign_kept, composed=composed.atan2, arguments=_TWO, not_a_number=_CUT, units=OfUnits.DIRECTION
    ),
    FunctionRow("hypot", "", "", _POSITIVE, with_operand, composed.norm, _TWO, units=OfUnits.KEPT),
    FunctionRow("norm", "", "", _POSITIVE, with_operand, composed.norm, _ANY, units=OfUnits.KEPT),
    FunctionRow("sign", "", "", sign_kept, _RISING, composed.sign, _TWO, width=_OF_SIGN, units=OfUnits.RATIO),
    FunctionRow("step", "", "", _POSITIVE, _RISING, composed.step, _TWO, width=_OF_STEP, units=OfUnits.RATIO),
    FunctionRow(
        "smooth_abs", "", "", _POSITIVE, with_operand, composed.smooth_abs, _TWO, width=_OF_ABS, units=OfUnits.KEPT
    ),
    FunctionRow(
        "abs",
        "x/abs(x)",
        sign=_POSITIVE,
        slope=with_operand,
        composed=lambda _, operands: abs(operands[0]),
        in_abs=1,
        units=OfUnits.KEPT,
    ),
    FunctionRow(
        "min",
        "",
        sign=_of_min,
        slope=_RISING,
        composed=partial(_exact, np.minimum),
        arguments=_ANY,
        in_abs=-1,
        units=OfUnits.KEPT,
    ),
    FunctionRow(
        "max",
        "",
        sign=_of_max,
        slope=_RISING,
        composed=partial(_exact, np.maximum),
        arguments=_ANY,
        in_abs=1,
        units=OfUnits.KEPT,
    ),
)

FUNCTIONS = {row.name: row for row in _ROWS}


def smooth_names() -> tuple[str, ...]:
    """The names of the functions that are consistent as they are."""
    return tuple(name for name, row in FUNCTIONS.items() if not row.in_abs)


def may_hold_commas(symbol: str) -> bool:
    """Whether it is a function that people give several operands: those that take them, and abs."""
    return symbol in FUNCTIONS and (FUNCTIONS[symbol].arguments[1] > 1 or is_inconsistent(symbol))


def is_inconsistent(symbol: str) -> bool:
    """Whether an operation is abs, min or max."""
    return symbol in FUNCTIONS and FUNCTIONS[symbol].in_abs != 0
