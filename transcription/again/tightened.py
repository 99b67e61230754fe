"""A solution with a smaller barrier parameter.

The barrier leaves a gap between J and the optimum of the nonlinear program, the sum of multiplier times slack over the
inequalities that act. The engine's own tolerance for one product does not see their number.
"""

from __future__ import annotations

import time

import numpy as np

from ..dual.multipliers import Multipliers
from ..engines.outcome import Start, Status
from ..engines.table import engine_solve
from ..engines.watch import Watch
from ..one_mesh import Found, in_place, measured, scaling_of
from ..settings import Settings

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


@np.errstate(all="ignore")
def tightened(found: Found, settings: Settings, gap: float, watch: Watch) -> Found:
    """The solution with a smaller barrier parameter, on the same mesh, from where it is; or as it is.

    found: a solved mesh.
    settings: of its solve.
    gap: that is small enough, in units of the objective.
    watch: who looks on.
    """
    solution, solved = found
    if settings.engine != "ipopt" or solution.status is not Status.SOLVED or "compl_inf_tol" in settings.options:
        return found
    own = Multipliers(solved.transcription, solved.nlp, solved.outcome)
    acting, count = own.acting_gap
    if acting <= gap and own.gap <= IDLE * gap:
        return found
    began = time.perf_counter()
    nlp, z, tolerance = solved.nlp, solved.outcome.z, solution.meshes[-1].tolerance
    nlp.seconds.update(dict.fromkeys(nlp.seconds, 0.0))
    product = max(AIM * gap / max(count, 1.0), SMALLEST_PRODUCT)
    options = {"tol": tolerance, **settings.options, **TIGHTENING, "compl_inf_tol": product, "mu_init": product}
    scaling = scaling_of(solved.transcription, nlp, z, settings)
    start = Start(solved.outcome.y, solved.outcome.z_lower, solved.outcome.z_upper)
    damped = solved.damping.of(nlp, solved.transcription)
    outcome = engine_solve(settings.engine)(
        damped or nlp, z, *own.bounds, options, start=start, scaling=scaling, **watch.callbacks()
    )
    if outcome.status is not Status.SOLVED:
        return found
    clock = [began] * 3 + [time.perf_counter()]
    better = measured(solved.transcription, nlp, outcome, solved.damping, tolerance, clock)  # J without damping
    moved = abs(better[1].outcome.objective - solved.outcome.objective)
    return found if moved > MOST_MOVED * own.gap else in_place(found, better)
