"""Whether a result file agrees with itself: what people read in it, the solver's point, and what it claims."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...transcription.layout import bounded_start
from ...transcription.solution.trajectory import Trajectory
from ..file.read import PhaseCurves, read
from ..file.reload import Reloaded
from .check import Check

SAME = 1e-8
"""Of the size of a curve, or of 1 + |J|: stored twice, a number differs by rounding only."""

MISSED = 1e-6
"""Of 1 + |bound|, or of the size of the state, or 10 times the tolerance of the engine: what the constraints may be
missed by at the points."""


def stored(path: Path, result: Reloaded) -> Iterator[Check]:
    """Checks of the arrays of a result file, of its objective and of its rows, all against the solver's point z."""
    phases = {phase.name: phase for phase in read(path).phases}
    for trajectory in result.trajectories:
        yield _arrays(trajectory, phases[trajectory.phase.name])
    objective = result.problem.sense * result.nlp.objective(result.outcome.z)
    difference = abs(objective - result.objective) / (1 + abs(result.objective))
    yield Check("stored objective, from that of the solver's point, relative", float(difference), SAME)
    if result.solved:
        limit = max(MISSED, 10 * result.records[-1].tolerance)
        yield Check("constraints at the points, relative", _missed(result), limit)


def _arrays(trajectory: Trajectory, curves: PhaseCurves) -> Check:
    """The largest difference of a stored curve from the trajectory of the solver's point, relative to its size."""
    phase, dense = trajectory.phase, trajectory.dense
    collocated = np.isin(np.arange(len(trajectory.times)), trajectory.mesh.collocated)
    rows = [("state", v.name, trajectory.x[i], dense.x[i]) for i, v in enumerate(phase.states)]
    kinds = ["control"] * len(phase.controls) + ["algebraic"] * (len(phase.inputs) - len(phase.controls))
    rows += [
        (kind, v.name, np.where(collocated, trajectory.u[i], np.nan), dense.u[i])
        for i, (kind, v) in enumerate(zip(kinds, phase.inputs, strict=True))
    ]
    if trajectory.costate is not None and dense.costate is not None:
        costate = trajectory.point_costate
        rows += [("costate", v.name, costate[i], dense.costate[i]) for i, v in enumerate(phase.states)]
    found = [(_difference(trajectory.times, curves.time), "points/time")]
    found.append((_difference(dense.t, curves.dense_time), "dense/time"))
    for kind, name, points, samples in rows:
        curve = curves.curves[kind].get(name)
        found.append((_difference(points, curve.points if curve else np.empty(0)), f"points/{kind}/{name}"))
        found.append((_difference(samples, curve.dense if curve else np.empty(0)), f"dense/{kind}/{name}"))
    worst, where = max(found, key=lambda own: np.inf if np.isnan(own[0]) else own[0])
    return Check(f"stored arrays of {phase.name}, from the solver's point, relative", worst, SAME, where)


def _difference(own: np.ndarray, stored: np.ndarray) -> float:
    """Relative to the largest value, where both have one; NaN if that is nowhere."""
    if own.shape != stored.shape:
        return float("inf")
    both = np.isfinite(own) & np.isfinite(stored)
    if not both.any():
        return float("nan")
    size = 1 + np.abs(own[both]).max(initial=0.0)
    return float(np.abs(own[both] - stored[both]).max(initial=0.0) / size)


def _missed(result: Reloaded) -> float:
    """By how much z, or rows of the program at z, are outside their bounds, at most.

    Relative to 1 + |bound|, and defects to 1 + the size of their state.
    """
    nlp, z = result.nlp, result.outcome.z
    sizes = {
        own.phase.name: dict(zip((s.name for s in own.phase.states), np.abs(own.x).max(axis=1), strict=True))
        for own in result.trajectories
    }
    size = np.zeros(nlp.n + nlp.m)
    for family in result.transcription.families:
        if family.kind.sized:
            size[nlp.n :][family.rows(nlp)] = sizes[family.phase].get(family.name, 0.0)
    _, lower, upper = bounded_start(result.transcription)
    values = np.concatenate([z, nlp.constraints_unchecked(z)])
    lower, upper = np.concatenate([lower, nlp.cl]), np.concatenate([upper, nlp.cu])
    below = (lower - values) / (1 + np.maximum(size, np.abs(np.where(np.isfinite(lower), lower, 0.0))))
    above = (values - upper) / (1 + np.maximum(size, np.abs(np.where(np.isfinite(upper), upper, 0.0))))
    missed = np.maximum(below, above)
    return float(np.max(np.nan_to_num(missed, nan=np.inf), initial=0.0))
