"""A solve in which a phase of free duration shrank: again, from a solution whose phases last."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ...problems.problem import Curves, Phase, Problem
from ...problems.quantities import Duration, Range
from ..engines.watch import Limit
from ..one_mesh import Found
from ..solution.solution import Solution
from ..solution.trajectory import Trajectory
from .attempt import Attempt

SHARE = 0.5
"""Of its guessed duration: a phase that ended shorter in a failed solve has shrunk, and is held to as much."""


def run_lasting(attempt: Attempt, guess: Sequence[Curves] | None, limit: Limit) -> Found:
    """The solution from a guess; if there is none and a duration shrank, from the solution in which it may not.

    In no time no control takes a state anywhere: a failed solve that has come there does not come back, whatever its
    guess was.

    attempt: what is solved, and how.
    guess: one for each phase; None for the problem's own.
    limit: of both solves.
    """
    found = attempt.run(guess, limit)
    return from_lasting(attempt, found, guess, limit) or found


def from_lasting(attempt: Attempt, failed: Found, guess: Sequence[Curves] | None, limit: Limit) -> Found | None:
    """The solution from the same guess, from one in which no phase is shorter than a share of its guess; None if no
    duration shrank, or if there is none.

    attempt: what is solved, and how.
    failed: what the guess led to.
    guess, limit: as of `run_lasting`.
    """
    if failed[0].status.usable or not any(map(_shrank, failed[0].trajectories)) or limit.reached():
        return None
    lasting = replace(attempt, problem=_lasting(attempt.problem)).run(guess, limit)
    if not lasting[0].status.usable:
        return None
    found = attempt.run(lasting[0].trajectories, limit)
    return found if found[0].status.usable else None


def told_of_lasting(failed: Solution) -> str:
    """What was done about the durations that shrank in a failed solve."""
    failed_so = f"the start of the file failed ({failed.status.message}), as the time shrank"
    return f"{failed_so}; this is the solution from another: a longer time, held first"


def _shrank(trajectory: Trajectory) -> bool:
    phase = trajectory.phase
    if phase.exact or (phase.initial_time.fixed and phase.final_time.fixed):
        return False
    return trajectory.final_time - trajectory.initial_time < SHARE * _guessed(phase)


def _guessed(phase: Phase) -> float:
    return phase.guess.final_time - phase.guess.initial_time


def _lasting(problem: Problem) -> Problem:
    """The problem, whose free durations are not shorter than a share of what is guessed."""
    return replace(problem, phases=tuple(map(_held, problem.phases)))


def _held(phase: Phase) -> Phase:
    least, start, end = SHARE * _guessed(phase), phase.initial_time, phase.final_time
    if phase.exact or (start.fixed and end.fixed):
        return phase
    if start.fixed:
        return replace(phase, final_time=Range(max(end.lower, start.lower + least), end.upper))
    if end.fixed:
        return replace(phase, initial_time=Range(start.lower, min(start.upper, end.lower - least)))
    held = [replace(own, bounds=Range(lower=least)) if isinstance(own, Duration) else own for own in phase.boundary]
    return replace(phase, boundary=tuple(held))
