"""How to solve, as data: the schedule of meshes, the engine and its options, refinement, scaling."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from typing import TYPE_CHECKING

import numpy as np

from ..problems.lean.records import dataclass
from ..problems.problem import Phase, Problem
from .engines.outcome import Status
from .measured.knots import measured_fractions, with_knots
from .schemes.discrete import DISCRETE, STATIC
from .schemes.mesh import Mesh
from .schemes.table import find

if TYPE_CHECKING:  # pydantic
    from ..problems.schema.solving import Engine, MeshEntry
    from ..problems.schema.spec import Spec


@dataclass(frozen=True)
class Step:
    """One entry of the mesh schedule: a method, a number of segments or their relative widths, the engine's tolerance.

    degree: of a family of methods, one for all segments or one for each. form: of its defects, "integral" or
    "differential". substeps: on each segment, and control: polynomial on each substep, of a shooting method.
    """

    method: str
    segments: int | Sequence[float]
    tolerance: float
    degree: int | Sequence[int] | None = None
    form: str | None = None
    substeps: int | None = None
    control: str | None = None

    def mesh(self) -> Mesh:
        if self.degree is None or isinstance(self.degree, int):
            return Mesh.of(find(self.method, self.degree, self.form, self.substeps, self.control), self.segments)
        widths = np.ones(len(self.degree)) if isinstance(self.segments, int) else np.asarray(self.segments)
        return Mesh(tuple(find(self.method, int(n), self.form) for n in self.degree), widths)


def meshes_of(problem: Problem, steps: Sequence[Step]) -> list[Mesh]:
    """The mesh of each phase, with knots at the times of its measurements; of one that is exact, what it needs.

    problem: of any number of phases.
    steps: one for each.
    """
    return [
        _exact_mesh(phase) or with_knots(step.mesh(), measured_fractions(phase))
        for phase, step in zip(problem.phases, steps, strict=True)
    ]


def _exact_mesh(phase: Phase) -> Mesh | None:
    """The steps of discrete time, one segment for a phase without time, None for others."""
    if phase.static:
        return Mesh.of(STATIC, 1)
    return Mesh.of(DISCRETE, phase.steps) if phase.steps else None


def schedule_of(spec: Spec) -> list[tuple[Step, ...]]:
    """The mesh schedule of a problem file: for each of its entries one step for each phase."""
    from ..problems.phases.merge import phase_specs

    return list(zip(*(steps(own.mesh) for own in phase_specs(spec).values()), strict=True))


def steps(schedule: Sequence[MeshEntry]) -> list[Step]:
    """The mesh schedule of one phase."""
    keys = "method", "segments", "tolerance", "degree", "form", "substeps", "control"
    return [Step(*(getattr(entry, key) for key in keys)) for entry in schedule]


@dataclass(frozen=True)
class Refine:
    """Refine until the relative error of every segment meets the tolerance, on at most max_meshes meshes more.

    objective: in place of that, until the error bar of the objective is this small, relative to 1 + |J|; None for not.
    """

    tolerance: float = 1e-6
    max_meshes: int = 10
    objective: float | None = None


@dataclass(frozen=True)
class Settings:
    """How to solve: the engine, its options, whether IPOPT's looser tolerance counts as solved (ACCEPTABLE), and
    whether meshes are refined after the schedule. scaling: None for the engine's own, or the sizes that the automatic
    scaling should not choose itself. coarse_start: whether a large first mesh starts from the solution on a coarse one.
    seconds: time limit for all meshes, or None. starts: how many are drawn beside the problem's own; seed: of these.
    gap: what the barrier may leave of the objective, relative to 1 + |J|, on a mesh after which no other comes; None
    where that is not known before.
    """

    options: Mapping[str, object] = field(default_factory=dict)
    engine: Engine = "ipopt"
    accept: Status = Status.SOLVED
    refine: Refine | None = None
    scaling: Mapping[str, float] | None = None
    coarse_start: bool = True
    seconds: float | None = None
    starts: int = 0
    seed: int = 0
    gap: float | None = None

    def within(self, iterations: int | None) -> Settings:
        """With so many iterations at most; as they are for None, or if they say how many themselves.

        iterations: of IPOPT.
        """
        if iterations is None or self.engine != "ipopt" or "max_iter" in self.options:
            return self
        return replace(self, options={**self.options, "max_iter": iterations})


DEFAULT = Settings()


def settings_of(spec: Spec) -> Settings:
    """The settings of a problem file."""
    return Settings(
        options=spec.solver.options,
        engine=spec.solver.engine,
        accept=Status.ACCEPTABLE if spec.solver.accept == "acceptable" else Status.SOLVED,
        refine=Refine(spec.refine.tolerance, spec.refine.max_meshes, spec.refine.objective) if spec.refine else None,
        scaling=_scaling(spec),
        coarse_start=spec.solver.coarse_start,
        seconds=spec.solver.seconds,
        starts=spec.solver.starts,
        seed=spec.solver.seed,
    )


def _scaling(spec: Spec) -> Mapping[str, float] | None:
    """As of `Settings`: a file says none, auto, or the sizes of some variables."""
    if spec.scaling == "none":
        return None
    return {} if isinstance(spec.scaling, str) else spec.scaling
