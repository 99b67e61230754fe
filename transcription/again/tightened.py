"""A solution with a smaller barrier parameter (see `less_barrier`)."""

from __future__ import annotations

import time
from dataclasses import replace
from functools import partial

import numpy as np

from ..dual.barrier import less_barrier
from ..dual.multipliers import Multipliers
from ..engines.watch import Watch
from ..one_mesh import Found, engine_of, in_place, measured
from ..settings import Settings


@np.errstate(all="ignore")
def tightened(found: Found, settings: Settings, gap: float, watch: Watch) -> Found:
    """The solution with a smaller barrier parameter, on the same mesh, from where it is; or as it is.

    found: a solved mesh.
    settings: of its solve.
    gap: that is small enough, in units of the objective.
    watch: who looks on.
    """
    solution, solved = found
    nlp, tolerance, clock = solved.nlp, solution.meshes[-1].tolerance, [time.perf_counter()] * 3
    outcome = replace(solved.outcome, objective=solved.outcome.objective + solved.worth)  # as the engine has it
    own = Multipliers(solved.transcription, nlp, outcome)
    nlp.seconds.update(dict.fromkeys(nlp.seconds, 0.0))
    engine = engine_of(solved.transcription, nlp, own.bounds, solved.damping, settings, watch)
    better = less_barrier(own, gap, tolerance, settings, partial(engine, outcome.z))
    if better is None:
        return found
    clock.append(time.perf_counter())
    return in_place(found, measured(solved.transcription, nlp, better, solved.damping, tolerance, clock))
