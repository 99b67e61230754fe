"""What an example consists of: problems to solve, numbers measured in the results, pictures drawn from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ....problems.lean.records import dataclass
from ...file.read import Curve, PhaseCurves, Result
from ...pictures.style import BLACK, BLUE, VERMILION, Frame, Numbers, labelled


@dataclass(frozen=True)
class Run:
    """One solve: `trajopt solve PROBLEM --set OVERRIDE ...`.

    shown: whether a figure shows it; the others are solved only for their numbers.
    """

    problem: str
    overrides: tuple[str, ...] = ()
    shown: bool = False


@dataclass(frozen=True)
class SolvedRun:
    """The result file of a run, read back: its curves, and what each mesh of the schedule took."""

    result: Result
    iterations: tuple[int, ...]
    seconds: tuple[float, ...]

    @property
    def phase(self) -> PhaseCurves:
        """The first phase: no problem of the paper has a second one."""
        return self.result.phases[0]

    @property
    def objective(self) -> float:
        return self.result.objective

    @property
    def effort(self) -> str:
        """Iterations and seconds in words, mesh by mesh."""
        pairs = zip(self.iterations, self.seconds, strict=True)
        return ", then ".join(f"{iterations} iterations in {seconds:.2g} s" for iterations, seconds in pairs)

    def curve(self, name: str) -> Curve:
        """A state, control or algebraic variable by its name."""
        return next(kind[name] for kind in self.phase.curves.values() if name in kind)


Solutions = Mapping[str, SolvedRun]
"""Name of a run -> its result."""


@dataclass(frozen=True)
class Picture:
    """One figure. file: its name without a suffix. caption: {name of a run} in it becomes that run's effort."""

    file: str
    title: str
    caption: str
    draw: Callable[[Solutions], Figure]


@dataclass(frozen=True)
class Example:
    """One example. measure: results of some runs, at least of those shown -> what is told by the name of each number.

    table: results -> rows of texts, the first one of headings; shown below the figures.
    """

    name: str
    title: str
    runs: Mapping[str, Run]
    measure: Callable[[Solutions], Mapping[str, float]]
    pictures: Sequence[Picture]
    table: Callable[[Solutions], list[list[str]]] = field(default=lambda solved: [])


def panel_grid(rows: Sequence[float], columns: int, width: float, **frame: float) -> tuple[Figure, list[list[Axes]]]:
    """A figure with panels in rows and columns, and its axes row by row.

    rows: height of each row, inches.
    columns: the number of columns.
    width: of each column, inches.
    frame: margins and gaps by their names in `Frame`, inches; by default its own, but less above and below.
    """
    frame = {"top": 0.35, "bottom": 0.55, **frame}
    figure, places = Frame(**frame).figure(rows, columns, width)
    return figure, [[figure.add_subplot(places[i, j]) for j in range(columns)] for i in range(len(rows))]


def draw(ax: Axes, solved: SolvedRun, name: str, label: str = "", colour: str = "") -> None:
    """A state or control over time, by the method's own interpolant, with circles at the knots (Figures 10 and 14).

    ax: the axes to draw on.
    solved: the run whose first phase is drawn.
    name: of the state or control.
    label: beside the axis, with the unit behind it; it may hold mathematics. "" for the name.
    colour: any of Matplotlib's; "" for that of a control or of a state.
    """
    phase, curve = solved.phase, solved.curve(name)
    control = name in phase.curves.get("control", {})
    knot = phase.at_knot
    ax.plot(phase.dense_time, curve.dense, color=colour or (VERMILION if control else BLUE), zorder=2)
    circle: dict[str, Any] = {
        "markersize": 3.2,
        "markerfacecolor": "none",
        "markeredgecolor": BLACK,
        "markeredgewidth": 0.7,
    }
    ax.plot(phase.time[knot], curve.points[knot], "o", zorder=3, **circle)
    ax.set_ylabel(with_unit(label or name, curve.unit))
    ax.yaxis.set_major_formatter(Numbers())
    ax.margins(x=0.015)


def with_unit(label: str, unit: str) -> str:
    """A label that may hold mathematics, and its unit."""
    return label + labelled("", unit)


def name_time(axes: Sequence[Sequence[Axes]], unit: str = "s") -> None:
    """Only the lowest panel of a column names and numbers the time axis."""
    for row in axes[:-1]:
        for ax in row:
            ax.tick_params(labelbottom=False)
    for ax in axes[-1]:
        ax.set_xlabel(labelled("time", unit))


def objectives(solved: Solutions, texts: Mapping[str, str]) -> dict[str, float]:
    """Text -> objective of the runs that have been solved."""
    return {f"J, {text}": solved[name].objective for name, text in texts.items() if name in solved}


def largest(values: np.ndarray) -> float:
    return float(np.abs(values).max())


def peak(values: np.ndarray) -> float:
    """The largest magnitude of a smooth curve given at equally spaced times: a polynomial through five of them."""
    k = int(np.clip(np.abs(values).argmax(), 2, len(values) - 3))
    near = np.arange(-2, 3)
    return largest(np.polyval(np.polyfit(near, values[k + near], 4), np.linspace(-1, 1, 401)))
