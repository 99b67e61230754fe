"""How exact the estimated parameters are: their covariance, from the reduced Hessian of the nonlinear program.

With J the sum of weighted squared residuals, and whatever else is minimised, J/2 is the negative logarithm of the
likelihood where the weights are 1/deviation^2. Let H be the Hessian of the Lagrangian at the solution and A the
Jacobian of the constraints that act. The parameters p move together with all other unknowns along A dz = 0, and the
second derivatives of J by p on the way, the reduced Hessian, are the inverse of a part of the inverse KKT matrix
(Bard 1974, Nonlinear Parameter Estimation, chapter 7; Lopez-Negrete and Biegler 2012):

    [ H  A^T ] [ Z ]   [ E_p ]
    [ A   0  ] [ . ] = [  0  ],          covariance of p = 2 s^2 Z_p

s^2 = 1 where deviations are given; else it is estimated, s^2 = sum of w r^2 / (measurements - unknowns that are free).
Parameters on their bounds are taken as known. Which are does not depend on their units: with the inequalities as the
barrier has them, H + sum of S_i a_i a_i^T, where S = multiplier/slack, and a is the gradient,

    theta_i = S_i a_i^T Z a_i = S_i / (S_i + c_i),          c_i the reduced second derivative along a_i,

is the part that an inequality has in what holds it, nearly 1 or nearly 0. So it is of states: one that the dynamics
take near its bound, as what is used up, is held by them and not by the bound, whatever its multiplier is.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..dual.multipliers import ACTS, Multipliers
from ..engines.linear import hessian_of, jacobian_of, solved
from ..engines.outcome import Outcome
from ..layout import Transcription
from ..measured.estimated import Estimates
from ..program.contract import NonlinearProgram

SINGULAR = 1e-10
"""Of the sum of w y^2: what J changes by at least where a parameter moves by 1 + its size, if it is determined."""

LEAST = 1e-12
"""Of a slack, relative to 1 + |bound|: the engine's own may be zero by rounding."""
TOGETHER = 200
"""Columns that are solved for at once."""


def estimates(transcription: Transcription, nlp: NonlinearProgram, outcome: Outcome) -> Estimates | None:
    """The estimated static parameters of a solved problem with measurements; None without them.

    transcription: of the problem on the mesh that was solved.
    nlp: its compiled program.
    outcome: its solution, with multipliers.
    """
    problem = transcription.problem
    measured = [own for phase in problem.phases for own in phase.measured]
    times = {name for phase in problem.phases for name in phase.time_parameters}
    wanted = [i for i, own in enumerate(problem.parameters) if own.name not in times]
    if not measured or not wanted:
        return None
    places = transcription.parameters[wanted]
    values, names = outcome.z[places], tuple(problem.parameters[i].name for i in wanted)
    count = int(sum((own.weights > 0).sum() for own in measured))
    residuals, given = nlp.term.objective(outcome.z), all(own.exact for own in measured)  # type: ignore[attr-defined]
    program = _Program(transcription, nlp, outcome, places)
    covariance, why_not = program.covariance(names)
    free, none = program.free, np.full(len(values), np.nan)
    scale = 1.0 if given else np.sqrt(residuals / (count - free)) if count > free else np.nan
    if any(phase.controls for phase in problem.phases) and not given:
        why_not = "with controls, nothing tells how exact the measurements are: give deviations:"
    elif not count > free and not given:
        why_not = (
            f"{count} measurements leave nothing over for {free} unknowns to tell how exact they are: give deviations:"
        )
    covariance = covariance * scale**2
    deviations = none if why_not else np.sqrt(np.diag(covariance))
    with np.errstate(all="ignore"):
        correlation = covariance / np.outer(deviations, deviations)
    correlation[np.diag_indices(len(values))] = np.where(np.isfinite(deviations), 1.0, np.nan)
    return Estimates(names, values, deviations, correlation, residuals, count, free, float(scale), given, why_not)


