"""How exact the estimated parameters are: their covariance, from the reduced Hessian of the nonlinear program.

With J the sum of weighted squared residuals, and whatever else is minimised, J/2 is the negative logarithm of the
likelihood where the weights are 1/deviation^2. Let H be the Hessian of the Lagrangian at the solution and A the
Jacobian of the constraints that act. The parameters p move together with all other unknowns along A dz = 0, and the
second derivatives of J by p on the way, the reduced Hessian, are the inverse of a part of the inverse KKT matrix
(Bard 1974, Nonlinear Parameter Estimation, chapter 7; Lopez-Negrete and Biegler 2012):

    [ H  A^T ] [ Z ]   [ E_p ]
    [ A   0  ] [ . ] = [  0  ],          covariance of p = 2 s^2 Z_p

s^2 = 1 where deviations are given; else it is estimated, s^2 = sum of w r^2 / (measurements - unknowns that are free).
Parameters on their bounds are taken as known.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ...problems.text import short_repr
from ..engines.outcome import Outcome
from ..layout import Transcription, bounded_start
from ..program.contract import NonlinearProgram

SINGULAR = 1e-10
"""Of the sum of w y^2: what J changes by at least where a parameter moves by 1 + its size, if it is determined."""


@short_repr
@dataclass(frozen=True)
class Estimates:
    """names: of the static parameters, (P,), and their values. deviations: (P,) standard errors; NaN where a parameter
    stands on a bound, and where there are none. correlation: (P, P).

    residuals: the sum of weighted squares. measurements, free: numbers of values and of what was free to fit them.
    scale: s. given: whether the deviations of the measurements were. why_not: why there are no standard errors, or "".
    """

    names: tuple[str, ...]
    values: np.ndarray
    deviations: np.ndarray
    correlation: np.ndarray
    residuals: float
    measurements: int
    free: int
    scale: float
    given: bool
    why_not: str = field(default="")


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
    acting = _Acting(transcription, nlp, outcome)
    free = acting.unknowns - acting.rows.size
    none = np.full(len(values), np.nan)
    scale = 1.0 if given else np.sqrt(residuals / (count - free)) if count > free else np.nan
    why_not, covariance = "", np.diag(none)
    if any(phase.controls for phase in problem.phases) and not given:
        why_not = "with controls, nothing tells how exact the measurements are: give deviations:"
    elif not count > free and not given:
        why_not = (
            f"{count} measurements leave nothing over for {free} unknowns to tell how exact they are: give deviations:"
        )
    else:
        covariance, why_not = acting.covariance(places, names)
        covariance = covariance * scale**2
    deviations = none if why_not else np.sqrt(np.diag(covariance))
    with np.errstate(all="ignore"):
        correlation = covariance / np.outer(deviations, deviations)
    correlation[np.diag_indices(len(values))] = np.where(np.isfinite(deviations), 1.0, np.nan)
    return Estimates(names, values, deviations, correlation, residuals, count, free, float(scale), given, why_not)


class _Acting:
    """The unknowns that no bound holds, and the constraints that act."""

    def __init__(self, transcription: Transcription, nlp: NonlinearProgram, outcome: Outcome) -> None:
        self.nlp, self.outcome = nlp, outcome
        _, lower, upper = bounded_start(transcription)
        z = outcome.z
        held = (lower == upper) | (outcome.z_lower > z - lower) | (outcome.z_upper > upper - z)
        g, y = nlp.constraints_unchecked(z), np.abs(outcome.y)
        self.moving = np.flatnonzero(~held)
        self.rows = np.flatnonzero((nlp.cl == nlp.cu) | (y > np.minimum(g - nlp.cl, nlp.cu - g)))
        self.unknowns = len(self.moving)
        measured = (own for phase in transcription.problem.phases for own in phase.measured)
        self.size = float(sum((own.weights * own.values**2).sum() for own in measured))

    def covariance(self, parameters: np.ndarray, names: Sequence[str]) -> tuple[np.ndarray, str]:
        """2 Z_p, shape (P, P), of parameters at these places, (P,); NaN for those on their bounds; and why there is
        none, or ""."""
        from scipy.sparse import bmat, coo_matrix
        from scipy.sparse.linalg import splu

        nlp, z, n = self.nlp, self.outcome.z, len(self.outcome.z)
        rows, columns = nlp.hessianstructure()
        lower = coo_matrix((nlp.hessian(z, self.outcome.y, 1.0), (rows, columns)), (n, n)).tocsr()
        H = (lower + lower.T).tolil()
        H.setdiag(lower.diagonal())
        A = coo_matrix((nlp.jacobian(z), nlp.jacobianstructure()), (nlp.m, n)).tocsr()[self.rows][:, self.moving]
        KKT = bmat([[H.tocsr()[self.moving][:, self.moving], A.T], [A, None]], format="csc")
        own = np.flatnonzero(np.isin(parameters, self.moving)).tolist()
        places = np.searchsorted(self.moving, parameters[own])
        right = np.zeros((KKT.shape[0], len(own)))
        right[places, np.arange(len(own))] = 1.0
        found = np.full((len(parameters), len(parameters)), np.nan)
        undetermined = f"the measurements do not determine {', '.join(names[i] for i in own)}: the reduced Hessian"
        try:
            part = splu(KKT).solve(right)[places]
        except RuntimeError:  # exactly singular
            return found, f"{undetermined} is singular"
        part = part + part.T  # 2 Z, symmetric
        size = 1 + np.abs(z[parameters[own]])
        scaled = np.linalg.eigvalsh(part / np.outer(size, size)) if np.isfinite(part).all() else np.array([np.nan])
        if not scaled.min(initial=1.0) > 0 or scaled.max(initial=0.0) * SINGULAR * self.size > 1:
            return found, f"{undetermined} is not positive"
        found[np.ix_(own, own)] = part
        return found, ""
