"""The bounds of what a result holds, beside its curves: which are near, and what goes beyond them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import inf

import numpy as np

from ...problems.problem import Phase, Problem
from ...problems.quantities import Range
from .read import Curve, PhaseCurves


def bounds_of(problem: Problem) -> dict[str, dict[str, Range]]:
    """Phase -> name of a state or input -> the range that its bounds and path constraints leave it.

    Of the path constraints those count that bound one name alone, such as `expression: x, upper: l`.
    """
    return {phase.name: _ranges(phase) for phase in problem.phases}


def extent(curves: Sequence[Curve]) -> tuple[float, float]:
    """The least and the greatest finite value; (0, 0) if there is none."""
    values = np.concatenate([part for curve in curves for part in (curve.points, curve.dense)])
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 0.0)


def beyond(values: np.ndarray, bound: float, upper: bool) -> float:
    """How far the finite values go beyond a bound; negative where they stay inside it.

    values: of any shape.
    bound: the value of it.
    upper: whether it is an upper one.
    """
    finite = values[np.isfinite(values)]
    return float(np.max(finite - bound if upper else bound - finite, initial=-np.inf))


def bounds_beside(
    phases: Sequence[PhaseCurves], kind: str, name: str, bounds: Mapping[str, Mapping[str, Range]]
) -> Iterator[tuple[PhaseCurves, float, bool, bool]]:
    """The finite bounds of a quantity: phase, value, whether it is the upper one, and whether it is near the curve.

    phases: that have the quantity.
    kind, name: of the quantity.
    bounds: phase -> name -> range, as `bounds_of` gives them.

    A bound is near if it is no farther off than the curve is high: one beyond that would flatten it.
    """
    low, high = extent([phase.curves[kind][name] for phase in phases])
    reach = high - low or max(abs(low), 1.0) / 10
    for phase in phases:
        own = bounds.get(phase.name, {}).get(name, Range())
        for value, gap, upper in ((own.lower, low - own.lower, False), (own.upper, own.upper - high, True)):
            if gap < inf:
                yield phase, value, upper, gap <= reach


def _ranges(phase: Phase) -> dict[str, Range]:
    ranges = {variable.name: variable.bounds for variable in (*phase.states, *phase.inputs)}
    ranges |= dict.fromkeys(phase.outputs, Range())
    for constraint in phase.path:
        ranges.setdefault(constraint.name, constraint.bounds)
        name = getattr(constraint.function, "text", None)
        if name in ranges:
            ranges[name] = ranges[name].intersection(constraint.bounds)
    return ranges
