"""What a solve gives back: the last mesh's trajectories and errors, and the history of meshes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field, replace
from functools import cached_property
from time import perf_counter

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.problem import Problem
from ...problems.text import short_repr
from ..arcs import Course
from ..engines.outcome import Outcome, Status
from ..measured.estimated import Estimates
from ..schemes.mesh import Mesh
from .error import ErrorProfile
from .objective_error import ObjectiveError
from .sensitivity import Sensitivities
from .trajectory import Trajectory
from .violation import Violation

LARGEST_ERROR = 1e-2
"""Relative error above which no point counts as accurate, whatever was asked for: a fixed mesh asks for nothing."""

LARGEST_BAR = 5e-2
"""The same of the error bar, relative to 1 + |J|: the largest of the shipped problems is 1.2e-2, on its fixed mesh."""

NO_TRAJECTORY = 1.0
"""Relative error of what is no trajectory of the dynamics at all."""


ENDED = {
    Status.INTERRUPTED: "was interrupted",
    Status.TIME_LIMIT: "was not solved within the time limit",
    Status.ACCEPTABLE: Status.ACCEPTABLE.message,
}
"""How a mesh is called that ended with one of these statuses; of all others, that it failed."""


@short_repr
@dataclass(frozen=True)
class MeshRecord:
    """How the solve on one mesh went; objective as the user wrote it, error as in `refine`, seconds by part.

    grids: the mesh of each phase. objective_error: |J - J*| is at most that, NaN where there is no error bar.
    objective_corrected: the better value, NaN with the bar.
    """

    grids: tuple[Mesh, ...]
    tolerance: float
    status: Status
    objective: float
    objective_error: float
    objective_corrected: float
    max_eta: float
    relative_error: float
    iterations: int
    unknowns: int
    constraints: int
    seconds: Mapping[str, float]

    @property
    def mesh(self) -> Mesh:
        """The mesh of the first phase, of one phase the only one."""
        return self.grids[0]

    @property
    def segments(self) -> int:
        """Of all phases together."""
        return sum(mesh.segments for mesh in self.grids)

    @property
    def why_not_kept(self) -> str:
        """Why the solution that is given back is not that of this mesh, but of the one before."""
        what = ENDED.get(self.status) or f"failed: {self.status.message}"
        return f"the next mesh, of {self.segments} segments, {what}"

    def after(self, first: MeshRecord) -> MeshRecord:
        """This record of a second solve on one mesh, with the work of the first."""
        seconds = {part: first.seconds[part] + own for part, own in self.seconds.items()}
        return replace(self, iterations=first.iterations + self.iterations, seconds=seconds)


@dataclass(frozen=True)
class ContinuationStep:
    """One solve on the way of a continuation: path -> value, and what it led to; objective NaN where it failed."""

    values: Mapping[str, float]
    status: Status
    objective: float
    iterations: int

    def __str__(self) -> str:
        where = ", ".join(f"{path} = {value:.6g}" for path, value in self.values.items())
        outcome = f"objective {self.objective:.8g}" if self.status.usable else self.status.message
        return f"{where}: {outcome}, {self.iterations} iterations"


@short_repr
@dataclass(frozen=True)
class Solution:
    """What `solve` gives back, solved or not: the last mesh's trajectories and errors, and the history of meshes.

    trouble: what explains a failed solve; involved: the names in it of all that cannot hold at once.
    unmet: the segments that refinement left above its tolerance, in words, the worst first. stopped: why the mesh after
    the last of the history is not in it, if refinement ended because that was not solved. objective_error: how far the
    objective is from the optimum. notes: what was done beyond what was asked, such as another start. relief: what of a
    problem that contradicts itself would have to give way, in words: each would do by itself. continuation: the solves
    on the way to this problem, itself the last. discarded: meshes that were not kept. elsewhere: seconds of work that
    the history does not tell: other starts, discarded meshes, the way. sensitive: computes `sensitivities`. estimates:
    of the static parameters, where something is measured. prices: of each phase, and prices_between: of conditions on
    several, see `structure.prices`. arcs: of each phase, see `structure.courses`. program: its kind, in words, if it is
    linear or quadratic.
    """

    problem: Problem
    status: Status
    objective: float
    trajectories: tuple[Trajectory, ...]
    errors: tuple[ErrorProfile, ...]
    meshes: tuple[MeshRecord, ...]
    outcome: Outcome
    objective_error: ObjectiveError
    violations: tuple[Violation, ...] = ()
    trouble: str = ""
    involved: tuple[str, ...] = ()
    accept: Status = Status.SOLVED
    unmet: tuple[str, ...] = ()
    stopped: str = ""
    notes: tuple[str, ...] = ()
    relief: tuple[str, ...] = ()
    continuation: tuple[ContinuationStep, ...] = ()
    discarded: tuple[MeshRecord, ...] = ()
    elsewhere: float = 0.0
    prices: tuple[Mapping[str, float], ...] = ()
    prices_between: Mapping[str, float] = field(default_factory=dict)
    arcs: tuple[tuple[Course, ...], ...] = ()
    program: str = ""
    estimates: Estimates | None = None
    sensitive: Callable[[], Sensitivities] = field(default=Sensitivities, repr=False, compare=False)

    @cached_property
    def sensitivities(self) -> Sensitivities:
        """How the objective changes with the numbers of the file; computed when it is asked for."""
        return self.sensitive()

    @property
    def remedy(self) -> str:
        """What to do about a failure: the status' advice, but more iterations do not help where the cause is known."""
        if self.status is Status.STEP_FAILED and self.trouble:
            return "mend the cause"
        return "mend the cause: more iterations do not help" if self.cause_is_known else self.status.remedy

    @property
    def seconds_of_meshes(self) -> float:
        """Of the work on the meshes that led here, `elsewhere` left out."""
        return sum(sum(record.seconds.values()) for record in self.meshes)

    def since(self, began: float) -> Solution:
        """The solution, with the seconds since `began` (`time.perf_counter`) that none of its meshes has."""
        return replace(self, elsewhere=max(perf_counter() - began - self.seconds_of_meshes, 0.0))

    def out_of_time(self) -> Solution:
        """The solution of an interrupted solve, of which the time limit is told."""
        return self._ended(Status.TIME_LIMIT)

    def contradictory(self, relief: tuple[str, ...]) -> Solution:
        """The failed solution of a problem that contradicts itself; relief: as of the fields. More iterations do not
        help where they ran out."""
        told = self._ended(Status.INFEASIBLE) if relief and self.status is Status.MAX_ITERATIONS else self
        return replace(told, relief=relief)

    def _ended(self, status: Status) -> Solution:
        meshes = (*self.meshes[:-1], replace(self.meshes[-1], status=status))
        return replace(self, status=status, meshes=meshes)

    @property
    def cause_is_known(self) -> bool:
        """Whether the iterations ran out for a reason that has a name: what runs away, or has a kink. No other start,
        mesh or number of iterations mends that."""
        return self.status is Status.MAX_ITERATIONS and bool(self.trouble)

    @property
    def solved(self) -> bool:
        """Whether the last mesh ended with an optimal point, or with one as good as `accept` asks for."""
        return self.status in (Status.SOLVED, Status.FEASIBLE, self.accept)

    @property
    def is_no_trajectory(self) -> bool:
        """Whether the dynamics are missed by as much as the states are large."""
        return self.meshes[-1].relative_error >= NO_TRAJECTORY

    @property
    def inaccurate(self) -> str:
        """Why a solved problem is not as accurate as was asked, or ""."""
        bar = self.objective_error.bar / (1 + abs(self.objective))
        return inaccurate(len(self.unmet), self.stopped, self.meshes[-1].relative_error, bar)

    @property
    def max_eta(self) -> float:
        return max(error.max_eta for error in self.errors)


