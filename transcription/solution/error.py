"""How well a trajectory meets the dynamics between its collocation points (paper, section 5.3).

    epsilon(t) = dx/dt(t) - f(t, x(t), u(t))                 zero at every collocation point
    eta_k      = integral of |epsilon| over segment k

The integral is taken by Romberg quadrature, as in the paper, on the pieces between neighbouring collocation points,
for all pieces at once. On such a piece epsilon seldom changes sign, so |epsilon| is smooth there and Richardson's
extrapolation earns its order. SciPy's adaptive Gauss-Kronrod rule would give the same digits, but it takes one interval
at a time, and importing it costs more than solving a typical problem.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.quantities import Complementarity, Function, Range
from ...problems.text import short_repr
from ..schemes.polynomials import gauss_legendre
from .implicit import consistent_inputs, where_defined
from .trajectory import Sample, Trajectory

ROMBERG_LEVELS = range(4, 9)  # 16 to 256 intervals a piece
ROMBERG_TOLERANCE = 1e-4  # relative to the largest eta of a state: an error estimate needs no more digits
INSET = 1e-10  # of a piece, kept from its ends: constant controls jump where pieces meet
GAUSS_POINTS = 8  # between neighbouring nodes, for integrands
RELAXED = 1e-8  # relative to 1 + |bound|: no more than IPOPT itself relaxes bounds by; a control that is off spans less
NEARLY_CONSTANT = 1e-3  # of its size: a curve that spans less counts as one that spans so much
EPSILON_FLOOR = 1e-15  # below this eta is rounding error, which never converges


@dataclass(frozen=True)
class Overshoot:
    """What exceeds its bounds most: by `amount` in its own unit, a `share` of the range of its curve, at a time.

    lasts: for how long it does so by more than a tenth of that; 0 in an exact phase.
    """

    name: str
    amount: float
    unit: str
    time: float
    share: float
    lasts: float


@short_repr
@dataclass(frozen=True)
class ErrorProfile:
    """epsilon: (n_x, M) on the trajectory's dense grid; eta: (n_x, N) in units of the state.

    relative: (N,) the largest eta of each segment relative to 1 + max |x|, or error of an integral if that is larger.
    excess: what has bounds -> (N,) how far it is beyond them on each segment, see `excesses`. overshoot: the largest.
    worth: (N,) what each segment adds to the error bar of the objective, relative to 1 + |J|; zero where there is none.
    """

    epsilon: np.ndarray
    eta: np.ndarray
    relative: np.ndarray
    excess: Mapping[str, np.ndarray]
    worth: np.ndarray
    overshoot: Overshoot | None = None

    @property
    def largest_excess(self) -> np.ndarray:
        """Of anything that has bounds, on each segment, shape (N,)."""
        return np.max([*self.excess.values(), np.zeros(len(self.relative))], axis=0)

    @property
    def max_eta(self) -> float:
        return float(self.eta.max(initial=0.0))


def error_profile(trajectory: Trajectory) -> ErrorProfile:
    """The error of a trajectory; epsilon is sampled where the trajectory's own dense grid is.

    trajectory: of an exact phase (`Phase.exact`) it has no error but what its bounds are exceeded by.
    """
    sample, N = trajectory.dense, trajectory.mesh.segments
    if trajectory.phase.exact:
        epsilon, eta, relative = np.zeros_like(sample.x), np.zeros((len(sample.x), N)), np.zeros(N)
    else:
        epsilon, eta = _epsilon(trajectory, sample), _eta(trajectory)
        size = 1 + np.abs(sample.x).max(axis=1, keepdims=True)
        relative = np.vstack([eta / size, _quadrature_error(trajectory)]).max(axis=0)
    # Algebraic variables and equations between them are interpolated, and hold at the points only by their nature.
    shown = [e for e in excesses(trajectory) if not e.algebraic]
    exact = trajectory.phase.exact
    excess = {} if exact else {e.name: trajectory.by_segment(e.values).max(axis=1) for e in shown}
    times = trajectory.times[trajectory.mesh.collocated] if exact else sample.t
    return ErrorProfile(epsilon, eta, relative, excess, np.zeros(N), _overshoot(shown, times, exact))


def _overshoot(shown: list[Excess], t: np.ndarray, exact: bool) -> Overshoot | None:
    """The largest excess by its share of the range of what is bounded; None if nothing has bounds."""
    edges = np.concatenate([t[:1], (t[1:] + t[:-1]) / 2, t[-1:]])
    around = np.diff(edges) * (not exact)
    found = []
    for e in shown:
        k = int(np.argmax(e.beyond))
        amount = float(e.beyond[k])
        share = amount / e.span if e.span > 0 and e.values[k] > RELAXED else 0.0
        found.append(Overshoot(e.name, amount, e.unit, float(t[k]), share, float(around[e.beyond > amount / 10].sum())))
    return max(found, key=lambda own: own.share, default=None)


def _epsilon(trajectory: Trajectory, sample: Sample) -> np.ndarray:
    """dx/dt - f(t, x, u, z): x and u are the interpolants, z solves the residuals for them."""
    phase, p = trajectory.phase, trajectory.parameters
    u = consistent_inputs(phase, sample.t, sample.x, sample.u, p)
    u = where_defined(phase, lambda own: phase.dynamics(sample.t, sample.x, own, p), u)
    return sample.dx - phase.dynamics(sample.t, sample.x, u, p)


def _eta(trajectory: Trajectory) -> np.ndarray:
    """Romberg quadrature of |epsilon| over every segment, shape (n_x, N), refined where it has not converged."""
    eta = np.empty((len(trajectory.phase.states), trajectory.mesh.segments))
    for group in trajectory.mesh.groups:
        breaks = group.scheme.sigma
        open_ = group.segments
        for level in ROMBERG_LEVELS:
            fine, coarse = _integrals(trajectory, open_, breaks, level)
            eta[:, open_] = trajectory.h[open_] * fine
            change = trajectory.h[open_] * np.abs(fine - coarse)
            scale = eta[:, group.segments].max(axis=1, keepdims=True)
            # What is not finite is as settled as it gets.
            unsettled = np.isfinite(change) & (change > ROMBERG_TOLERANCE * scale + EPSILON_FLOOR)
            open_ = open_[unsettled.any(axis=0)]
            if not len(open_):
                break
    return eta


def _integrals(trajectory: Trajectory, segments: np.ndarray, breaks: np.ndarray, level: int) -> list[np.ndarray]:
    """The integral of |epsilon| over tau in [0, 1] for G segments, shape (n_x, G): by 2^level intervals between breaks,
    and by half as many.
    """
    inside = np.linspace(INSET, 1 - INSET, 2**level + 1)
    tau = breaks[:-1, None] + np.diff(breaks)[:, None] * inside
    epsilon = np.abs(_epsilon(trajectory, trajectory.grid(segments, tau.ravel())))
    epsilon = epsilon.reshape(*epsilon.shape[:-1], *tau.shape)
    return [_romberg(epsilon[..., ::step]) @ np.diff(breaks) for step in (1, 2)]


def _quadrature_error(trajectory: Trajectory) -> np.ndarray:
    """The error of the integrals of each segment, relative to 1 + |the integral|: shape (integrals, N).

    The integrands, of the objective and of integral constraints, are integrated along the interpolants (Gauss's rule
    between neighbouring nodes), and compared with the scheme's own quadrature.
    """
    phase, mesh = trajectory.phase, trajectory.mesh
    integrands = ([phase.lagrange] if phase.lagrange else []) + [c.function for c in phase.integral]
    errors, totals = np.zeros((len(integrands), mesh.segments)), np.zeros(len(integrands))
    nodes, weights = gauss_legendre(GAUSS_POINTS)
    for group in mesh.groups:
        if group.scheme.quadrature is None:
            continue
        width = np.diff(group.scheme.sigma)[:, None]
        tau = (group.scheme.sigma[:-1, None] + width * (nodes + 1) / 2).ravel()
        own_tau, own_weights = group.scheme.quadrature
        fine, own = (trajectory.grid(group.segments, t) for t in (tau, own_tau))
        for i, w in enumerate(integrands):
            exact = _values(trajectory, w, fine) @ (width * weights / 2).ravel()
            rule = _values(trajectory, w, own) @ own_weights
            errors[i, group.segments] = np.abs(trajectory.h[group.segments] * (exact - rule))
            totals[i] += float((trajectory.h[group.segments] * rule).sum())
    return errors / (1 + np.abs(totals[:, None]))


@short_repr
@dataclass(frozen=True)
class Excess:
    """How far something is beyond its bounds, relative to 1 + |bound|: values (M,) on the grid of `excesses`.

    beyond: (M,) the same in its own unit, and span: the range of what is bounded. unit: "" if none is known.
    algebraic: whether it is an algebraic variable, or an equation, as that between slack variables. control: whether it
    is a control, which could be held within its bounds.
    """

    name: str
    values: np.ndarray
    algebraic: bool
    beyond: np.ndarray
    span: float
    unit: str = ""
    control: bool = False


def excesses(trajectory: Trajectory) -> Iterator[Excess]:
    """Of everything that is bounded over time; the solver holds only the collocation points to it. An exact phase has
    nothing between these, so there the values are of the collocation points."""
    phase, sample = trajectory.phase, trajectory.dense
    if phase.exact:
        values = trajectory.at_collocated
    else:
        values = phase.arguments(sample.t, sample.x, sample.u, trajectory.parameters)
    for variable in (*phase.states, *phase.inputs):
        if variable.bounds != Range():
            curve, bounds = values[variable.name], variable.bounds
            yield Excess(
                f"bounds of {variable.name}", bounds.excess(curve), variable in phase.algebraic,
                bounds.beyond(curve), _span(curve), variable.unit, variable in phase.controls,
            )  # fmt: skip
    relaxed = {own.name for own in phase.complementarity}  # they hold at the points only, or nothing could begin
    for constraint in (own for own in phase.path if own.name not in relaxed):
        g = np.broadcast_to(constraint.function(values, np), np.shape(values["t"]))
        bounds, name = constraint.bounds, f"path constraint '{constraint.name}'"
        yield Excess(name, bounds.excess(g), bounds.fixed, bounds.beyond(g), _span(g))


def exactness(trajectory: Trajectory) -> Iterator[tuple[Complementarity, float, float]]:
    """Each pair of which one must be zero, their largest product at the points that the solver holds, and its time."""
    values = trajectory.at_collocated
    t = values["t"]
    for pair in trajectory.phase.complementarity:
        product = np.broadcast_to(pair.product(values, np), t.shape)
        worst = int(np.argmax(np.nan_to_num(product, nan=np.inf)))
        yield pair, float(product[worst]), float(t[worst])


def _span(curve: np.ndarray) -> float:
    """What a curve spans; of one that is all but constant, a part of its size: its range is rounding."""
    return max(float(np.ptp(curve)), NEARLY_CONSTANT * float(np.abs(curve).max()))


def _values(trajectory: Trajectory, function: Function, sample: Sample) -> np.ndarray:
    def at(u: np.ndarray) -> np.ndarray:
        values = trajectory.phase.arguments(sample.t, sample.x, u, trajectory.parameters)
        return np.broadcast_to(function(values, np), sample.t.shape)

    return at(where_defined(trajectory.phase, at, sample.u))


def _romberg(y: np.ndarray) -> np.ndarray:
    """Romberg's rule from equally spaced samples y, shape (..., 2^k + 1), over an interval of width 1: shape (...)."""
    k = (y.shape[-1] - 1).bit_length() - 1
    table = []
    for level in range(k + 1):
        step = 2 ** (k - level)
        coarse = y[..., ::step]
        table.append(2.0**-level * (coarse.sum(axis=-1) - (coarse[..., 0] + coarse[..., -1]) / 2))
    for order in range(1, k + 1):
        table = [fine + (fine - coarse) / (4**order - 1) for coarse, fine in pairwise(table)]
    return table[-1]
