"""The drawing of a problem: the section `drawing:` of its file."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from ..errors import Mistake, SpecError
from ..expressions.expression import Expression
from ..names.symbols import Symbols
from ..phases.merge import phase_specs
from ..quantities import Function
from ..schema.drawing import WHOLE as WHOLE_TRAIL
from ..schema.drawing import ShapeEntry
from ..schema.spec import Spec
from .shapes import SO_FAR, WHOLE, Circle, Drawing, Ground, Point, Polyline, Rectangle, Shape

ROLES = {"line": "pole", "point": "tip", "circle": "tip", "box": "cart", "ground": "ground", "": "pole"}
OBSTACLE = "obstacle"
NOWHERE = (np.nan, np.nan)


def drawings_of(spec: Spec) -> dict[str, Drawing]:
    """The drawing of each phase, by its name; all have the same number of shapes.

    spec: of a file. Raises SpecError if it has no drawing.
    """
    phases = phase_specs(spec)
    if spec.drawing:
        return {name: _of_file(phase) for name, phase in phases.items()}
    states = [*spec.states, "x", "y"][:2]
    shape = f"drawing: [{{circle: [{', '.join(states)}], radius: 0.1, trail: true}}]"
    what = "this problem has no drawing to animate"
    raise SpecError(Mistake(spec.name, what, f"add one to its file and solve it again: {shape}"))


def obstacles_of(spec: Spec) -> list[Shape]:
    """The obstacles that stand still, as the first phase has them; none without a drawing."""
    phase = next(iter(phase_specs(spec).values()))
    symbols = Symbols(phase)
    fixed = [entry for entry in phase.drawing if entry.obstacle and _stands_still(entry, symbols)]
    return [_shape(entry, _Values(symbols.function, {})) for entry in fixed]


def _of_file(phase: Spec) -> Drawing:
    function = cache(Symbols(phase).function)  # a film asks for the same ones in every picture

    def drawing(values: Mapping[str, Any]) -> list[Shape]:
        numbers = _Values(function, values)
        return [_shape(entry, numbers) for entry in phase.drawing]

    return drawing


def _stands_still(entry: ShapeEntry, symbols: Symbols) -> bool:
    parts = [entry.radius, entry.width, entry.height, entry.angle, entry.ground]
    parts += [*(entry.circle or ()), *(entry.box or ()), *(entry.point or ())]
    parts += [part for corner in entry.line or () for part in corner]
    return not any(symbols.function(part).names for part in parts if part is not None)


class _Values:
    """The numbers of expressions at one time."""

    def __init__(self, function: Callable[[Expression], Function], values: Mapping[str, Any]):
        self.function, self.values = function, values

    def __call__(self, expression: Expression | None) -> float:
        """NaN where it has no finite value; 0 for none."""
        if expression is None:
            return 0.0
        with np.errstate(all="ignore"):
            return float(self.function(expression)(self.values, np))

    def pair(self, pair: Sequence[Expression]) -> Point:
        return self(pair[0]), self(pair[1])


def _shape(entry: ShapeEntry, at: _Values) -> Shape:
    """One shape of the file at one time; nowhere, if its phase has none of it."""
    role = OBSTACLE if entry.obstacle else ROLES[entry.kind]
    trace = {True: SO_FAR, WHOLE_TRAIL: WHOLE}.get(entry.trail, "")
    colour = entry.color or ""
    if entry.line is not None:
        return Polyline(role, [at.pair(corner) for corner in entry.line], colour, entry.dashed)
    if entry.ground is not None:
        return Ground(at(entry.ground), role, colour)
    if entry.box is not None:
        return Rectangle(role, at.pair(entry.box), at(entry.width), at(entry.height), at(entry.angle), trace, colour)
    middle = entry.circle or entry.point
    return Circle(role, at.pair(middle) if middle else NOWHERE, at(entry.radius), trace, colour)
