"""Whether the first and second order conditions hold at the collocation points, with the stored multipliers."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ...problems.problem import Phase
from ...problems.quantities import Function, Range
from ...transcription.constraint_kinds import INTEGRAL, PATH, RESIDUAL
from ...transcription.dual.multipliers import Multipliers
from ...transcription.measured.knots import knots_at, measured_fractions
from ..file.reload import Reloaded
from .check import ENGINE, Check, at
from .jumps import point_shares

COMPLEX_STEP = 1e-30
SECOND_STEP = 1e-5  # relative to 1 + the size of a control, of central differences of complex-step derivatives
NEAR_BOUND = 1e-3  # of the range of a control: a barrier leaves a control that is on a bound as far from it
ACTIVE = 1e-4  # of the largest multiplier of a constraint over time: what is smaller does not act
IN_LAGRANGIAN = (PATH, RESIDUAL, INTEGRAL)  # of constraints in H and L


class Hamiltonian:
    """H and L of one phase along the collocation points, sums of weight * function, for the minimised objective."""

    def __init__(self, result: Reloaded, number: int) -> None:
        self.trajectory = result.trajectories[number]
        self.phase: Phase = self.trajectory.phase
        self.points = self.trajectory.mesh.collocated
        phase, sense = self.phase, result.problem.sense
        costate = sense * self._costate(result, number)
        self.terms = [(row, state.rate) for row, state in zip(costate, phase.states, strict=True)]
        self.terms += [(float(sense), phase.lagrange)] if phase.lagrange else []
        self.constraints: list[tuple[np.ndarray, Function]] = []
        self.equations: list[bool] = []  # whether each of the constraints is one
        named = {(kind, c.name): c for kind in IN_LAGRANGIAN for c in getattr(phase, kind.functions)}
        for (kind, name), multiplier in self._multipliers(result).items():
            constraint = named[kind, name]
            group = self.terms if kind is INTEGRAL else self.constraints
            group.append((multiplier, constraint.function))
            if kind is not INTEGRAL:
                self.equations.append(constraint.bounds.fixed)

    def _costate(self, result: Reloaded, number: int) -> np.ndarray:
        """lambda at the points, shape (n_x, M); in discrete time that after the step that begins there.

        At a knot on which a bound of a state acts over time, both sides have their part of its multiplier.
        """
        assert self.trajectory.costate is not None
        mesh = self.trajectory.mesh
        if not self.phase.steps:
            multipliers = Multipliers(result.transcription, result.nlp, result.outcome)
            of_bounds = result.problem.sense * multipliers.at_knots(result.transcription.phases[number])
            return replace(self.trajectory, costate=self.trajectory.costate + of_bounds).point_costate[:, self.points]
        return self.trajectory.costate[:, mesh.offset + mesh.degrees]

    def _multipliers(self, result: Reloaded) -> dict:
        """(kind, name) -> the multiplier function at the points; of an integral constraint, its one multiplier."""
        mesh, duration = self.trajectory.mesh, self.trajectory.t[1] - self.trajectory.t[0]
        found: dict = {}
        for family in result.transcription.families:
            if family.phase != self.phase.name or family.kind not in IN_LAGRANGIAN:
                continue
            y, key = result.outcome.y[family.rows(result.nlp)], (family.kind, family.name)
            if family.kind is INTEGRAL:
                found[key] = float(y[0])
                continue
            row = found.setdefault(key, np.zeros(len(mesh.fractions)))
            row[np.searchsorted(mesh.fractions, family.span[:, 0] - 1e-14)] = y / (family.weights * duration)
        return {key: y if isinstance(y, float) else y[self.points] for key, y in found.items()}

    def values(self) -> dict:
        t, x, u = (a[..., self.points] for a in (self.trajectory.times, self.trajectory.x, self.trajectory.u))
        return self.phase.arguments(t, x, u, self.trajectory.parameters)

    def hamiltonian(self, values: dict) -> np.ndarray:
        """H = w + lambda f, (B.7), and mu g for each integral constraint."""
        return sum(weight * function(values, np) for weight, function in self.terms)

    def scale(self, values: dict) -> float:
        """The largest term of H."""
        return max(float(np.max(np.abs(weight * f(values, np)))) for weight, f in self.terms)

    def lagrangian(self, values: dict) -> np.ndarray:
        """L = H + nu g + kappa r."""
        return self.hamiltonian(values) + sum(weight * function(values, np) for weight, function in self.constraints)

    def normals(self, values: dict) -> np.ndarray:
        """Derivatives of the constraints that act by the inputs, shape (M, m, n), and 0 where they do not act."""
        inputs = self.phase.found
        found = np.zeros((len(self.points), len(self.constraints), len(inputs)))
        for i, (multiplier, function) in enumerate(self.constraints):
            acts = self.equations[i] | (np.abs(multiplier) > ACTIVE * np.abs(multiplier).max(initial=0.0))
            for j, variable in enumerate(inputs):
                slope = self.derivative(partial(_of_arrays, function), values, variable.name)
                found[:, i, j] = np.where(acts, slope, 0.0)
        return found

    def derivative(self, function: Callable[[dict], Any], values: dict, name: str) -> np.ndarray:
        """The derivative of a function of the values by one of them, by the complex step, shape (M,).

        function: of a dict of arrays (M,).
        values: name -> array (M,).
        name: of the one.
        """
        shifted = {**values, name: values[name] + COMPLEX_STEP * 1j}
        return np.broadcast_to(np.imag(function(shifted)), self.points.shape) / COMPLEX_STEP


def optimality(result: Reloaded, number: int, claimed: float, tolerance: float) -> Iterator[Check]:
    """Checks of one phase: how H changes along it, dL/du = 0 for each input, no negative eigenvalue of d2L/du2.

    result: read back, with multipliers.
    number: of the phase, from 0; its trajectory has costates.
    claimed: how far the objective may be from the optimum: what is worth less over the whole phase is nothing.
    tolerance: the largest value of each measure that passes, all of them relative.
    """
    hamiltonian = Hamiltonian(result, number)
    values = hamiltonian.values()
    t = values["t"]
    slopes = np.stack(
        [hamiltonian.derivative(hamiltonian.lagrangian, values, x.name) for x in hamiltonian.phase.states]
    )
    if hamiltonian.phase.delayed:
        yield Check("Hamiltonian along the trajectory", 0.0, 0.0, "not looked at: with delays it is not constant")
    else:
        yield _hamiltonian_drift(hamiltonian, values, slopes, claimed, tolerance)
    yield from stationarity(result, hamiltonian, values, slopes * _lopsided(hamiltonian), claimed, tolerance)
    if hamiltonian.phase.found:
        yield _legendre(hamiltonian, values, t, tolerance)


def stationarity(
    result: Reloaded, hamiltonian: Hamiltonian, values: dict, blurred: np.ndarray, claimed: float, tolerance: float
) -> Iterator[Check]:
    """The check of dL/du = 0 for each input.

    result: read back, with multipliers.
    hamiltonian: of one of its phases.
    values: at the points.
    blurred: what the costates may be off by, (n_x, M).
    claimed, tolerance: as of `optimality`.
    """
    t = values["t"]
    engine = _left_by_engine(result, hamiltonian)
    for variable in hamiltonian.phase.found:
        gradient = hamiltonian.derivative(hamiltonian.lagrangian, values, variable.name)
        scale = _scale(hamiltonian, values, variable.name)
        unknown = _of_costates(hamiltonian, values, variable.name, blurred)
        unknown += engine
        unknown += claimed / float(np.ptp(hamiltonian.trajectory.t)) / (1 + np.abs(values[variable.name]).max())
        gradient = np.sign(gradient) * np.where(np.abs(gradient) > unknown, np.abs(gradient) - unknown, 0 * gradient)
        residual = _natural_residual(gradient / scale, values[variable.name], variable.bounds)
        k = int(np.argmax(np.nan_to_num(residual, nan=np.inf)))
        name = f"stationarity dH/d{variable.name}, relative"
        yield Check(name, float(residual[k]), tolerance, at(hamiltonian.trajectory, t[k]))


def _left_by_engine(result: Reloaded, hamiltonian: Hamiltonian) -> np.ndarray:
    """What the engine's tolerance leaves of dL/du at each point, shape (M,): it ends with weight T dL/du that small."""
    trajectory = hamiltonian.trajectory
    weights = trajectory.mesh.weights[hamiltonian.points] * float(np.ptp(trajectory.t))
    left: np.ndarray = ENGINE * result.records[-1].tolerance / np.where(weights > 0, weights, np.inf)
    return left


