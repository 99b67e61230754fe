"""Refinement for the objective: the error bar, shared out among the segments, in place of their eta.

Of the bar each of N segments may have the N-th part. What a segment adds to the bar falls as a higher power of its
width than eta does (the bar is a residual times the error of a costate), so that fewer are split than for eta.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.text import short_repr
from ..solution.error import ErrorProfile
from ..solution.objective_error import ObjectiveError
from ..solution.solution import Solution


@short_repr
@dataclass(frozen=True)
class Goal:
    """An error bar that is asked for, relative to 1 + |J|, and what a solution has of it."""

    tolerance: float
    solution: Solution

    @property
    def error(self) -> ObjectiveError:
        return self.solution.objective_error

    @property
    def size(self) -> float:
        return 1 + abs(self.solution.objective)

    @property
    def reached(self) -> bool:
        return self.error.applies and self.error.bar <= self.tolerance * self.size

    @property
    def errors(self) -> list[ErrorProfile]:
        """For each phase the error whose `relative` is N times the share of each segment, relative to 1 + |J|.

        Without a bar it is the error of the segments as it is. What is exceeded counts in the bar already,
        and what a segment is worth is no other error.
        """
        if not self.error.applies:
            return list(self.solution.errors)
        count = sum(len(shares) for shares in self.error.shares)
        return [
            replace(error, relative=np.abs(shares) * count / self.size, excess={}, worth=np.zeros(len(shares)))
            for error, shares in zip(self.solution.errors, self.error.shares, strict=True)
        ]

    @property
    def missed(self) -> str:
        """What is missing of the goal, or "" if it is reached."""
        if self.reached:
            return ""
        if not self.error.applies:
            return f"there is no error bar: {self.error.why_not}"
        return f"the error bar {self.error.bar:.1e} is above the {self.tolerance * self.size:.1e} asked for"

    @property
    def beyond_engine(self) -> str:
        """Why no finer mesh would help where the bar is what the engine's barrier leaves, once that is as small as the
        engine can have it; "" elsewhere, and if the goal is reached.
        """
        if self.reached or not self.error.applies or self.error.gap <= self.error.bar:
            return ""
        return f"{self.missed}: it is what the engine's barrier leaves at the bounds, and a finer mesh has more of them"

    @property
    def unreachable(self) -> str:
        """Why no finer mesh would help, or "" if the goal is reached."""
        more = ", and no finer mesh mends that: lower the tolerance of the engine (--tol)"
        return self.missed + more if self.missed and self.error.applies else self.missed
