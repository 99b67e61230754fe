"""What stands in for abs, min and max of anything that varies, as operations on values.

min and max are made of |y| (`FunctionRow.from_abs`). Three stand-ins for |y| (paper, sections 8.5 and 8.6) give three
operations each, whose last operands are

    "... tanh"     alpha: |y| is y tanh(y/alpha)                              (8.12)
    "... sqrt"     beta: |y| is sqrt(y^2 + beta^2)                            (8.13)
    "... slack"    the slack sums s1 + s2 of each |y| in turn                 (8.9); abs itself is then s1 + s2
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from . import composed
from .functions import FUNCTIONS, FunctionRow

SLACK, TANH, SQRT = "slack", "tanh", "sqrt"


def stand_in(symbol: str, treatment: str) -> str:
    """The name of the operation that stands in for abs, min or max."""
    return f"{symbol} {treatment}"


def smooth_abs(treatment: str, functions: Any, y: Any, width: Any) -> Any:
    """|y|, smooth (paper, section 8.6).

    treatment: "tanh" for y tanh(y/width), (8.12); else sqrt(y^2 + width^2), (8.13).
    functions: `numpy` or `pyomo.core`.
    y: a number, an array of any shape or an expression.
    width: alpha or beta, positive, in the unit of y.
    """
    return composed.smooth_abs(functions, [y, width]) if treatment == TANH else functions.sqrt(y**2 + width**2)


def _smooth(row: FunctionRow, treatment: str, functions: Any, operands: Sequence[Any]) -> Any:
    *values, width = operands
    return row.from_abs(values, lambda y: smooth_abs(treatment, functions, y, width))


def _slack(row: FunctionRow, functions: Any, operands: Sequence[Any]) -> Any:
    """The n values, then the n - 1 slack sums of their differences."""
    n = (len(operands) + 1) // 2
    sums = iter(operands[n:])
    return row.from_abs(operands[:n], lambda y: next(sums))


_INCONSISTENT = [row for row in FUNCTIONS.values() if row.in_abs]

STAND_INS = {
    **{
        stand_in(row.name, treatment): partial(_smooth, row, treatment)
        for row in _INCONSISTENT
        for treatment in (TANH, SQRT)
    },
    **{stand_in(row.name, SLACK): partial(_slack, row) for row in _INCONSISTENT if row.arguments != (1, 1)},
}
