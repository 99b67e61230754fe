"""A violated constraint, and how messages call constraints and times."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...problems.lean.records import dataclass
from ..constraint_kinds import ConstraintKind
from ..layout import BETWEEN
from .trajectory import Trajectory


@dataclass(frozen=True)
class Violation:
    """A constraint that an iterate violates by `amount`, between the times `start` and `end`."""

    phase: str
    kind: ConstraintKind
    name: str
    start: float
    end: float
    amount: float

    def __str__(self) -> str:
        when = when_between(self.start, self.end) if self.kind.timed else ""
        return f"{constraint_named(self.phase, self.kind, self.name)}{when} missed by {self.amount:.2e}"


class Trouble(NamedTuple):
    """What explains a failed solve: words, with {} where the names of all that is involved belong, and these."""

    words: str = ""
    involved: tuple[str, ...] = ()

    def __str__(self) -> str:
        return self.words.replace("{}", ", ".join(self.involved)) if self.involved else self.words


def times_at(trajectory: Trajectory, s: np.ndarray) -> list[float]:
    """The times at normalised times s of a phase, shape (K,), as words tell them."""
    return [trajectory.told(t) for t in trajectory.t[0] + (trajectory.t[1] - trajectory.t[0]) * s]


def when_between(start: float, end: float) -> str:
    return f" at t = {start:.6g}" if start == end else f" between t = {start:.6g} and {end:.6g}"


def constraint_named(phase: str, kind: ConstraintKind, name: str) -> str:
    """A constraint by its name; the phase is told where the file has phases.

    phase: its name.
    kind: of the constraint.
    name: of the constraint, or of the state it is about.
    """
    return kind.phrase.format(name) + of_phase(phase)


def of_phase(phase: str) -> str:
    """The phase as messages tell it: not at all where there is one only, or where a link belongs to several."""
    return "" if phase in ("main", BETWEEN) else f" of phase {phase}"
