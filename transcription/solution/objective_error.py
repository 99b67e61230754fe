"""How far the objective J of a solution is from the optimum J*: a dual-weighted residual.

Let L be the Lagrangian of the continuous problem, for the minimised objective: M + integral of

    w(x, u) + lambda (f(x, u) - dx/dt) + nu g(x, u),          H = w + lambda f,

where integral constraints stand in w with their multipliers. At the optimum it is stationary in x, u, lambda, nu, free
times and parameters. So its value at the solution's own interpolants x, u and costates lambda misses J* only in the
second order of their errors, while J misses it in the first (Becker and Rannacher, Acta Numerica 10, 2001). L - J is,
segment by segment,

    quadrature     exact integral of w - the scheme's own quadrature of it
    dynamics       integral of lambda (f(x, u) - dx/dt)
    control        integral of min over v of H(x, v, lambda) - H(x, u, lambda)
    constraints    integral of nu (g(x) - bound), for bounds of states and path constraints without controls;
                   and what a touch between points gains where it belongs (`touch`)

Algebraic variables solve the residuals at every time (see `implicit`). v is any control within its bounds and its path
constraints, at the same x (see `hamiltonian`): this is the second-order term of an error of u, and where u smears a
jump or leaves its bounds between the points, the first-order one too. The multiplier of a constraint on states acts at
instants: what a point holds has no error there, only what two neighbours hold between them has. What the barrier leaves
is in it, as u and x are a little inside what binds them; for bounds that hold at one instant it is added (see
`multipliers`), as are residuals of equations times their multipliers. Free times and parameters add nothing: J is
stationary in them as it stands.

The bar is a sum over the segments, as errors of either sign on different segments cancel in J by chance only:

    SAFETY (|quadrature + dynamics| + |control, from the nearest v within bounds|)
    + integral of |H(x, nearest v within bounds, lambda) - H(x, u, lambda)|
    + |constraints, the masses of their multipliers spread around their points|
    + TOUCHED * (what of it exceeds a constraint between two points that both hold it)
    + SHIFTED * |where a touch of a constraint belongs, see `touch`|
    + what the barrier leaves at the ends + residuals of equations + rounding

A phase in discrete time, or without time, is its own nonlinear program: it adds to the last line alone.

Measured by tests/benchmarks/error_bar.py, 14 methods on three meshes each of 22 problems with known optima: the moduli
of what each segment adds to L - J cover 76 % of the errors, as parts cancel there where the errors do not; the bar
covers 94 % with SAFETY = 1, 99.1 % with 1.5, 99.3 % with 2 and 99.5 % with 3. What is left are coarsest meshes, where
errors are of third order, and the midpoint rule where jumps of a control make no other difference than the error. The
median of bar over error is 3.0. An excess over bounds of controls is taken by its modulus, as an optimum that is
pressed against them uses it with one sign. J + correction is nearer to J* than J in 77 % of the cases, by a factor of
16 in the median. It is not where a control or a costate jumps inside a segment (bang-bang controls, bounds of states
that begin to act): there what is left is of the same order as the error, and the bar holds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.text import short_repr
from ..dual.multipliers import Multipliers
from ..engines.outcome import Outcome, Status
from ..layout import Transcription
from ..program.contract import NonlinearProgram
from .lagrangian import TERMS, PhaseLagrangian, SegmentTerms, no_terms
from .touch import touches
from .trajectory import Trajectory

SHIFTED = 1.5  # with a mass on one point alone, what a touch is worth is too small by a sixth
ROUNDING = 1e-11  # relative to 1 + |J|: of sums, of derivatives by differences, and of the engine


NOT_UNIQUE = "where one of two things must be zero, multipliers are not unique"
"""Why nothing that is made of multipliers is told of a problem with complementarity."""


@short_repr
@dataclass(frozen=True)
class ObjectiveError:
    """How far the objective J of a solution is from the optimum J*, as the problem writes it.

    J + correction is the better value, |J - J*| <= bar the claim. segments: for each phase, (N,) what each segment adds
    to the correction, and shares: (N,) what it adds to the bar. terms: the segments' contributions by kind, see TERMS.
    gap: of the barrier, the sum of multiplier times slack; what of it acts is in both correction and bar.
    why_not: why there is no such estimate, or "". Then all numbers are NaN, and there are no segments.
    """

    correction: float = np.nan
    bar: float = np.nan
    gap: float = np.nan
    segments: tuple[np.ndarray, ...] = ()
    shares: tuple[np.ndarray, ...] = ()
    terms: Mapping[str, tuple[np.ndarray, ...]] = field(default_factory=dict)
    why_not: str = ""

    @property
    def applies(self) -> bool:
        return not self.why_not


@np.errstate(all="ignore")
def objective_error(
    transcription: Transcription, nlp: NonlinearProgram, outcome: Outcome, trajectories: Sequence[Trajectory]
) -> ObjectiveError:
    """The error of the objective of an outcome.

    transcription: of the problem on the mesh that was solved.
    nlp: its compiled program.
    outcome: its solution, with multipliers.
    trajectories: one for each phase, read from the outcome, with costates (see `costate`).

    Where it does not apply, the result says why.
    """
    if why_not := _why_not(outcome, trajectories):
        return ObjectiveError(why_not=why_not)
    multipliers, sense = Multipliers(transcription, nlp, outcome), transcription.problem.sense
    approximate = [(i, trajectory) for i, trajectory in enumerate(trajectories) if not trajectory.phase.exact]
    phases = {i: PhaseLagrangian(i, multipliers, trajectory) for i, trajectory in approximate}
    found = [phases[i].terms() if i in phases else no_terms(own.mesh) for i, own in enumerate(trajectories)]
    if why_not := next((phase.why_not for phase in phases.values() if phase.why_not), ""):
        return ObjectiveError(why_not=why_not)
    for i, phase in phases.items():
        _add_touches(phase, found[i])
    terms = {kind: tuple(sense * own.signed[kind] for own in found) for kind in TERMS}
    segments = tuple(np.sum(own, axis=0) for own in zip(*terms.values(), strict=True))
    shares = tuple(own.shares for own in found)
    single, missed = multipliers.single, multipliers.missed
    correction = float(sum(s.sum() for s in segments)) + sense * (single + float(missed.sum()))
    bar = float(sum(s.sum() for s in shares)) + abs(single) + float(np.abs(missed).sum())
    bar += ROUNDING * (1 + abs(outcome.objective))
    if not np.isfinite([correction, bar]).all():
        return ObjectiveError(why_not="a function of the problem has no finite value between the points")
    return ObjectiveError(correction, bar, multipliers.gap, segments, shares, terms)


def _add_touches(phase: PhaseLagrangian, terms: SegmentTerms) -> None:
    """Add what touches of constraints are worth: to the segment that has one, and to that where it belongs."""
    if any(group.scheme.simulated for group in phase.mesh.groups):
        return
    knots = phase.mesh.fractions[phase.mesh.knots]
    for touch in touches(phase):
        for s in (touch.at, touch.belongs):
            segment = min(int(np.searchsorted(knots, s, side="right")) - 1, phase.mesh.segments - 1)
            terms.signed["constraints"][segment] -= touch.worth / 2
            terms.shares[segment] += SHIFTED * touch.worth / 2


def _why_not(outcome: Outcome, trajectories: Sequence[Trajectory]) -> str:
    if not all(scheme.has_costates for own in trajectories for scheme in own.mesh.schemes):
        return "finite differences have no costates"
    if outcome.status is Status.FEASIBLE:
        return "nothing is left to optimise, and the engine computes no multipliers"
    if outcome.status is not Status.SOLVED:
        return "the point is not optimal"
    if any(own.phase.complementarity for own in trajectories):
        return NOT_UNIQUE
    if any(own.costate is None or not np.isfinite(own.costate).all() for own in trajectories):
        return "there are no finite costates"
    return ""
