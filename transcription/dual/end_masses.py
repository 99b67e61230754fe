"""Multipliers of path constraints at the ends of time: what acts over time, without what acts at the end only.

A path constraint on the states alone may act at a free initial or final value as a boundary constraint would: then its
row there has a multiplier that is no density times a weight. It belongs to the end, as the multiplier of a bound on the
initial value does: the costate jumps by it, and its value inside the phase has nothing of it.

Of an algebraic variable z that the states determine, by residuals r(x, z) = 0, the same holds of a path constraint g
and of its bounds. What these do at the end only, d nu and d zeta, the residuals pass on to the states, by d kappa:

    d nu dg/dz + d kappa dr/dz + d zeta = 0
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ...problems.conserved.determined import Determined, determined, of_states_alone
from ...problems.problem import Phase
from ..constraint_kinds import PATH, RESIDUAL
from ..engines.outcome import Outcome
from ..layout import Family, Layout, Transcription


def without_end_masses(transcription: Transcription, nlp: Any, outcome: Outcome) -> np.ndarray:
    """The multipliers with those at the ends cut to the density that the next point has, shape (m,).

    transcription: its path constraints on the states alone are meant.
    nlp: the compiled program, which knows the rows of a family.
    outcome: with multipliers of all rows, which are left as they are.
    """
    cut = np.array(outcome.y)
    for layout in transcription.phases:
        phase = layout.phase
        for constraint in phase.path:
            same = list(_families(transcription, phase, PATH, constraint.name))
            if same and of_states_alone(phase, constraint.function):
                _cut(cut, *(np.concatenate(part) for part in zip(*(_points(f, nlp) for f in same), strict=True)))
        if outcome.status.usable and (own := determined(phase)).names:
            _pass_on(cut, transcription, layout, own, nlp, outcome)
    return cut


def _families(transcription: Transcription, phase: Phase, kind: Any, name: str) -> Iterator[Family]:
    wanted = (phase.name, kind, name)
    return (own for own in transcription.families if (own.phase, own.kind, own.name) == wanted)


def _points(family: Family, nlp: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Normalised times, rows and weights of a family, each (M,)."""
    return family.span[:, 0], family.rows(nlp), np.broadcast_to(family.weights, len(family.span))


def _cut(y: np.ndarray, s: np.ndarray, rows: np.ndarray, weights: np.ndarray) -> None:
    order = np.argsort(s, kind="stable")
    for end, first, second in ((0.0, *order[:2]), (1.0, *order[:-3:-1])) if len(order) > 1 else ():
        if s[first] == end:
            y[rows[first]] = _without_mass(y[rows[[first, second]]], weights[[first, second]])


def _without_mass(y: np.ndarray, weights: np.ndarray) -> float:
    """The multiplier at an end, as far as it is a density; y, weights: there and at the next point, (2,) each."""
    largest = abs(y[1] / weights[1] * weights[0]) if weights[1] else 0.0
    return float(np.clip(y[0], -largest, largest))


def _pass_on(
    cut: np.ndarray, transcription: Transcription, layout: Layout, own: Determined, nlp: Any, outcome: Outcome
) -> None:
    """Change the multipliers of the residuals at the ends by what those of constraints there have lost."""
    names = [variable.name for variable in layout.phase.inputs]
    places = layout.u[[names.index(name) for name in sorted(own.names)]]
    zeta = np.where(places >= 0, outcome.z_upper[places] - outcome.z_lower[places], 0.0)
    weights, points = layout.mesh.weights, np.flatnonzero((places >= 0).all(axis=0))
    for first, second in ((points[0], points[1]), (points[-1], points[-2])) if len(points) > 1 else ():
        s, both = layout.mesh.fractions[first], [first, second]
        if s not in (0.0, 1.0) or not weights[first]:  # what is there for the end alone is of no other density
            continue
        lost = np.array([_without_mass(each[both], weights[both]) - each[first] for each in zeta])
        rows = np.concatenate([
            rows[times == s]
            for residual in own.residuals
            for family in _families(transcription, layout.phase, RESIDUAL, residual.name)
            for times, rows, _ in [_points(family, nlp)]
        ])  # fmt: skip
        slopes = _columns(nlp, outcome.z, places[:, first])
        left = slopes.T @ (cut - outcome.y) + lost
        cut[rows] -= np.linalg.lstsq(slopes[rows].T, left, rcond=None)[0]


def _columns(nlp: Any, z: np.ndarray, places: np.ndarray) -> np.ndarray:
    """The derivatives of all rows by a few unknowns, shape (m, len(places))."""
    rows, columns = nlp.jacobianstructure()
    values, found = nlp.jacobian(z), np.zeros((nlp.m, len(places)))
    for slopes, place in zip(found.T, places, strict=True):
        np.add.at(slopes, rows[columns == place], values[columns == place])
    return found
