"""What has to hold where one phase goes on in another: the links, and H where the time of the passage is free.

The time of a passage that nothing fixes and nothing pays for is optimal only if H is the same on both sides of it
(Bryson and Ho 1975, section 3.7; the jump of H is the multiplier of what the time is otherwise bound by).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...problems.phases.links import DURATION
from ...problems.probe import names_asked
from ...problems.problem import Phase
from ...problems.quantities import Range
from ...transcription.constraint_kinds import ENDS, LINK
from ..file.reload import Reloaded
from .check import Check, at
from .optimality import Hamiltonian

NEAR = 1e-6
"""Of the guessed duration: a time as near to its bound is on it."""


def links(result: Reloaded, limit: float) -> Iterator[Check]:
    """How far each link is missed, the worst told; none without links.

    result: read back.
    limit: the largest value that passes, relative to 1 + the size of the bound.
    """
    missed, worst = -1.0, ""
    g = result.nlp.constraints_unchecked(result.outcome.z)
    bounds = {link.name: link.bounds for link in result.problem.links}
    for family in result.transcription.families:
        if family.kind in (LINK, ENDS):
            value = float(bounds[family.name].excess(g[family.rows(result.nlp)]).max())
            if not value <= missed:
                missed, worst = value, family.name
    if worst:
        yield Check("links between phases, relative", missed, limit, worst)


def junctions(result: Reloaded, claimed: float, tolerance: float) -> Iterator[Check]:
    """The jump of H at every passage whose time is free, relative to the largest term of H.

    result: read back, with costates.
    claimed: how far the objective may be from the optimum: what a jump is worth less over a phase is nothing.
    tolerance: the largest value that passes.
    """
    numbers = {phase.name: i for i, phase in enumerate(result.problem.phases)}
    for source, target in _free_passages(result):
        sides = [Hamiltonian(result, numbers[name]) for name in (source, target)]
        (before, after), values = sides, [side.values() for side in sides]
        jump = float(before.hamiltonian(values[0])[-1] - after.hamiltonian(values[1])[0])
        scale = max(side.scale(own) for side, own in zip(sides, values, strict=True)) or 1.0
        shortest = min(float(np.ptp(side.trajectory.t)) for side in sides)
        if not shortest:  # a phase that takes no time: H has no meaning in it
            continue
        value = max(abs(jump) - claimed / shortest, 0.0) / scale
        yield Check(
            f"H goes on from {source} to {target}, relative",
            value,
            tolerance,
            at(before.trajectory, before.trajectory.t[1]),
        )


def _free_passages(result: Reloaded) -> Iterator[tuple[str, str]]:
    """(phase, the one after it) where the time between them is free, and nothing but their dynamics depends on it."""
    problem = result.problem
    trajectories = {t.phase.name: t for t in result.trajectories}
    asked = [names_asked(link.function) for link in problem.links]
    others = set().union(*(own for own in asked if not _is_time(own)))
    others |= names_asked(problem.mayer) if problem.mayer else set()
    for own in filter(_is_time, asked):
        source = next(name.removesuffix(".t[final]") for name in own if name.endswith("[final]"))
        target = next(name.removesuffix(".t[initial]") for name in own if name.endswith("[initial]"))
        before, after = trajectories[source], trajectories[target]
        if before.costate is None or after.costate is None or own & others:
            continue
        near = NEAR * float(np.ptp(before.t) + np.ptp(after.t))
        inside = all(
            _inside(bounds, float(t), near)
            for bounds, t in ((before.phase.final_time, before.t[1]), (after.phase.initial_time, after.t[0]))
        )
        named = {name for phase in (before.phase, after.phase) for name in _asked_at_ends(phase)}
        lasting = min(float(np.ptp(before.t)), float(np.ptp(after.t))) > near
        if inside and lasting and not named & {"t[initial]", "t[final]"}:
            yield source, target


def _is_time(asked: set[str]) -> bool:
    """Whether a link is that time goes on from one phase to another; not one on the duration of a phase."""
    ends = sorted(name.partition(".")[2] for name in asked)
    return ends == ["t[final]", "t[initial]"] and len({name.partition(".")[0] for name in asked}) == 2


def _inside(bounds: Range, t: float, near: float) -> bool:
    return bounds.lower + near < t < bounds.upper - near


def _asked_at_ends(phase: Phase) -> set[str]:
    functions = [c.function for c in phase.boundary if c.name != DURATION] + ([phase.mayer] if phase.mayer else [])
    return set().union(*map(names_asked, functions))
