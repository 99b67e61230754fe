"""How a solve ended: the only table of solver statuses, each with what it means and what to do about it."""

from __future__ import annotations

from dataclasses import field
from enum import Enum
from typing import Any

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.text import short_repr


class Status(Enum):
    """Name -> (IPOPT's return code, what happened, what to do)."""

    SOLVED = (0, "solved", "")
    ACCEPTABLE = (
        1,
        "stopped at a point that meets only the looser 'acceptable' tolerance",
        "look at the error estimate; scale the problem or refine the mesh, or say 'solver: {accept: acceptable}'",
    )
    INFEASIBLE = (
        2,
        "the constraints contradict each other near this point",
        "relax one of the constraints named, or start from a guess nearer to satisfying them",
    )
    STALLED = (
        3,
        "the search directions became too small",
        "the problem is badly scaled or not smooth here; rescale it, or loosen the tolerance",
    )
    DIVERGING = (
        4,
        "the iterates run to infinity",
        "add bounds to the states and controls, or check the sign of the objective",
    )
    INTERRUPTED = (5, "interrupted; this is the last iterate", "go on from this result with --guess, or run it again")
    FEASIBLE = (6, "found a feasible point of a problem without freedom left to optimise", "")
    TIME_LIMIT = (
        -1001,  # not IPOPT's: it was asked to stop
        "ran out of the time it was given; this is the last iterate",
        "raise --time-limit, or 'solver: {seconds: ...}'; go on from this result with --guess",
    )
    MAX_ITERATIONS = (
        -1,
        "ran out of iterations",
        "raise 'solver: {max_iter: ...}', give a better guess, or start on a coarser mesh",
    )
    RESTORATION_FAILED = (
        -2,
        "could not become more feasible from here",
        "look at the constraints named; give a better guess, or a coarser first mesh",
    )
    STEP_FAILED = (
        -3,
        "no search direction could be computed",
        "if no cause is named, two constraints probably say the same thing: remove one, or give a better guess",
    )
    MAX_CPU_TIME = (-4, "ran out of CPU time", "raise 'solver: {max_cpu_time: ...}' or use a coarser mesh")
    MAX_WALL_TIME = (-5, "ran out of time", "raise 'solver: {max_wall_time: ...}' or use a coarser mesh")
    OVERDETERMINED = (
        -10,
        "there are more equality constraints than unknowns",
        "free a boundary value, or add a control or a free final time",
    )
    INVALID_PROBLEM = (-11, "IPOPT refused the problem's definition", "look for a lower bound above its upper bound")
    INVALID_OPTION = (
        -12,
        "IPOPT could not use an option",
        "check the 'solver:' section; a linear solver of the HSL needs 'hsllib: <its library>' too",
    )
    INVALID_NUMBER = (
        -13,
        "a function had no finite value where IPOPT had to have one",
        "bound the variables of the expression named away from that point, or change the guess",
    )
    NO_MEMORY = (-102, "ran out of memory", "use fewer segments")
    FAILED = (-199, "IPOPT failed inside", "try another 'solver: {linear_solver: ...}' or report it")

    def __init__(self, code: int, message: str, remedy: str) -> None:
        self.code, self.message, self.remedy = code, message, remedy

    @property
    def usable(self) -> bool:
        """Whether the point is optimal, or nearly: good enough to start the next mesh from."""
        return self in (Status.SOLVED, Status.ACCEPTABLE, Status.FEASIBLE)

    def may_replace(self, other: Status) -> bool:
        """Whether a point that ended so may stand in place of another: an acceptable one not in place of an optimal."""
        return self.usable and not (self is Status.ACCEPTABLE and other in (Status.SOLVED, Status.FEASIBLE))

    @classmethod
    def from_code(cls, code: int) -> Status:
        return next((status for status in cls if status.code == code), cls.FAILED)


COLUMNS = (
    "mode", "iteration", "objective", "primal_infeasibility", "dual_infeasibility", "mu",
    "step_norm", "regularization", "dual_step", "primal_step", "line_search_trials",
)  # fmt: skip
"""What is told of each iteration, in the order of IPOPT's callback."""


@short_repr
@dataclass(frozen=True)
class Start:
    """Multipliers to start from, with the signs and shapes of `Outcome`."""

    y: np.ndarray
    z_lower: np.ndarray
    z_upper: np.ndarray


@short_repr
@dataclass(frozen=True)
class Outcome:
    """What a solver gives back.

    z: (n,) last iterate. y: (m,) constraint multipliers, z_lower and z_upper: (n,) bound multipliers, all for the
    minimised objective. iterations: name -> (iterations,) array. failed: the last evaluation that was not finite,
    as (point z, list of (component name, index)), or None.
    """

    status: Status
    z: np.ndarray
    y: np.ndarray
    z_lower: np.ndarray
    z_upper: np.ndarray
    objective: float
    iterations: dict[str, np.ndarray]
    solver: dict[str, Any] = field(default_factory=dict)
    failed: tuple[np.ndarray, list] | None = None

    @property
    def count(self) -> int:
        """Of its iterations; the first record is of the start."""
        return max(len(self.iterations["iteration"]) - 1, 0)
