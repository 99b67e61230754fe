"""Implicit dynamics between the collocation points: the algebraic variables that solve the residuals.

Collocation makes the residuals vanish at its points only. Elsewhere the interpolated algebraic variables are as wrong
as the state is, so measuring the error with them would hide it: an acceleration that is an algebraic variable is
interpolated just as the slope of the velocity is. There the residuals 0 = r(t, x, u, z, p) are solved for z.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from ...problems.problem import Phase

MAX_STEPS = 20
CHORD_STEPS = 4
TOLERANCE = 1e-12  # of a Newton step, relative to 1 + |z|
COMPLEX_STEP = 1e-30  # any tiny number: the derivative has no subtraction in it


def consistent_inputs(phase: Phase, t: np.ndarray, x: np.ndarray, u: np.ndarray, p: Mapping[str, float]) -> np.ndarray:
    """The inputs, shape (n_u, ...), with the algebraic rows replaced by the solution of the residuals.

    phase: without algebraic variables u is given back as it is.
    t: times, of any shape (...).
    x: states there, shape (n_x, ...).
    u: inputs, of which algebraic variables are what to start from, shape (n_u, ...); left as they are.
    p: static parameters by name.

    Newton's method from the given values, for all times at once. Where it does not converge, as where the residuals do
    not determine z, the result is NaN: such a point has no dynamics.
    """
    if not phase.algebraic:
        return u
    shape, n = np.shape(t), len(phase.inputs) - len(phase.algebraic)
    t, x, u = np.ravel(t), x.reshape(len(x), -1), np.array(u).reshape(len(u), -1)
    with np.errstate(all="ignore"):
        for _ in range(MAX_STEPS):
            step = _newton_step(phase, t, x, u, p)
            u[n:] += step
            if (np.abs(step) <= TOLERANCE * (1 + np.abs(u[n:]))).all():
                break
        u[n:, (np.abs(step) > np.sqrt(TOLERANCE) * (1 + np.abs(u[n:]))).any(axis=0)] = np.nan
    return u.reshape(-1, *shape)


def where_defined(phase: Phase, function: Callable[[np.ndarray], np.ndarray], u: np.ndarray) -> np.ndarray:
    """The inputs, shape (n_u, ...), with controls within their bounds where a function has no finite value beyond them.

    phase: whose controls they are. Between the points they overshoot, and a root or a logarithm may end at a bound.
    function: of inputs (n_u, ...), with values of any shape (..., *those of the inputs).
    u: left as it is.
    """
    values = function(u)
    finite = np.isfinite(values).reshape(-1, *u.shape[1:]).all(axis=0)
    if finite.all():
        return u
    bounds = np.array([[own.bounds.lower, own.bounds.upper] for own in phase.controls]).reshape(-1, 2).T
    n, shape = len(phase.controls), (-1, *(1,) * (u.ndim - 1))
    v = u.copy()
    v[:n] = np.where(finite, u[:n], np.clip(u[:n], bounds[0].reshape(shape), bounds[1].reshape(shape)))
    return v


class Nearby:
    """`consistent_inputs` of many controls at M times and states: t (M,), x (n_x, M), and consistent u (n_u, M) there.

    dr/dz is inverted once, at u, and serves for all by the chord method; where that does not settle, Newton's does it.
    """

    def __init__(self, phase: Phase, t: np.ndarray, x: np.ndarray, u: np.ndarray, p: Mapping[str, float]) -> None:
        self.phase, self.t, self.x, self.u, self.p = phase, t, x, u, p
        n = len(phase.inputs) - len(phase.algebraic)
        if phase.algebraic:
            _, jacobian = _residuals(phase, t, x, u, p, np.arange(len(u)))
            self.inverse = _inverse(jacobian[..., n:].copy())
            self.slope = -self.inverse @ jacobian[..., :n]

    def inputs(self, controls: np.ndarray, k: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """t (B, S), x (n_x, B, S) and consistent inputs (n_u, B, S) for B controls (n, B, S) at the samples k (S,)."""
        shape, late = controls.shape[1:], self.u[self.phase.rows_of_delayed, None, k]
        t, x = np.broadcast_to(self.t[k], shape), np.broadcast_to(self.x[:, None, k], (len(self.x), *shape))
        controls = np.concatenate([controls, np.broadcast_to(late, (len(late), *shape))]) if len(late) else controls
        n = len(controls)
        if not self.phase.algebraic:
            return t, x, controls
        z = self.u[n:, None, k] + np.einsum("szc,cbs->zbs", self.slope[k], controls - self.u[:n, None, k])
        for _ in range(CHORD_STEPS):
            values = self.phase.arguments(t, x, np.concatenate([controls, z]), self.p)
            r = np.stack([np.broadcast_to(own, shape) for own in self.phase.residuals_at_once(values, np)])
            step = -np.einsum("szr,rbs->zbs", self.inverse[k], r)
            z = z + step
            if (np.abs(step) <= TOLERANCE * (1 + np.abs(z))).all():
                return t, x, np.concatenate([controls, z])
        return t, x, consistent_inputs(self.phase, t, x, np.concatenate([controls, z]), self.p)


def _newton_step(phase: Phase, t: np.ndarray, x: np.ndarray, u: np.ndarray, p: Mapping[str, float]) -> np.ndarray:
    """-(dr/dz)^-1 r at every time, shape (n_z, M)."""
    residual, jacobian = _residuals(phase, t, x, u, p, np.arange(len(phase.inputs) - len(phase.algebraic), len(u)))
    singular = _replace_singular(jacobian)
    step = -np.linalg.solve(jacobian, residual.T[..., None])[..., 0].T
    step[:, singular] = np.nan
    return step


def _residuals(
    phase: Phase, t: np.ndarray, x: np.ndarray, u: np.ndarray, p: Mapping[str, float], rows: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """r (n_z, M), and its derivatives by some rows of u (M, n_z, rows), by the complex step: exact to rounding.

    All shifted inputs are evaluated at once: one row for each shift, and the unshifted one.
    """
    size = len(rows)
    shifts = np.zeros((len(u), size + 1, 1), complex)
    shifts[rows, np.arange(size)] = COMPLEX_STEP * 1j
    values = phase.arguments(t[None, :], x[:, None, :], u[:, None, :] + shifts, p)
    found = [np.broadcast_to(r, (size + 1, len(t))) for r in phase.residuals_at_once(values, np)]
    residual = np.stack([row[-1].real for row in found])
    return residual, np.stack([row[:-1].imag for row in found]).transpose(2, 0, 1) / COMPLEX_STEP


def _inverse(jacobian: np.ndarray) -> np.ndarray:
    """Inverses of matrices (M, n, n), which it may change; NaN for those that have none."""
    singular = _replace_singular(jacobian)
    inverse = np.linalg.inv(jacobian)
    inverse[singular] = np.nan
    return inverse


def _replace_singular(jacobian: np.ndarray) -> np.ndarray:
    """Put the unit matrix in place of the singular ones of (M, n, n); returns which they are, (M,)."""
    singular = ~(np.abs(np.linalg.det(jacobian)) > 0)
    jacobian[singular] = np.eye(jacobian.shape[-1])
    return singular
