"""The minimum of the Hamiltonian over the controls, at many times at once.

At every sample of a trajectory, a function of the controls u (n_u,) is minimised between their bounds, and subject to

    lower <= c(u) <= upper            for constraints that the controls take part in,

from the control that is there, so that a local minimum is that of the same branch. Inside the bounds by projected
Newton steps: derivatives by differences (the minimum is of second order in their error), the Hessian's negative
curvature reversed and its small one raised, so that a function that is linear in a control goes to its bound; all step
lengths are tried at once and the best is taken. The constraints by the method of multipliers (Rockafellar 1973), from
the multipliers that the solve left: its value is that of the dual function, below the constrained minimum by the square
of what the multipliers miss.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.text import short_repr

STEPS = 20  # of Newton's method, at most
RADIUS = 2.0  # longest step of a control between bounds, in sizes of the controls: half the distance of the bounds
FAR = 100.0  # longest step without bounds; a minimum that STEPS of them do not reach is none
DIFFERENCE = 1e-4  # of derivatives, in sizes of the controls
LENGTHS = np.array([0.5, 0.2, 0.05, 0.01, 2.0])  # of a step, tried where the step itself is not as good as foreseen
AS_FORESEEN = 1e-3  # a full step that earns what the derivatives promised, this nearly, needs no other after it
HOLLOW, LEAVING = 1e-4, 0.1  # curvature below minus this is one; how far to go from a stationary point that has it
SETTLED = 1e-13  # a decrease below this, relative to 1 + |H|, is rounding
STEPS_A_ROUND = 6  # of Newton's method: the next round goes on from there
ROUNDS = 8  # of the method of multipliers
STEADY = 1e-4  # a change of the multipliers below this, relative to the largest, is none
STIFFNESS = 100.0  # of its penalty, relative to the curvature of the function

Values = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Controls (n_u, B, S) and the numbers (S,) of the samples they belong to -> values (B, S), or (n_c, B, S)."""


@short_repr
@dataclass(frozen=True)
class Constrained:
    """Constraints c of the controls: their values, (n_c, B, S), their bounds (n_c,) and multipliers (n_c, all samples).

    The multipliers have the sign of IPOPT's: positive at an upper bound.
    """

    values: Values
    lower: np.ndarray
    upper: np.ndarray
    multipliers: np.ndarray


@short_repr
@dataclass(frozen=True)
class Minimum:
    """u (n_u, S) and value (S,); found (S,): whether there is a minimum, not a way down without an end."""

    u: np.ndarray
    value: np.ndarray
    found: np.ndarray


def minimise(function: Values, u: np.ndarray, bounds: np.ndarray, constrained: Constrained | None = None) -> Minimum:
    """The minimum of a function of the controls at each of S samples.

    function: as of `Values`, with values (B, S): B controls at once for each sample.
    u: controls to start from, shape (n_u, S); clipped to the bounds.
    bounds: of the controls, lower and upper, shape (2, n_u).
    constrained: constraints of the controls, with multipliers to start from; None for none.
    """
    size = _sizes(u, bounds)[:, None]
    lower, upper = bounds[0][:, None] / size, bounds[1][:, None] / size
    start = np.clip(u / size, lower, upper)

    def scaled(v: np.ndarray, samples: np.ndarray) -> Any:
        return function(v * size[:, None], samples)

    if constrained is None:
        v, value, found = _newton(scaled, start, lower, upper)
    else:
        v, value, found = _multipliers(scaled, start, lower, upper, constrained, size)
    return Minimum(v * size, value, found)


def _sizes(u: np.ndarray, bounds: np.ndarray) -> np.ndarray:
    """Half the distance of the bounds of each control, or the largest magnitude along the trajectory: shape (n_u,)."""
    half = (bounds[1] - bounds[0]) / 2
    typical = np.abs(u).max(axis=1, initial=0.0)
    return np.where(np.isfinite(half) & (half > 0), half, np.where(typical > 0, typical, 1.0))


