"""Sparse linear systems that may be singular."""

from __future__ import annotations

from typing import Any

import numpy as np


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
