"""What the constraints that hold once are worth: the change of the objective with their bound.

    price = dJ / d(bound)                 L = f - price (g - bound)         (introduction to collocation, (20) and (21))

For a range it is the change with the bound that acts, and 0 where none does: what the barrier leaves there is nothing.
The engine's multipliers y stand in L = f + y g, so price = - sense y.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...problems.quantities import Continuity, Range
from ..constraint_kinds import Multiplier
from ..dual.multipliers import ACTS, Multipliers
from ..engines.outcome import Outcome
from ..layout import BETWEEN, Transcription
from ..program.contract import NonlinearProgram


def prices(
    transcription: Transcription, nlp: NonlinearProgram, outcome: Outcome
) -> tuple[tuple[Mapping[str, float], ...], Mapping[str, float]]:
    """For each phase, name -> dJ/d(bound) of its boundary and integral constraints, and of bounds of static parameters;
    and the same of conditions on the ends of several phases.

    transcription: of the problem.
    nlp: its program.
    outcome: its solution, with multipliers.
    """
    sense, problem, own_bounds = (
        transcription.problem.sense,
        transcription.problem,
        Multipliers(transcription, nlp, outcome),
    )
    (lower, below, low), (upper, above, high), (_, slack, bound) = own_bounds.sides
    acting = own_bounds.equations | (own_bounds.acting(outcome.y, slack, bound) > ACTS)
    lower = np.where(own_bounds.acting(lower, below, low) > ACTS, lower, 0.0)
    upper = np.where(own_bounds.acting(upper, above, high) > ACTS, upper, 0.0)
    y = np.where(acting, outcome.y, 0.0)
    passages = {link.name for link in problem.links if isinstance(link, Continuity)}

    def of(phase: str) -> dict[str, float]:
        own = [family for family in transcription.families if family.phase == phase and not family.kind.timed]
        numbers = [family for family in own if family.kind.multiplier is Multiplier.NUMBER]
        return {family.name: float(-sense * y[family.rows(nlp)].sum()) + 0.0 for family in numbers}

    found: list[dict[str, float]] = []
    for phase in problem.phases:
        own = of(phase.name)
        for parameter, place in zip(problem.parameters, transcription.parameters, strict=True):
            if parameter.bounds != Range():
                own[f"bounds of {parameter.name}"] = float(sense * (lower[place] - upper[place])) + 0.0
        found.append(own)
    return tuple(found), {name: value for name, value in of(BETWEEN).items() if name not in passages}
