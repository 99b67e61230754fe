"""A problem without time and of two unknowns as a picture: level lines of the objective, the constraints, the optimum.

It is the figure of the introduction to direct collocation (its Figure 2), for any such problem.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ...problems.problem import Phase, Problem
from ...problems.quantities import Constraint, Range, Variable
from ..file.read import Result
from .plots import finish
from .style import BLACK, GREY, VERMILION, Frame, Numbers, labelled, legend, look

SAMPLES = 301  # along each axis
LEVELS = 16
AROUND = 1.5  # times 1 + |value|, on each side of an unknown without two bounds
SIDE = 4.2  # inches
LEGEND = ("objective", "constraint", "not allowed", "solution")


def plane_figure(result: Result) -> Figure:
    """Level lines over two static parameters.

    result: of a problem without time with exactly two of them.
    """
    problem, _ = result.build()
    (phase,) = problem.phases
    point = result.phases[0].parameters
    with look():
        figure, grid = Frame().figure([SIDE], 1, SIDE)
        ax = figure.add_subplot(grid[0, 0])
        _draw(ax, problem, phase, point)
        finish(figure, result)
        legend(figure, LEGEND)
    return figure


def _draw(ax: Axes, problem: Problem, phase: Phase, point: Mapping[str, float]) -> None:
    first, second = problem.parameters
    x, y = (_axis(own, point[own.name]) for own in problem.parameters)
    values = dict(zip((first.name, second.name), np.meshgrid(x, y), strict=True))
    shape = SAMPLES, SAMPLES
    with np.errstate(all="ignore"):
        if phase.mayer:
            cost = np.broadcast_to(phase.mayer(values, np), shape)
            if np.ptp(cost[np.isfinite(cost)]) > 0:
                lines = ax.contour(x, y, cost, LEVELS, cmap="viridis", linewidths=0.8, zorder=1)
                ax.clabel(lines, fontsize=6, fmt=Numbers())
                ax.plot([], [], color=GREY, linewidth=0.8, label="objective")
        for constraint in phase.boundary:
            _draw_constraint(ax, x, y, np.broadcast_to(constraint.function(values, np), shape), constraint)
    ax.plot(point[first.name], point[second.name], "o", color=VERMILION, markersize=6, label="solution", zorder=4)
    ax.set_xlabel(labelled(first.name, first.unit))
    ax.set_ylabel(labelled(second.name, second.unit))
    ax.grid(False)


def _draw_constraint(ax: Axes, x: np.ndarray, y: np.ndarray, g: np.ndarray, constraint: Constraint) -> None:
    """The lines on which a constraint acts, and in grey where it does not hold."""
    bounds = constraint.bounds
    for level in sorted({end for end in (bounds.lower, bounds.upper) if np.isfinite(end)}):
        ax.contour(x, y, g, [level], colors=BLACK, linewidths=1.4, zorder=3)
    ax.add_line(Line2D([], [], color=BLACK, label="constraint"))
    if not bounds.fixed:
        broken = np.where(np.isfinite(g), bounds.beyond(g), 0.0) > 0
        ax.contourf(x, y, broken, [0.5, 1.5], colors=[GREY], alpha=0.15, zorder=0)
        if broken.any():
            ax.fill([], [], color=GREY, alpha=0.15, label="not allowed")


def _axis(own: Variable, value: float) -> np.ndarray:
    """Values of an unknown to draw over: all that its bounds allow, or what is around its value."""
    half = AROUND * (1 + abs(value))
    shown = own.bounds.intersection(Range(value - half, value + half))
    lower, upper = own.bounds.lower, own.bounds.upper
    if np.isfinite(upper - lower) and upper - lower <= 10 * half:
        shown = own.bounds
    margin = 0.03 * (shown.upper - shown.lower)
    return np.linspace(shown.lower - margin, shown.upper + margin, SAMPLES)
