"""A solved neighbour, the same problem with other numbers on the same mesh -> multipliers to start from.

They also foretell the objective, by the Lagrangian of the new program at the point z of the neighbour,

    L = f(z) + y (g(z) - b) - z_L (z - l) + z_U (z - u)      b: the bound of g that y belongs to,

which differs from the new optimum in the second order of the step between the two. Measured over six problems and 28
steps, multipliers take 0.1 to 0.7 of the iterations where the step is small, and up to 4 times as many where it is not:
where other bounds act than did, or the objective changes by a tenth. So only what is close starts from them, and what
is then worse than foretold by much of the step, maybe another optimum, is solved without them, too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, TypeVar

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.text import short_repr
from ..engines.outcome import Outcome, Start, Status
from ..layout import Transcription
from ..program.contract import NonlinearProgram, NotFinite
from ..solution.solution import Solution

PASSED, CHANGED = 0.01, 0.1
"""A neighbour is close if z passes no new bound by more than that, relative to 1 + its size, and the objective is
foretold to change by no more than that, relative to 1 + |J|."""

LOST, SAME = 0.5, 1e-3
"""Of the foretold change, and relative to 1 + |J|: what may be lost beyond it."""

ITERATIONS = 50
"""At most, from a neighbour: a start that needs more is none."""

Run = Callable[[Mapping[str, object], Start | None], Outcome]
"""An engine that has everything but its options and multipliers."""


@short_repr
@dataclass(frozen=True)
class Near:
    """What the solution of a neighbour leaves beside its trajectories.

    points: of the mesh of each phase, (K,) each, as `Mesh.fractions`. objective: minimised.
    """

    points: tuple[np.ndarray, ...]
    objective: float
    start: Start

    def fits(self, transcription: Transcription, nlp: NonlinearProgram) -> bool:
        """Whether the program has as many rows and unknowns, at the same points."""
        here = [layout.mesh.fractions for layout in transcription.phases]
        sizes = len(self.start.y), len(self.start.z_lower), len(self.start.z_upper)
        alike = len(here) == len(self.points) and all(map(np.array_equal, here, self.points))
        return alike and sizes == (nlp.m, nlp.n, nlp.n)

    def is_like(self, other: Near) -> bool:
        """Whether another one is of the same points, and has as many multipliers."""
        sizes = [[len(own) for own in (near.start.y, near.start.z_lower, near.start.z_upper)] for near in (self, other)]
        alike = len(self.points) == len(other.points) and all(map(np.array_equal, self.points, other.points))
        return alike and sizes[0] == sizes[1]

    def ahead(self, earlier: Near, share: float) -> Near:
        """What the next neighbour may leave: it lies a step on, as long as that from an earlier one, times `share`.

        earlier: one that `is_like` this.
        share: above 0.
        """
        names = ("y", "z_lower", "z_upper")
        y, z_lower, z_upper = (further(getattr(self.start, n), getattr(earlier.start, n), share) for n in names)
        return replace(self, start=Start(y, np.maximum(z_lower, 0.0), np.maximum(z_upper, 0.0)))

    def foretold(self, nlp: NonlinearProgram, z: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> float:
        """The Lagrangian of a program at the neighbour's point; NaN if that is not close.

        nlp: with as many rows and unknowns as the neighbour's.
        z: (n,) the neighbour's point.
        lower, upper: (n,) bounds of the unknowns.
        """
        y, z_lower, z_upper = self.start.y, self.start.z_lower, self.start.z_upper
        try:
            f, g = nlp.objective(z), nlp.constraints(z)
        except NotFinite:
            return np.nan
        unequal = nlp.cl < nlp.cu
        rows = _passed(g[unequal], nlp.cl[unequal], nlp.cu[unequal])
        b = np.where(y > 0, nlp.cu, nlp.cl)
        terms = ((y, g - b), (-z_lower, z - lower), (z_upper, z - upper))
        foretold = float(f + sum(own @ np.where(np.isfinite(gap), gap, 0.0) for own, gap in terms))
        close = abs(foretold - self.objective) <= CHANGED * (1 + abs(self.objective))
        return foretold if close and max(rows, _passed(z, lower, upper)) <= PASSED else np.nan


Moved = TypeVar("Moved", float, np.ndarray)


def further(here: Moved, earlier: Moved, share: float) -> Moved:
    """A step on, as long as the last one times a share.

    here, earlier: the end and the beginning of the last one: numbers, or arrays of one shape.
    share: above 0.
    """
    return here + share * (here - earlier)


def _passed(values: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> float:
    """By how much the worst value passes its bound, relative to 1 + the size of that; all (n,)."""
    gaps = ((own[known] - values[known]) * sign / (1 + np.abs(own[known]))
            for own, sign in ((lower, 1), (upper, -1)) for known in [np.isfinite(own)])  # fmt: skip
    return max(float(gap.max(initial=0.0)) for gap in gaps)


def what_is_left(solution: Solution) -> Near:
    """What a solution leaves for its neighbours."""
    own = solution.outcome
    points = tuple(trajectory.mesh.fractions for trajectory in solution.trajectories)
    return Near(points, own.objective, Start(own.y, own.z_lower, own.z_upper))


def solved_from(
    near: Near,
    run: Run,
    nlp: NonlinearProgram,
    z: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    options: Mapping[str, Any],
) -> tuple[Outcome, int]:
    """The outcome from the multipliers of a close neighbour; without them if there is none so, and the better of the
    two if it is worse than foretold. Also the iterations of the other, if any.

    near: it fits the program.
    run: the engine.
    nlp: the program.
    z, lower, upper: (n,) the neighbour's point and the bounds of the unknowns.
    options: of the engine.
    """
    foretold = near.foretold(nlp, z, lower, upper)
    if np.isnan(foretold):
        return run(options, None), 0
    few = min(int(options.get("max_iter", ITERATIONS)), ITERATIONS)
    first = run({**options, "max_iter": few}, near.start)
    loss = first.objective - foretold
    believed = loss <= LOST * abs(foretold - near.objective) + SAME * (1 + abs(foretold))
    if first.status is Status.INTERRUPTED or (first.status is Status.SOLVED and believed):
        return first, 0
    second = run(options, None)
    worse = not second.status.usable or second.objective > first.objective
    return (first, second.count) if first.status is Status.SOLVED and worse else (second, first.count)
