"""The drawing of a chain: its links, its cart, the ground, and the path of its last tip."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..schema.model import CART
from .bodies import Body
from .motion import ACROSS, CART_NAME, UP, Chain
from .step import Stride


def drawing(chain: Chain) -> Iterator[dict[str, Any]]:
    """The links as lines from joint to tip, a cart as a box, the ground of a walker, and the path of the last tip.

    A walker's legs have colours of their own, and the one that stands is dashed, as in Kelly 2017, Figure 13.
    """
    legs = chain.entry.step and Stride(chain, chain.entry.step)
    first, last = chain.bodies[0].constant("length"), chain.bodies[-1]
    if chain.entry.base == CART:
        yield {"ground": f"-{first}/20"}
        yield {"box": [ACROSS, 0], "width": f"0.3*{first}", "height": f"{first}/10", "name": CART_NAME}
    if chain.entry.step:
        yield {"ground": 0}
    for body in chain.bodies:
        ends = [[chain.position(point, axis) for axis in (ACROSS, UP)] for point in (body.along("0"), body.tip)]
        yield {"line": ends, "name": body.name, **(_look_of(legs, body) if legs else {})}
    tip = [f"{last.name}_{axis}" for axis in (ACROSS, UP)]
    own = {"circle": tip, "radius": f"{last.constant('length')}/20", "trail": True, "name": f"tip of {last.name}"}
    yield {**own, "color": _look_of(legs, last)["color"]} if legs else own


def _look_of(legs: Stride, body: Body) -> dict[str, Any]:
    """Colour and dashes of a link of a walker; of two links that change roles, the one nearer to the base stands."""
    before = legs.before[body.number]
    if before == body.number:
        return {"color": "purple"}
    return {"color": "vermilion", "dashed": True} if body.number < before else {"color": "blue"}
