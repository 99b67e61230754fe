"""Equations that say the same thing: null vectors of the transposed Jacobian of all equations.

Rows of equations, and unknowns that their bounds fix, are taken together; each row is scaled to length 1. A pivoted QR
factorisation of the transposed matrix finds the rows that are combinations of others, and with each the ones that it is
a combination of. That is slow, and most rows are independent: where a Cholesky factorisation of A A' shows it, in a
tenth of the time, there is nothing to find. Linear algebra is dense, so large programs are left alone.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ..engines.linear import jacobian_of
from ..engines.outcome import Outcome
from ..layout import Transcription, bounded_start
from ..program.contract import NonlinearProgram, NotFinite
from ..solution.violation import Trouble, constraint_named, of_phase

RANK = 1e-9  # of the largest diagonal entry of R: below it, a row adds nothing
INDEPENDENT = 1e-13  # eigenvalues of A A' above it: some hundred times its rounding, and above the square of RANK
SHARE = 0.05  # of the largest coefficient of a combination: smaller ones name nobody
LARGEST = 1500  # equations of a program that is looked at: a second of work, in each attempt that fails


def dependent(transcription: Transcription, nlp: NonlinearProgram, outcome: Outcome) -> Trouble:
    """Which equations are combinations of each other at a point, if any are and it can be said.

    transcription: what stands where.
    nlp: its compiled program.
    outcome: how the engine ended.
    """
    from scipy.sparse import csr_matrix, vstack

    _, lower, upper = bounded_start(transcription)
    fixed, rows = np.flatnonzero(lower == upper), np.flatnonzero(nlp.cl == nlp.cu)
    if not len(rows) or len(rows) + len(fixed) > LARGEST:
        return Trouble()
    try:
        equations = jacobian_of(nlp, outcome.z).tocsr()[rows]
    except NotFinite:
        return Trouble()
    units = csr_matrix((np.ones(len(fixed)), (np.arange(len(fixed)), fixed)), (len(fixed), nlp.n))
    combination = _combination(vstack([equations, units], format="csr"))
    if combination is None:
        return Trouble()
    strong = np.abs(combination) > SHARE * np.abs(combination).max()
    named = tuple(dict.fromkeys(_names(transcription, nlp, rows[strong[: len(rows)]], fixed[strong[len(rows) :]])))
    if len(named) < 2:
        return Trouble()
    return Trouble("these say the same thing, at least at this point: {}; remove one of them", named)


def _combination(matrix: Any) -> np.ndarray | None:
    """Coefficients (rows,) of the combination of the fewest rows of a sparse matrix that vanishes; None without one."""
    from scipy.linalg import qr, solve_triangular
    from scipy.sparse import diags

    lengths = np.sqrt(matrix.multiply(matrix).sum(axis=1)).A1
    scaled = diags(1 / np.where(lengths > 0, lengths, 1.0)) @ matrix
    if _independent((scaled @ scaled.T).toarray()):
        return None
    R, pivots = qr(scaled.toarray().T, mode="r", pivoting=True, check_finite=False)
    diagonal, count = np.abs(np.diag(R)), len(lengths)
    rank = int((diagonal > RANK * diagonal.max(initial=0.0)).sum())
    if rank == count:
        return None
    found = []
    for extra in range(rank, min(count, R.shape[1])):
        own = np.zeros(count)
        own[pivots[extra]] = 1.0
        own[pivots[:rank]] = -solve_triangular(R[:rank, :rank], R[:rank, extra])
        found.append(own)
    return min(found, key=lambda own: int((np.abs(own) > SHARE * np.abs(own).max()).sum()))


def _independent(products: np.ndarray) -> bool:
    """Whether rows certainly are independent.

    products: A A' of rows of length 1, shape (rows, rows).
    """
    try:
        np.linalg.cholesky(products - INDEPENDENT * np.eye(len(products)))
    except np.linalg.LinAlgError:
        return False
    return True


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
