"""Numbers of a file that know where they come from: what depends on them can be differentiated by what was written."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property
from math import nan

from ..expressions.expression import Expression
from ..expressions.tree import Number

STEP = 2.0**-10
"""Of differences, relative to the number: the error of four values is of its fourth power, 1e-12."""

SMALLEST = 2.0**-34
EPSILON = 2.0**-52
AGREED = 1e-4  # differences of second order with steps h and 2h, relative: then that of fourth order has 8 digits


class Given(float):
    """A number of the file.

    path: of the place in the file, as "states.x.upper", where another number may be put; "" for none.
    expression: of parameters alone, bound; None where the file has the number itself.
    unit: of the number.
    """

    path: str
    expression: Expression | None
    unit: str

    def __new__(cls, value: float, path: str = "", expression: Expression | None = None, unit: str = "") -> Given:
        own = super().__new__(cls, value)
        own.path, own.expression, own.unit = path, expression, unit
        return own

    def __getnewargs__(self) -> tuple[float, str, Expression | None, str]:  # type: ignore[override]
        return float(self), self.path, self.expression, self.unit

    @cached_property
    def sources(self) -> dict[str, tuple[Given, float]]:
        """The numbers of the file that this one is made of, itself included, and its derivative by each: by path."""
        found = {self.path: (self, 1.0)} if self.path else {}
        expression = self.expression
        for name in expression.constants if expression else ():
            assert expression is not None
            inner = expression.parameters[name]
            slope = _slope(expression, name) if isinstance(inner, Given) else 0.0
            for path, (own, by_own) in inner.sources.items() if isinstance(inner, Given) else ():
                before = found[path][1] if path in found else 0.0
                found[path] = own, before + slope * by_own
        return found


def given(expression: Expression, bind: Callable[[Expression], Expression], path: str = "", unit: str = "") -> Given:
    """The value of an expression of the file.

    expression: a number, or made of parameters alone.
    bind: gives it its numbers.
    path, unit: as of `Given`.
    """
    if isinstance(expression.root, Number):  # most are, and there are hundreds of them in a file
        return Given(expression.root.value, path, None, unit)
    bound = bind(expression)
    return Given(bound.constant(), path, bound, unit)


def _slope(expression: Expression, name: str) -> float:
    if expression.text == name:
        return 1.0
    numbers = expression.parameters

    def value(number: float) -> float:
        return replace(expression, parameters={**numbers, name: number}).constant()

    return difference(value, float(numbers[name]))


def difference(function: Callable[[float], float], at: float, rounding: float = 0.0) -> float:
    """The derivative of a function of one number, by central differences of fourth order; NaN where there is none.

    The step is made smaller until those of second order agree, and those ahead and behind come nearer to each other in
    proportion to it: a scale of the function that is smaller than the number is found, and at a corner they never do.

    function: called with numbers near `at`; not finite where it has no value.
    at: the number.
    rounding: of the function's values, absolute; that of a double is added.
    """
    step, smallest, here = STEP * (abs(at) or 1.0), SMALLEST * (abs(at) or 1.0), function(at)
    while step >= smallest:
        ahead, behind = ([function(at + sign * k * step) for k in (1, 2)] for sign in (1, -1))
        pairs = [*zip((step, 2 * step), ahead, behind, strict=True)]
        first, second = ((a - b) / (2 * h) for h, a, b in pairs)
        bend, bend_twice = (abs(a - 2 * here + b) / h for h, a, b in pairs)
        near = AGREED * abs(first) + (rounding + EPSILON * max(map(abs, (*ahead, *behind)))) / step
        if abs(second - first) <= near and (bend <= near or bend_twice > 1.5 * bend):  # false for NaN
            return (4 * first - second) / 3
        step /= 16
    return nan