def with_error_bar(solution: Solution, bar: float) -> Solution:
    """A solution whose objective has another error bar, as far as it tells of it.

    solution: one with an error bar.
    bar: the other.
    """
    last = replace(solution.meshes[-1], objective_error=bar)
    error = replace(solution.objective_error, bar=bar)
    return replace(solution, objective_error=error, meshes=(*solution.meshes[:-1], last))


def without_error_bar(solution: Solution, why_not: str) -> Solution:
    """A solution that says why its objective has no error bar.

    solution: any.
    why_not: as of `ObjectiveError`.
    """
    last = replace(solution.meshes[-1], objective_error=np.nan, objective_corrected=np.nan)
    return replace(solution, objective_error=ObjectiveError(why_not=why_not), meshes=(*solution.meshes[:-1], last))


def inaccurate(unmet: int, stopped: str, relative_error: float | None, relative_bar: float) -> str:
    """Why a solution is not as accurate as was asked, or "".

    unmet: the number of segments that miss the tolerance.
    stopped: why refinement ended early, or "".
    relative_error: of the last mesh, None or NaN if it cannot be measured; then nothing is known against the solution
        but what was said.
    relative_bar: the error bar over 1 + |J|, NaN if there is none.
    """
    if unmet:
        return f"{unmet} segment{'s' if unmet > 1 else ''} of the mesh miss the tolerance"
    if stopped:
        return stopped
    if relative_error is not None and relative_error > LARGEST_ERROR:
        what = f"the mesh is too coarse: the relative error is {relative_error:.1e}"
        return f"{what}; give it more segments, or --refine 1e-6"
    if relative_bar > LARGEST_BAR:
        return f"the error bar is {relative_bar:.1e} of 1 + |J|: more segments, or --accuracy 1e-3, may lessen it"
    return ""
