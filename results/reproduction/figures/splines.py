"""Approximation by splines, sections 3.4 and 4.4: Figures 3 to 6, from the schemes that the solver uses."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ....transcription.schemes.scheme import Scheme
from ....transcription.schemes.table import HERMITE_SIMPSON, TRAPEZOID
from ...pictures.style import BLACK, BLUE, GREEN, GREY, VERMILION
from .example import Example, Picture, Solutions, largest, panel_grid

SEGMENTS = 5
FINE = np.linspace(0, 1, 101)


def function(t: np.ndarray) -> np.ndarray:
    """The function that is approximated on [0, 1]."""
    return np.sin(7.5 * t) * np.exp(-t) + 0.6 * t


def spline(scheme: Scheme, segments: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The spline through the function at the collocation points: times, values, and the points' times (N, n)."""
    edges = np.linspace(0, 1, segments + 1)
    times = edges[:-1, None] + np.diff(edges)[:, None] * FINE
    points = edges[:-1, None] + np.diff(edges)[:, None] * scheme.c
    return times, function(points) @ scheme.interpolant(FINE).U.T, points


def paper_formulas(h: float, x: float, f: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """The paper's splines on a segment beside those of the schemes, by name, at the times of FINE, shape (101,) each.

    h: duration of the segment.
    x: the state at its start.
    f: at its start, middle and end, shape (3,): the values of the controls, and the slopes of the states.
    """
    tau = h * FINE
    k, mid, end = f
    linear, quadratic = TRAPEZOID.interpolant(FINE), HERMITE_SIMPSON.interpolant(FINE)
    s = tau / h
    return {
        "linear control (3.7)": (k + tau / h * (end - k), linear.U @ f[[0, 2]]),
        "quadratic state (3.10)": (
            x + k * tau + tau**2 / (2 * h) * (end - k),
            x * linear.X[:, 0] + h * linear.F @ f[[0, 2]],
        ),
        "quadratic control (4.10)": (
            2 / h**2 * ((tau - h / 2) * (tau - h) * k - 2 * tau * (tau - h) * mid + tau * (tau - h / 2) * end),
            quadratic.U @ f,
        ),
        # As printed, (4.13) lacks the factor h: the correction of the paper multiplies every slope by it.
        "cubic state (4.13)": (
            x + h * (k * s + (-3 * k + 4 * mid - end) * s**2 / 2 + (2 * k - 4 * mid + 2 * end) * s**3 / 3),
            x * quadratic.X[:, 0] + h * quadratic.F @ f,
        ),
    }


def measure(solved: Solutions) -> dict[str, float]:
    pairs = paper_formulas(0.7, 0.3, np.array([1.1, -0.4, 0.8]))
    errors = [_error(scheme) for scheme in (TRAPEZOID, HERMITE_SIMPSON)]
    return {
        **{f"{name} against the scheme": largest(a - b) for name, (a, b) in pairs.items()},
        "error of the linear spline / error of the quadratic one": errors[0] / errors[1],
    }


def _error(scheme: Scheme) -> float:
    times, values, _ = spline(scheme, SEGMENTS)
    return largest(values - function(times))


# -- Figures 3 and 5 ------------------------------------------------------------------------------------------------


def linear(solved: Solutions) -> Figure:
    return _approximation(TRAPEZOID, "linear spline")


def quadratic(solved: Solutions) -> Figure:
    return _approximation(HERMITE_SIMPSON, "quadratic spline")


def _approximation(scheme: Scheme, name: str) -> Figure:
    figure, ((ax,),) = panel_grid([2.6], 1, 5.2)
    times, values, points = spline(scheme, SEGMENTS)
    ax.plot(times.ravel(), function(times).ravel(), color=BLACK, linestyle="--", linewidth=1.6, label="function")
    ax.plot(times.ravel(), values.ravel(), color=VERMILION, linewidth=1.6, label=name)
    knots = np.append(points[:, 0], 1.0)
    ax.plot(knots, function(knots), "o", color=BLUE, markersize=6, label="knot point")
    if len(scheme.c) > 2:
        middle = points[:, 1]
        ax.plot(middle, function(middle), "D", markerfacecolor="white", color=BLUE, markersize=5, label="midpoint")
    ax.set_title(f"{SEGMENTS} segments, largest error {_error(scheme):.2g}", loc="left")
    ax.set_xlabel("$t$")
    ax.set_ylabel("$f(t)$")
    ax.legend(loc="upper center", bbox_to_anchor=(0.56, 1.0))
    return figure


# -- Figures 4 and 6 ------------------------------------------------------------------------------------------------


def trapezoid_segment(solved: Solutions) -> Figure:
    return _segment(TRAPEZOID, np.array([0.35, 0.9]), np.array([0.25, 1.5]))


def simpson_segment(solved: Solutions) -> Figure:
    return _segment(HERMITE_SIMPSON, np.array([0.3, 1.0, 0.75]), np.array([1.3, -0.15, 1.7]))


DEGREES = {1: "linear", 2: "quadratic", 3: "cubic"}


def _segment(scheme: Scheme, u: np.ndarray, f: np.ndarray) -> Figure:
    """One segment, of duration 1: control (left) and state with its slopes (right)."""
    figure, ((left, right),) = panel_grid([2.4], 2, 3.2, across=0.6)
    basis, n = scheme.interpolant(FINE), len(scheme.c)
    ends = {0.0: "k", 0.5: r"k+\frac{1}{2}", 1.0: "k+1"}
    names = [ends[c] for c in scheme.c]
    left.plot(FINE, basis.U @ u, color=VERMILION, linewidth=2)
    left.set_title(f"control: {DEGREES[n - 1]}", loc="left")
    x0 = 0.3
    x = x0 * basis.X[:, 0] + basis.F @ f
    right.plot(FINE, x, color=BLUE, linewidth=2)
    right.set_title(f"state: {DEGREES[n]}", loc="left")
    at = x0 + scheme.interpolant(scheme.c).F @ f
    for c, slope, value in zip(scheme.c, f, at, strict=True):
        run = np.array([-0.14, 0.14])
        right.plot(c + run, value + slope * run, color=GREEN, linewidth=1.4, zorder=3)
    for ax, values, symbol, last in ((left, u, "u", ((8, 6), "left")), (right, at, "x", ((-8, 8), "right"))):
        _name_points(ax, scheme.c, values, [f"${symbol}_{{{name}}}$" for name in names], last)
        ax.set_xticks(scheme.c, [f"$t_{{{name}}}$" for name in names])
        ax.set_xlim(-0.25, 1.25)
        ax.set_yticks([])
        ax.margins(y=0.25)
    for c, value, name in zip(scheme.c, at, names, strict=True):
        right.annotate(
            f"slope $f_{{{name}}}$", (c, value), (10, -14), textcoords="offset points", color=GREEN, fontsize=8
        )
    return figure


def _name_points(ax: Axes, c: np.ndarray, values: np.ndarray, names: list[str], last: tuple) -> None:
    """last: offset and alignment of the name of the last point."""
    ax.vlines(c, 0, 1, transform=ax.get_xaxis_transform(), color=GREY, linewidth=0.6, linestyle=":", zorder=1)
    ax.plot(c, values, "o", color=BLACK, markersize=6, zorder=4)
    for t, value, name in zip(c, values, names, strict=True):
        offset, align = {0.0: ((-6, 7), "right"), 0.5: ((0, 11), "center")}.get(t, last)
        ax.annotate(name, (t, value), offset, textcoords="offset points", ha=align, fontsize=11)


EXAMPLE = Example(
    name="splines",
    title="Splines (sections 3 and 4)",
    runs={},
    measure=measure,
    pictures=(
        Picture(
            "fig03_linear_spline",
            "Figure 3. A function and a linear spline",
            "How trapezoidal collocation sees controls and dynamics: straight lines between the knots, which are "
            "also its collocation points.",
            linear,
        ),
        Picture(
            "fig04_trapezoid_segment",
            "Figure 4. One segment of trapezoidal collocation",
            "The control is linear, (3.7); the state has the slopes f at the knots and a slope that is linear "
            "between them, so it is quadratic, (3.10). Both curves are drawn by the interpolants that the solver "
            "uses.",
            trapezoid_segment,
        ),
        Picture(
            "fig05_quadratic_spline",
            "Figure 5. The same function and a quadratic spline",
            "As Figure 3, with as many segments, but each has a collocation point in its middle too, as in "
            "Hermite-Simpson collocation; the error is far smaller.",
            quadratic,
        ),
        Picture(
            "fig06_hermite_simpson_segment",
            "Figure 6. One segment of Hermite-Simpson collocation",
            "The control is quadratic, (4.10), through both knots and the midpoint; the state has the slopes f at "
            "all three, so it is cubic, (4.13) as corrected. Both curves are drawn by the interpolants that the "
            "solver uses.",
            simpson_segment,
        ),
    ),
)
