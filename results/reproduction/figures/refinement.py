"""Mesh refinement by subdividing segments, section 5.2: Figure 7."""

from __future__ import annotations

from math import ceil, sqrt

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ....transcription.schemes.table import TRAPEZOID
from ...pictures.style import BLACK, BLUE, ORANGE, VERMILION, Numbers
from .example import Example, Picture, Solutions, panel_grid

EDGES = np.linspace(0, 1, 7)
TOLERANCE = 0.015
MOST = 4  # subsegments of a segment
FINE = np.linspace(0, 1, 101)


def function(t: np.ndarray) -> np.ndarray:
    """What is approximated on [0, 1]: calm at its ends, fast in its middle."""
    return np.tanh(9 * (t - 0.45)) + 0.25 * np.sin(3 * t)


def spline(edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The linear spline through the function at the edges (N + 1,): times and values, (N, 101) each."""
    times = edges[:-1, None] + np.diff(edges)[:, None] * FINE
    return times, np.stack([function(edges[:-1]), function(edges[1:])], axis=1) @ TRAPEZOID.interpolant(FINE).U.T


def peak_errors(edges: np.ndarray) -> np.ndarray:
    """The largest error of the spline on each segment, shape (N,)."""
    times, values = spline(edges)
    return np.abs(values - function(times)).max(axis=1)


def subdivide(edges: np.ndarray, tolerance: float) -> tuple[np.ndarray, list[int]]:
    """The next mesh, and the number of subsegments of each segment: the error of a linear spline falls as h^2."""
    counts = [min(max(ceil(sqrt(error / tolerance)), 1), MOST) for error in peak_errors(edges)]
    parts = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(edges[:-1], edges[1:], counts, strict=True)]
    return np.append(np.concatenate(parts), edges[-1]), counts


def measure(solved: Solutions) -> dict[str, float]:
    edges, counts = subdivide(EDGES, TOLERANCE)
    return {
        "least number of subsegments": min(counts),
        "largest number of subsegments": max(counts),
        "largest error before / after": peak_errors(EDGES).max() / peak_errors(edges).max(),
    }


def subdividing(solved: Solutions) -> Figure:
    figure, axes = panel_grid([2.1, 1.3], 2, 3.2, down=0.25, across=0.3)
    refined, counts = subdivide(EDGES, TOLERANCE)
    top = 1.1 * peak_errors(EDGES).max()
    for i, (edges, title) in enumerate(((EDGES, "before"), (refined, "after"))):
        above, below = axes[0][i], axes[1][i]
        _draw_spline(above, edges)
        above.set_title(f"{title}: {len(edges) - 1} segments", loc="left")
        below.stairs(peak_errors(edges), edges, fill=True, color=ORANGE, edgecolor=BLACK, linewidth=0.6)
        below.axhline(TOLERANCE, color=BLACK, linestyle="--", linewidth=0.9)
        below.set_ylim(0, 1.25 * top)
        below.set_xlabel("$t$")
        above.tick_params(labelbottom=False)
    for left, right, n in zip(EDGES[:-1], EDGES[1:], counts, strict=True):
        axes[1][0].text((left + right) / 2, 1.2 * top, str(n), ha="center", va="top")
    axes[0][0].legend(loc="lower right")
    axes[0][0].set_ylabel("$f(t)$")
    axes[1][0].set_ylabel("peak error")
    axes[1][1].text(1, TOLERANCE, "tolerance", ha="right", va="bottom", fontsize=8)
    for row in axes:
        row[1].tick_params(labelleft=False)
        row[0].yaxis.set_major_formatter(Numbers())
    return figure


def _draw_spline(ax: Axes, edges: np.ndarray) -> None:
    times, values = spline(edges)
    t = np.linspace(0, 1, 400)
    ax.plot(t, function(t), color=BLACK, linestyle="--", label="function")
    ax.plot(times.ravel(), values.ravel(), color=VERMILION, label="linear spline")
    ax.plot(edges, function(edges), "o", color=BLUE, markersize=4.5, label="knot point")


EXAMPLE = Example(
    name="refinement",
    title="Mesh refinement (section 5.2)",
    runs={},
    measure=measure,
    pictures=(
        Picture(
            "fig07_mesh_refinement",
            "Figure 7. Refinement by subdividing segments",
            f"A linear spline before and after one refinement. The numbers above the errors are those of the "
            f"subsegments, 1 to {MOST}, which the peak error of each segment determines: as many as bring it below "
            f"the tolerance (dashed) where the error falls as the square of the width, as it does on short segments. "
            f"Function, mesh and tolerance were chosen by us. ('trajopt solve --refine' takes eta for the error, and "
            f"may raise the degree instead.)",
            subdividing,
        ),
    ),
)
