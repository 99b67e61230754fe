"""Bounds and relations of Pyomo, of a range of the problem."""

from __future__ import annotations

from math import isfinite
from typing import Any

from ...problems.quantities import Range


def bound(variable: Any, bounds: Range, value: float) -> None:
    """Give a Pyomo variable its bounds and its initial value.

    variable: a scalar Var, or one element of an indexed one.
    bounds: in the unit of the variable; an end that is infinite is no bound.
    value: the initial value, not checked against the bounds.
    """
    variable.setlb(finite(bounds.lower))
    variable.setub(finite(bounds.upper))
    variable.set_value(value, skip_validation=True)


def finite(value: float) -> float | None:
    """A bound as Pyomo takes it; None for one that is infinite."""
    return float(value) if isfinite(value) else None  # Pyomo takes no kinds of float but its own


def between(bounds: Range, body: Any) -> Any:
    """The relation lower <= body <= upper, or body == value where both ends are one."""
    if bounds.fixed:
        return body == float(bounds.lower)
    return (finite(bounds.lower), body, finite(bounds.upper))
