"""The sparse matrices of a nonlinear program, and linear systems that may be singular."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..program.contract import NonlinearProgram


def jacobian_of(nlp: NonlinearProgram, z: np.ndarray) -> Any:
    """dg/dz at z (n,), sparse, (m, n), compressed by rows. Raises NotFinite."""
    from scipy.sparse import coo_matrix

    return coo_matrix((nlp.jacobian(z), nlp.jacobianstructure()), (nlp.m, nlp.n)).tocsr()


def hessian_of(nlp: NonlinearProgram, z: np.ndarray, y: np.ndarray) -> Any:
    """d2(f + y g)/dz2, both of its halves, sparse, (n, n), compressed by rows.

    nlp: the program.
    z: (n,) the unknowns.
    y: (m,) the multipliers.

    Raises NotFinite.
    """
    from scipy.sparse import coo_matrix, diags

    half = coo_matrix((nlp.hessian(z, y, 1.0), nlp.hessianstructure()), (nlp.n, nlp.n)).tocsr()
    return half + half.T - diags(half.diagonal())


def solved(matrix: Any, right: np.ndarray) -> np.ndarray | None:
    """The solution of a square sparse system; None if its matrix is singular.

    matrix: (n, n), compressed by columns.
    right: (n,) or (n, K).

    SuperLU finds a matrix singular by its numbers. One that is singular whatever its numbers are, as with more
    equations than unknowns in them, makes it read what it has not written, and may end the process
    (https://github.com/xiaoyeli/superlu/issues/33): that is looked at before.
    """
    from scipy.sparse.csgraph import structural_rank
    from scipy.sparse.linalg import splu

    if structural_rank(matrix) < matrix.shape[0]:
        return None
    try:
        solution: np.ndarray = splu(matrix).solve(right)
    except RuntimeError:  # the factor is exactly singular
        return None
    return solution
