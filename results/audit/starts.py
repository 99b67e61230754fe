"""Whether the problem, solved anew from other first trajectories, has a better objective than the result.

A result may meet every condition that is looked at along it, Pontryagin's at all controls too, and be the lesser of
two optima. No check of the trajectory alone can tell; another solve can. It is done on a mesh of few points first, and
counts if it is better by more than both error bars on the result's own mesh as well. That none is better proves
nothing: it is no search of everything.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ...problems.problem import Problem
from ...transcription.engines.outcome import Status
from ...transcription.engines.watch import Watch
from ...transcription.one_mesh import Origin, solve_mesh
from ...transcription.schemes.discrete import DISCRETE
from ...transcription.schemes.mesh import Mesh
from ...transcription.settings import Settings
from ...transcription.solution.objective_error import ObjectiveError
from ...transcription.solution.trajectory import Trajectory
from ...transcription.starts.drawn import other_parameters
from ...transcription.starts.other import OtherStart, other_starts
from ..file.reload import Reloaded
from .check import Check
from .trajectory import between_points

NAME = "no better objective from other starts, relative"
OTHERS = 8  # starts with other static parameters
POINTS = 100  # about: enough to tell one optimum from another
MOST_ITERATIONS = 150
TOLERANCE = 1e-8
ROUNDING = 1e-8  # of 1 + |J|: what two engines' tolerances differ by


class _Found(NamedTuple):
    """What a start led to: how much better than the result, relative, and what of that the error bars explain."""

    better: float
    claimed: float
    objective: float = 0.0
    words: str = ""
    origin: Origin = Origin(None, None)  # for another mesh
    trajectories: tuple[Trajectory, ...] = ()
    inaccurate: bool = False

    def counts(self, tolerance: float) -> bool:
        """Whether dynamics, bounds and constraints hold between the points: what breaks them may well be better."""
        checks = [check for own in self.trajectories for check in between_points(own, tolerance)]
        return not self.inaccurate and all(check.passed for check in checks)


_NOTHING = _Found(0.0, 0.0)


def starts(result: Reloaded, estimate: ObjectiveError, tolerance: float) -> Iterator[Check]:
    """The check of a whole result; none where nothing is optimised by controls, or where there is no error bar.

    result: read back.
    estimate: of the error of its objective.
    tolerance: of what another solution exceeds its bounds by between the points, as for the result itself.

    A problem file may mean the lesser optimum: where its reference is nearer to the result, the better one is told and
    does not count.
    """
    phases = result.problem.phases
    if not estimate.applies or not result.solved or not all(phase.controls or phase.static for phase in phases):
        return
    best, meshes = _NOTHING, result.records[-1].grids
    for start in _origins(result.problem):
        origin = Origin(start.guesses, None)
        if coarse := _coarse(meshes):
            near = _from(result, estimate, coarse, origin, start.words)
            if near is None or near.better <= near.claimed:
                continue
            origin = near.origin
        # What is better on a few points may be so by what they do not see: the result's own mesh decides.
        found = _from(result, estimate, meshes, origin, start.words)
        if found and found.better - found.claimed > best.better - best.claimed and found.counts(tolerance):
            best = found
    where = f"{best.objective:.7g} from {best.words}" if best.words else ""
    reference = result.spec.reference
    if where and reference and abs(result.objective - reference.objective) < abs(best.objective - reference.objective):
        where, best = f"not counted, the reference is the result's: {where}", _NOTHING
    yield Check(NAME, best.better, best.claimed, where)


def _origins(problem: Problem) -> Iterator[OtherStart]:
    """Other first trajectories, and other values of the static parameters."""
    if not all(phase.static for phase in problem.phases):
        yield from other_starts(problem, False)
    yield from other_parameters(problem, OTHERS)


def _coarse(meshes: Sequence[Mesh]) -> list[Mesh] | None:
    """Meshes of few points by the same methods; None where they are such, or are the steps of discrete time."""
    if any(mesh.schemes[0] is DISCRETE for mesh in meshes):
        return None
    if sum(len(mesh.fractions) for mesh in meshes) <= POINTS or all(mesh.segments == 1 for mesh in meshes):
        return None
    schemes = [min(mesh.schemes, key=lambda own: len(own.sigma)) for mesh in meshes]
    share = POINTS // len(meshes)
    return [Mesh.of(scheme, max(share // (len(scheme.sigma) - 1), 1)) for scheme in schemes]


@np.errstate(all="ignore")
def _from(
    result: Reloaded, estimate: ObjectiveError, meshes: Sequence[Mesh], origin: Origin, words: str
) -> _Found | None:
    """What a start leads to on these meshes; None for nothing that is known to be near an optimum."""
    problem, settings = result.problem, Settings({"max_iter": MOST_ITERATIONS}, coarse_start=False)
    solution, solved = solve_mesh(problem, list(meshes), TOLERANCE, settings, origin, Watch(None, None, 0))
    if solution.status is not Status.SOLVED:
        return None
    other = solution.objective_error
    if not other.applies:
        return None
    size = 1 + abs(result.objective)
    better = problem.sense * (result.objective - solution.objective) / size
    claimed = (estimate.bar + other.bar) / size + ROUNDING
    origin = Origin(solution.trajectories, solved)
    return _Found(
        float(better), float(claimed), solution.objective, words, origin, solution.trajectories,
        bool(solution.inaccurate),
    )  # fmt: skip
