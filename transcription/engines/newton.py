"""Newton's method on the KKT system: the solver of the introduction to direct collocation, sections 2 to 6.

For   minimise F(z)  subject to  g(z) = c   the Lagrangian is L = F + y (g - c), and each step solves

    [ H_L  J^T ] [ dz    ]     [ -grad F  ]
    [ J    0   ] [ y_new ]  =  [ -(g - c) ]                     (36), with y = -lambda, the sign that IPOPT uses

It knows equality constraints and fixed variables only, and it finds a stationary point, which may be a maximum or
a saddle: small and exact where it applies, and an independent check of IPOPT.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from scipy.sparse import bmat

from ...problems.errors import Mistake, SpecError
from ..program.contract import NonlinearProgram, NotFinite
from .linear import hessian_of, jacobian_of, solved
from .outcome import COLUMNS, Outcome, Start, Status

DEFAULTS = {"tol": 1e-8, "max_iter": 100, "line_search": "no"}
SHORTEST_STEP = 1e-8


def solve_program(
    nlp: NonlinearProgram,
    z: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    options: Mapping[str, object] | None = None,
    start: Start | None = None,
    progress: Callable[[dict], None] | None = None,
    stop: Callable[[], bool] | None = None,
    scaling: object = None,
) -> Outcome:
    """Find a stationary point from z, to the contract of `ipopt.solve_program`.

    nlp: all its constraints must be equations.
    z: initial values of the unknowns, shape (n,).
    lower, upper: shape (n,); equal where an unknown is fixed, and infinite elsewhere.
    options: tol, max_iter, and line_search (yes or no: halve a step until the KKT residual shrinks).
    start: its y are the initial multipliers of the constraints, which are 0 otherwise; those of bounds are not used.
    progress, stop: as of `ipopt.solve_program`.
    scaling: not used, as Newton's steps do not depend on it.

    Raises SpecError for another option, for an inequality constraint, and for a bound that does not fix its variable.
    """
    chosen = {**DEFAULTS, **(options or {})}
    if mistakes := [*check_options(chosen), *_inequalities(nlp, lower, upper)]:
        raise SpecError(mistakes)
    return _Newton(nlp, z, lower, upper, chosen, start, progress, stop).run()


def check_options(options: Mapping[str, object]) -> list[Mistake]:
    """The options this engine does not take, as `ipopt.check_options` tells them."""
    mistakes = []
    for name, value in options.items():
        if name not in DEFAULTS:
            remedy = f"it takes {', '.join(DEFAULTS)}; or leave out 'engine: newton'"
            mistakes.append(Mistake(f"solver.{name}", "the Newton engine has no such option", remedy))
        elif name == "line_search" and value not in ("yes", "no"):
            mistakes.append(Mistake(f"solver.{name}", f"line_search is {value!r}", "write yes or no"))
        elif name != "line_search" and not (isinstance(value, int | float) and value > 0):
            mistakes.append(Mistake(f"solver.{name}", f"{name} is {value!r}", "write a positive number"))
    return mistakes


def _inequalities(nlp: NonlinearProgram, lower: np.ndarray, upper: np.ndarray) -> list[Mistake]:
    remedy = "use IPOPT: leave out 'engine: newton'"
    mistakes = []
    if (nlp.cl != nlp.cu).any():
        name, _ = nlp.row_name(int(np.argmax(nlp.cl != nlp.cu)))
        what = f"the Newton engine takes equality constraints only, and {name} is an inequality"
        mistakes.append(Mistake("solver.engine", what, remedy))
    if ((lower != upper) & (np.isfinite(lower) | np.isfinite(upper))).any():
        mistakes.append(Mistake("solver.engine", "the Newton engine takes no bounds on variables", remedy))
    return mistakes


class _Newton:
    """One solve; `free` are the variables that no bound fixes."""

    def __init__(
        self,
        nlp: NonlinearProgram,
        z: np.ndarray,
        lower: np.ndarray,
        upper: np.ndarray,
        options: Mapping[str, Any],
        start: Start | None,
        progress: Callable[[dict], None] | None,
        stop: Callable[[], bool] | None,
    ) -> None:
        self.nlp, self.options, self.progress, self.stop = nlp, options, progress, stop
        self.free = np.flatnonzero(lower != upper)
        self.z = np.where(lower == upper, lower, z)
        self.y = np.array(start.y) if start else np.zeros(nlp.m)
        self.record: dict[str, list[float]] = {name: [] for name in COLUMNS}
        self.failed: tuple[np.ndarray, list] | None = None

    def run(self) -> Outcome:
        try:
            status = self._iterate()
        except NotFinite as error:
            status, self.failed = Status.INVALID_NUMBER, (self.z.copy(), error.names)
        bounds = np.zeros(self.nlp.n)
        return Outcome(
            status=status,
            z=self.z,
            y=self.y,
            z_lower=bounds,
            z_upper=bounds.copy(),
            objective=self.record["objective"][-1] if self.record["objective"] else np.nan,
            iterations={name: np.array(values) for name, values in self.record.items()},
            solver={"engine": "newton", **self.options, "scaling": json.dumps(None)},
            failed=self.failed,
        )

    def _iterate(self) -> Status:
        tolerance, before = self.options["tol"], np.inf
        self._note(0, 0.0, 0.0)
        for iteration in range(1, int(self.options["max_iter"]) + 1):
            if self.stop and self.stop():
                return Status.INTERRUPTED
            step = self._step()
            if step is None:
                return Status.STEP_FAILED
            dz, y_new = step
            length = self._step_length(dz, y_new) if self.options["line_search"] == "yes" else 1.0
            self.z[self.free] += length * dz
            self.y += length * (y_new - self.y)
            objective, infeasibility = self._note(iteration, np.abs(dz).max(initial=0.0), length)
            small_step = np.abs(dz).max(initial=0.0) <= tolerance * (1 + np.abs(self.z).max())
            if (
                small_step
                and infeasibility <= tolerance
                and abs(objective - before) <= tolerance * (1 + abs(objective))
            ):
                return Status.SOLVED
            before = objective
        return Status.MAX_ITERATIONS

    @property
    def _jacobian(self) -> Any:
        """dg/dz by the free unknowns."""
        return jacobian_of(self.nlp, self.z)[:, self.free]

    def _step(self) -> tuple[np.ndarray, np.ndarray] | None:
        """(dz, y_new) from the KKT system (36), or None if its matrix is singular."""
        J = self._jacobian
        H = hessian_of(self.nlp, self.z, self.y)[self.free][:, self.free]
        matrix = bmat([[H, J.T], [J, None]], format="csc")
        right = np.concatenate([-self.nlp.gradient(self.z)[self.free], self.nlp.cl - self.nlp.constraints(self.z)])
        solution = solved(matrix, right)  # (36)
        if solution is None or not np.isfinite(solution).all():
            return None
        n = len(self.free)
        return solution[:n], solution[n:]

    def _step_length(self, dz: np.ndarray, y_new: np.ndarray) -> float:
        """The first of 1, 1/2, 1/4, ... that shrinks the KKT residual; the last one tried if none does."""
        z, y, length = self.z.copy(), self.y.copy(), 1.0
        reference = self._residual()
        try:
            while length > SHORTEST_STEP:
                self.z[self.free] = z[self.free] + length * dz
                self.y = y + length * (y_new - y)
                if self._residual() < reference:
                    break
                length /= 2
        finally:
            self.z, self.y = z, y
        return length

    def _residual(self) -> float:
        """|| (grad L, g - c) ||; infinite where a function has no finite value."""
        try:
            gradient = self.nlp.gradient(self.z)[self.free] + self._jacobian.T @ self.y
            return float(np.linalg.norm(np.append(gradient, self.nlp.constraints(self.z) - self.nlp.cl)))
        except NotFinite:
            return np.inf

    def _note(self, iteration: int, step: float, length: float) -> tuple[float, float]:
        """Record an iteration; returns the objective and the largest constraint residual."""
        objective = self.nlp.objective(self.z)
        infeasibility = float(np.abs(self.nlp.constraints(self.z) - self.nlp.cl).max(initial=0.0))
        gradient = self.nlp.gradient(self.z)[self.free] + self._jacobian.T @ self.y
        dual = float(np.abs(gradient).max(initial=0.0))
        values = (0, iteration, objective, infeasibility, dual, 0.0, step, 0.0, length, length, 0)
        for name, value in zip(COLUMNS, values, strict=True):
            self.record[name].append(value)
        if self.progress:
            self.progress(dict(zip(COLUMNS, values, strict=True)))
        return objective, infeasibility