class _Program:
    """The nonlinear program at its solution: the unknowns that no bound holds, and the constraints that act."""

    def __init__(
        self, transcription: Transcription, nlp: NonlinearProgram, outcome: Outcome, parameters: np.ndarray
    ) -> None:
        self.nlp, self.outcome, self.parameters = nlp, outcome, parameters
        own = Multipliers(transcription, nlp, outcome)
        lower, upper, inner = ((side[0] > 0) & (own.acting(*side) > ACTS) for side in own.sides)
        self.H, A = hessian_of(nlp, outcome.z, outcome.y), jacobian_of(nlp, outcome.z)
        controls = [layout.u[: len(layout.phase.controls)].ravel() for layout in transcription.phases]
        bounded, of_controls = lower | upper, np.isin(np.arange(nlp.n), np.concatenate(controls))
        held = (own.bounds[0] == own.bounds[1]) | bounded & of_controls
        self.A, self.moving = A[own.equations], np.flatnonzero(~held)
        on, acting = self._held(own, A, np.flatnonzero(bounded & ~held), np.flatnonzero(inner))
        self.A, self.moving = A[np.union1d(np.flatnonzero(own.equations), acting)], np.setdiff1d(self.moving, on)
        measured = (own for phase in transcription.problem.phases for own in phase.measured)
        self.size = float(sum((own.weights * own.values**2).sum() for own in measured))

    def _held(self, own: Multipliers, A: Any, bounds: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What of the unknowns on a bound, and of the rows on one, is held by that: by theta.

        own: of the solution.
        A: (m, n), the Jacobian.
        bounds, rows: numbers of what may be.
        """
        from scipy.sparse import diags, identity, vstack

        below, above, inside = (
            np.where(z > 0, z / np.maximum(slack, LEAST * (1 + np.abs(bound))), 0.0) for z, slack, bound in own.sides
        )
        gradients = vstack([identity(self.nlp.n, format="csr")[bounds], A[rows]], format="csr")
        S = np.concatenate([(below + above)[bounds], inside[rows]])
        theta = np.ones(len(S))
        H = self.H + gradients.T @ diags(S) @ gradients
        for first in range(0, len(S), TOGETHER):
            some = slice(first, first + TOGETHER)
            a = gradients[some][:, self.moving].T.toarray()
            Z = self._inverse(H, a)
            if Z is not None:
                theta[some] = S[some] * (a * Z).sum(axis=0)
        on = theta > ACTS
        return bounds[on[: len(bounds)]], rows[on[len(bounds) :]]

    def _inverse(self, H: Any, right: np.ndarray) -> np.ndarray | None:
        """The inverse KKT matrix of the moving unknowns times columns, both (M, K); None if there is no inverse."""
        from scipy.sparse import bmat

        A, none = self.A[:, self.moving], np.zeros((self.A.shape[0], right.shape[1]))
        matrix = bmat([[H.tocsr()[self.moving][:, self.moving], A.T], [A, None]], format="csc")
        solution = solved(matrix, np.concatenate([right, none]))
        return None if solution is None else solution[: len(self.moving)]

    def covariance(self, names: Sequence[str]) -> tuple[np.ndarray, str]:
        """2 Z_p, shape (P, P); NaN for parameters on their bounds; and why there is none, or ""."""
        own = np.flatnonzero(np.isin(self.parameters, self.moving))
        at = self.parameters[own]
        found = np.full((len(self.parameters),) * 2, np.nan)
        undetermined = (
            f"the measurements do not determine {', '.join(names[i] for i in own.tolist())}: the reduced Hessian"
        )
        places = np.searchsorted(self.moving, at)
        units = np.zeros((len(self.moving), len(at)))
        units[places, np.arange(len(at))] = 1.0
        Z = self._inverse(self.H, units)
        if Z is None:
            return found, f"{undetermined} is singular"
        Z = Z[places]
        part, size = Z + Z.T, 1 + np.abs(self.outcome.z[at])
        scaled = np.linalg.eigvalsh(part / np.outer(size, size)) if np.isfinite(part).all() else np.array([np.nan])
        if not scaled.min(initial=1.0) > 0 or scaled.max(initial=0.0) * SINGULAR * self.size > 1:
            return found, f"{undetermined} is not positive"
        found[np.ix_(own, own)] = part
        return found, ""

    @property
    def free(self) -> int:
        """How many unknowns the constraints that act leave free to fit the measurements."""
        return len(self.moving) - self.A.shape[0]
