"""Shapes: x points to the right and y upwards. Each has a role, by which whoever paints it chooses how it looks."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..lean.records import dataclass

Point = tuple[float, float]

SO_FAR, WHOLE = "path", "wire"
"""The traces that a middle may leave: what it has passed so far, or all of it from the start."""


@dataclass(frozen=True)
class Polyline:
    """Straight lines from point to point."""

    role: str
    points: Sequence[Point]
    colour: str = ""
    dashed: bool = False


@dataclass(frozen=True)
class Rectangle:
    """A rectangle, turned counter-clockwise by an angle in radians."""

    role: str
    centre: Point
    width: float
    height: float
    angle: float = 0.0
    trace: str = ""
    colour: str = ""


@dataclass(frozen=True)
class Circle:
    """A disc; of radius zero a mark of a fixed size."""

    role: str
    centre: Point
    radius: float
    trace: str = ""
    colour: str = ""


@dataclass(frozen=True)
class Ground:
    """A level line that goes on beyond the picture."""

    height: float
    role: str = "ground"
    colour: str = ""


Shape = Polyline | Rectangle | Circle | Ground
Drawing = Callable[[Mapping[str, Any]], list[Shape]]
"""The values of t, states, controls, algebraic variables and parameters at one time -> shapes."""
