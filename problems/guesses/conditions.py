"""What conditions on one value at an end say of it: x[final] == 2, a.x[final] - 1.5 <= 0.

To the solver they are constraints as others are. A guess takes them for what the file could have written at the state.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..probe import names_asked
from ..quantities import Constraint, Function, Range

PLACES = np.array([0.0, 1.0, 3.0])
EXACT = 1e-12
"""Of its values: a function that misses the straight line through two of them by more is none."""


def conditioned(constraints: Iterable[Constraint]) -> dict[str, Range]:
    """Name of a value at an end, as functions ask for it -> what the constraints that ask for it alone leave of it.

    constraints: on values at the ends. Those that contradict each other say nothing.
    """
    found: dict[str, Range] = {}
    for own in constraints:
        asked = names_asked(own.function)
        if len(asked) == 1 and (range_ := _of_value(own.function, own.bounds, *asked)):
            name = asked.pop()
            found[name] = found.get(name, Range()).intersection(range_)
    return {name: own for name, own in found.items() if own.lower <= own.upper}


def _of_value(function: Function, bounds: Range, name: str) -> Range | None:
    """The range of a value of which a function is linear; None if it is not."""
    with np.errstate(all="ignore"):
        offset, once, thrice = np.broadcast_to(function({name: PLACES}, np), PLACES.shape).tolist()
        slope = once - offset
        line = offset + 3 * slope
    if not np.isfinite(line) or slope == 0 or abs(thrice - line) > EXACT * (abs(offset) + abs(thrice)):
        return None
    lower, upper = sorted(((bounds.lower - offset) / slope, (bounds.upper - offset) / slope))
    return Range(lower + 0.0, upper + 0.0)
