"""Many first trajectories, drawn within the bounds, and the distinct optima that they lead to.

What is drawn (a scrambled Sobol sequence, SciPy's): the value of every control at NODES times, the duration where the
final time is free, the static parameters. States are simulated under the controls, since white noise in the states is
no trajectory of anything.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import isfinite

import numpy as np

from ...problems.problem import Guess, Phase, Problem
from ...problems.quantities import Range
from ...problems.text import shorten
from .other import POINTS, OtherStart, at_level, under_controls

NODES = 4
"""Times at which each control is drawn; it is linear between them."""

SHORTEST, LONGEST = 0.3, 3.0
"""Times the guessed duration, for a free final time without two bounds."""

SPREAD = 2.0
"""Times 1 + its guess, for a static parameter without two bounds."""

SAME = 1e-5
"""Relative to 1 + |J|: what objectives on one mesh differ by at most, if they are of one optimum."""

MOST_TOLD = 6
"""Distinct optima in a note."""


def drawn_starts(problem: Problem, count: int, seed: int) -> Iterator[list[Guess]]:
    """First trajectories, one for each phase.

    problem: of any number of phases.
    count: how many.
    seed: the same one gives the same starts.
    """
    from scipy.stats import qmc  # it takes longer to import than a small problem to solve

    sampler = qmc.Sobol(max(_size(problem), 1), seed=seed)
    for sample in sampler.random_base2(max(int(np.ceil(np.log2(count))), 0))[:count]:
        yield _from(problem, sample)


def other_parameters(problem: Problem, count: int) -> Iterator[OtherStart]:
    """Starts with other static parameters, and controls that go with them; none where there is none to choose.

    They are plain random numbers, always the same: as good as a sequence where they are few, and there at once.

    problem: of any number of phases.
    count: how many.
    """
    names = chosen_parameters(problem)
    for sample in np.random.default_rng(0).random((count if names else 0, _size(problem))):
        guesses = _from(problem, sample)
        values = ", ".join(f"{name} = {guesses[0].parameters[name]:.3g}" for name in names)
        yield OtherStart(shorten(values), guesses)


def chosen_parameters(problem: Problem) -> list[str]:
    """The names of the static parameters that are no times.

    problem: of any number of phases.
    """
    times = {name for phase in problem.phases for name in phase.time_parameters}
    return [own.name for own in problem.parameters if own.name not in times]


def _size(problem: Problem) -> int:
    """How many numbers a start takes."""
    return len(problem.parameters) + sum(1 + NODES * len(phase.controls) for phase in problem.phases)


def _from(problem: Problem, sample: np.ndarray) -> list[Guess]:
    """The start that numbers from 0 to 1 mean."""
    numbers = iter(sample.tolist())
    parameters = {
        p.name: _within(p.bounds, problem.phases[0].guess.parameters[p.name], next(numbers)) for p in problem.parameters
    }
    return [_drawn(phase, parameters, numbers) for phase in problem.phases]


def _drawn(phase: Phase, parameters: Mapping[str, float], numbers: Iterator[float]) -> Guess:
    guess = replace(phase.guess, parameters=dict(parameters))
    at = next(numbers)
    if not phase.final_time.fixed:
        duration = guess.final_time - guess.initial_time
        lower, upper = phase.final_time.lower, phase.final_time.upper
        final = guess.initial_time + duration * SHORTEST * (LONGEST / SHORTEST) ** at
        if isfinite(lower) and isfinite(upper):
            final = lower + at * (upper - lower)
        guess = replace(guess, final_time=max(phase.final_time.clip(final), guess.initial_time))
    s, nodes = np.linspace(0.0, 1.0, POINTS), np.linspace(0.0, 1.0, NODES)
    controls = {
        control.name: np.interp(s, nodes, [at_level(control, 2 * next(numbers) - 1) for _ in range(NODES)])
        for control in phase.controls
    }
    return under_controls(phase, guess, controls) if controls else guess


def _within(bounds: Range, guess: float, at: float) -> float:
    if isfinite(bounds.lower) and isfinite(bounds.upper):
        return bounds.lower + at * (bounds.upper - bounds.lower)
    return bounds.clip(guess + SPREAD * (1 + abs(guess)) * (2 * at - 1))


def told_of_starts(objectives: Sequence[float | None], sense: int) -> str:
    """The distinct optima of many starts, the best first, and how many starts led to each.

    objectives: of every start, None where it was not solved.
    sense: +1 where the least is the best, -1 where the largest is.
    """
    found: list[list[float]] = []
    for value in sorted((own for own in objectives if own is not None), key=lambda own: sense * own):
        if found and abs(value - found[-1][0]) <= SAME * (1 + abs(value)):
            found[-1].append(value)
        else:
            found.append([value])
    parts = [f"{own[0]:.6g} ({len(own)})" for own in found[:MOST_TOLD]]
    if len(found) > MOST_TOLD:
        parts.append(f"{len(found) - MOST_TOLD} more optima")
    if failed := sum(own is None for own in objectives):
        parts.append(f"not solved ({failed})")
    return f"{len(objectives)} starts on the first mesh led to {', '.join(parts)}; the best is kept"
