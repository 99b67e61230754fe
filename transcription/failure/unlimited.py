"""Inputs without a bound that grow and grow: a duration goes to zero under them, or they come to act as impulses.

A double integrator that is to be elsewhere as soon as possible, with a force that nothing limits, has no shortest time:
for each there is a shorter one, with a larger force.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from ..layout import Transcription
from ..solution.trajectory import Trajectory, trajectories
from ..solution.violation import of_phase

SHARE = 1e-3
"""Of its guess, of a duration that has gone to zero."""

GROWN = 1e6
"""Times 1 + the largest guess, of an input that has grown without limit."""


def shrinks_away(transcription: Transcription, z: np.ndarray) -> bool:
    """Whether a duration goes to zero while an input grows.

    transcription: what stands where.
    z: the unknowns, (n,).
    """
    return bool(told_of_shrinking(trajectories(transcription, z)))


def told_of_shrinking(found: Iterable[Trajectory]) -> str:
    """Which duration goes to zero while which inputs grow, and the remedy; "" where none does.

    found: the phases of a solve that failed, or may do so.
    """
    return next((_shrinking(own) for own in found if _has_shrunk(own) and any(_grown(own))), "")


def told_of_impulses(found: Iterable[Trajectory]) -> Iterator[str]:
    """What is told of inputs that have grown, of a solution that is not as accurate as was asked.

    found: its phases.
    """
    for own in found:
        for name, size in _grown(own):
            what = f"{name}{of_phase(own.phase.name)} grows to {size:.2g} and has no bound there"
            yield f"{what}: it acts as an impulse, which no mesh holds; give {name} bounds, or a price in the objective"


def _has_shrunk(trajectory: Trajectory) -> bool:
    guess, duration = trajectory.phase.guess, trajectory.final_time - trajectory.initial_time
    return not trajectory.phase.exact and duration < SHARE * (guess.final_time - guess.initial_time)


def _shrinking(trajectory: Trajectory) -> str:
    phase, grown = trajectory.phase, dict(_grown(trajectory))
    what = f"final time{of_phase(phase.name)} goes to its lower bound"
    if not phase.initial_time.fixed:
        what = f"duration{of_phase(phase.name)} goes to zero"
    how = " and ".join(f"{name} grows (to {size:.2g})" for name, size in grown.items())
    so = f"for each there is a shorter one; give {', '.join(grown)} bounds, or a price in the objective"
    return f"the {what} as {how}: {so}"


def _grown(trajectory: Trajectory) -> Iterator[tuple[str, float]]:
    """Each input that has grown towards a side where it has no bound, and the value that is farthest from zero."""
    guessed = trajectory.phase.guess.samples(trajectory.mesh.fractions)
    for own, values in zip(trajectory.phase.inputs, trajectory.u, strict=True):
        size = float(values[np.argmax(np.abs(values))])
        bound = own.bounds.upper if size > 0 else own.bounds.lower
        if np.isinf(bound) and abs(size) > GROWN * (1 + np.abs(guessed[own.name]).max()):
            yield own.name, size
