"""The errors of a result as a figure: of the dynamics, state by state, and of the objective."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ...problems.errors import Mistake, SpecError
from ..file.read import Result
from .plots import PANEL_HEIGHT, PANEL_WIDTH, check_panels, draw_mesh_marks, finish, set_times, unlabel
from .style import BLACK, BLUE, GREY, LETTER, ORANGE, SKY, Frame, Numbers, labelled, look, set_title, width_of

DECADES = 8
AXIS = 0.05  # inches: an empty row, whose two gaps hold the names of the axes above it


def draw_error(axes: tuple[Axes, Axes], result: Result, state: str) -> None:
    """epsilon(t) = dx/dt - f of one state on the left, eta of each segment on the right (Figs 11, 15), logarithmic.

    axes: left and right.
    result: its phases are drawn one after the other.
    state: the name of a state.
    """
    left, right = axes
    phases = [phase for phase in result.phases if state in phase.epsilon]
    for phase in phases:
        left.plot(phase.dense_time, np.abs(phase.epsilon[state].dense), color=BLUE, linewidth=1.0, label="epsilon")
        draw_mesh_marks(left, phase.knots)
    set_title(left, labelled(f"|ε| of {state}", phases[0].epsilon[state].unit), raised=len(phases) > 1)
    _logarithmic(left, np.concatenate([np.abs(phase.epsilon[state].dense) for phase in phases]))
    set_times(left, result.phases)
    eta = np.concatenate([phase.eta[state] for phase in phases])
    _draw_segments(right, labelled(f"η of {state}", phases[0].curves["state"][state].unit), eta, ORANGE)


def draw_bar(axes: tuple[Axes, Axes], result: Result) -> None:
    """The largest relative eta of each segment on the left, what it adds to the error bar on the right, or why nothing.

    axes: left and right.
    result: its phases are drawn one after the other.
    """
    left, right = axes
    relative = np.concatenate([phase.relative for phase in result.phases])
    _draw_segments(left, "largest relative η", relative, ORANGE)
    if result.objective_error_missing:
        draw_no_bar(right, result)
        return
    label = f"part of the error bar {result.objective_error:.2g}"
    _draw_segments(right, label, np.concatenate([phase.shares for phase in result.phases]), SKY)


def draw_no_bar(ax: Axes, result: Result) -> None:
    """Empty axes, which say why a result has no error bar of the objective."""
    why = f"no error bar of the objective: {result.objective_error_missing}"
    text = textwrap.fill(why, max(int(width_of(ax) / LETTER) - 2, 12))
    ax.text(0.5, 0.5, text, transform=ax.transAxes, ha="center", va="center", color=GREY)
    ax.set_axis_off()


def _draw_segments(ax: Axes, label: str, values: np.ndarray, colour: str) -> None:
    """A step for each segment, values (N,), which are told to be largest where they are."""
    if not len(values):
        set_title(ax, label, "not in this result")  # of an older version
        ax.set_axis_off()
        return
    ax.stairs(values, np.arange(len(values) + 1) + 0.5, fill=True, color=colour, edgecolor=BLACK, linewidth=0.4)
    finite = np.isfinite(values).any()
    note = f"max {np.nanmax(values):.2g} in segment {np.nanargmax(values) + 1}" if finite else "not finite"
    set_title(ax, label, note)
    ax.set_xlim(0.5, len(values) + 0.5)
    _logarithmic(ax, values)
    ax.xaxis.set_major_locator(MaxNLocator(6, integer=True))
    ax.set_xlabel("segment")


def _logarithmic(ax: Axes, values: np.ndarray) -> None:
    """A logarithmic axis for values that are not negative, over DECADES at most; a plain one where all are zero."""
    positive = values[np.isfinite(values) & (values > 0)]
    if not len(positive):
        ax.set_ylim(0, 1)
        ax.yaxis.set_major_formatter(Numbers())
        return
    top = float(positive.max())
    ax.set_yscale("log")
    ax.set_ylim(max(float(positive.min()) / 2, top * 10.0**-DECADES), 2 * top)


def error_figure(result: Result, only: Sequence[str] = ()) -> Figure:
    """One row for each state: epsilon over time, and eta by segment; below them the error bar of the objective.

    result: solved or not.
    only: the states to draw, without the objective; empty for all.

    Raises SpecError as `trajectory_figure`.
    """
    states = [name for name in result.states if not only or name in only]
    if not states:
        raise SpecError(Mistake("--only", "none of these names is a state", "give " + ", ".join(result.states[:30])))
    rows = [PANEL_HEIGHT] * len(states) + ([] if only else [AXIS, PANEL_HEIGHT])
    check_panels(result, 2 * len(states))
    with look():
        figure, grid = Frame(top=1.0, bottom=0.55).figure(rows, 2, PANEL_WIDTH[2])
        for row, state in enumerate(states):
            pair = figure.add_subplot(grid[row, 0]), figure.add_subplot(grid[row, 1])
            draw_error(pair, result, state)
            if row < len(states) - 1:
                unlabel(pair[0])
                unlabel(pair[1])
        if not only:
            draw_bar((figure.add_subplot(grid[-1, 0]), figure.add_subplot(grid[-1, 1])), result)
        finish(figure, result, "ε = dx/dt − f, η = integral of |ε| over a segment")
    return figure
