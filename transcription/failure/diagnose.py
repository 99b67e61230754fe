"""A failed solve in the user's terms: which constraint, which expression, which phase, when, by how much."""

from __future__ import annotations

import numpy as np

from ..engines.outcome import Outcome, Status
from ..layout import Transcription
from ..program.contract import NonlinearProgram
from ..solution.trajectory import trajectories
from ..solution.violation import Trouble, Violation
from .runaway import divided, fallen, runaway
from .unlimited import told_of_shrinking
from .violations import counted, violations

BROKEN = (Status.INVALID_NUMBER, Status.STEP_FAILED, Status.RESTORATION_FAILED, Status.STALLED, Status.FAILED)
"""Statuses that a function without a finite value explains, if there was one at the end."""

NEVER_RAN = (Status.INVALID_OPTION, Status.INVALID_PROBLEM, Status.NO_MEMORY)
"""What the guess violates is no reason for these."""


def diagnose(
    transcription: Transcription, nlp: NonlinearProgram, outcome: Outcome
) -> tuple[tuple[Violation, ...], Trouble]:
    """The constraints that the last iterate violates, worst first, and what explains the failure.

    transcription: what stands where.
    nlp: its compiled program.
    outcome: how the engine ended.
    """
    if outcome.status in (Status.SOLVED, Status.FEASIBLE, *NEVER_RAN):
        return (), Trouble(runaway(transcription, outcome) if fallen(outcome) else "")
    # what explains a failure is loaded when there is one
    from .conflict import conflict
    from .dependent import dependent
    from .non_finite import explain_non_finite

    if outcome.status is Status.INVALID_NUMBER:  # the guess violates much, and that is not why
        told = [explain_non_finite(transcription, outcome.failed)]
        told += [_kink(transcription, outcome.failed[0])] if outcome.failed else []
        return (), Trouble("; ".join(filter(None, told)))
    found = tuple(violations(transcription, nlp, outcome.z))
    if outcome.failed and outcome.status in BROKEN:
        return found, Trouble(explain_non_finite(transcription, outcome.failed))
    if outcome.status is Status.INFEASIBLE:
        return found, conflict(transcription, nlp, outcome)
    if outcome.status is Status.OVERDETERMINED:
        return found, Trouble(counted(transcription, nlp))
    words = told_of_shrinking(trajectories(transcription, outcome.z)) or runaway(transcription, outcome)
    words = words or _kink(transcription, outcome.z)
    words = words or (divided(trajectories(transcription, outcome.z)) if outcome.status in BROKEN else "")
    return found, Trouble(words) if words else dependent(transcription, nlp, outcome)


def _kink(transcription: Transcription, z: np.ndarray) -> str:
    """The first norm that vanishes at the unknowns z, shape (n,), and the remedy."""
    from .kinks import vanishing_norm  # as above

    return next(filter(None, map(vanishing_norm, trajectories(transcription, z))), "")
