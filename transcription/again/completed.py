"""What is worked out once, of the solution that is given back: what its bounds cost, its arcs, what was estimated."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from ...problems.conserved.invariant import told_as_kept
from ..failure.runaway import divided, runaway_times
from ..failure.unlimited import told_of_impulses
from ..solution.sensitivity import sensitivities
from ..solution.solution import Solution, without_error_bar
from ..starts.warm import Solved
from ..structure.convexity import kind_of_program
from ..structure.courses import courses
from ..structure.estimates import estimates
from ..structure.prices import prices
from ..transcribe import numbers_of


def completed(solution: Solution, solved: Solved) -> Solution:
    """The solution with all that its program tells; sensitivities are worked out when they are asked for.

    Where it is not as accurate as was asked, a division by what changes its sign is told, and there is no error bar: an
    integral across a pole has no value that more points would come nearer to. Inputs that have grown without a bound
    are told, too.
    """
    own = (solved.transcription, solved.nlp, solved.outcome)
    pole = divided(solution.trajectories) if solution.solved and solution.inaccurate else ""
    if pole:
        solution = without_error_bar(solution, "a pole is crossed")
    told = (*runaway_times(solution.trajectories), *told_as_kept(solution.problem), *filter(None, [pole]))
    if solution.solved and solution.inaccurate:
        told = (*told, *told_of_impulses(solution.trajectories))
    solution = replace(solution, notes=(*solution.notes, *told), sensitive=partial(sensitivities, *own, numbers_of))
    if not solution.status.usable:
        return solution
    continuous = not all(phase.exact for phase in solution.problem.phases)
    of_phases, between = prices(*own)
    return replace(
        solution,
        prices=of_phases,
        prices_between=between,
        program=kind_of_program(solved.nlp, solved.outcome.z).told(continuous),
        arcs=courses(*own, solution.trajectories),
        estimates=estimates(*own) if solution.solved else None,
    )
