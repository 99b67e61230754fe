"""abs, min and max as operations on values: exact ones for constants, consistent ones for everything that varies.

min and max go through abs, from the left: min(a, b) = (a + b - |a - b|)/2 and max(a, b) = (a + b + |a - b|)/2. Three
stand-ins for |y| (paper, sections 8.5 and 8.6) give three operations each, whose last operands are

    "... tanh"     alpha: |y| is y tanh(y/alpha)                              (8.12)
    "... sqrt"     beta: |y| is sqrt(y^2 + beta^2)                            (8.13)
    "... slack"    the slack sums s1 + s2 of each |y| in turn                 (8.9); abs itself is then s1 + s2
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial, reduce
from typing import Any

import numpy as np

from .slips import INCONSISTENT

SLACK, TANH, SQRT = "slack", "tanh", "sqrt"


def stand_in(symbol: str, kind: str) -> str:
    """The name of the operation that stands in for abs, min or max."""
    return f"{symbol} {kind}"


def smooth_abs(kind: str, functions: Any, y: Any, width: Any) -> Any:
    """|y| by (8.12) or (8.13)."""
    return y * functions.tanh(y / width) if kind == TANH else functions.sqrt(y**2 + width**2)


def fold(symbol: str, operands: Sequence[Any], absolute: Callable[[Any], Any]) -> Any:
    """abs, min or max of the operands by means of a function |y|."""
    if symbol == "abs":
        return absolute(operands[0])
    sign = 1 if symbol == "max" else -1
    return reduce(lambda a, b: (a + b + sign * absolute(a - b)) / 2, operands)


def _smooth(symbol: str, kind: str, functions: Any, operands: Sequence[Any]) -> Any:
    *values, width = operands
    return fold(symbol, values, lambda y: smooth_abs(kind, functions, y, width))


def _slack(symbol: str, functions: Any, operands: Sequence[Any]) -> Any:
    """The n values, then the n - 1 slack sums of their differences."""
    n = (len(operands) + 1) // 2
    sums = iter(operands[n:])
    return fold(symbol, operands[:n], lambda y: next(sums))


EXACT = {
    "abs": lambda operands: abs(operands[0]),
    "min": partial(reduce, np.minimum),
    "max": partial(reduce, np.maximum),
}

STAND_INS = {
    **{stand_in(s, kind): partial(_smooth, s, kind) for s in INCONSISTENT for kind in (TANH, SQRT)},
    **{stand_in(s, SLACK): partial(_slack, s) for s in ("min", "max")},
}
