"""A solution whose controls do not minimise the Hamiltonian: where, by how much, and a start with those that do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.problem import Curves, Guess
from ...problems.text import short_repr
from ..dual.multipliers import Multipliers
from ..solution.lagrangian import PhaseLagrangian
from ..solution.solution import Solution
from ..solution.trajectory import Trajectory
from ..solution.violation import of_phase
from ..starts.warm import Solved
from .minimum import BestControls, least_hamiltonian

LEAST = 1e-5
"""Of 1 + |J|: with less to gain than that, controls are as good as any."""

BEARING = 0.1  # of the largest excess: where another control is told of


@short_repr
@dataclass(frozen=True)
class Lower:
    """Other controls with a lower Hamiltonian: what they would gain of the objective, in words, and a start with them.

    gain: the integral of what H is lower by, over all phases. where: they are, and what. guesses: one for each phase,
    the trajectory with these controls.
    """

    gain: float
    where: str
    guesses: Sequence[Curves]


def lower_hamiltonian(solution: Solution, solved: Solved, share: float) -> Lower | None:
    """What other controls would gain, if that is a good deal; None if there are none such, or no error bar.

    solution, solved: what a solve led to.
    share: of the error bar, that they have to gain.
    """
    trajectories, bar = solution.trajectories, solution.objective_error
    if not bar.applies:
        return None
    multipliers = Multipliers(solved.transcription, solved.nlp, solved.outcome)
    phases = {
        i: PhaseLagrangian(i, multipliers, own)
        for i, own in enumerate(trajectories)
        if own.phase.controls and not own.phase.exact and own.lasts
    }
    notable = max(share * bar.bar, LEAST * (1 + abs(solution.objective)))
    for rough in (True, False):
        found = {i: least_hamiltonian(phase, rough) for i, phase in phases.items()}
        gain = sum(own.total for own in found.values())
        if not notable < gain < np.inf:
            return None
    worst = max(found, key=lambda i: found[i].total)
    guesses = [_improved(own, found[i]) if i in found else own for i, own in enumerate(trajectories)]
    return Lower(gain, _where(trajectories[worst], found[worst]), guesses)


def _where(trajectory: Trajectory, least: BestControls) -> str:
    bearing = np.flatnonzero(least.excess > BEARING * least.excess.max())
    k = int(np.argmax(least.excess))
    controls = zip(trajectory.phase.controls, least.controls[:, k], strict=True)
    names = ", ".join(f"{control.name} = {value:.4g}" for control, value in controls)
    t, (start, end) = least.points.t[k], least.points.t[bearing[[0, -1]]]
    return f"within t = {start:.4g} to {end:.4g}{of_phase(trajectory.phase.name)}, as {names} at t = {t:.4g}"


def _improved(trajectory: Trajectory, least: BestControls) -> Guess:
    """A trajectory with the controls of least Hamiltonian."""
    controls = zip(trajectory.phase.controls, least.controls, strict=True)
    s = trajectory.mesh.fractions
    return trajectory.with_controls({own.name: np.interp(s, least.points.s, u) for own, u in controls})
