"""What a solve gives back: the last mesh's trajectories and errors, and the history of meshes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ...problems.problem import Problem
from ...problems.text import short_repr
from ..engines.outcome import Outcome, Status
from ..schemes.mesh import Mesh
from .diagnose import Violation
from .error import ErrorProfile
from .objective_error import ObjectiveError
from .trajectory import Trajectory

NOT_MEASURED = ObjectiveError(why_not="this mesh is not the last")


@short_repr
@dataclass(frozen=True)
class MeshRecord:
    """How the solve on one mesh went; objective as the user wrote it, error as in `refine`, seconds by part."""

    mesh: Mesh
    tolerance: float
    status: Status
    objective: float
    max_eta: float
    relative_error: float
    iterations: int
    unknowns: int
    constraints: int
    seconds: Mapping[str, float]


@short_repr
@dataclass(frozen=True)
class Solution:
    """What `solve` gives back, solved or not: the last mesh's trajectories and errors, and the history of meshes.

    unmet: the segments that refinement left above its tolerance, in words, the worst first. stopped: why the mesh after
    the last of the history is not in it, if refinement ended because that was not solved. objective_error: how far the
    objective is from the optimum. note: which other starts were tried, and what the result itself gives to suspect.
    """

    problem: Problem
    status: Status
    objective: float
    trajectories: tuple[Trajectory, ...]
    errors: tuple[ErrorProfile, ...]
    meshes: tuple[MeshRecord, ...]
    outcome: Outcome
    violations: tuple[Violation, ...] = ()
    trouble: str = ""
    accept: Status = Status.SOLVED
    unmet: tuple[str, ...] = ()
    stopped: str = ""
    note: str = ""
    objective_error: ObjectiveError = NOT_MEASURED

    @property
    def solved(self) -> bool:
        """Whether the last mesh ended with an optimal point, or with one as good as `accept` asks for."""
        return self.status in (Status.SOLVED, Status.FEASIBLE, self.accept)

    @property
    def max_eta(self) -> float:
        return max(error.max_eta for error in self.errors)
