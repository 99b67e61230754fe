"""Whether a point that the engine calls acceptable only is as near to the constraints as rounding lets it be.

IPOPT's tolerance of a constraint is absolute, in the unit of the file. Where states are of the order 1e7, a defect is
a difference of terms of 1e8, and double precision has no digits for the 1e-8 that it should be: the iterations go round
in circles, and end at an acceptable point that is as good as a solved one.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..program.contract import NonlinearProgram, NotFinite

UNITS = 100.0
"""Of the rounding of the largest terms of a constraint: so far from its bounds it may be."""

MEAN = 100.0
"""The mean multiplier from which on IPOPT's dual infeasibility is relative to it (Waechter and Biegler 2006, (5))."""


def met_to_rounding(
    nlp: NonlinearProgram,
    z: np.ndarray,
    multipliers: np.ndarray,
    last: Mapping[str, float],
    tolerance: float,
) -> bool:
    """Whether nothing but rounding keeps a point from the tolerance.

    nlp: the program.
    z: the point, shape (n,).
    multipliers: of all constraints and bounds.
    last: the record of the last iteration, name in COLUMNS -> number.
    tolerance: of the engine.

    |g_i - [its bounds]| <= max(tolerance, UNITS eps sum_j |J_ij z_j|) for all i; the duals meet the tolerance.
    """
    scale = max(MEAN, float(np.abs(multipliers).mean())) / MEAN
    if not (last["mu"] <= tolerance and last["dual_infeasibility"] <= tolerance * scale):
        return False
    try:
        g, J = nlp.constraints(z), nlp.jacobian(z)
    except NotFinite:
        return False
    rows, columns = nlp.jacobianstructure()
    terms = np.zeros(nlp.m)
    np.add.at(terms, rows, np.abs(J * z[columns]))
    beyond = np.maximum(np.maximum(nlp.cl - g, g - nlp.cu), 0.0)
    return bool((beyond <= np.maximum(tolerance, UNITS * np.finfo(float).eps * terms)).all())
