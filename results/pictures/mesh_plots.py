"""The history of a result's meshes as a figure."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ..file.read import Result
from .plots import finish, set_times
from .style import BLUE, LETTER, VERMILION, Frame, Numbers, look


def draw_meshes(ax: Axes, result: Result) -> None:
    """The segments' edges of each mesh of the schedule over time, the first mesh at the top.

    Times are those of the result: where the final time is free, earlier meshes had another one.
    """
    knots = result.phases[0].knots
    for number, mesh in enumerate(result.meshes, start=1):
        times = knots[0] + (knots[-1] - knots[0]) * mesh.edges
        ax.hlines(number, times[0], times[-1], color=BLUE, linewidth=0.8)
        ax.vlines(times, number - 0.3, number + 0.3, color=BLUE, linewidth=0.8)
    names = [f"{k}: {mesh.method}, {len(mesh.edges) - 1}" for k, mesh in enumerate(result.meshes, start=1)]
    step = ceil(len(names) / 20)
    ax.set_yticks(range(1, len(names) + 1, step), names[::step])
    ax.set_ylim(len(names) + 0.6, 0.4)
    ax.grid(False)
    ax.set_title("segment edges of each mesh", loc="left")
    set_times(ax, result.phases[:1])


def draw_history(ax: Axes, label: str, values: Sequence[float], logarithmic: bool = False) -> None:
    """One number for each mesh, over the number of the mesh.

    ax: the axes to draw on.
    label: their title.
    values: of the meshes in turn.
    logarithmic: whether the axis is so, if all values are positive and the largest is over five times the smallest.
    """
    ax.plot(range(1, len(values) + 1), values, "o-", color=VERMILION, markersize=4)
    if logarithmic and max(values) > 5 * min(values) > 0:
        ax.set_yscale("log")
    else:
        ax.yaxis.set_major_formatter(Numbers())
    ax.set_xlim(0.5, len(values) + 0.5)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True, min_n_ticks=1))
    ax.set_xlabel("mesh")
    ax.set_title(label, loc="left")


def mesh_figure(result: Result) -> Figure:
    """The history of refinement: edges of all meshes; unknowns, objective and largest eta by mesh."""
    meshes = result.meshes
    with look():
        longest = max(len(mesh.method) for mesh in meshes) + 10
        frame = Frame(left=longest * 0.9 * LETTER, bottom=0.55, down=0.75)
        figure, grid = frame.figure([float(np.clip(0.32 * len(meshes), 0.6, 6.0)), 1.5], 3, 2.0)
        draw_meshes(figure.add_subplot(grid[0, :]), result)
        draw_history(figure.add_subplot(grid[1, 0]), "unknowns", [mesh.unknowns for mesh in meshes])
        draw_history(figure.add_subplot(grid[1, 1]), "objective", [mesh.objective for mesh in meshes])
        draw_history(figure.add_subplot(grid[1, 2]), "max η", [mesh.max_eta for mesh in meshes], logarithmic=True)
        finish(figure, result)
    return figure
