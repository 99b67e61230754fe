"""Several results in one picture, and one quantity against another."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...problems.drawings.drawing import obstacles_of
from ...problems.errors import Mistake, SpecError
from ..file.read import CURVE_KINDS, PhaseCurves, Result
from .animate import paint
from .axes import NONE_BROKEN, Bounds, Broken, bound_lines, frame
from .plots import PANEL_HEIGHT, PANEL_WIDTH, check_panels, label_of, outputs_drawn, set_times, unlabel
from .style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    LETTER,
    ORANGE,
    PURPLE,
    SKY,
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

CYCLE = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY, BLACK)
DASHES = ("-", "--", "-.", ":")
PLANE = 4.5  # inches, the longer side of a picture of one quantity against another


def _style(number: int) -> dict[str, Any]:
    """The colour and the line of one of several results; they repeat together after 28."""
    return {"color": CYCLE[number % len(CYCLE)], "linestyle": DASHES[number // len(CYCLE) % len(DASHES)]}


def _named(results: Sequence[Result]) -> list[str]:
    """What the legend calls each result: its file, with the folder where two have one name."""
    names = [result.path.stem for result in results]
    return [plain_label(n if names.count(n) == 1 else str(r.path), 40) for n, r in zip(names, results, strict=True)]


def overlay_figure(
    results: Sequence[Result],
    bounds: Sequence[Bounds] = (),
    only: Sequence[str] = (),
    broken: Sequence[Broken] = (),
) -> Figure:
    """Quantities of several results over time, one panel each, one colour a result.

    results: solved or not; the legend says which.
    bounds: of each of them; none to draw none. Where they differ, each has the colour of its result.
    only: the names to draw, with their costates; empty for all.
    broken: of each result what `broken_bounds` of `audit.broken` gives; none where nothing is known.

    Raises SpecError for a name that no result has, and if there are too many panels.
    """
    panels = _panels(results, only)
    check_panels(results[0], len(panels))
    columns = 1 if len(panels) < 3 else 2
    rows = ceil(len(panels) / columns)
    apart = False
    with look():
        figure, grid = Frame().figure([PANEL_HEIGHT] * rows, columns, PANEL_WIDTH[columns])
        lowest: dict[int, Axes] = {}
        for i, (kind, name) in enumerate(panels):
            ax = figure.add_subplot(grid[i // columns, i % columns])
            apart |= _draw(ax, results, kind, name, bounds, broken)
            unlabel(lowest.get(i % columns))
            lowest[i % columns] = ax
        _finish(
            figure, results, f"{len(results)} results" + ("; each bound in the colour of its result" if apart else "")
        )
    return figure


def _panels(results: Sequence[Result], only: Sequence[str]) -> list[tuple[str, str]]:
    known = dict.fromkeys((kind, name) for kind in CURVE_KINDS for result in results for name in result.names(kind))
    _check_names("--only", [name for _, name in known], only, results)
    outputs = {name for result in results for name in outputs_drawn(result)}
    return [(kind, name) for kind, name in known if (name in only if only else kind != "output" or name in outputs)]


def _check_names(option: str, known: Sequence[str], wanted: Sequence[str], results: Sequence[Result]) -> None:
    if unknown := next((name for name in wanted if name not in known), None):
        what = f'there is no "{unknown}" in {results[0].path}'
        raise SpecError(Mistake(option, what, "it has " + ", ".join(dict.fromkeys(known[:30]))))


def _draw(
    ax: Axes,
    results: Sequence[Result],
    kind: str,
    name: str,
    bounds: Sequence[Bounds],
    broken: Sequence[Broken],
) -> bool:
    """One panel; the value is whether the bounds of the results differ."""
    having = [[phase for phase in result.phases if name in phase.curves.get(kind, {})] for result in results]
    for number, (phases, label) in enumerate(zip(having, _named(results), strict=True)):
        for phase in phases:
            ax.plot(phase.dense_time, phase.curves[kind][name].dense, label=label, zorder=2, **_style(number))
    every: list[PhaseCurves] = [phase for phases in having for phase in phases]
    apart = kind != "costate" and _draw_bounds(ax, having, kind, name, bounds, broken)
    frame(ax, [phase.curves[kind][name] for phase in every])
    set_title(ax, labelled(*label_of(kind, name, every[0]), width_of(ax)))
    ax.yaxis.set_major_formatter(Numbers())
    set_times(ax, [phase for result in results for phase in result.phases], shaded=False)
    return apart


def _draw_bounds(
    ax: Axes,
    having: Sequence[Sequence[PhaseCurves]],
    kind: str,
    name: str,
    bounds: Sequence[Bounds],
    broken: Sequence[Broken],
) -> bool:
    """Those of the first result that has the quantity, in grey, if all have the same; else each result's own."""
    known = [(number, phases, bounds[number]) for number, phases in enumerate(having) if phases and bounds]
    given = [[own.get(phase.name, {}).get(name) for phase in phases] for _, phases, own in known]
    apart = any(own != given[0] for own in given)
    for number, phases, own in known if apart else known[:1]:
        fails = broken[number] if broken else NONE_BROKEN
        bound_lines(ax, phases, kind, name, own, fails, _style(number)["color"] if apart else GREY)
    return apart