def _hamiltonian_drift(
    hamiltonian: Hamiltonian, values: dict, slopes: np.ndarray, claimed: float, tolerance: float
) -> Check:
    """Half the range of H(t) - H(t_0) - integral of dL/dt, which should be 0, relative to the largest term of H.

    What is measured at a time makes H jump there (`audit.measured` looks at the jump of the costates), so that the
    range is that between two measurements.

    Within a jump of a control, or of the slopes dL/dx of the costates (as where a multiplier jumps), the costates at
    the points are those of neither side: there the drift counts times the jump's share of the phase.
    """
    trajectory, t = hamiltonian.trajectory, values["t"]
    H = hamiltonian.hamiltonian(values)
    explicit = hamiltonian.derivative(hamiltonian.lagrangian, values, "t")
    drift = H - H[0] - np.append(0, np.cumsum(np.diff(t) * (explicit[1:] + explicit[:-1]) / 2))
    shares = point_shares(trajectory, slopes)
    of_a_side = np.zeros(len(t), bool)
    for here in _between_measurements(hamiltonian):
        of_a_side |= here
        counted = drift[here & (shares == 1)] if (here & (shares == 1)).any() else drift[here]
        drift[here] -= (counted.max() + counted.min()) / 2
    drift = np.where(of_a_side, np.abs(drift), 0.0)
    scale = hamiltonian.scale(values)
    value = np.maximum(shares * drift - claimed / float(np.ptp(trajectory.t)), 0.0) / (scale or 1.0)
    k, worst = int(np.argmax(np.nan_to_num(value, nan=np.inf))), int(np.argmax(np.nan_to_num(drift, nan=np.inf)))
    where = at(trajectory, t[k])
    if drift[worst] > tolerance * (scale or 1.0) and shares[worst] < 1:
        where += f"; {drift[worst] / (scale or 1.0):.1e} in a jump, {at(trajectory, t[worst])}"
    return Check("Hamiltonian along the trajectory, relative", float(value[k]), tolerance, where)


