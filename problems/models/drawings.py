"""What the shipped problems look like: geometry in metres, nothing of colours or of a plotting library.

A drawing maps the values of the states and controls at one time, and the parameters of the problem, to shapes. x points
to the right and y upwards. Each shape has a role, by which whoever paints it chooses its colour.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from math import cos, sin
from typing import Any

from ..errors import Mistake, SpecError
from . import find_model

Point = tuple[float, float]


@dataclass(frozen=True)
class Polyline:
    """Straight lines from point to point."""

    role: str
    points: Sequence[Point]


@dataclass(frozen=True)
class Rectangle:
    """An upright rectangle."""

    role: str
    centre: Point
    width: float
    height: float


@dataclass(frozen=True)
class Circle:
    """A disc. Its centre may leave a trace: "path", what it has passed so far, or "wire", there from the start."""

    role: str
    centre: Point
    radius: float
    trace: str = ""


@dataclass(frozen=True)
class Ground:
    """A level line that goes on beyond the picture."""

    height: float
    role: str = "ground"


Shape = Polyline | Rectangle | Circle | Ground
Drawing = Callable[[Mapping[str, float], Mapping[str, float]], list[Shape]]

CART = (0.15, 0.05)  # m, width and height, as in the paper's Figure 9
BLOCK = 0.1  # m


def cart_pole(values: Mapping[str, float], parameters: Mapping[str, float]) -> list[Shape]:
    """A cart at q1 on a track; a pole of length l, whose angle q2 is zero when it hangs down."""
    x, angle, l = values["q1"], values["q2"], parameters["l"]  # noqa: E741
    tip = (x + l * sin(angle), -l * cos(angle))
    return [
        Ground(-CART[1] / 2),
        Rectangle("cart", (x, 0.0), *CART),
        Polyline("pole", [(x, 0.0), tip]),
        Circle("tip", tip, 0.03 * l, trace="path"),
    ]


def pendulum(values: Mapping[str, float], parameters: Mapping[str, float]) -> list[Shape]:
    """A bob at distance l or r from a fixed pivot; the angle is zero when it hangs down, counter-clockwise positive."""
    angle = next(values[name] for name in _ANGLES if name in values)
    length = next(parameters[name] for name in _LENGTHS if name in parameters)
    bob = (length * sin(angle), -length * cos(angle))
    return [
        Polyline("pole", [(0.0, 0.0), bob]),
        Circle("pivot", (0.0, 0.0), 0.02 * length),
        Circle("tip", bob, 0.06 * length, trace="path"),
    ]


def block(values: Mapping[str, float], parameters: Mapping[str, float]) -> list[Shape]:
    """A block whose middle is at x, on level ground."""
    return [Ground(0.0), Rectangle("block", (values["x"], BLOCK / 2), BLOCK, BLOCK)]


def brachistochrone(values: Mapping[str, float], parameters: Mapping[str, float]) -> list[Shape]:
    """A bead at (x, y) on the wire that it runs along."""
    return [Circle("bead", (values["x"], values["y"]), 0.2, trace="wire")]


def shot_put(values: Mapping[str, float], parameters: Mapping[str, float]) -> list[Shape]:
    """A ball at (x, y), thrown from height h."""
    return [
        Ground(0.0),
        Polyline("post", [(0.0, 0.0), (0.0, parameters["h"])]),
        Circle("ball", (values["x"], values["y"]), 0.15, trace="path"),
    ]


def five_link_biped(values: Mapping[str, float], parameters: Mapping[str, float]) -> list[Shape]:
    """Two legs and a torso; the stance foot is at the origin, and the swing foot leaves its path."""
    pose = find_model("five_link_biped").pose
    assert pose is not None
    parts = pose(values, parameters)
    lines = [Polyline(part, [(float(x), float(y)) for x, y in joints]) for part, joints in parts.items()]
    foot = next(line for line in lines if line.role == "swing leg").points[-1]
    return [Ground(0.0), *lines, Circle("swing foot", foot, 0.012, trace="path")]


DRAWINGS: dict[str, Drawing] = {
    "cart_pole": cart_pole,
    "pendulum": pendulum,
    "block": block,
    "brachistochrone": brachistochrone,
    "shot_put": shot_put,
    "five_link_biped": five_link_biped,
}

_ANGLES, _LENGTHS = ("theta", "q", "phi", "x"), ("l", "r")
_LINKS = range(1, 6)
_NAMES = {  # drawing -> the names of all states, and some of the parameters that it needs
    "cart_pole": ({"q1", "q2", "v1", "v2"}, {"l"}),
    "block": ({"x", "v"}, set()),
    "brachistochrone": ({"x", "y", "v"}, set()),
    "shot_put": ({"x", "y", "vx", "vy"}, {"h"}),
    "five_link_biped": ({f"{q}{i}" for q in ("q", "dq") for i in _LINKS}, {f"l{i}" for i in _LINKS}),
}


def drawing_of(spec: Mapping[str, Any], states: Collection[str]) -> Drawing:
    """The drawing of a problem: that of its model, or the one for states and parameters of these names.

    spec: the full problem file as plain data. Raises SpecError if there is none.
    """
    model = spec.get("model")
    name = model if model in DRAWINGS else _by_names(set(states), set(spec.get("parameters", {})))
    if name is None:
        known = "the drawings are " + ", ".join(DRAWINGS)
        raise SpecError(Mistake(spec.get("name", ""), "this problem has no drawing to animate", known))
    return DRAWINGS[name]


def _by_names(states: set[str], parameters: set[str]) -> str | None:
    for name, (wanted, needed) in _NAMES.items():
        if states == wanted and needed <= parameters:
            return name
    angle, length = _first(_ANGLES, states), _first(_LENGTHS, parameters)
    return "pendulum" if angle and length and len(states) == 2 else None


def _first(wanted: Sequence[str], names: Collection[str]) -> str | None:
    return next((name for name in wanted if name in names), None)
