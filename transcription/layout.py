"""What a transcription is: the unknowns in order, where each stands, and what each row of constraints means."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from pyomo.core import ConcreteModel, Constraint

from ..problems.problem import Phase, Problem
from ..problems.text import short_repr
from .schemes.mesh import Mesh


@short_repr
@dataclass(frozen=True)
class Family:
    """The constraints of one Pyomo component, or of a part of one, told in the user's terms.

    kind: "defect", "residual", "path", "path end" (of a path constraint at an end that is no collocation point),
    "bound" (of a state that is no variable), "boundary" or "integral". name: of the state or the constraint. span:
    (M, 2) normalised times that each constraint covers. weights: (M,) quadrature weights of the points of a constraint
    that holds over time, else 1. group, row: of the mesh and of the scheme's defects; a
    component that holds several rows of each segment has a tuple of them. part: of the component.
    """

    component: Constraint
    phase: str
    kind: str
    name: str
    span: np.ndarray
    weights: np.ndarray
    group: int = 0
    row: int | tuple[int, ...] = 0
    part: slice = field(default_factory=lambda: slice(None))

    def rows(self, nlp) -> np.ndarray:
        """The numbers of its rows in a compiled program, shape (M,)."""
        return nlp.rows(self.component)[self.part]


@short_repr
@dataclass(frozen=True)
class Layout:
    """Where the unknowns of one phase stand: x (n_x, K), inputs u (n_u, K), t (2,); -1 where there is no unknown.

    owners: id of a Set of the model whose elements belong to segments each -> the segment of each element.
    explicit: id of the Set of the points at which states are variables and the dynamics are collocated, or of None.
    """

    phase: Phase
    mesh: Mesh
    x: np.ndarray
    u: np.ndarray
    t: np.ndarray
    owners: Mapping[int, np.ndarray]
    explicit: int


@short_repr
@dataclass(frozen=True)
class Transcription:
    """A Pyomo model (None for shooting), its free variables in the order of z, and what stands where."""

    problem: Problem
    model: ConcreteModel | None
    variables: tuple
    phases: tuple[Layout, ...]
    parameters: np.ndarray
    families: tuple[Family, ...]


def bounded_start(transcription: Transcription) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The initial values of the unknowns and their bounds, each shape (n,); infinite where there is no bound."""
    table = [(v.value, *v.bounds) for v in transcription.variables]
    z, lower, upper = (np.array(column, float) for column in zip(*table, strict=True))
    return z, np.where(np.isnan(lower), -np.inf, lower), np.where(np.isnan(upper), np.inf, upper)
