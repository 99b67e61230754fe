"""Controls that a minimum of the Hamiltonian over all of them is looked for among: samples of what is feasible.

An even sequence of points (Kronecker's, by the powers of a generalised golden ratio; NumPy's random numbers take longer
to import) between the bounds, or around what the trajectory does where there are none, with the corners if they are
few (where H is linear in the controls the minimum is at one), and the controls of other times. Path constraints are
met by Newton steps from there, the shortest ones: so an equation is sampled on its manifold.
"""

from __future__ import annotations

import numpy as np

from ..solution.hamiltonian import Constrained

SAMPLES = 64  # of the sequence, for each control
MOST_SAMPLES = 256
CORNERS = 4  # controls at most, for their corners
OTHER_TIMES = 16
BEYOND = 3.0  # so that values of the other sign are among them
STEPS = 30  # of Newton's method
MET = 1e-10  # of 1 + |bound|, by what a constraint may be missed
DIFFERENCE = 1e-7  # of a derivative, in widths of the box; steps go on until the constraint is met, so it may be rough
DAMPING = 1e-12  # of the squared slopes: keeps the equations of a step solvable where constraints say the same


def box(u: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """Where to look for controls, shape (2, n): between the bounds, or BEYOND times its size around the trajectory.

    u: the controls along the trajectory, shape (n, M).
    bounds: lower and upper, shape (2, n).
    """
    size = np.abs(u).max(axis=1)
    size = np.where(size > 0, size, 1.0)
    around = np.array([u.min(axis=1) - BEYOND * size, u.max(axis=1) + BEYOND * size])
    return np.where(np.isfinite(bounds), bounds, around)


def candidates(u: np.ndarray, within: np.ndarray, samples: int = SAMPLES) -> np.ndarray:
    """Controls to try at every time, shape (n, B), before they meet the path constraints.

    u: the controls along the trajectory, shape (n, M).
    within: as of `box`.
    samples: of the sequence, for each control.
    """
    n = len(u)
    count = min(samples * n, MOST_SAMPLES)
    ratio = np.max(np.roots([1.0, *[0.0] * (n - 1), -1.0, -1.0]).real)  # of x^(n + 1) = x + 1
    multiples = np.arange(1, count + 1) * ratio ** -np.arange(1.0, n + 1)[:, None]
    unit = [(0.5 + multiples) % 1.0, np.full((n, 1), 0.5)]
    if n <= CORNERS:
        unit.append(np.stack(np.meshgrid(*[[0.0, 1.0]] * n)).reshape(n, -1))
    lower, width = within[0][:, None], np.diff(within, axis=0).T
    others = u[:, np.linspace(0, u.shape[1] - 1, OTHER_TIMES).astype(int)]
    others = np.clip(others, *within[:, :, None])
    return np.concatenate([lower + width * np.concatenate(unit, axis=1), others], axis=1)


def feasible(
    v: np.ndarray, within: np.ndarray, constrained: Constrained | None, k: np.ndarray, steps: int = STEPS
) -> np.ndarray:
    """Controls v, shape (n, B, S), moved onto the constraints; NaN where that does not succeed.

    v: controls within the box.
    within: the box, shape (2, n).
    constrained: the constraints, or None.
    k: the numbers of the samples, shape (S,).
    steps: of Newton's method, at most.
    """
    if constrained is None:
        return v
    v, (lower, upper) = v.copy(), within[:, :, None, None]
    for _ in range(steps):
        missed = _missed(v, constrained, k)
        if not (np.abs(missed) > 0).any():
            break
        slopes = _slopes(v, upper - lower, constrained, k)
        step = _step(missed, slopes)
        held = ((v <= lower) & (step < 0)) | ((v >= upper) & (step > 0))
        step = _step(missed, np.where(held.transpose(1, 2, 0)[:, :, None, :], 0.0, slopes))
        v = np.clip(v + np.nan_to_num(step) * (upper - lower), lower, upper)
    size = 1 + np.abs(_bound(_missed(v, constrained, k), constrained))
    met = (np.abs(_missed(v, constrained, k)) <= MET * size).all(axis=0)
    return np.where(met, v, np.nan)


def _missed(v: np.ndarray, c: Constrained, k: np.ndarray) -> np.ndarray:
    """By what each constraint is missed, with its sign: shape (n_c, B, S)."""
    g = c.values(v, k)
    missed: np.ndarray = g - np.clip(g, c.lower[:, None, None], c.upper[:, None, None])
    return missed


def _bound(missed: np.ndarray, c: Constrained) -> np.ndarray:
    """The bound that is missed, or 0."""
    near = np.where(missed > 0, c.upper[:, None, None], c.lower[:, None, None])
    return np.where(np.isfinite(near), near, 0.0)


def _slopes(v: np.ndarray, width: np.ndarray, c: Constrained, k: np.ndarray) -> np.ndarray:
    """Derivatives of the constraints by the controls in widths of the box, shape (B, S, n_c, n)."""
    here, columns = c.values(v, k), []
    for i in range(len(v)):
        moved = v.copy()
        moved[i] += DIFFERENCE * width[i]
        columns.append((c.values(moved, k) - here) / DIFFERENCE)
    return np.stack(columns).transpose(2, 3, 1, 0)


def _step(missed: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """The shortest step that meets the constraints which are missed to first order, shape (n, B, S), in widths."""
    r = missed.transpose(1, 2, 0)
    J = np.where(np.abs(r)[..., None] > 0, np.nan_to_num(slopes), 0.0)
    normal = J @ J.swapaxes(-1, -2)
    damping = DAMPING * np.trace(normal, axis1=-2, axis2=-1)[..., None, None] + (np.abs(r) == 0)[..., None]
    normal = normal + (damping + np.finfo(float).tiny) * np.eye(r.shape[-1])
    step: np.ndarray = -np.einsum("bscn,bsc->nbs", J, np.linalg.solve(normal, np.nan_to_num(r)[..., None])[..., 0])
    return step
