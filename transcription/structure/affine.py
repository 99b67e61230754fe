"""Whether the Hamiltonian is linear in a control: inside its bounds, such a one is singular or holds a constraint."""

from __future__ import annotations

import numpy as np

from ..solution.trajectory import Trajectory

AFFINE = 1e-9  # relative: what the middle of two values may differ from the value of the middle
STEP = 0.1  # of the range of a control, or of 1 + its size where it has none


def is_affine(trajectory: Trajectory, i: int) -> bool:
    """Whether all that makes the Hamiltonian, and what bounds it, is linear in a control, at the points.

    trajectory: of one phase.
    i: which of its controls.

    With algebraic variables, which depend on it by equations, that is not known: no.
    """
    phase = trajectory.phase
    if phase.algebraic:
        return False
    points = trajectory.mesh.collocated
    t, x, u = trajectory.times[points], trajectory.x[:, points], trajectory.u[:, points]
    width = phase.controls[i].bounds.upper - phase.controls[i].bounds.lower
    step = STEP * (width if np.isfinite(width) else 1.0 + np.abs(u[i]))
    sides = []
    for shift in (-step, 0 * step, step):
        own = u.copy()
        own[i] = own[i] + shift
        sides.append(phase.arguments(t, x, own, trajectory.parameters))
    with np.errstate(all="ignore"):
        for function in phase.over_time:
            low, middle, high = (np.broadcast_to(function(values, np), t.shape) for values in sides)
            bent, size = np.abs(low - 2 * middle + high), 1 + np.abs(middle) + np.abs(high - low)
            if (bent > AFFINE * size)[np.isfinite(bent)].any():
                return False
    return True
