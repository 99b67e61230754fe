"""What a transcription is: the unknowns in order, where each stands, and what each row of constraints means."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from typing import Any, NamedTuple

import numpy as np

from ..problems.lean.records import dataclass
from ..problems.problem import Phase, Problem
from ..problems.quantities import Range
from ..problems.text import short_repr
from .constraint_kinds import AT_ENDS, DEFECT, DELAY, OF_STATES, ConstraintKind, range_of_state
from .program.contract import NonlinearProgram
from .schemes.mesh import Mesh

BETWEEN = ""
"""The phase of a constraint that belongs to several: a link."""

EQUAL = Range(0.0, 0.0)


@short_repr
@dataclass(frozen=True)
class Family:
    """The constraints of one Pyomo component, or of a part of one, told in the user's terms.

    phase: its name, or BETWEEN.
    name: of the state or the constraint. span: (M, 2) normalised times that each constraint covers. weights: (M,)
    quadrature weights of the points of a constraint that holds over time, else 1. group, row: of the mesh and of the
    scheme's defects; a component that holds several rows of each segment has a tuple of them. part: of the component.
    """

    component: Any  # a Constraint of Pyomo, or shooting's `ConstraintRows`
    phase: str
    kind: ConstraintKind
    name: str
    span: np.ndarray
    weights: np.ndarray
    group: int = 0
    row: int | tuple[int, ...] = 0
    part: slice = field(default_factory=lambda: slice(None))

    def rows(self, nlp: NonlinearProgram) -> np.ndarray:
        """The numbers of its rows in a compiled program, shape (M,)."""
        return nlp.rows(self.component)[self.part]


@short_repr
@dataclass(frozen=True)
class Layout:
    """Where the unknowns of one phase stand: x (n_x, K), inputs u (n_u, K), t (2,); -1 where there is no unknown.

    owners: name of a Set of the model whose elements belong to segments each -> the segment of each element.
    explicit: name of the Set of the points at which states are variables and the dynamics are collocated, if any.
    shared: name of a Set whose elements read states at a knot each -> the numbers of the knots, and the shares of the
    elements that belong to the segments before and after it.
    """

    phase: Phase
    mesh: Mesh
    x: np.ndarray
    u: np.ndarray
    t: np.ndarray
    owners: Mapping[str, np.ndarray] = field(default_factory=dict)
    explicit: str = ""
    shared: Mapping[str, tuple[np.ndarray, np.ndarray, np.ndarray]] = field(default_factory=dict)


def places(
    phase: Phase,
    mesh: Mesh,
    state: Callable[[int, int], int],
    own_input: Callable[[int, int], int],
    time: Callable[[int], int],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Number the unknowns of a phase point by point, (x_0, u_0, x_1, u_1, ...), the times last: x, u, t of a `Layout`.

    phase: says how many states and inputs there are.
    mesh: says how many points there are.
    state, own_input: (which, point) -> the number of the unknown, or -1 where there is none.
    time: 0 for the initial, 1 for the final time -> the same.

    They are called in the order of the numbering.
    """
    K = len(mesh.fractions)
    x, u = np.full((len(phase.states), K), -1), np.full((len(phase.inputs), K), -1)
    for k in range(K):
        for i in range(len(x)):
            x[i, k] = state(i, k)
        for i in range(len(u)):
            u[i, k] = own_input(i, k)
    return x, u, np.array([time(0), time(1)])


class Unknown(NamedTuple):
    """A free variable: its initial value and its bounds, None where there is none."""

    value: float
    bounds: tuple[float | None, float | None]


class Unknowns(Sequence[Unknown]):
    """Free variables, of which there may be a million: as arrays, (n,) each, which nobody changes.

    z: initial values. lower, upper: bounds, infinite where there is none.
    """

    def __init__(self, z: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> None:
        self.z, self.lower, self.upper = z, lower, upper

    def __len__(self) -> int:
        return len(self.z)

    def __getitem__(self, k: Any) -> Any:
        lower, upper = (None if np.isinf(own[k]) else float(own[k]) for own in (self.lower, self.upper))
        return Unknown(float(self.z[k]), (lower, upper))


@short_repr
@dataclass(frozen=True)
class Transcription:
    """A Pyomo model (None for shooting), its free variables in the order of z, and what stands where.

    variables: those of Pyomo, `Unknown`, or `Unknowns`; then the numbers in the model, if there is one, are not those
    of this problem (see `collocation.kept`).
    """

    problem: Problem
    model: Any
    variables: Sequence[Any]
    phases: tuple[Layout, ...]
    parameters: np.ndarray
    families: tuple[Family, ...]


def bounded_start(transcription: Transcription) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The initial values of the unknowns and their bounds, each shape (n,); infinite where there is no bound."""
    if isinstance(own := transcription.variables, Unknowns):
        return own.z.copy(), own.lower.copy(), own.upper.copy()
    table = [(v.value, *v.bounds) for v in transcription.variables]
    z, lower, upper = (np.array(column, float) for column in zip(*table, strict=True))
    return z, np.where(np.isnan(lower), -np.inf, lower), np.where(np.isnan(upper), np.inf, upper)


def range_of_rows(problem: Problem, family: Family) -> Range:
    """The range of what the rows of a family hold, as a problem has it.

    problem: one whose program has the family.
    family: of its transcription.
    """
    kind, name = family.kind, family.name
    if family.phase == BETWEEN:
        return next(link.bounds for link in problem.links if link.name == name)
    phase = next(own for own in problem.phases if own.name == family.phase)
    if kind in OF_STATES:
        return range_of_state(kind, next(state for state in phase.states if state.name == name))
    if kind in (DEFECT, DELAY):
        return EQUAL
    constraints = getattr(phase, AT_ENDS.get(kind, kind).functions)
    return next(own.bounds for own in constraints if own.name == name)