def _finish(figure: Figure, results: Sequence[Result], what: str) -> None:
    letters = int(figure.get_figwidth() / (1.15 * LETTER))
    problems = list(dict.fromkeys(result.problem for result in results))
    lines = [plain_label(f"{', '.join(problems)}: {what}", letters)]
    bad = [name for name, result in zip(_named(results), results, strict=True) if result.verdict != "solved"]
    if bad:
        lines.append(plain_label("not solved, or tolerance missed: " + ", ".join(bad), letters))
    head(figure, lines, BLACK if not bad else VERMILION)
    legend(figure, [*dict.fromkeys(_named(results)), "knot", "bound", "violated bound", "beginning", "obstacle"])


def path_in_plane(results: Sequence[Result], across: str, upwards: str) -> Figure:
    """One quantity against another, of one result or of several, with the obstacles of the drawing.

    results: the obstacles are those of the first.
    across, upwards: names of states, controls, algebraic variables or outputs; lengths of one unit have one scale.

    Raises SpecError for a name that no result has.
    """
    kinds = [kind for kind in CURVE_KINDS if kind != "costate"]
    known = [name for kind in kinds for result in results for name in result.names(kind)]
    _check_names("--xy", known, (across, upwards), results)
    with look():
        figure, grid = Frame().figure([PLANE], 1, PLANE)
        ax = figure.add_subplot(grid[0, 0])
        units = ["", ""]
        for number, (result, label) in enumerate(zip(results, _named(results), strict=True)):
            for phase in result.phases:
                found = {name: phase.curves[kind][name] for kind in kinds for name in phase.curves.get(kind, {})}
                if across not in found or upwards not in found:
                    continue
                x, y = found[across], found[upwards]
                units = [x.unit, y.unit]
                ax.plot(x.dense, y.dense, label=label, zorder=2, **_style(number))
                knot = phase.at_knot
                ax.plot(x.points[knot], y.points[knot], "o", color=BLACK, markersize=2.2, label="knot", zorder=3)
                ax.plot(x.points[:1], y.points[:1], "s", color=BLACK, markersize=4.5, label="beginning", zorder=3)
        ax.set_xlabel(labelled(across, units[0]))
        ax.set_ylabel(labelled(upwards, units[1]))
        ax.xaxis.set_major_formatter(Numbers())
        ax.yaxis.set_major_formatter(Numbers())
        if units[0] == units[1] != "":
            view = np.array([ax.get_xlim(), ax.get_ylim()])
            for shape in obstacles_of(results[0].stated()[0]):
                paint(ax, shape, layer=1)
            ax.update_datalim(view.T)
            ax.autoscale_view()
            ax.set_aspect("equal", adjustable="datalim")
        _finish(figure, results, f"{upwards} against {across}")
    return figure
