"""One more solve of a problem on its first mesh, or on one with more segments."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...problems.lean.records import dataclass
from ...problems.problem import Curves, Problem
from ..engines.watch import Limit, Watch
from ..one_mesh import Found, Origin, solve_mesh
from ..schemes.mesh import Mesh
from ..settings import Settings
from ..solution.solution import Solution
from ..transcribe import divided


@dataclass(frozen=True)
class Attempt:
    """What is solved, and how; all as of `solve_mesh`."""

    problem: Problem
    meshes: Sequence[Mesh]
    tolerance: float
    settings: Settings
    start: Origin
    watch: Watch

    def own(self, iterations: int | None = None) -> Found:
        """The solution from the start itself.

        iterations: at most; None for as many as the settings allow.
        """
        return solve_mesh(
            self.problem, self.meshes, self.tolerance, self.settings.within(iterations), self.start, self.watch
        )

    def run(
        self, guess: Sequence[Curves] | None, limit: Limit, *, times: int = 1, iterations: int | None = None
    ) -> Found:
        """The solution from a guess.

        guess: one for each phase; None for the problem's own.
        limit: of this solve.
        times: as many segments for each of the mesh.
        iterations: at most; None for as many as the settings allow.
        """
        origin, watch = replace(self.start, guess=guess, near=None), replace(self.watch, stop=limit.reached)
        settings = self.settings.within(iterations)
        return solve_mesh(
            self.problem, divided(self.problem, self.meshes, times), self.tolerance, settings, origin, watch
        )


def better(new: Solution, old: Solution, sense: int) -> bool:
    """Whether a solution is one where the other is none, or has the better objective by more than rounding; an optimal
    point does not give way to an acceptable one.

    new, old: of one problem.
    sense: +1 where the least is the best, -1 where the largest is.
    """
    if not new.status.may_replace(old.status) or not old.status.usable:
        return new.status.usable and not old.status.usable
    gain = sense * (old.objective - new.objective)
    return gain > 1e-6 * (1 + abs(old.objective))
