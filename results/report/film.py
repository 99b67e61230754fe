"""How the system moves, as plain data that `assets/film.js` draws: the shapes of the problem's own drawing."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...problems.drawings.shapes import Circle, Ground, Polyline, Rectangle, Shape
from ...problems.errors import SpecError
from ..file.read import Result

FRAMES = 120
DIGITS = 5
MARK = 0.01  # radius of a point, part of the longer side of the picture


def film(result: Result) -> dict[str, Any] | None:
    """{unit, box, times, frames: the shapes of each, traces}; None for a problem that has no drawing."""
    from ..pictures.animate import corners, scene

    try:
        stage = scene(result)
    except SpecError:
        return None
    mark = MARK * float(np.ptp(stage.box, axis=0).max())
    times = np.linspace(stage.start, stage.end, FRAMES)
    return {
        "unit": result.phases[0].time_unit,
        "box": stage.box.tolist(),
        "times": times.tolist(),
        "frames": [
            [_plain(shape, mark) for shape in pose.shapes if np.isfinite(corners(shape)).any(axis=0)[1]]
            for pose in stage.at(times)
        ],
        "traces": [_rounded(trace[np.isfinite(trace).all(axis=1)]) for trace in stage.traces.values()],
    }


def _rounded(points: Any) -> list[list[float]]:
    return [[float(f"{x:.{DIGITS}g}") for x in point] for point in np.asarray(points).tolist()]


def _plain(shape: Shape, mark: float) -> dict[str, Any]:
    """A shape as JSON; mark: the radius of a disc that has none."""
    look = {"colour": shape.colour or shape.role}
    match shape:
        case Polyline(points=points, dashed=dashed):
            return {"kind": "line", "points": _rounded(points), "dashed": dashed, **look}
        case Rectangle(angle=angle) if angle:
            from ..pictures.animate import corners

            outline = corners(shape)
            return {"kind": "line", "points": _rounded([*outline, outline[0]]), "dashed": False, **look}
        case Rectangle(centre=centre, width=width, height=height):
            return {"kind": "box", "centre": list(centre), "size": [width, height], **look}
        case Circle(centre=centre, radius=radius):
            return {"kind": "disc", "centre": list(centre), "radius": radius or mark, **look}
        case Ground(height=height):
            return {"kind": "ground", "height": height, **look}
