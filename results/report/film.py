"""How the system moves, as plain data that `assets/film.js` draws: the shapes of the problem's own drawing."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...problems.errors import SpecError
from ...problems.models.drawings import Circle, Ground, Polyline, Rectangle, Shape
from ..file.read import Result

FRAMES = 120
DIGITS = 5


def film(result: Result) -> dict[str, Any] | None:
    """{unit, box, times, frames: the shapes of each, traces}; None for a problem that has no drawing."""
    from ..pictures.animate import scene

    try:
        stage = scene(result)
    except SpecError:
        return None
    times = np.linspace(stage.start, stage.end, FRAMES)
    return {
        "unit": result.phases[0].time_unit,
        "box": stage.box.tolist(),
        "times": times.tolist(),
        "frames": [[_plain(shape) for shape in pose.shapes] for pose in stage.at(times)],
        "traces": [_rounded(trace) for trace in stage.traces.values()],
    }


def _rounded(points: Any) -> list[list[float]]:
    return [[float(f"{x:.{DIGITS}g}") for x in point] for point in np.asarray(points).tolist()]


def _plain(shape: Shape) -> dict[str, Any]:
    match shape:
        case Polyline(role=role, points=points):
            return {"kind": "line", "role": role, "points": _rounded(points)}
        case Rectangle(role=role, centre=centre, width=width, height=height):
            return {"kind": "box", "role": role, "centre": list(centre), "size": [width, height]}
        case Circle(role=role, centre=centre, radius=radius):
            return {"kind": "disc", "role": role, "centre": list(centre), "radius": radius}
        case Ground(height=height, role=role):
            return {"kind": "ground", "role": role, "height": height}
