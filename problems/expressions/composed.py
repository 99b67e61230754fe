"""Functions made of those that NumPy, Pyomo and SymEngine all have under one name.

Each takes `functions`, which is `numpy` or `pyomo.core`, and the operands: numbers, arrays, also complex ones (the
complex step), or expressions. Each is one formula without branches, so that it is consistent (paper, section 5.5).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from functools import reduce
from operator import add
from typing import Any

ROUNDING = 1e-9
"""What rounds the corner of hypot and norm at zero, in the unit of the operands. They are too large by at most this."""
_SQUARED = 1e-18  # ROUNDING**2, which has other digits

ERF_STEP = 0.5  # of the rule below: its error is exp(-(pi/step)^2), 7e-18
ERF_TERMS = 12  # exp(-((12 + 1/2) step)^2) = 1e-17: more would add nothing


def _sum(terms: Iterable[Any]) -> Any:
    """Pyomo puts a function of its own in the place of Python's `sum` while it makes templates."""
    return reduce(add, terms)


def log10(functions: Any, operands: Sequence[Any]) -> Any:
    return functions.log(operands[0]) / math.log(10)


def cot(functions: Any, operands: Sequence[Any]) -> Any:
    return functions.cos(operands[0]) / functions.sin(operands[0])


def sec(functions: Any, operands: Sequence[Any]) -> Any:
    return 1 / functions.cos(operands[0])


def csc(functions: Any, operands: Sequence[Any]) -> Any:
    return 1 / functions.sin(operands[0])


def erf(functions: Any, operands: Sequence[Any]) -> Any:
    """The error function, for every real x with a relative error below 1e-14.

    The midpoint rule for an integral over s that is erf, and a tanh for the poles of its integrand at s = +-i x
    (D. B. Hunter and T. Regan, A note on the evaluation of the complementary error function, 1972):

        erf(x) = tanh(pi x/h) - 2 h x/pi exp(-x^2) sum of exp(-s^2)/(x^2 + s^2) over s = h/2, 3h/2, 5h/2, ...
    """
    x = operands[0]
    nodes = [(k + 0.5) * ERF_STEP for k in range(ERF_TERMS)]
    total = _sum(math.exp(-(s**2)) / (x**2 + s**2) for s in nodes)
    return functions.tanh(math.pi / ERF_STEP * x) - 2 * ERF_STEP / math.pi * x * functions.exp(-(x**2)) * total


def atan2(functions: Any, operands: Sequence[Any]) -> Any:
    """The angle of the point (x, y), right to rounding in all four quadrants.

    tan(angle/2) is y/(r + x), and it is (r - x)/y. The first loses all digits near the negative x axis, the second has
    no value on the positive one. With weights r + x and y on numerators and denominators alike they make one quotient,
    2 r y/((r + x)^2 + y^2), which does neither. It has no value, 0/0, at the origin and on the negative x axis, where
    the angle jumps from pi to -pi.
    """
    y, x = operands
    r = functions.sqrt(x**2 + y**2)
    return 2 * functions.atan(2 * r * y / ((r + x) ** 2 + y**2))


def norm(functions: Any, operands: Sequence[Any]) -> Any:
    """The root of the sum of squares, smooth at zero, where it is ROUNDING."""
    return functions.sqrt(_sum([_SQUARED, *(operand**2 for operand in operands)]))


def sign(functions: Any, operands: Sequence[Any]) -> Any:
    """From -1 to 1 over a width."""
    x, width = operands
    return functions.tanh(x / width)


def step(functions: Any, operands: Sequence[Any]) -> Any:
    """From 0 to 1 over a width."""
    return (1 + sign(functions, operands)) / 2


def smooth_abs(functions: Any, operands: Sequence[Any]) -> Any:
    """|x| rounded over a width (paper, equation 8.12): what `nonsmooth: {tanh: width}` makes of abs(x)."""
    return operands[0] * sign(functions, operands)
