"""Pontryagin's minimum: no other control that is allowed gives H a smaller value, at any collocation point.

With E the integral of what H is above the least value found (see `transcription.pontryagin.minimum`), J + E is no
better than the Lagrangian's value with these controls: a result that claims J to an error bar claims that E is no more
than it. Both are given relative to the duration and the largest term of H.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...transcription.dual.multipliers import Multipliers
from ...transcription.pontryagin.minimum import least_hamiltonian
from ...transcription.solution.lagrangian import PhaseLagrangian
from ...transcription.solution.trajectory import Trajectory
from ..file.reload import Reloaded
from .check import Check, at

NAME = "Pontryagin's minimum of H over the controls, relative"


@np.errstate(all="ignore")
def pontryagin(result: Reloaded, claimed: float) -> Iterator[tuple[Trajectory, Check]]:
    """Each phase that has controls, unique costates and a duration, and its check; not in discrete time, where it need
    not hold.

    result: read back, with multipliers.
    claimed: how far its objective may be from the optimum.
    """
    multipliers = Multipliers(result.transcription, result.nlp, result.outcome)
    for number, trajectory in enumerate(result.trajectories):
        unique = not trajectory.phase.complementarity and not trajectory.phase.exact
        if trajectory.costate is not None and trajectory.phase.controls and unique and trajectory.lasts:
            yield trajectory, _check(PhaseLagrangian(number, multipliers, trajectory), claimed)


def _check(phase: PhaseLagrangian, claimed: float) -> Check:
    """The check of a phase whose minimised objective may be above the optimum by what is claimed."""
    least = least_hamiltonian(phase)
    excess = least.excess
    scale = float(phase.sizes(least.points).max()) or 1.0
    k = int(np.argmax(np.nan_to_num(excess, nan=np.inf)))
    where = ""
    if excess[k] > 0:
        controls = zip(phase.phase.controls, least.controls[:, k], strict=True)
        names = ", ".join(f"{c.name} = {v:.4g}" for c, v in controls)
        where = f"{at(phase.trajectory, least.points.t[k])}, by {excess[k] / scale:.1e} with {names}"
    return Check(NAME, least.total / (phase.duration * scale), claimed / (phase.duration * scale), where)
