"""Whether costates jump where something is measured by what the measurement says (see `transcription.measured`)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...transcription.measured.knots import knots_at, measured_fractions
from ..file.reload import Reloaded
from .check import Check, at

ROUNDING = 1e-8
"""Of 1 + |J|: what a state is worth over its range, where its costate is zero but for rounding."""


def jumps_of_costates(result: Reloaded, number: int, tolerance: float) -> Iterator[Check]:
    """The worst of lambda(t-) - lambda(t+) - dW/dx(t) at the times of measurements, relative to the largest costate.

    result: read back, with measurements.
    number: of the phase, from 0; its trajectory has costates.
    tolerance: the largest value that passes.
    """
    trajectory, layout = result.trajectories[number], result.transcription.phases[number]
    mesh, costate = trajectory.mesh, trajectory.costate
    inner = knots_at(mesh, measured_fractions(trajectory.phase))
    if costate is None or not len(inner):
        return
    slopes = result.nlp.term.gradient(result.outcome.z)[layout.x[:, mesh.knots[inner]]]  # type: ignore[attr-defined]
    before, after = costate[:, mesh.offset[inner] - 1], costate[:, mesh.offset[inner]]
    worth = ROUNDING * (1 + abs(result.outcome.objective)) / np.where(moved := np.ptp(trajectory.x, axis=1), moved, 1.0)
    missed = np.abs(before - after - slopes) / (np.abs(costate).max(axis=1) + worth)[:, None]
    i, k = map(int, np.unravel_index(np.argmax(np.nan_to_num(missed, nan=np.inf)), missed.shape))
    name = "costates jump by what is measured, relative"
    where = f"{trajectory.phase.states[i].name}, {at(trajectory, trajectory.knots[inner[k]])}"
    yield Check(name, float(missed[i, k]), tolerance, where)
