"""What an axis of values spans, and the bounds that are drawn on it."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ...problems.quantities import Range
from ..file.bounds import beyond, bounds_beside, extent
from ..file.read import Curve, PhaseCurves
from .style import GREY, VIOLATED

Bounds = Mapping[str, Mapping[str, Range]]  # phase -> name -> range, as `curves.bounds_of` gives them
NO_BOUNDS: Bounds = {}
Broken = Mapping[str, Collection[str]]  # phase -> names whose bounds do not hold between the points
NONE_BROKEN: Broken = {}

AT_POINTS = 1e-6
"""Relative to 1 + |bound|: what the solver's own points may exceed it by, as for `trajopt verify`."""

FLAT = 1e-3  # of the size of a curve: an axis spans at least that, so that noise does not look like a movement
NOISE = 1e-9  # the same for a curve around zero, in its unit
SPIKE, FEW = 0.25, 0.05  # a curve that leaves the range of its points by more than that part of it, for so few samples


def frame(ax: Axes, curves: Sequence[Curve]) -> None:
    """Widen the axis of what hardly varies, and narrow that of what shoots out beside a jump.

    ax: the axes that the curves, and their bounds, are drawn on.
    curves: of one quantity.
    """
    low, high = extent(curves)
    if high - low <= max(FLAT * max(abs(low), abs(high)), NOISE):
        middle, half = (low + high) / 2, max(FLAT * max(abs(low), abs(high)) / 2, NOISE) if low or high else 1.0
        ax.set_ylim(middle - half, middle + half)
    elif spikes := _without_spikes(curves):
        view = ax.get_ylim()
        ax.set_ylim(max(view[0], spikes[0]), min(view[1], spikes[1]))


def _without_spikes(curves: Sequence[Curve]) -> tuple[float, float] | None:
    """The range to draw where few samples of a polynomial shoot out beside a jump; None where nothing does."""
    points, dense = (np.concatenate([getattr(curve, part) for curve in curves]) for part in ("points", "dense"))
    if not (np.isfinite(points).all() and np.isfinite(dense).all()):
        return None
    beyond = SPIKE * (points.max() - points.min())
    low, high = points.min() - beyond, points.max() + beyond
    outside = ((dense < low) | (dense > high)).mean()
    return (float(low), float(high)) if beyond and 0 < outside < FEW else None


def bound_lines(
    ax: Axes,
    phases: Sequence[PhaseCurves],
    kind: str,
    name: str,
    bounds: Bounds,
    broken: Broken,
    color: str = GREY,
) -> list[str]:
    """Dashed lines at the bounds near the curve; those so far off that they would flatten it are given in words.

    ax: the axes to draw on.
    phases: that have the quantity.
    kind, name: of the curve.
    bounds: of every quantity.
    broken: what a check says does not hold between the points; at the points themselves the curve tells.
    color: of bounds that are held.
    """
    far = []
    for phase, value, upper, near in bounds_beside(phases, kind, name, bounds):
        if not near:
            far.append(f"{'↑' if upper else '↓'} {value:.3g}".replace("-", "\N{MINUS SIGN}"))
            continue
        curve, tolerated = phase.curves[kind][name], AT_POINTS * (1 + abs(value))
        fails = name in broken.get(phase.name, ()) and beyond(curve.dense, value, upper) > tolerated
        style: dict[str, Any] = {"color": color, "label": "bound"}
        if fails or beyond(curve.points, value, upper) > tolerated:
            style = {"color": VIOLATED, "label": "violated bound"}
        ax.plot(phase.knots[[0, -1]], [value, value], linestyle=(0, (5, 3)), linewidth=0.9, zorder=1, **style)
    return far
