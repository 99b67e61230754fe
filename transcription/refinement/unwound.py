"""Angles among the controls: of all values that mean the same, those that make a curve.

A heading that stands under sin and cos alone may be theta at one point and theta + 2 pi at the next. The program sees
no difference, but the interpolant swings by 2 pi between them: the error is large on every mesh, and no refinement
helps. So multiples of the period are taken off where that leaves the objective and the constraints as they are.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from ..layout import Transcription, bounded_start
from ..program.contract import NonlinearProgram, NotFinite

PERIODS = (np.pi, 2 * np.pi, 4 * np.pi)
"""Of sin(2 theta), sin(theta) and sin(theta/2)."""

SAME = 1e-9  # relative; what is left is the rounding of sin(theta + 2 pi)
SEEN = 1e-3  # of what a third of a period changes, at most, by whole ones


def unwound(transcription: Transcription, nlp: NonlinearProgram, z: np.ndarray) -> np.ndarray:
    """The unknowns with each input that jumps by multiples of a period made continuous.

    transcription: of the solve that led to z.
    nlp: its program.
    z: unknowns, shape (n,).

    An input stays as it is if the objective or a constraint would change, or if it would leave its bounds.
    """
    rows = [row[row >= 0] for layout in transcription.phases for row in layout.u]
    jumping = [row for row in rows if np.any(np.abs(np.diff(z[row])) > PERIODS[0] / 2)]
    if not jumping:
        return z
    _, lower, upper = bounded_start(transcription)
    meant = _values(nlp, z)
    for row, period in product(jumping, PERIODS):
        other = _continuous(z, row, period)
        within = np.all((other >= lower)[row] & (other <= upper)[row])
        if within and _is_period(_values(nlp, other) - meant, _between(nlp, z, row, period) - meant, meant):
            z = other
    return z


def _is_period(moved: np.ndarray, between: np.ndarray, meant: np.ndarray) -> bool:
    """Whether nothing changes by whole periods, and something does between them: what is small in itself is no angle.

    moved, between: changes of the values `meant`, by whole periods and by a part of one, all (1 + m,).
    """
    same = bool(np.all(np.abs(moved) <= SAME * (1 + np.abs(meant))))
    return same and bool(np.abs(moved).max() <= SEEN * np.abs(between).max())  # NaN between: nothing is known


def _between(nlp: NonlinearProgram, z: np.ndarray, row: np.ndarray, period: float) -> np.ndarray:
    """The values with the unknowns of a row moved by a part of a period."""
    aside = z.copy()
    aside[row] += period / 3
    return _values(nlp, aside)


def _continuous(z: np.ndarray, row: np.ndarray, period: float) -> np.ndarray:
    """The unknowns with those of a row, in the order of time, moved by multiples of a period; none if none jumps."""
    turned = np.unwrap(z[row], period=period)
    other = z.copy()
    if not np.array_equal(turned, z[row]):
        other[row] = turned - period * np.round(turned.mean() / period)
    return other


def _values(nlp: NonlinearProgram, z: np.ndarray) -> np.ndarray:
    """The constraints and the objective, NaN where it is not finite: with that nothing is the same."""
    try:
        objective = nlp.objective(z)
    except NotFinite:
        objective = np.nan
    return np.append(nlp.constraints_unchecked(z), objective)
