"""One line of the verdict of `verify`."""

from __future__ import annotations

from ...problems.lean.records import dataclass
from ...transcription.solution.trajectory import Trajectory

ENGINE = 10.0
"""Times the engine's tolerance, relative to 1 + |J|: what a solved program may be off by."""


@dataclass(frozen=True)
class Check:
    """One line of the verdict: a measure, relative where the name says so, and the largest value that passes."""

    name: str
    value: float
    limit: float
    where: str = ""

    @property
    def passed(self) -> bool:
        return bool(self.value <= self.limit)  # False for NaN


def at(trajectory: Trajectory, t: float) -> str:
    """A time of a trajectory, for people to read."""
    return f"t = {trajectory.told(t):.4g}"
