"""Multipliers of path constraints at the ends of time: what acts over time, without what acts at the end only.

A path constraint on the states alone may act at a free initial or final value as a boundary constraint would: then its
row there has a multiplier that is no density times a weight. It belongs to the end, as the multiplier of a bound on the
initial value does: the costate jumps by it, and its value inside the phase has nothing of it.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...problems.probe import depends_on
from ...problems.problem import Phase
from ..constraint_kinds import PATH
from ..layout import Family, Transcription


def without_end_masses(transcription: Transcription, nlp: Any, y: np.ndarray) -> np.ndarray:
    """The multipliers with those at the ends cut to the density that the next point has, shape (m,).

    transcription: its path constraints on the states alone are meant.
    nlp: the compiled program, which knows the rows of a family.
    y: multipliers of all rows, shape (m,); left as they are.
    """
    cut = np.array(y)
    for phase in (layout.phase for layout in transcription.phases):
        for constraint in phase.path:
            if depends_on(constraint.function, inputs_of(phase)):
                continue
            own = (phase.name, PATH, constraint.name)
            same = [f for f in transcription.families if (f.phase, f.kind, f.name) == own]
            if same:
                _cut(cut, *(np.concatenate(part) for part in zip(*(_points(f, nlp) for f in same), strict=True)))
    return cut


def inputs_of(phase: Phase) -> set[str]:
    """The names of the controls and algebraic variables."""
    return {variable.name for variable in phase.found}


def _points(family: Family, nlp: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Normalised times, rows and weights of a family, each (M,)."""
    return family.span[:, 0], family.rows(nlp), np.broadcast_to(family.weights, len(family.span))


def _cut(y: np.ndarray, s: np.ndarray, rows: np.ndarray, weights: np.ndarray) -> None:
    order = np.argsort(s, kind="stable")
    for end, first, second in ((0.0, *order[:2]), (1.0, *order[:-3:-1])) if len(order) > 1 else ():
        if s[first] == end:
            density = y[rows[second]] / weights[second] if weights[second] else 0.0
            largest = abs(density * weights[first])
            y[rows[first]] = np.clip(y[rows[first]], -largest, largest)