def _between_measurements(hamiltonian: Hamiltonian) -> Iterator[np.ndarray]:
    """Masks (M,) of the points between two times of measurements: these times themselves are of both sides."""
    s = hamiltonian.trajectory.mesh.fractions[hamiltonian.points]
    times = measured_fractions(hamiltonian.phase)
    at = np.isin(s, hamiltonian.trajectory.mesh.edges[knots_at(hamiltonian.trajectory.mesh, times)])
    number = np.searchsorted(times, s)
    for own in np.unique(number[~at]):
        yield (number == own) & ~at


def _lopsided(hamiltonian: Hamiltonian) -> np.ndarray:
    """How far from each point the control there acts on average, shape (M,), in time.

    The trapezoid rule has one control for both segments at a knot, which is optimal for the costate in the middle of
    the two: that is not at the knot where one is longer.
    """
    trajectory, mesh = hamiltonian.trajectory, hamiltonian.trajectory.mesh
    found = np.zeros(len(mesh.fractions))
    if all(len(scheme.sigma) == 2 and len(scheme.collocated) == 2 for scheme in mesh.schemes):
        before, after = np.append(0.0, trajectory.h), np.append(trajectory.h, 0.0)
        found[mesh.knots] = np.abs(after - before) / 2
    return found[hamiltonian.points]


def _of_costates(hamiltonian: Hamiltonian, values: dict, name: str, costates: np.ndarray) -> np.ndarray:
    """What dL/du may be off by, shape (M,), where each costate may be so by its row of (n_x, M)."""
    rates = [
        np.abs(hamiltonian.derivative(partial(_of_arrays, state.rate), values, name))
        for state in hamiltonian.phase.states
    ]
    total: np.ndarray = (np.abs(costates) * np.stack(rates)).sum(axis=0)
    return total


