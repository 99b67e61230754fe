"""Figures of a result: trajectories, and what every figure of a result has.

The functions named draw_* draw on axes that they are given, so that figures of any layout can be made of them; those
named *_figure lay out a whole figure. Curves are those of the file's dense grid, that is, of the method's own
interpolant, never straight lines between the points of the mesh.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil, log
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...problems.errors import Mistake, SpecError
from ..file.read import CURVE_KINDS, NEAR, Curve, PhaseCurves, Result, beside_each_other
from .axes import NO_BOUNDS, NONE_BROKEN, Bounds, Broken, bound_lines, frame
from .style import (
    BLACK,
    GREY,
    KIND_COLOURS,
    LETTER,
    VERMILION,
    Frame,
    Numbers,
    head,
    labelled,
    legend,
    look,
    plain_label,
    set_title,
    width_of,
)

MAX_PANELS = 160
TOO_NEAR = 0.8  # typographic points between markers: nearer ones only hide the curve
LEGEND = (*CURVE_KINDS, "measured", "knot", "point inside a segment", "segment edge", "bound", "violated bound")
PANEL_WIDTH = {1: 5.5, 2: 3.7, 3: 2.9, 4: 2.4, 5: 2.0}  # inches, by the number of columns
PANEL_HEIGHT = 1.25
SMALL_LETTER = 0.05  # inches, of the names of phases
SEEN = 0.002  # of the duration: a shorter phase is a line, and its neighbours are told apart
MAX_NAME_ROWS, NAME_ROW = 4, 0.08  # of the names of phases, and their distance, part of the height of a panel


def draw_curve(
    ax: Axes, result: Result, kind: str, name: str, bounds: Bounds = NO_BOUNDS, broken: Broken = NONE_BROKEN
) -> None:
    """Draw one quantity of all phases over time: dense curve, points of the mesh, bounds, marks of the mesh.

    ax: the axes to draw on; they get title, formats and the name of the time axis.
    result: at least one of its phases has the quantity.
    kind: "state", "control", "algebraic" or "costate".
    name: of the quantity; of a costate, that of its state.
    bounds: as `bounds_of` of `file.read` gives them; empty for a picture without them. A costate has none.
    broken: as `broken_bounds` of `audit.broken` gives them.
    """
    phases = [phase for phase in result.phases if name in phase.curves.get(kind, {})]
    points = 72 * width_of(ax) / sum(len(phase.time) for phase in phases)
    for phase in phases:
        curve = phase.curves[kind][name]
        colour = KIND_COLOURS[kind]
        if phase.discrete:
            ax.step(phase.time, curve.points, where="post", color=colour, label=kind, zorder=2)
        else:
            ax.plot(phase.dense_time, curve.dense, color=colour, label=kind, zorder=2)
        _draw_points(ax, phase, curve, colour, points)
        if kind != "costate":
            _draw_measured(ax, phase, name)
        draw_mesh_marks(ax, phase.knots)
    far = [] if kind == "costate" else bound_lines(ax, phases, kind, name, bounds, broken)
    frame(ax, [phase.curves[kind][name] for phase in phases])
    width = width_of(ax)
    told = "bound " + " ".join(dict.fromkeys(far)) if far else ""
    set_title(ax, labelled(*label_of(kind, name, phases[0]), width), told, raised=len(phases) > 1)
    ax.yaxis.set_major_formatter(Numbers())
    set_times(ax, result.phases)


def label_of(kind: str, name: str, phase: PhaseCurves) -> tuple[str, str]:
    """What a panel is called, and its unit; a costate has that of the objective per unit of its state.

    kind: of the curve, as of `draw_curve`.
    name: of the quantity.
    phase: one that has it.
    """
    if kind != "costate":
        return name, phase.curves[kind][name].unit
    unit = phase.curves["state"][name].unit if name in phase.curves["state"] else ""
    compound = f"({unit})" if set("/*^ ") & set(unit) else unit
    return f"costate of {name}", f"objective/{compound}" if unit not in ("", "1") else "objective"


def _draw_points(ax: Axes, phase: PhaseCurves, curve: Curve, colour: str, points: float) -> None:
    """The points of the mesh; points: between their markers, 72 to an inch, on average over all phases."""
    if points < TOO_NEAR:
        return
    size = float(np.clip(0.6 * points, 1.2, 3.5))
    knot = phase.at_knot
    style: dict[str, Any] = {"linestyle": "", "markeredgewidth": 0.8, "zorder": 3}
    ax.plot(phase.time[knot], curve.points[knot], "o", color=BLACK, markersize=size, label="knot", **style)
    if not knot.all():
        inner: dict[str, Any] = {"markerfacecolor": "white", "markeredgecolor": colour, "markersize": 0.9 * size}
        ax.plot(phase.time[~knot], curve.points[~knot], "D", label="point inside a segment", **inner, **style)


def _draw_measured(ax: Axes, phase: PhaseCurves, name: str) -> None:
    """Crosses at what was measured of a quantity by itself."""
    for own in phase.measured:
        if own.expression == name:
            style: dict[str, Any] = {"linestyle": "", "marker": "x", "markersize": 4, "markeredgewidth": 1.0}
            ax.plot(own.time, own.value, color=VERMILION, label="measured", zorder=4, **style)


def draw_mesh_marks(ax: Axes, knots: np.ndarray) -> None:
    """Short strokes on the time axis, at the segments' edges."""
    style: dict[str, Any] = {"color": GREY, "linewidth": float(np.clip(50 / len(knots), 0.25, 0.6)), "zorder": 1}
    ax.vlines(knots, 0, 0.035, transform=ax.get_xaxis_transform(), label="segment edge", **style)


