"""An independent look at a result: does the control really do what the trajectory says, and is it optimal?

Dynamics      The stored control is integrated forward from the stored initial state (SciPy's DOP853, restarted at every
              knot), and compared with the stored states.
Optimality    With lambda the costate and nu, kappa the multiplier functions of path constraints and residuals,

                  L = w + lambda f + nu g + kappa r                        (B.7), extended

              has dL/du = 0 where u is inside its bounds, points into the bound where it is on one, and H = w + lambda f
              changes along the trajectory only as dH/dt = the partial derivative by t: constant if nothing depends on
              t. Without path constraints, d2H/du2 has no negative eigenvalue for the controls inside their bounds
              (Legendre's condition): a point that is stationary but no minimum, a maximum even, fails here.
Constraints   Bounds and path constraints, on a grid between the collocation points; less strictly within a jump of a
              control, where no mesh makes them hold.
Reference     The objective beside the problem file's own reference, unless the command line changed the problem.

Derivatives are taken by the complex step, so nothing here shares code with the derivatives that the solver used.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..problems.problem import Phase, Range
from ..transcription.refinement.switches import Switches
from ..transcription.solution.error import excesses
from ..transcription.solution.implicit import consistent_inputs
from ..transcription.solution.trajectory import Trajectory
from .file.reload import Reloaded, reload

RTOL, ATOL = 1e-10, 1e-12
COMPLEX_STEP = 1e-30
SECOND_STEP = 1e-5  # relative to 1 + the size of a control, of central differences of complex-step derivatives
KINDS = {"path": "path", "residual": "residuals", "integral": "integral"}  # of constraints -> attribute of Phase


@dataclass(frozen=True)
class Check:
    """One line of the verdict: a measure, relative where the name says so, and the largest value that passes."""

    name: str
    value: float
    limit: float
    where: str = ""

    @property
    def passed(self) -> bool:
        return bool(self.value <= self.limit)  # False for NaN


@np.errstate(all="ignore")  # a result without finite values fails its checks, and needs no warnings beside
def verify(path: Path, tolerance: float = 5e-2) -> list[Check]:
    """All checks of a result file; `tolerance` is the relative error that passes. Raises FileError for another file."""
    result = reload(path)
    checks = [Check("solver status", 0.0 if result.solved else 1.0, 0.0, result.outcome.status.message)]
    for number, trajectory in enumerate(result.trajectories):
        checks += _simulation(trajectory, tolerance)
        checks += _between_points(trajectory, tolerance)
        if trajectory.costate is not None:
            checks += _optimality(result, number, tolerance)
        else:
            checks.append(Check("optimality", 0.0, 0.0, "not looked at: this method gives no costates"))
    if (reference := result.spec.reference) and not result.overrides:
        difference = abs(result.objective - reference.objective)
        checks.append(
            Check("objective, difference from the reference", difference, reference.tolerance, reference.source)
        )
    return checks


def _simulation(trajectory: Trajectory, tolerance: float) -> Iterator[Check]:
    stored = trajectory.x[:, trajectory.mesh.knots]
    simulated = simulate(trajectory)
    scale = np.ptp(trajectory.dense.x, axis=1)
    scale[scale == 0] = 1.0
    for i, state in enumerate(trajectory.phase.states):
        deviation = np.abs(simulated[i] - stored[i]) / scale[i]
        k = int(np.argmax(np.nan_to_num(deviation, nan=np.inf)))
        where = _at(trajectory.knots[k])
        if not np.isfinite(deviation[k]):
            where = f"the simulation fails before {where}: the dynamics have no finite value, or run away"
        yield Check(f"simulated {state.name}, relative to its range", float(deviation[k]), tolerance, where)


class _NoDynamicsError(ArithmeticError):
    """The dynamics have no finite value where the simulation has come to."""


def simulate(trajectory: Trajectory) -> np.ndarray:
    """States at the knots, shape (n_x, N + 1), by integrating the trajectory's control from its initial state.

    NaN from the knot on at which the integration fails.
    """
    from scipy.integrate import solve_ivp

    phase, p = trajectory.phase, trajectory.parameters
    x = np.full((len(phase.states), trajectory.mesh.segments + 1), np.nan)
    x[:, 0] = trajectory.x[:, 0]
    for segment, (start, end) in enumerate(zip(trajectory.knots[:-1], trajectory.knots[1:], strict=True)):
        which = np.array([segment])

        def rate(t, x, which=which, start=start, h=end - start):
            u = trajectory.grid(which, np.array([(t - start) / h])).u[..., 0]
            t, x = np.array([t]), x[:, None]
            f = phase.dynamics(t, x, consistent_inputs(phase, t, x, u, p), p)[:, 0]
            if not np.isfinite(f).all():
                raise _NoDynamicsError
            return f

        try:
            step = solve_ivp(rate, (start, end), x[:, segment], method="DOP853", rtol=RTOL, atol=ATOL)
        except _NoDynamicsError:  # SciPy would make its steps ever smaller, for ever
            break
        if not step.success or not np.isfinite(step.y[:, -1]).all():
            break
        x[:, segment + 1] = step.y[:, -1]
    return x


def _between_points(trajectory: Trajectory, tolerance: float) -> Iterator[Check]:
    """Bounds and path constraints on the dense grid, relative to 1 + |bound|.

    On a segment in which a control jumps, its polynomial overshoots by a share of the jump, however short the segment
    is: there the excess counts times the segment's share of the phase, and is told.
    """
    mesh, jumping, t = trajectory.mesh, list(Switches(trajectory).jumps), trajectory.dense.t
    weights = np.ones((mesh.segments, 1))
    weights[jumping, 0] = mesh.widths[jumping]
    for excess in excesses(trajectory):
        by_segment = np.nan_to_num(trajectory.by_segment(excess.values), nan=np.inf)
        peak, counted = by_segment.ravel(), (by_segment * weights).ravel()
        k, worst = int(np.argmax(counted)), int(np.argmax(peak))
        where = _at(t[k]) if counted[k] > 0 else ""
        if peak[worst] > tolerance >= counted[k]:
            where += f"; {peak[worst]:.1e} in a jump, {_at(t[worst])}"
        yield Check(f"{excess.name} between the points", float(counted[k]), tolerance, where)


# -- optimality -----------------------------------------------------------------------------------------------------


class _Hamiltonian:
    """H and L of one phase along the collocation points, sums of weight * function, for the minimised objective."""

    def __init__(self, result: Reloaded, number: int):
        self.trajectory = result.trajectories[number]
        self.phase: Phase = self.trajectory.phase
        self.points = self.trajectory.mesh.collocated
        phase, sense = self.phase, result.problem.sense
        costate = sense * self.trajectory.point_costate[:, self.points]
        self.terms = [(row, state.rate) for row, state in zip(costate, phase.states, strict=True)]
        self.terms += [(float(sense), phase.lagrange)] if phase.lagrange else []
        self.constraints = []
        functions = {(kind, c.name): c.function for kind in KINDS for c in getattr(phase, KINDS[kind])}
        for (kind, name), multiplier in self._multipliers(result).items():
            group = self.terms if kind == "integral" else self.constraints
            group.append((multiplier, functions[kind, name]))

    def _multipliers(self, result: Reloaded) -> dict:
        """(kind, name) -> the multiplier function at the points; of an integral constraint, its one multiplier."""
        mesh, duration = self.trajectory.mesh, self.trajectory.t[1] - self.trajectory.t[0]
        found: dict = {}
        for family in result.transcription.families:
            if family.phase != self.phase.name or family.kind not in KINDS:
                continue
            y, key = result.outcome.y[family.rows(result.nlp)], (family.kind, family.name)
            if family.kind == "integral":
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

    def lagrangian(self, values: dict) -> np.ndarray:
        """L = H + nu g + kappa r."""
        return self.hamiltonian(values) + sum(weight * function(values, np) for weight, function in self.constraints)

    def derivative(self, function, values: dict, name: str) -> np.ndarray:
        """Of a function of the values by one of them, by the complex step."""
        shifted = {**values, name: values[name] + COMPLEX_STEP * 1j}
        return np.broadcast_to(np.imag(function(shifted)), self.points.shape) / COMPLEX_STEP


def _optimality(result: Reloaded, number: int, tolerance: float) -> Iterator[Check]:
    hamiltonian = _Hamiltonian(result, number)
    values = hamiltonian.values()
    t = values["t"]
    yield _hamiltonian_drift(hamiltonian, values, t, tolerance)
    for variable in hamiltonian.phase.inputs:
        gradient = hamiltonian.derivative(hamiltonian.lagrangian, values, variable.name)
        scale = _scale(hamiltonian, values, variable.name)
        residual = _natural_residual(gradient / scale, values[variable.name], variable.bounds)
        k = int(np.argmax(np.nan_to_num(residual, nan=np.inf)))
        name = f"stationarity dH/d{variable.name}, relative"
        yield Check(name, float(residual[k]), tolerance, _at(t[k]))
    if hamiltonian.phase.inputs and not hamiltonian.constraints:
        yield _legendre(hamiltonian, values, t, tolerance)


def _hamiltonian_drift(hamiltonian: _Hamiltonian, values: dict, t: np.ndarray, tolerance: float) -> Check:
    """Half the range of H(t) - H(t_0) - integral of dL/dt, which should be 0, relative to the largest term of H."""
    H = hamiltonian.hamiltonian(values)
    explicit = hamiltonian.derivative(hamiltonian.lagrangian, values, "t")
    drift = H - H[0] - np.append(0, np.cumsum(np.diff(t) * (explicit[1:] + explicit[:-1]) / 2))
    drift -= (drift.max() + drift.min()) / 2
    scale = max(float(np.max(np.abs(weight * f(values, np)))) for weight, f in hamiltonian.terms) or 1.0
    k = int(np.argmax(np.abs(drift)))
    return Check("Hamiltonian along the trajectory, relative", float(abs(drift[k]) / scale), tolerance, _at(t[k]))


def _legendre(hamiltonian: _Hamiltonian, values: dict, t: np.ndarray, tolerance: float) -> Check:
    """The smallest eigenvalue of d2H/du2, over controls inside their bounds, if negative; relative to the largest."""
    inputs = hamiltonian.phase.inputs
    hessian, inside = np.zeros((len(t), len(inputs), len(inputs))), np.ones((len(t), len(inputs)))
    for j, variable in enumerate(inputs):
        u = values[variable.name]
        step = SECOND_STEP * (1 + np.abs(u).max())
        sides = [{**values, variable.name: u + side * step} for side in (1, -1)]
        for i, other in enumerate(inputs):
            up, down = (hamiltonian.derivative(hamiltonian.hamiltonian, side, other.name) for side in sides)
            hessian[:, i, j] = (up - down) / (2 * step)
        inside[:, j] = (u - variable.bounds.lower > step) & (variable.bounds.upper - u > step)
    scale = float(np.abs(hessian).max()) or 1.0
    hessian *= inside[:, :, None] * inside[:, None, :] / scale
    finite = np.isfinite(hessian).all(axis=(1, 2))  # of other matrices LAPACK may refuse to tell eigenvalues
    hessian[~finite] = 0.0
    lowest = np.linalg.eigvalsh((hessian + hessian.transpose(0, 2, 1)) / 2).min(axis=1)
    lowest[~finite] = np.nan
    k = int(np.argmin(lowest))
    value = float(np.maximum(0.0, -lowest[k])) + 0.0  # NaN stays NaN
    return Check("d2H/du2 without negative eigenvalues, relative", value, tolerance, _at(t[k]))


def _natural_residual(gradient: np.ndarray, u: np.ndarray, bounds: Range) -> np.ndarray:
    """How far u is from stationary: the way a step against the relative gradient goes before a bound ends it.

    That is |dL/du| inside the bounds, and 0 on the bound that the step points to; in between, where an interior-point
    method leaves u, the smaller of |dL/du| and the distance from the bound relative to the range of u.
    """
    width = bounds.upper - bounds.lower
    width = width if 0 < width < np.inf else max(float(np.ptp(u)), 1.0)
    room = np.where(gradient > 0, u - bounds.lower, bounds.upper - u) / width
    return np.minimum(np.abs(gradient), np.maximum(room, 0.0))


def _scale(hamiltonian: _Hamiltonian, values: dict, name: str) -> float:
    """The largest term of dL/du along the trajectory: what its zero is the balance of."""
    sizes = [
        np.abs(weight * hamiltonian.derivative(lambda v, f=function: f(v, np), values, name)).max()
        for weight, function in hamiltonian.terms + hamiltonian.constraints
    ]
    return float(max(sizes)) or 1.0


def _at(t: float) -> str:
    return f"t = {t:.4g}"