def _legendre(hamiltonian: Hamiltonian, values: dict, t: np.ndarray, tolerance: float) -> Check:
    """The smallest eigenvalue of d2L/du2 if negative, relative to the largest: over controls inside their bounds, and
    directions in which no constraint that acts changes."""
    inputs = hamiltonian.phase.found
    hessian, inside = np.zeros((len(t), len(inputs), len(inputs))), np.ones((len(t), len(inputs)))
    for j, variable in enumerate(inputs):
        u = values[variable.name]
        step = SECOND_STEP * (1 + np.abs(u).max())
        sides = [{**values, variable.name: u + side * step} for side in (1, -1)]
        for i, other in enumerate(inputs):
            up, down = (hamiltonian.derivative(hamiltonian.lagrangian, side, other.name) for side in sides)
            hessian[:, i, j] = (up - down) / (2 * step)
        width = variable.bounds.upper - variable.bounds.lower
        margin = max(step, NEAR_BOUND * width) if np.isfinite(width) else step
        inside[:, j] = (u - variable.bounds.lower > margin) & (variable.bounds.upper - u > margin)
    scale = float(np.abs(hessian).max()) or 1.0
    hessian *= inside[:, :, None] * inside[:, None, :] / scale
    finite = np.isfinite(hessian).all(axis=(1, 2))  # of other matrices LAPACK may refuse to tell eigenvalues
    hessian[~finite] = 0.0
    hessian = _on_tangent(hessian, hamiltonian.normals(values) * inside[:, None, :])
    lowest = np.linalg.eigvalsh((hessian + hessian.transpose(0, 2, 1)) / 2).min(axis=1)
    lowest[~finite] = np.nan
    k = int(np.argmin(lowest))
    value = float(np.maximum(0.0, -lowest[k])) + 0.0  # NaN stays NaN
    return Check("d2H/du2 without negative eigenvalues, relative", value, tolerance, at(hamiltonian.trajectory, t[k]))


def _on_tangent(hessian: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Matrices (M, n, n) on the directions in which nothing of normals (M, m, n) changes, and 0 in the others."""
    if not normals.shape[1]:
        return hessian
    normals = np.nan_to_num(normals)
    projector = np.eye(hessian.shape[-1]) - np.linalg.pinv(normals, rcond=1e-8) @ normals
    return projector @ hessian @ projector


def _natural_residual(gradient: np.ndarray, u: np.ndarray, bounds: Range) -> np.ndarray:
    """How far u is from stationary: the way a step against the relative gradient goes before a bound ends it.

    That is |dL/du| inside the bounds, and 0 on the bound that the step points to; in between, where an interior-point
    method leaves u, the smaller of |dL/du| and the distance from the bound relative to the range of u.
    """
    width = bounds.upper - bounds.lower
    width = width if 0 < width < np.inf else max(float(np.ptp(u)), 1.0)
    room = np.where(gradient > 0, u - bounds.lower, bounds.upper - u) / width
    return np.minimum(np.abs(gradient), np.maximum(room, 0.0))


def _scale(hamiltonian: Hamiltonian, values: dict, name: str) -> float:
    """What the zero of dL/du is the balance of: its largest term along the trajectory, or what the whole control makes
    of it, d2L/du2 times its size, if that is more: a single term that is a difference, as 2 (u - 1), is all rounding.
    """
    sizes = [
        np.abs(weight * hamiltonian.derivative(partial(_of_arrays, function), values, name)).max()
        for weight, function in hamiltonian.terms + hamiltonian.constraints
    ]
    u = values[name]
    step = SECOND_STEP * (1 + np.abs(u).max())
    up, down = (hamiltonian.derivative(hamiltonian.lagrangian, {**values, name: u + d}, name) for d in (step, -step))
    sizes.append(np.median(np.abs(up - down)) / (2 * step) * np.abs(u).max())
    return float(np.max(sizes)) or 1.0


def _of_arrays(function: Function, values: dict) -> np.ndarray:
    return function(values, np)
