"""What an iterate violates, and by how much."""

from __future__ import annotations

import numpy as np

from ..constraint_kinds import ConstraintKind
from ..layout import Family, Transcription
from ..program.contract import NonlinearProgram
from ..solution.trajectory import Trajectory, trajectories
from ..solution.violation import Violation, constraint_named, times_at

NEGLIGIBLE = 1e-7  # IPOPT itself lets constraints be missed by 1e-8
TELLING = 1e-4  # of the largest violation: smaller ones tell nothing


def violations(transcription: Transcription, nlp: NonlinearProgram, z: np.ndarray) -> list[Violation]:
    """The largest violation of each constraint, worst first; without those that do not matter.

    transcription: what stands where.
    nlp: its compiled program.
    z: the iterate, shape (n,).
    """
    g = nlp.constraints_unchecked(z)
    excess = np.maximum(np.maximum(nlp.cl - g, g - nlp.cu), 0.0)
    excess[np.isnan(excess)] = np.inf
    phases = {trajectory.phase.name: trajectory for trajectory in trajectories(transcription, z)}
    worst: dict[tuple[str, ConstraintKind, str], Violation] = {}
    for family in transcription.families:
        violation = _worst(family, excess[family.rows(nlp)], phases.get(family.phase))
        key = family.phase, family.kind, family.name
        worst[key] = max(worst.get(key, violation), violation, key=lambda v: v.amount)
    large = max((v.amount for v in worst.values()), default=0.0) * TELLING
    telling = (v for v in worst.values() if v.amount > max(large, NEGLIGIBLE))
    return sorted(telling, key=lambda v: -v.amount)


def _worst(family: Family, excess: np.ndarray, trajectory: Trajectory | None) -> Violation:
    i = int(np.argmax(excess))
    start, end = times_at(trajectory, family.span[i]) if trajectory else (np.nan, np.nan)
    return Violation(family.phase, family.kind, family.name, start, end, float(excess[i]))


def counted(transcription: Transcription, nlp: NonlinearProgram) -> str:
    """How many equalities there are, of which kind, and how many unknowns."""
    ranges = [variable.bounds for variable in transcription.variables]
    free = sum(lower is None or lower != upper for lower, upper in ranges)
    counts: dict[str, int] = {}
    for family in transcription.families:
        rows = family.rows(nlp)
        what = constraint_named(family.phase, family.kind, family.name)
        counts[what] = counts.get(what, 0) + int((nlp.cl[rows] == nlp.cu[rows]).sum())
    parts = [f"{count} from {what}" for what, count in counts.items() if count]
    return f"{sum(counts.values())} equations for {free} unknowns: {', '.join(parts)}"