def set_times(ax: Axes, phases: Sequence[PhaseCurves], *, shaded: bool = True) -> None:
    """The time axis, from the first beginning to the last end.

    ax: the axes.
    phases: all of the result, or results: so that panels above each other have one scale, whatever phases they draw.
    shaded: whether of several phases each second one is shaded and all are named.
    """
    start, end = min(phase.knots[0] for phase in phases), max(phase.knots[-1] for phase in phases)
    if end > start:
        ax.set_xlim(start - 0.015 * (end - start), end + 0.015 * (end - start))
    ax.set_xlabel(labelled("time", phases[0].time_unit))
    if len(phases) > 1 and shaded:
        _name_phases(ax, phases, end - start)


def _name_phases(ax: Axes, phases: Sequence[PhaseCurves], duration: float) -> None:
    """Names above the axes, those of phases at the same times (branches) one above the other; each second is shaded."""
    across, rows = ax.get_xaxis_transform(), [-np.inf] * MAX_NAME_ROWS
    together, shade = beside_each_other(phases), False
    for phase in phases:
        first, last = phase.knots[[0, -1]]
        if shade and not together:
            ax.axvspan(first, last, color=GREY, alpha=0.1, linewidth=0, zorder=0)
        shade ^= bool(last - first > SEEN * duration)
        scale = max(duration, 1e-300) / width_of(ax)  # of time, to an inch
        half = len(phase.name) * SMALL_LETTER * scale / 2
        free = [row for row, end in enumerate(rows) if end <= (first + last) / 2 - half + NEAR * duration]
        if 2 * half <= last - first + NEAR * duration and free:
            rows[free[0]] = (first + last) / 2 + half
            style: dict[str, Any] = {"ha": "center", "va": "bottom", "fontsize": 5.5, "color": GREY}
            ax.text((first + last) / 2, 1.0 - NAME_ROW * free[0], plain_label(phase.name), transform=across, **style)


