r"""Closed loops of a chain: two points that are pinned together, by a force that is whatever holds them there.

    G(q) = p - r = 0        for the point p of a link, and r of another link or of the base

is a constraint of index 3. It is differentiated twice: G = 0 and G' = 0 hold at the initial time, and

    G'' = 0                 over time, which determines the force (lambda_x, lambda_y) on p, and its opposite on r

together with the accelerations, as residuals. The links are those of the tree; their ends of time are constrained as
many times as the mechanism can move. What G is at other times is the error of the dynamics, which refinement holds.
"""

from __future__ import annotations

from ..expressions.expression import parse
from ..lean.records import dataclass
from ..schema.model import BASE, ForceEntry, LoopEntry, ModelEntry
from .angles import negated, summed
from .bodies import Reach
from .motion import ACROSS, UP, Chain

AXES = (ACROSS, UP)


@dataclass(frozen=True)
class Closed:
    """One loop of a chain; number: from 1."""

    chain: Chain
    entry: LoopEntry
    number: int

    @property
    def ends(self) -> list[tuple[str, Reach]]:
        """The links that are pinned together, and where; of the base none."""
        return [
            (name, self._point(name, key))
            for name, key in ((self.entry.link, "at"), (self.entry.to, "to_at"))
            if name != BASE
        ]

    def _point(self, link: str, key: str) -> Reach:
        body = self.chain.bodies[self.chain.number_of(link)]
        return body.along(self.constant(key) if getattr(self.entry, key) else body.constant("length"))

    def constant(self, key: str) -> str:
        """The name of one of its numbers: "loop1_at"."""
        return f"{name_of_loop(self.number)}_{key}"

    def force(self, axis: str) -> str:
        """The name of the force on its first link."""
        return self.constant(f"f{axis}")

    def gap(self, axis: str) -> str:
        """G, m."""
        return self._difference([self.chain.position(point, axis) for _, point in self.ends], self._of_base(axis))

    def closing(self, axis: str) -> str:
        """G', m/s."""
        return self._difference([self.chain.velocity(point, axis) for _, point in self.ends])

    def residual(self, axis: str) -> str:
        """G'', m/s^2."""
        return self._difference([self.chain.acceleration(point, axis) for _, point in self.ends])

    def _of_base(self, axis: str) -> str:
        place = getattr(self.entry, axis)
        return "" if place is None else self.constant(axis)

    @staticmethod
    def _difference(ends: list[str], of_base: str = "") -> str:
        """The first minus the second, or minus what is of the base."""
        second = f"-({ends[1]})" if len(ends) > 1 else negated(of_base)
        return summed([ends[0], second])


def name_of_loop(number: int) -> str:
    return f"loop{number}"


def forces_of(entry: LoopEntry, number: int = 1) -> list[ForceEntry]:
    """The force that holds a loop together: on its first link, and the opposite on the second.

    entry: of the file.
    number: of the loop, from 1.
    """
    across, up = (f"{name_of_loop(number)}_f{axis}" for axis in AXES)
    first = ForceEntry(link=entry.link, at=entry.at, x=parse(across), y=parse(up))
    if entry.to == BASE:
        return [first]
    return [first, ForceEntry(link=entry.to, at=entry.to_at, x=parse(f"-{across}"), y=parse(f"-{up}"))]


def with_loops(entry: ModelEntry) -> ModelEntry:
    """The chain with the forces of its loops among those from outside, at the end of them."""
    own = [force for number, loop in enumerate(entry.loops, start=1) for force in forces_of(loop, number)]
    return entry.model_copy(update={"forces": [*entry.forces, *own]})
