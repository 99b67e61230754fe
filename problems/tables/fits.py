"""Curves through points along one axis, as cubics on cells: what the kinds of a table differ in.

Each fit takes points (n,), values (n, ...) and whether the curve is held outside, and gives `Pieces`. A curve that is
held has a constant cell beyond either end; others go on as the cubic of the cell at the end.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from math import factorial
from typing import NamedTuple

import numpy as np

from .choices import CUBIC, LINEAR, MONOTONE

ORDER = 4  # coefficients of a cubic

Array = np.ndarray


class Pieces(NamedTuple):
    """breaks: (m + 1,), increasing. coefficients: (m, 4, ...) of 1, d, d^2, d^3, where d is the distance from the left
    break of the cell."""

    breaks: Array
    coefficients: Array


Fit = Callable[[Array, Array, bool], Pieces]


def fit_of(kind: str, smooth: float) -> Fit:
    """The fit of a kind.

    kind: cubic, monotone or linear.
    smooth: half the width over which `linear` rounds its kinks, less than half of the smallest distance of points.
    """
    fits: dict[str, Fit] = {CUBIC: _cubic, MONOTONE: _monotone, LINEAR: partial(_rounded, smooth)}
    return fits[kind]


def _cubic(points: Array, values: Array, held: bool) -> Pieces:
    """The spline with two continuous derivatives. Not-a-knot; held, it is flat and straight at both ends."""
    from scipy.interpolate import CubicSpline  # it takes longer to import than most solves

    if not held:
        return _powers(points, CubicSpline(points, values, axis=0).c)
    return _with_constants(_flat_spline(points, values))


def _flat_spline(points: Array, values: Array) -> Pieces:
    """First and second derivative are zero at both ends, for which the first and the last cell have a knot more."""
    from scipy.interpolate import make_interp_spline

    inner = np.array([(points[0] + points[1]) / 2, (points[-1] + points[-2]) / 2])
    if len(points) == 2:
        inner = points[0] + (points[1] - points[0]) * np.array([1, 2]) / 3
    breaks = np.sort(np.concatenate([points, inner]))
    knots = np.concatenate([breaks[:1].repeat(ORDER - 1), breaks, breaks[-1:].repeat(ORDER - 1)])
    none = np.zeros(values.shape[1:])
    flat = [(1, none), (2, none)]
    spline = make_interp_spline(points, values, k=3, t=knots, bc_type=(flat, flat))
    powers = [spline(breaks[:-1], nu=k) / factorial(k) for k in range(ORDER)]
    return Pieces(breaks, np.stack(powers, axis=1))


def _monotone(points: Array, values: Array, held: bool) -> Pieces:
    """PCHIP, which rises and falls as its points do; its second derivative jumps at them."""
    from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

    slopes = PchipInterpolator(points, values).derivative()(points)
    if not held:
        return _powers(points, CubicHermiteSpline(points, values, slopes).c)
    slopes[[0, -1]] = 0.0
    return _with_constants(_powers(points, CubicHermiteSpline(points, values, slopes).c))


def _rounded(smooth: float, points: Array, values: Array, held: bool) -> Pieces:
    """Straight lines, their kinks averaged over a hat of half-width `smooth`: two continuous derivatives.

    A kink whose slope jumps by s becomes two cubics with the second derivative of the hat, from 0 to s/smooth to 0.
    """
    w, slopes = smooth, np.diff(values, axis=0) / np.diff(points)[(...,) + (None,) * (values.ndim - 1)]
    kinks, at = (points, values) if held else (points[1:-1], values[1:-1])
    if held:
        none = np.zeros_like(slopes[:1])
        slopes = np.concatenate([none, slopes, none])
    elif not len(kinks):
        return Pieces(points, np.stack([values[:1], slopes, 0 * slopes, 0 * slopes], axis=1))
    before, jump = slopes[:-1], np.diff(slopes, axis=0)
    start = at - w * before
    zero = np.zeros_like(at)
    first = [start, before, zero, jump / (6 * w**2)]
    second = [at + jump * w / 6, before + jump / 2, jump / (2 * w), -jump / (6 * w**2)]
    after = [at + w * slopes[1:], slopes[1:], zero, zero]
    inside = np.stack([np.stack(cell, axis=1) for cell in (first, second, after)], axis=1)
    lead = np.stack([values[0], before[0], zero[0], zero[0]])  # a line, as the cell after each kink
    left, right = (kinks[0] - 2 * w, kinks[-1] + 2 * w) if held else (points[0], points[-1])
    breaks = np.concatenate([[left], (kinks[:, None] + w * np.array([-1, 0, 1])).ravel(), [right]])
    return Pieces(breaks, np.concatenate([lead[None], inside.reshape(-1, *lead.shape)]))


def _powers(breaks: Array, highest_first: Array) -> Pieces:
    """From the coefficients (4, m, ...) of SciPy's piecewise polynomials."""
    return Pieces(np.asarray(breaks, float), np.moveaxis(highest_first[::-1], 0, 1))


def _with_constants(pieces: Pieces) -> Pieces:
    """With a constant cell on either side."""
    breaks, inside = pieces
    width = breaks[-1] - breaks[-2]
    end = np.tensordot(width ** np.arange(ORDER), inside[-1], axes=1)
    first, last = np.zeros((2, 1, *inside.shape[1:]))
    first[0, 0], last[0, 0] = inside[0, 0], end
    wider = np.concatenate([[breaks[0] - width], breaks, [breaks[-1] + width]])
    return Pieces(wider, np.concatenate([first, inside, last]))