def trajectory_figure(
    result: Result, bounds: Bounds = NO_BOUNDS, only: Sequence[str] = (), broken: Broken = NONE_BROKEN
) -> Figure:
    """States, controls, algebraic variables and costates over time, each in its panel.

    result: solved or not; the title says which.
    bounds, broken: as of `draw_curve`.
    only: the names to draw, with their costates; empty for all.

    Raises SpecError for a name that is not there, and if there are too many panels for one picture.
    """
    sections = _sections(result, only)
    columns, two_lines = _layout(result, sections)
    rows = sum(ceil(len(names) / columns) for names in sections.values())
    with look():
        frame = Frame(down=0.66, top=1.0) if two_lines else Frame()
        figure, grid = frame.figure([PANEL_HEIGHT] * rows, columns, PANEL_WIDTH[columns])
        row = 0
        lowest: dict[int, Axes] = {}
        for kind, names in sections.items():
            for i, name in enumerate(names):
                ax = figure.add_subplot(grid[row + i // columns, i % columns])
                draw_curve(ax, result, kind, name, bounds, broken)
                unlabel(lowest.get(i % columns))
                lowest[i % columns] = ax
            row += ceil(len(names) / columns)
        finish(figure, result)
        legend(figure, LEGEND)
    return figure


def unlabel(ax: Axes | None) -> None:
    """Only the lowest panel of a column names the time axis."""
    if ax is not None:
        ax.set_xlabel("")
        ax.tick_params(labelbottom=False)


def _sections(result: Result, only: Sequence[str]) -> dict[str, list[str]]:
    """kind -> the names to draw; kinds without any are left out."""
    known = {name for kind in CURVE_KINDS for name in result.names(kind)}
    if result.static:
        what = "there is no time to draw anything over"
        remedy = "trajopt show lists the values; a picture can be drawn of two static parameters"
        raise SpecError(Mistake(str(result.path), what, remedy))
    if unknown := [name for name in only if name not in known]:
        what = f'there is no "{unknown[0]}" in {result.path}'
        raise SpecError(Mistake("--only", what, "it has " + ", ".join(sorted(known)[:30])))
    chosen = {kind: [n for n in result.names(kind) if not only or n in only] for kind in CURVE_KINDS}
    if not only:
        chosen["output"] = outputs_drawn(result)
    check_panels(result, sum(map(len, chosen.values())))
    return {kind: names for kind, names in chosen.items() if names}


def outputs_drawn(result: Result) -> list[str]:
    """Named expressions that are drawn without being asked for: without a unit most are parts of others."""
    units = {n: phase.curves["output"][n].unit for phase in result.phases for n in phase.curves.get("output", {})}
    measured = {own.expression for phase in result.phases for own in phase.measured}
    return [name for name in result.names("output") if units[name] or name in measured]


def check_panels(result: Result, count: int) -> None:
    if count > MAX_PANELS:
        what = f"{count} panels do not fit into one picture"
        raise SpecError(Mistake(str(result.path), what, "choose some names with --only NAME,NAME"))


def _layout(result: Result, sections: Mapping[str, Sequence[str]]) -> tuple[int, bool]:
    """The number of columns, and whether some title needs two lines.

    Few empty places, a page that is neither wide nor long, and panels no narrower than their names.
    """
    counts = [len(names) for names in sections.values()]
    labels = [
        label_of(kind, name, phase)
        for phase in result.phases
        for kind, names in sections.items()
        for name in names
        if name in phase.curves[kind]
    ]

    def badness(columns: int) -> float:
        rows = sum(ceil(count / columns) for count in counts)
        shape = columns * (PANEL_WIDTH[columns] + Frame.across) / (rows * (PANEL_HEIGHT + Frame.down) + Frame.bottom)
        cut = any(len(part) * LETTER > PANEL_WIDTH[columns] for label in labels for part in label)
        return (rows * columns - sum(counts)) / sum(counts) + abs(log(shape / 1.1)) + 5 * cut

    columns = min(PANEL_WIDTH, key=badness)
    return columns, any("\n" in labelled(*label, PANEL_WIDTH[columns]) for label in labels)


def finish(figure: Figure, result: Result, *notes: str) -> None:
    """The title: the problem, how the solve ended, objective and mesh; and notes, a line for each."""
    mesh = result.meshes[-1]
    status = result.verdict if result.solved else f"NOT SOLVED: {result.message}"
    letters, exact = int(figure.get_figwidth() / (1.15 * LETTER)), all(phase.discrete for phase in result.phases)
    lines = [
        plain_label(f"{result.problem}: {status}", letters),
        plain_label(f"objective {result.objective:.8g}" + ("" if exact else f", max η {mesh.max_eta:.2g}"), letters),
        plain_label(f"{mesh.segments} steps" if exact else f"{mesh.method}, {mesh.segments} segments", letters),
    ]
    if result.static:  # no time, no mesh
        lines[1:] = [plain_label(f"objective {result.objective:.8g}", letters), ""]
    if len(lines[1]) + len(lines[2]) + 2 <= letters:
        lines[1:] = ["; ".join(filter(None, lines[1:]))]
    head(figure, [*lines, *notes], BLACK if result.verdict == "solved" else VERMILION)
