"""Equations that say the same thing: null vectors of the transposed Jacobian of all equations.

Rows of equations, and unknowns that their bounds fix, are taken together; each row is scaled to length 1. A pivoted QR
factorisation of the transposed matrix finds the rows that are combinations of others, and with each the ones that it is
a combination of. Linear algebra is dense, so large programs are left alone.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..engines.linear import jacobian_of
from ..engines.outcome import Outcome
from ..layout import Transcription, bounded_start
from ..program.contract import NonlinearProgram, NotFinite
from ..solution.violation import Trouble, constraint_named, of_phase

RANK = 1e-9  # of the largest diagonal entry of R: below it, a row adds nothing
SHARE = 0.05  # of the largest coefficient of a combination: smaller ones name nobody
LARGEST = 1500  # equations of a program that is looked at: a second of work, in each attempt that fails


def dependent(transcription: Transcription, nlp: NonlinearProgram, outcome: Outcome) -> Trouble:
    """Which equations are combinations of each other at a point, if any are and it can be said.

    transcription: what stands where.
    nlp: its compiled program.
    outcome: how the engine ended.
    """
    _, lower, upper = bounded_start(transcription)
    fixed, rows = np.flatnonzero(lower == upper), np.flatnonzero(nlp.cl == nlp.cu)
    if not len(rows) or len(rows) + len(fixed) > LARGEST:
        return Trouble()
    try:
        dense = jacobian_of(nlp, outcome.z).toarray()
    except NotFinite:
        return Trouble()
    units = np.zeros((len(fixed), nlp.n))
    units[np.arange(len(fixed)), fixed] = 1.0
    combination = _combination(np.vstack([dense[rows], units]))
    if combination is None:
        return Trouble()
    strong = np.abs(combination) > SHARE * np.abs(combination).max()
    named = tuple(dict.fromkeys(_names(transcription, nlp, rows[strong[: len(rows)]], fixed[strong[len(rows) :]])))
    if len(named) < 2:
        return Trouble()
    return Trouble("these say the same thing, at least at this point: {}; remove one of them", named)


def _combination(matrix: np.ndarray) -> np.ndarray | None:
    """Coefficients (rows,) of the combination of the fewest rows that vanishes; None if none does."""
    from scipy.linalg import qr, solve_triangular

    lengths = np.linalg.norm(matrix, axis=1)
    scaled = matrix / np.where(lengths > 0, lengths, 1.0)[:, None]
    R, pivots = qr(scaled.T, mode="r", pivoting=True, check_finite=False)
    diagonal = np.abs(np.diag(R))
    rank = int((diagonal > RANK * diagonal.max(initial=0.0)).sum())
    if rank == len(matrix):
        return None
    found = []
    for extra in range(rank, min(len(matrix), R.shape[1])):
        own = np.zeros(len(matrix))
        own[pivots[extra]] = 1.0
        own[pivots[:rank]] = -solve_triangular(R[:rank, :rank], R[:rank, extra])
        found.append(own)
    return min(found, key=lambda own: int((np.abs(own) > SHARE * np.abs(own).max()).sum()))


def _names(transcription: Transcription, nlp: NonlinearProgram, rows: np.ndarray, fixed: np.ndarray) -> Iterator[str]:
    """What rows and fixed unknowns are called: what holds once before the dynamics, which are in most combinations."""
    families = sorted(transcription.families, key=lambda family: (family.kind.model, family.kind.timed))
    for family in (own for own in families if not own.kind.model):
        if np.isin(family.rows(nlp), rows).any():
            yield constraint_named(family.phase, family.kind, family.name)
    for layout in transcription.phases:
        for state, places in zip(layout.phase.states, layout.x, strict=True):
            for end, place in (("initial", places[0]), ("final", places[-1])):
                if place >= 0 and place in fixed:
                    yield f"the {end} value of {state.name}{of_phase(layout.phase.name)}"
    for family in (own for own in families if own.kind.model):
        if np.isin(family.rows(nlp), rows).any():
            yield constraint_named(family.phase, family.kind, family.name)
