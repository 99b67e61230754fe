"""What it is worth that a trajectory touches a constraint at the points of the mesh, and not where it would.

A constraint on the states whose second derivative has the control in it may act at one instant tau only, as an atom of
its multiplier. The nonlinear program holds it at points: the trajectory touches between two of them, s_i, both with a
mass m_i. Other pairs of points are other local optima, so the touch is held near where it came to lie. Let V(delta) be
the optimum with all s_i moved by delta. L = J + sum of m_i g(x(s_i + delta)) gives

    V'  = sum of m_i dg/dt(s_i),
    V'' = L_dd + [L_wd, c_d] [dw/dd, dm/dd],        K [dw/dd, dm/dd] = - [L_wd, c_d],

K being the KKT matrix, w the unknowns and c_d = dg/dt in the rows of the s_i. At the optimum of the continuous problem
V' = 0. The touch belongs V'/V'' earlier, and there the objective is less by

    V'^2 / (2 V'').

That is of the second order in the error of tau, but tau is off by as much as the points are apart, and more. For a
crane over an obstacle it is all of the error: 8.58e-6 = 1.34e-5 - 4.83e-6, which is what passes between both points.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..dual.multipliers import ConstraintMeasure, Multipliers
from ..engines.linear import hessian_of, jacobian_of, solved
from .lagrangian import PhaseLagrangian

MOST_POINTS = 3
"""That share one touch; an arc on a constraint has more."""

NONE = 1e-3
"""Of the largest mass of a constraint: a point with less holds nothing."""

STEP = 1e-5
"""Of differences, relative to 1 + the size of what is moved."""

LARGE = 1e16
"""Stands for an infinite number in the KKT matrix."""


class Touch(NamedTuple):
    """Where a trajectory belongs by V'/V'', in normalised time, where it touches now, and what that is worth."""

    at: float
    belongs: float
    worth: float


def touches(own: PhaseLagrangian) -> Iterator[Touch]:
    """The touches of one phase, for the minimised objective.

    own: a phase whose states at its points are unknowns.
    """
    kkt = None
    for measure, *_ in own.of_states:
        for points in _groups(measure):
            kkt = kkt or _KKT(own.multipliers)
            yield _touch(own, measure, points, kkt)


def _groups(measure: ConstraintMeasure) -> Iterator[np.ndarray]:
    """Numbers of the few neighbouring points inside the phase that hold a constraint, and none beside them does."""
    mass = np.abs(measure.mass)
    held = np.flatnonzero(mass > NONE * mass.max(initial=0.0))
    for group in np.split(held, np.flatnonzero(np.diff(held) > 1) + 1):
        if 1 <= len(group) <= MOST_POINTS and group[0] > 0 and group[-1] < len(mass) - 1:
            yield group


def _touch(own: PhaseLagrangian, measure: ConstraintMeasure, points: np.ndarray, kkt: _KKT) -> Touch:
    s, mass = measure.s[points], measure.mass[points]
    rates = [_Rate(own, measure, at) for at in s]
    slopes = np.array([rate.value for rate in rates])
    around = measure.s[points[[0, -1]] + ([-1, 1] if len(points) == 1 else 0)]
    turn = np.diff([_Rate(own, measure, at).value for at in around])[0]
    apart = float(np.diff(around)[0]) * own.duration
    first = float(mass @ slopes)
    bend = mass.sum() * turn / apart  # L_dd
    by_unknowns = np.zeros(kkt.n)  # L_wd
    for rate, own_mass in zip(rates, mass, strict=True):
        np.add.at(by_unknowns, rate.places, own_mass * rate.gradient)
    second = bend + kkt.response(by_unknowns, measure.places[points], slopes)
    at = float(mass @ s / mass.sum())
    if not second > 0:  # nothing holds it but the points
        return Touch(at, at, abs(first) * apart)
    return Touch(at, float(np.clip(at - first / second / own.duration, 0.0, 1.0)), first**2 / (2 * second))


class _Rate:
    """dg/dt at a point as the dynamics have it: its value, and its gradient by the unknowns there, at their places."""

    def __init__(self, own: PhaseLagrangian, measure: ConstraintMeasure, s: float) -> None:
        tr, layout = own.trajectory, own.layout
        node = int(np.argmin(np.abs(own.mesh.fractions - s)))
        self.own, self.function, self.n = own, measure.function, len(layout.x)
        values = np.concatenate([tr.x[:, node], tr.u[:, node]])
        places = np.concatenate([layout.x[:, node], layout.u[:, node]])
        free = np.flatnonzero(places >= 0)
        steps = STEP * (1 + np.abs(values[free]))
        moved = np.zeros((len(values), 2 * len(free)))
        moved[free, np.arange(len(free))], moved[free, len(free) + np.arange(len(free))] = steps, -steps
        t = np.full(1 + 2 * len(free), tr.times[node])
        rates = self._along(t, values[:, None] + np.concatenate([np.zeros((len(values), 1)), moved], axis=1))
        self.value, self.places = float(rates[0]), places[free]
        self.gradient = (rates[1 : 1 + len(free)] - rates[1 + len(free) :]) / (2 * steps)

    def _along(self, t: np.ndarray, values: np.ndarray) -> np.ndarray:
        """dg/dt by a difference along the dynamics, shape (K,); values: states and inputs (n, K)."""
        own, x, u = self.own, values[: self.n], values[self.n :]
        f = own.phase.dynamics(t, x, u, own.p)
        step = STEP / (1 + float(np.abs(f).max(initial=0.0)))
        ahead, behind = (own.values(self.function, t + h, x + h * f, u) for h in (step, -step))
        return (ahead - behind) / (2 * step)


class _KKT:
    """The KKT matrix of the nonlinear program at its solution, with inequalities as the barrier has them."""

    def __init__(self, multipliers: Multipliers) -> None:
        nlp, outcome = multipliers.nlp, multipliers.outcome
        self.n, self.m = nlp.n, nlp.m
        self.H, self.A = hessian_of(nlp, outcome.z, outcome.y), jacobian_of(nlp, outcome.z)
        with np.errstate(all="ignore"):
            lower, upper, rows = (np.where(y > 0, s / y, LARGE) for y, s, _ in multipliers.sides)
        tiny = 1 / LARGE
        self.of_bounds = 1 / (1 / np.maximum(lower, tiny) + 1 / np.maximum(upper, tiny))  # slack over multiplier
        self.of_rows = np.where(multipliers.equations, 0.0, np.minimum(rows, LARGE))

    def response(self, by_unknowns: np.ndarray, places: np.ndarray, slopes: np.ndarray) -> float:
        """- r K^-1 r for r = (by_unknowns, slopes in the rows at places); NaN without an inverse.

        places: of unknowns whose bound is a row, or n + that of a row.
        """
        from scipy.sparse import bmat, csr_matrix, diags

        bounds = np.flatnonzero(places < self.n)
        stiff = 1 / self.of_bounds
        stiff[places[bounds]] = 0.0
        k = len(bounds)
        E = csr_matrix((np.ones(k), (np.arange(k), places[bounds])), (k, self.n))
        A = bmat([[self.A], [E]]) if k else self.A
        D = np.concatenate([self.of_rows, self.of_bounds[places[bounds]]])
        right = np.concatenate([by_unknowns, np.zeros(self.m + k)])
        rows = np.array(places)
        rows[bounds] = self.n + self.m + np.arange(k)
        right[rows] = slopes
        solution = solved(bmat([[self.H + diags(stiff), A.T], [A, -diags(D)]], format="csc"), -right)
        return float("nan") if solution is None else float(right @ solution)
