"""The arcs of a solution, as data: when each bounded control, state and path constraint is on which bound."""

from __future__ import annotations

from math import nan

from ..problems.lean.records import dataclass
from ..problems.quantities import Range

LOWER, INSIDE, UPPER = "lower", "inside", "upper"
"""Where something is, on an arc."""

CONTROL, STATE, PATH = "control", "state", "path"
"""What has arcs."""

SINGULAR, HELD = "singular", "held by "
"""What determines a control inside its bounds: H is linear in it, or it keeps something else, named after HELD, on a
bound. "" where it is neither."""


CLOSE = 0.05
"""Of an arc: what happens nearer to its end, happens there."""


@dataclass(frozen=True)
class Arc:
    """From start to end, in the unit of time: LOWER, INSIDE or UPPER. by: as above, of a control that is INSIDE.

    One that has no duration is a point at which a bound is touched.
    """

    start: float
    end: float
    on: str
    by: str = ""


@dataclass(frozen=True)
class Course:
    """The arcs of one quantity, one after the other. kind: CONTROL, STATE or PATH. bounds: infinite where none is."""

    name: str
    kind: str
    bounds: Range
    arcs: tuple[Arc, ...]

    def bound(self, arc: Arc) -> float:
        """The bound that it is on, on an arc; NaN inside of both."""
        return {LOWER: self.bounds.lower, UPPER: self.bounds.upper}.get(arc.on, nan)

    def at(self, t: float) -> Arc:
        """The arc of a time."""
        return next((arc for arc in self.arcs if t <= arc.end and arc.end > arc.start), self.arcs[-1])
