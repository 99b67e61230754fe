"""An outcome with a smaller barrier parameter.

The barrier leaves a gap between J and the optimum of the nonlinear program, the sum of multiplier times slack over the
inequalities that act. The engine's own tolerance for one product does not see their number.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ..engines.outcome import Outcome, Start, Status
from ..settings import Settings
from .multipliers import Multipliers

SMALLEST_PRODUCT = 1e-11  # of multiplier and slack, as IPOPT asks for: its barrier parameter ends at a tenth of it
AIM = 0.3  # of the gap that is small enough
IDLE = 100.0  # as much may be left by inequalities that do not act: it bends singular arcs only
MOST_MOVED = 2.0  # times the gap: an objective that moves by more has gone to another point
TIGHTENING = {
    "max_iter": 50,
    **dict.fromkeys(("warm_start_bound_push", "warm_start_bound_frac", "warm_start_slack_bound_push"), 1e-13),
    **dict.fromkeys(("warm_start_slack_bound_frac", "warm_start_mult_bound_push"), 1e-13),
}
"""Options of a solve that starts from a solution with a larger barrier parameter: it stays where it is."""

Again = Callable[[Mapping[str, object], Start], Outcome]
"""The engine once more from a solution, with other options and the multipliers."""


def less_barrier(own: Multipliers, gap: float, tolerance: float, settings: Settings, again: Again) -> Outcome | None:
    """The outcome with a smaller barrier parameter, from where it is; None if there is no need, or none is found.

    own: the multipliers of an outcome; its objective is that of the program which the engine solves.
    gap: that is small enough, in units of the objective.
    tolerance: of the engine.
    settings: of the solve.
    again: solves from the outcome's point.
    """
    outcome = own.outcome
    if settings.engine != "ipopt" or outcome.status is not Status.SOLVED or "compl_inf_tol" in settings.options:
        return None
    acting, count = own.acting_gap
    if acting <= gap and own.gap <= IDLE * gap:
        return None
    product = max(AIM * gap / max(count, 1.0), SMALLEST_PRODUCT)
    if own.largest_product <= product:
        return None
    options = {"tol": tolerance, **settings.options, **TIGHTENING, "compl_inf_tol": product, "mu_init": product}
    better = again(options, Start(outcome.y, outcome.z_lower, outcome.z_upper))
    stayed = abs(better.objective - outcome.objective) <= MOST_MOVED * own.gap
    return better if better.status is Status.SOLVED and stayed else None
