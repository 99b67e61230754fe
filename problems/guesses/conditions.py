"""What conditions on one value at an end say of it: x[final] == 2, a.x[final] - 1.5 <= 0, x[final] == x[initial].

To the solver they are constraints as others are. A guess takes them for what the file could have written at the state.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from ..probe import names_asked
from ..quantities import Constraint, Function, Range, State

ENDS = "initial", "final"

PLACES = np.array([0.0, 1.0, 3.0])
EXACT = 1e-12
"""Of its values: a function that misses the straight line through two of them by more is none."""


def conditioned(constraints: Iterable[Constraint], known: Mapping[str, float]) -> dict[str, Range]:
    """Name of a value at an end, as functions ask for it -> what the constraints that ask for it alone leave of it.

    constraints: on values at the ends. Those that contradict each other say nothing.
    known: name -> value of what they may ask for besides, such as the guess of an angle: vx[initial] == v*cos(angle).
    """
    found: dict[str, Range] = {}
    for own in constraints:
        asked = names_asked(own.function) - known.keys()
        if len(asked) != 1:
            continue
        (name,) = asked
        if range_ := _of_value(own.function, own.bounds, name, known):
            found[name] = found.get(name, Range()).intersection(range_)
    return {name: own for name, own in found.items() if own.lower <= own.upper}


def known_ends(states: Iterable[State]) -> dict[str, float]:
    """Name of a value at an end, as functions ask for it -> the value that is given there.

    states: with their ranges at both ends.
    """
    ends = (
        (f"{state.name}[{end}]", own)
        for state in states
        for end, own in zip(ENDS, (state.initial, state.final), strict=True)
    )
    return {name: own.lower for name, own in ends if own.fixed}


def _of_value(function: Function, bounds: Range, name: str, known: Mapping[str, float]) -> Range | None:
    """The range of a value of which a function is linear; None if it is not."""
    with np.errstate(all="ignore"):
        offset, once, thrice = np.broadcast_to(function({**known, name: PLACES}, np), PLACES.shape).tolist()
        slope = once - offset
        line = offset + 3 * slope
    if not np.isfinite(line) or slope == 0 or abs(thrice - line) > EXACT * (abs(offset) + abs(thrice)):
        return None
    lower, upper = sorted(((bounds.lower - offset) / slope, (bounds.upper - offset) / slope))
    return Range(lower + 0.0, upper + 0.0)
