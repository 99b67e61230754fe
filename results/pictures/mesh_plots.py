"""The history of a result's meshes as a figure."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..file.read import Result
from .error_plots import draw_no_bar
from .plots import finish, set_times
from .style import BLUE, GREY, LETTER, VERMILION, Frame, Numbers, look, set_title


def draw_meshes(ax: Axes, result: Result) -> None:
    """The segments' edges of each mesh of the schedule over time, the first mesh at the top.

    Times are those of the result: where the final time is free, earlier meshes had another one.
    """
    for number, mesh in enumerate(result.meshes, start=1):
        for phase, edges in zip(result.phases, mesh.edges, strict=True):
            times = phase.knots[0] + (phase.knots[-1] - phase.knots[0]) * edges
            ax.hlines(number, times[0], times[-1], color=BLUE, linewidth=0.8)
            ax.vlines(times, number - 0.3, number + 0.3, color=BLUE, linewidth=0.8)
    names = [f"{k}: {mesh.method}, {mesh.segments}" for k, mesh in enumerate(result.meshes, start=1)]
    step = ceil(len(names) / 20)
    ax.set_yticks(range(1, len(names) + 1, step), names[::step])
    ax.set_ylim(len(names) + 0.6, 0.4)
    ax.grid(False)
    set_title(ax, "segment edges of each mesh", raised=len(result.phases) > 1)
    set_times(ax, result.phases)


def draw_history(
    ax: Axes, label: str, values: Sequence[float], bars: Sequence[float] = (), *, logarithmic: bool = False
) -> None:
    """One number for each mesh, over the number of the mesh; a mesh where it is NaN is left out.

    ax: the axes to draw on.
    label: their title.
    values: of the meshes in turn.
    bars: how far each value is off, at most, NaN where that is not known; empty for none. All but the smallest may
        leave the axes: the first is often far larger than all that changes after it.
    logarithmic: whether the axis is so, if all values are positive and the largest is over five times the smallest.
    """
    numbers, finite = range(1, len(values) + 1), np.array(values)[np.isfinite(values)]
    ax.plot(numbers, values, "o-", color=VERMILION, markersize=4)
    if np.isfinite(bars).any():
        low, high = np.array(values) - bars, np.array(values) + bars
        least = int(np.nanargmin(bars))
        ax.update_datalim([(least + 1, low[least]), (least + 1, high[least])])
        ax.set_ylim(ax.get_ylim())
        ax.vlines(numbers, low, high, color=GREY, linewidth=1.2, zorder=1)
    if logarithmic and len(finite) and finite.max() > 5 * finite.min() > 0:
        ax.set_yscale("log")
    else:
        ax.yaxis.set_major_formatter(Numbers())
    ax.set_xlim(0.5, len(values) + 0.5)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    ax.set_xlabel("mesh")
    ax.set_title(label, loc="left")


def mesh_figure(result: Result) -> Figure:
    """The history of refinement: edges of all meshes; unknowns, objective, its error bar and largest eta by mesh."""
    meshes = result.meshes
    bars = [mesh.objective_error for mesh in meshes]
    with look():
        longest = max(len(mesh.method) for mesh in meshes) + 10
        frame = Frame(left=longest * 0.9 * LETTER, bottom=0.55, across=1.0, down=0.75)
        figure, grid = frame.figure([float(np.clip(0.32 * len(meshes), 0.6, 6.0)), 1.5], 4, 2.0)
        draw_meshes(figure.add_subplot(grid[0, :]), result)
        below = [figure.add_subplot(grid[1, column]) for column in range(4)]
        draw_history(below[0], "unknowns", [mesh.unknowns for mesh in meshes])
        draw_history(below[1], "objective", [mesh.objective for mesh in meshes], bars)
        if np.isfinite(bars).any():
            draw_history(below[2], "error bar of the objective", bars, logarithmic=True)
        else:
            draw_no_bar(below[2], result)
        draw_history(below[3], "max η", [mesh.max_eta for mesh in meshes], logarithmic=True)
        finish(figure, result)
    return figure
