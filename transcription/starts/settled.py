"""States at earlier times where times are free: a mesh is solved again until the times are those that its rows know.

The rows are exact for the times that a solve starts from, and of second order beside them (`collocation.moving`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ...problems.problem import Curves, Phase, Problem

SETTLED = 1e-7
"""Of the duration: times that move by less are those of the rows, also where a row begins to read another segment."""
MOST = 12
"""Solves of one mesh."""


def has_moving(problem: Problem) -> bool:
    """Whether states at earlier times are read where free times say.

    problem: of any phases.
    """
    return any(phase.delayed and not all(map(_is_timed, (phase, *_before(problem, phase)))) for phase in problem.phases)


def _is_timed(phase: Phase) -> bool:
    return phase.initial_time.fixed and phase.final_time.fixed


def _before(problem: Problem, phase: Phase) -> Iterator[Phase]:
    """The phases whose time goes on in this one: states at earlier times may be theirs."""
    named = {own.name: own for own in problem.phases}
    while before := named.get(phase.before):
        yield (phase := before)


def moved(problem: Problem, start: Sequence[Curves], end: Sequence[Curves]) -> float:
    """By how much times have moved in a solve, of the duration of their phase.

    problem: that was solved.
    start, end: of the solve, one for each phase.
    """
    shifts = [0.0]
    for phase, a, b in zip(problem.phases, start, end, strict=True):
        first, last = phase.initial_time.clip(a.initial_time), phase.final_time.clip(a.final_time)
        shift = max(abs(b.initial_time - first), abs(b.final_time - last))
        shifts.append(shift / max(b.final_time - b.initial_time, 1e-300))
    return max(shifts)


def unsettled(shift: float) -> str:
    """What is told of times that have not settled.

    shift: by which they moved in the last solve.
    """
    return (
        f"the times did not settle in {MOST} solves, the last of which moved them by {shift:.1g} of the duration: "
        "states at earlier times are read nearly where they should be"
    )
