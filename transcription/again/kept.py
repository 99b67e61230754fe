"""Which of the solved meshes is given back, where that is not the last one."""

from __future__ import annotations

from collections.abc import Sequence

from ...problems.lean.records import dataclass
from ..engines.outcome import Status
from ..one_mesh import Found
from ..refinement.basin import nearer
from ..settings import Settings
from ..solution.solution import MeshRecord


@dataclass(frozen=True)
class Kept:
    """A solution, its segments that miss the tolerance, and how much of the history leads to it."""

    found: Found
    unmet: tuple[str, ...]
    known: int


class Candidates:
    """optimal: the last mesh that ended at an optimal point. best: the most exact one of refinement."""

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.optimal: Kept | None = None
        self.best: Kept | None = None

    def add(self, kept: Kept, refined: bool) -> None:
        """kept: of the mesh that was solved last. refined: whether refinement begins with it, or made it."""
        status = kept.found[0].status
        if not status.usable or status is Status.ACCEPTABLE:
            return
        self.optimal = kept
        if refined and not (self.best and self._nearer(self.best.found, kept.found)):
            self.best = kept

    def instead_of(
        self, last: Found, missed: bool, stopped: str, history: Sequence[MeshRecord]
    ) -> tuple[Kept, str] | None:
        """What to give back in place of a solution, and why; None if that stands.

        It is the last mesh of the same problem at an optimal point, if finer ones are acceptable only; and the most
        exact one, if the last one is not and misses what is asked for.

        last: the solution.
        missed: whether it misses that.
        stopped: why no mesh came after it.
        history: of all meshes.
        """
        own = last[0]
        if own.status is Status.ACCEPTABLE:
            other = self.optimal
            if self.settings.accept is Status.ACCEPTABLE or not other or other.found[0].problem is not own.problem:
                return None
            return other, history[other.known].why_not_kept
        if not missed or not self.best or not self._nearer(self.best.found, last):
            return None
        best = self.best.found[0]
        bars = f"{best.objective_error.bar:.1e} and {own.objective_error.bar:.1e}"
        told = f"the mesh of {best.meshes[-1].segments} segments is kept, not that of {own.meshes[-1].segments}"
        return self.best, "; ".join(filter(None, (stopped, f"{told}: their error bars are {bars}")))

    def _nearer(self, before: Found, after: Found) -> bool:
        refine = self.settings.refine
        return refine is not None and nearer(before[0], after[0], by_bar=refine.objective is not None)