def _newton(
    function: Values, v: np.ndarray, lower: np.ndarray, upper: np.ndarray, most: int = STEPS
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Projected Newton from v (n_u, S), in place of which the minimum is given back, with its value and `found`."""
    v = v.copy()
    value = function(v[:, None], np.arange(v.shape[1]))[0]
    found, open_ = np.ones(v.shape[1], bool), np.arange(v.shape[1])
    for _ in range(most):
        if not len(open_):
            return v, value, found
        here, before = v[:, open_], value[open_]
        gradient, hessian = _derivatives(function, here, open_, lower, upper)
        step, foreseen = _step(here, gradient, hessian, lower, upper)
        _move(function, v, value, here, step[:, None], open_, lower, upper)
        surprise = ~(np.abs(before - value[open_] - foreseen) <= AS_FORESEEN * foreseen)
        surprise &= ~(foreseen <= SETTLED * (1 + np.abs(before)))
        open_, before = open_[surprise], before[surprise]
        if len(open_):
            others = np.concatenate(
                [LENGTHS[:, None] * step[:, None], _by_one(gradient, hessian, lower, upper)], axis=1
            )
            _move(function, v, value, here[:, surprise], others[..., surprise], open_, lower, upper)
        open_ = open_[before - value[open_] > SETTLED * (1 + np.abs(before))]
    found[open_] = (np.abs(v[:, open_]) < FAR * most / 2).all(axis=0)
    return v, value, found


def _move(
    function: Values,
    v: np.ndarray,
    value: np.ndarray,
    start: np.ndarray,
    steps: np.ndarray,
    samples: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
) -> None:
    """Take the best of some steps (n_u, B, S) from `start` where it is better than v: changes v and value."""
    tried = np.clip(start[:, None] + steps, lower[:, None], upper[:, None])
    values = function(tried, samples)
    values[~np.isfinite(values)] = np.inf
    best, each = values.argmin(axis=0), np.arange(len(samples))
    better = values[best, each] < value[samples]
    v[:, samples[better]] = tried[:, best[better], each[better]]
    value[samples[better]] = values[best, each][better]


def _radii(lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """The longest step of each control, shape (n_u, 1)."""
    return np.where(np.isfinite(lower) & np.isfinite(upper), RADIUS, FAR)


def _by_one(gradient: np.ndarray, hessian: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Newton steps of one control alone, shape (n_u, n_u, S): where bounds bend the step of all, they still descend."""
    curvature = np.maximum(np.abs(np.einsum("sii->is", hessian)), np.abs(gradient) / _radii(lower, upper))
    return np.eye(len(gradient))[:, :, None] * (-gradient / np.where(curvature > 0, curvature, 1.0))


def _derivatives(
    function: Values, v: np.ndarray, samples: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Gradient (n_u, S) and Hessian (S, n_u, n_u) at v by differences whose points are within the bounds."""
    n = len(v)
    d = np.minimum(DIFFERENCE, (upper - lower) / 4)
    d[d == 0] = DIFFERENCE  # a control with one value only
    centre = np.clip(v, lower + d, upper - d)
    pairs = [(i, j) for i in range(n) for j in range(i)]
    shifts = np.concatenate(
        [np.zeros((1, n)), np.eye(n), -np.eye(n), *[(np.eye(n)[i] + np.eye(n)[j])[None] for i, j in pairs]]
    )
    f = function(centre[:, None] + (shifts.T[:, :, None] * d[:, None]), samples)
    f0, plus, minus = f[0], f[1 : n + 1], f[n + 1 : 2 * n + 1]
    gradient = (plus - minus) / (2 * d)
    hessian = np.zeros((len(samples), n, n))
    for i in range(n):
        hessian[:, i, i] = (plus[i] - 2 * f0 + minus[i]) / d[i] ** 2
    for (i, j), both in zip(pairs, f[2 * n + 1 :], strict=True):
        hessian[:, i, j] = hessian[:, j, i] = (both - plus[i] - plus[j] + f0) / (d[i] * d[j])
    gradient += np.einsum("sij,js->is", hessian, v - centre)
    finite = np.isfinite(gradient).all(axis=0) & np.isfinite(hessian).all(axis=(1, 2))
    gradient[:, ~finite] = 0.0
    hessian[~finite] = np.eye(n)
    return gradient, hessian


def _step(
    v: np.ndarray, gradient: np.ndarray, hessian: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The Newton step (n_u, S) of the controls that are not held at their bounds, at most RADIUS long; and how much the
    function should fall by it (S,), NaN where a bound or the radius cuts it short."""
    held = ((v <= lower) & (gradient > 0)) | ((v >= upper) & (gradient < 0))
    free = ~held.T
    g = np.where(held, 0.0, gradient).T
    H = np.where(free[:, :, None] & free[:, None, :], hessian, 0.0)
    curvature, axes = np.linalg.eigh(H)
    along = (axes.transpose(0, 2, 1) @ g[..., None])[..., 0]
    # Curvature that would make the step too long is raised until it does not.
    raised = np.maximum(np.abs(curvature), np.abs(along) / _radii(lower, upper).max())
    steps = -along / np.where(raised > 0, raised, 1.0)
    # A maximum or a saddle is left, although it is stationary.
    hollow = curvature < -HOLLOW * (1 + np.abs(curvature).max(axis=1, keepdims=True))
    steps = np.where(hollow & (np.abs(steps) < LEAVING), np.where(along > 0, -LEAVING, LEAVING), steps)
    step = np.where(held, 0.0, (axes @ steps[..., None])[..., 0].T).clip(-_radii(lower, upper), _radii(lower, upper))
    cut = ((raised > curvature) & (along != 0)).any(axis=1) | hollow.any(axis=1)
    cut |= ((v + step < lower) | (v + step > upper)).any(axis=0)
    return step, np.where(cut, np.nan, -(along * steps).sum(axis=1) / 2)


def _multipliers(
    function: Values, v: np.ndarray, lower: np.ndarray, upper: np.ndarray, c: Constrained, size: np.ndarray
) -> Any:
    """The method of multipliers: `_newton` on the augmented function, whose value is given back."""
    nu, samples = c.multipliers.copy(), np.arange(v.shape[1])
    low, high = c.lower[:, None, None], c.upper[:, None, None]

    def values(v: np.ndarray, samples: np.ndarray) -> Any:
        return c.values(v * size[:, None], samples)

    rho = STIFFNESS * _curvature(function, v, samples, lower, upper) / _steepness(values, v, samples, lower, upper)

    def missed(v: np.ndarray, samples: np.ndarray) -> Any:
        y = values(v, samples) + nu[:, None, samples] / rho[:, None, samples]
        return y - np.clip(y, low, high)

    def augmented(v: np.ndarray, samples: np.ndarray) -> Any:
        r, own = rho[:, None, samples], nu[:, None, samples]
        return function(v, samples) + (r * missed(v, samples) ** 2 - own**2 / r).sum(axis=0) / 2

    for _ in range(ROUNDS):
        v, _, found = _newton(augmented, v, lower, upper, STEPS_A_ROUND)
        before, nu = nu, rho * missed(v[:, None], samples)[:, 0]
        if np.abs(nu - before).max(initial=0.0) <= STEADY * np.abs(nu).max(initial=0.0):
            break
    return v, augmented(v[:, None], samples)[0], found


def _curvature(
    function: Values, v: np.ndarray, samples: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> np.ndarray:
    """How much the function bends or slopes, shape (S,), in sizes of the controls; above 0."""
    gradient, hessian = _derivatives(function, v, samples, lower, upper)
    much = np.abs(gradient).sum(axis=0) + np.abs(hessian).sum(axis=(1, 2))
    return np.maximum(much, 1e-8 * max(much.max(initial=0.0), 1e-8))


def _steepness(values: Values, v: np.ndarray, samples: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """The squared slope of each constraint, shape (n_c, S), in sizes of the controls; above 0."""

    def one(i: int) -> Values:
        return lambda v, s: values(v, s)[i]

    count = len(values(v[:, None], samples))
    slopes = np.array([(_derivatives(one(i), v, samples, lower, upper)[0] ** 2).sum(axis=0) for i in range(count)])
    return np.maximum(slopes, 1e-4 * np.maximum(slopes.max(axis=1, keepdims=True), 1e-8))
