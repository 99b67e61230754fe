"""Moving pictures of a result, and many poses in one picture: any problem that has a drawing."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps, patches
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from ...problems.drawings.drawing import drawings_of
from ...problems.drawings.shapes import WHOLE, Circle, Ground, Polyline, Rectangle, Shape
from ...problems.errors import Mistake, SpecError
from ...problems.files import replacing
from ...problems.lean.records import dataclass
from ..file.read import PhaseCurves, Result
from .film import write_film
from .style import (
    BLACK,
    COLOURS,
    GREY,
    LETTER,
    PARTS,
    TIME_COLOURS,
    VERMILION,
    Frame,
    head,
    labelled,
    look,
    mark,
    plain_label,
)

SHOWN = ("state", "control", "algebraic")
"""The kinds of curves that a drawing may be made of."""

TRACE_POINTS = 400
FILM_DPI = 100
LARGEST, SMALLEST = (6.0, 5.5), (3.0, 1.0)  # inches: width and height of the panel
MARGIN = 0.06  # around what is drawn, part of its longer side


@dataclass(frozen=True)
class Pose:
    """What there is to see at time t."""

    t: float
    shapes: Sequence[Shape]


@dataclass(frozen=True)
class Scene:
    """All that is drawn of a result.

    at: times (K,) -> the poses. times: from the initial to the final one. box: (2, 2), the lower left and upper right
    corners around everything. traces: number of a shape -> the path of its centre, (len(times), 2).
    """

    result: Result
    at: Callable[[np.ndarray], list[Pose]]
    times: np.ndarray
    box: np.ndarray
    traces: Mapping[int, np.ndarray]

    @property
    def start(self) -> float:
        return float(self.times[0])

    @property
    def end(self) -> float:
        return float(self.times[-1])


def scene(result: Result) -> Scene:
    """Raises SpecError if the problem has no drawing, or the result no finite values to draw."""
    drawings = drawings_of(result.stated()[0])
    if {phase.name for phase in result.phases} - drawings.keys():
        what = "its phases are not those of the problem that it holds"
        raise SpecError(Mistake(str(result.path), what, "solve the problem again"))
    parameters = result.phases[0].parameters  # static ones; other numbers are those of the phase that is drawn

    def at(times: np.ndarray) -> list[Pose]:
        poses = []
        for t, phase in zip(times, _owners(result, times), strict=True):
            drawn = drawings[phase.name]({**parameters, "t": float(t), **_values(phase, float(t))})
            poses.append(Pose(float(t), drawn))
        return poses

    times = np.linspace(result.phases[0].knots[0], result.phases[-1].knots[-1], TRACE_POINTS)
    curves = [own.dense for phase in result.phases for kind in SHOWN for own in phase.curves.get(kind, {}).values()]
    if not all(np.isfinite(dense).all() for dense in curves):
        raise SpecError(Mistake(str(result.path), "the trajectory is not finite", "look at it with 'trajopt show'"))
    poses = at(times)
    places = np.concatenate([corners(shape) for pose in poses for shape in pose.shapes])
    if not np.isfinite(places).any(axis=0).all():
        raise SpecError(Mistake(str(result.path), "its drawing has no finite place", "look at drawing: in its file"))
    traces = {
        i: np.array([_middle(pose.shapes[i]) for pose in poses])
        for i in range(len(poses[0].shapes))
        if any(getattr(pose.shapes[i], "trace", "") for pose in poses)
    }
    return Scene(result, at, times, np.array([np.nanmin(places, axis=0), np.nanmax(places, axis=0)]), traces)


def _middle(shape: Shape) -> tuple[float, float]:
    """Where a shape leaves its trace; nowhere for one that has no middle."""
    return shape.centre if isinstance(shape, Circle | Rectangle) else (np.nan, np.nan)


def _owners(result: Result, times: np.ndarray) -> Iterator[PhaseCurves]:
    """The phase that each time belongs to."""
    ends = [phase.knots[-1] for phase in result.phases[:-1]]
    return (result.phases[number] for number in np.searchsorted(ends, times, side="right"))


def _values(phase: PhaseCurves, t: float) -> dict[str, float]:
    """States, controls and algebraic variables at a time."""
    at = np.array([t])
    return {name: float(row[0]) for kind in SHOWN for name, row in phase.values(kind, at).items()}


def corners(shape: Shape) -> np.ndarray:
    """Points (K, 2) whose hull holds the shape; of the ground, which has no ends, the height alone."""
    match shape:
        case Polyline(points=points):
            return np.array(points)
        case Rectangle(centre=centre, width=width, height=height, angle=angle):
            half = 0.5 * np.array([[-width, -height], [width, -height], [width, height], [-width, height]])
            turned = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
            return np.array(centre) + half @ turned
        case Circle(centre=centre, radius=radius):
            return np.array(centre) + radius * np.array([[-1.0, -1.0], [1.0, 1.0]])
        case Ground(height=height):
            return np.array([[np.nan, height]])


def stop_action(ax: Axes, result: Result, n_frames: int = 9, *, spread: float = 0.0, by_part: bool = False) -> None:
    """Draw poses uniform in time, coloured by time from dark to light, and the path of what leaves one (Figure 9).

    ax: the axes to draw on; their limits are set.
    result: of a problem that has a drawing.
    n_frames: the number of poses.
    spread: metres by which each pose stands to the right of the one before; then no paths are drawn.
    by_part: shapes keep their colours, which tell parts of a body apart; earlier poses are paler (Figure 13).

    Raises SpecError as `scene` does.
    """
    stage = scene(result)
    poses = stage.at(np.linspace(stage.start, stage.end, n_frames))
    for trace in stage.traces.values() if not spread else ():
        ax.plot(*trace.T, color=GREY, linewidth=0.9, zorder=1)
    moving = [
        any(repr(a) != repr(b) for b in others) for a, *others in zip(*(pose.shapes for pose in poses), strict=True)
    ]
    for shape in (s for s, moves in zip(poses[0].shapes, moving, strict=True) if not moves):
        paint(ax, shape)
    for k, pose in enumerate(poses):
        progress = k / max(n_frames - 1, 1)
        colour = None if by_part else colormaps[TIME_COLOURS](0.93 * progress)
        for shape in (s for s, moves in zip(pose.shapes, moving, strict=True) if moves):
            paint(ax, shape, colour, fade=0.65 * (1 - progress) if by_part else 0.0, shift=k * spread, layer=2 + k)
    _set_view(ax, stage.box + np.array([[0.0, 0.0], [(n_frames - 1) * spread, 0.0]]))


def paint(
    ax: Axes, shape: Shape, colour: Any = None, *, fade: float = 0.0, shift: float = 0.0, layer: float = 2
) -> Artist:
    """Draw one shape of a pose.

    ax: the axes to draw on.
    shape: its lengths are metres.
    colour: any of Matplotlib's; None for that of the shape's role.
    fade: 0 to 1, how much nearer white it is than the colour.
    shift: metres to the right.
    layer: what has a larger one lies above.

    A level ground is not faded, stays in its place and lies below all.
    """
    if colour is None:
        colour = COLOURS[shape.colour] if shape.colour else PARTS[shape.role]
    style: dict[str, Any] = {"alpha": 1 - fade, "zorder": layer}
    match shape:
        case Polyline(points=points, dashed=dashed):
            x, y = np.array(points).T
            line: dict[str, Any] = {
                "linewidth": 2.4,
                "marker": "" if shape.role == "obstacle" else "o",
                "markersize": 3.5,
                "solid_capstyle": "round",
                "linestyle": "--" if dashed else "-",
            }
            return ax.plot(x + shift, y, color=colour, **line, **style)[0]
        case Rectangle(centre=(x, y), width=w, height=h, angle=angle):
            corner, turned = (x + shift - w / 2, y - h / 2), {"angle": np.degrees(angle), "rotation_point": "center"}
            style |= turned
            return ax.add_patch(patches.Rectangle(corner, w, h, facecolor=colour, edgecolor=BLACK, lw=0.6, **style))
        case Circle(centre=(x, y), radius=radius) if radius == 0:
            return ax.plot([x + shift], [y], "o", color=colour, markersize=5, **style)[0]
        case Circle(centre=(x, y), radius=radius):
            return ax.add_patch(patches.Circle((x + shift, y), radius, facecolor=colour, edgecolor="none", **style))
        case Ground(height=height):
            return ax.axhline(height, color=colour, linewidth=1.6, zorder=0.5)


def _set_view(ax: Axes, box: np.ndarray) -> None:
    """The box and a margin around it, the same scale on both axes."""
    low, high = box
    margin = MARGIN * (high - low).max() or 0.5
    ax.set_xlim(low[0] - margin, high[0] + margin)
    ax.set_ylim(low[1] - margin, high[1] + margin)
    ax.set_aspect("equal")
    ax.grid(False)
    ax.set_xlabel(labelled("x", "m"))
    ax.set_ylabel(labelled("y", "m"))


def _canvas(stage: Scene, title: str) -> tuple[Figure, Axes]:
    """A figure whose panel has the shape of the scene."""
    low, high = stage.box
    sides = high - low + (2 * MARGIN * (high - low).max() or 1.0)
    width, height = np.maximum(sides * (LARGEST / sides).min(), SMALLEST)
    figure, grid = Frame(top=0.65, bottom=0.6).figure([float(height)], 1, float(width))
    letters = int(figure.get_figwidth() / (1.15 * LETTER))
    lines = [plain_label(title, letters)]
    if not stage.result.solved:
        lines.append(plain_label(f"NOT SOLVED: {stage.result.message}", letters))
    head(figure, lines, BLACK if stage.result.solved else VERMILION)
    return figure, figure.add_subplot(grid[0, 0])


def stop_action_figure(result: Result, n_frames: int) -> Figure:
    """A whole figure of `stop_action`. Raises SpecError as `scene` does."""
    with look():
        stage = scene(result)
        shapes = stage.at(stage.times[:1])[0].shapes
        by_part = len({shape.colour for shape in shapes if isinstance(shape, Polyline) and shape.colour}) > 1
        shades = ("pale", "full") if by_part else ("dark", "light")
        times = f"{stage.start:.4g} ({shades[0]}) to {stage.end:.4g} {result.phases[0].time_unit} ({shades[1]})"
        title = f"{result.problem}: {n_frames} poses, t = {times}"
        figure, ax = _canvas(stage, title)
        stop_action(ax, result, n_frames, by_part=by_part)
    return figure


def animate(result: Result, path: Path, frames: int, fps: int) -> None:
    """Write a film to a .gif or .mp4.

    result: of a problem that has a drawing.
    path: of the film; its suffix says the format.
    frames: the number of pictures, uniform in time.
    fps: pictures a second.

    Raises SpecError as `scene` does, or for a .mp4 where there is no ffmpeg; FileError if it cannot be written.
    """
    with look():
        stage = scene(result)
        figure, ax = _canvas(stage, result.problem)
        figure.set_dpi(FILM_DPI)
        with replacing(path) as temporary:
            write_film(temporary, path.suffix.lower(), _film(stage, figure, ax, frames), fps, mark(result.problem))


def _film(stage: Scene, figure: Figure, ax: Axes, frames: int) -> Iterator[Image.Image]:
    """The pictures one after the other; the axes are drawn once, and over them what moves."""
    canvas: Any = FigureCanvasAgg(figure)
    unit = plain_label(stage.result.phases[0].time_unit, 20)
    _set_view(ax, stage.box)
    canvas.draw()
    background = canvas.copy_from_bbox(figure.bbox)
    clock = ax.text(1, 1.02, "", transform=ax.transAxes, ha="right", va="bottom")
    lines = {i: ax.plot([], [], color=GREY, linewidth=0.9, zorder=1)[0] for i in stage.traces}
    for pose in stage.at(np.linspace(stage.start, stage.end, frames)):
        past = stage.times <= pose.t
        for i, line in lines.items():
            whole = getattr(pose.shapes[i], "trace", "") == WHOLE
            line.set_data(*stage.traces[i][slice(None) if whole else past].T)
        clock.set_text(f"t = {pose.t:.2f} {unit}")
        shapes = [paint(ax, shape) for shape in pose.shapes]
        canvas.restore_region(background)
        for artist in sorted([clock, *lines.values(), *shapes], key=lambda artist: artist.get_zorder()):
            ax.draw_artist(artist)
        yield Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy())
        for artist in shapes:
            artist.remove()
