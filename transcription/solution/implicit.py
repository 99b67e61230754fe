"""Implicit dynamics between the collocation points: the algebraic variables that solve the residuals.

Collocation makes the residuals vanish at its points only. Elsewhere the interpolated algebraic variables are as wrong
as the state is, so measuring the error with them would hide it: an acceleration that is an algebraic variable is
interpolated just as the slope of the velocity is. There the residuals 0 = r(t, x, u, z, p) are solved for z.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...problems.problem import Phase

MAX_STEPS = 20
TOLERANCE = 1e-12  # of a Newton step, relative to 1 + |z|
COMPLEX_STEP = 1e-30  # any tiny number: the derivative has no subtraction in it


def consistent_inputs(phase: Phase, t: np.ndarray, x: np.ndarray, u: np.ndarray, p: Mapping[str, float]) -> np.ndarray:
    """The inputs u, shape (n_u, ...), with the algebraic rows replaced by the solution of the residuals.

    Newton's method from the given values, for all times at once. Where it does not converge, as where the residuals do
    not determine z, the result is NaN: such a point has no dynamics.
    """
    if not phase.algebraic:
        return u
    shape, n = np.shape(t), len(phase.controls)
    t, x, u = np.ravel(t), x.reshape(len(x), -1), np.array(u).reshape(len(u), -1)
    with np.errstate(all="ignore"):
        for _ in range(MAX_STEPS):
            step = _newton_step(phase, t, x, u, p)
            u[n:] += step
            if (np.abs(step) <= TOLERANCE * (1 + np.abs(u[n:]))).all():
                break
        u[n:, (np.abs(step) > np.sqrt(TOLERANCE) * (1 + np.abs(u[n:]))).any(axis=0)] = np.nan
    return u.reshape(-1, *shape)


def _newton_step(phase: Phase, t, x, u, p) -> np.ndarray:
    """-(dr/dz)^-1 r at every time, shape (n_z, M); derivatives by the complex step, exact to rounding.

    All shifted inputs are evaluated at once: one row for each algebraic variable, and the unshifted one.
    """
    n, size = len(phase.controls), len(phase.algebraic)
    shifts = np.zeros((len(u), size + 1, 1), complex)
    shifts[n + np.arange(size), np.arange(size)] = COMPLEX_STEP * 1j
    values = phase.arguments(t[None, :], x[:, None, :], u[:, None, :] + shifts, p)
    rows = [np.broadcast_to(r.function(values, np), (size + 1, len(t))) for r in phase.residuals]
    residual = np.stack([row[-1].real for row in rows])
    jacobian = np.stack([row[:-1].imag for row in rows]).transpose(2, 0, 1) / COMPLEX_STEP
    singular = ~(np.abs(np.linalg.det(jacobian)) > 0)
    jacobian[singular] = np.eye(size)
    step = -np.linalg.solve(jacobian, residual.T[..., None])[..., 0].T
    step[:, singular] = np.nan
    return step
