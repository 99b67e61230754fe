"""What has to hold where one phase goes on in another: the links, and H where the time of the passage is free.

The time of a passage that nothing fixes and nothing pays for is optimal only if H is the same on both sides of it
(Bryson and Ho 1975, section 3.7; the jump of H is the multiplier of what the time is otherwise bound by). Where phases
branch there, or meet, it is the sum over those that end and over those that begin.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.probe import names_asked
from ...problems.problem import Phase
from ...problems.quantities import Duration, Range
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
    """The jump of H at every time between phases that is free, relative to the largest term of H.

    result: read back, with costates.
    claimed: how far the objective may be from the optimum: what a jump is worth less over a phase is nothing.
    tolerance: the largest value that passes.
    """
    numbers = {phase.name: i for i, phase in enumerate(result.problem.phases)}
    for event in _free_events(result):
        sides = {name: Hamiltonian(result, numbers[name]) for name in (*event.ending, *event.beginning)}
        values = {name: side.values() for name, side in sides.items()}
        before = [sides[name].hamiltonian(values[name])[-1] for name in event.ending]
        after = [sides[name].hamiltonian(values[name])[0] for name in event.beginning]
        jump = float(sum(before) - sum(after))
        scale = max(side.scale(values[name]) for name, side in sides.items()) or 1.0
        shortest = min(float(np.ptp(side.trajectory.t)) for side in sides.values())
        if not shortest:  # a phase that takes no time: H has no meaning in it
            continue
        value = max(abs(jump) - claimed / shortest, 0.0) / scale
        trajectory = sides[event.ending[0]].trajectory
        yield Check(f"H goes on from {event.told}, relative", value, tolerance, at(trajectory, trajectory.t[1]))


@dataclass(frozen=True)
class _Event:
    """One time that phases share: those that end there, and those that begin."""

    ending: tuple[str, ...]
    beginning: tuple[str, ...]

    @property
    def told(self) -> str:
        return f"{' and '.join(self.ending)} to {' and '.join(self.beginning)}"


def _free_events(result: Reloaded) -> Iterator[_Event]:
    """The times between phases that are free, where nothing but the dynamics depends on them."""
    problem = result.problem
    trajectories = {t.phase.name: t for t in result.trajectories}
    asked = [names_asked(link.function) for link in problem.links]
    others = set().union(*(own for own in asked if not _is_time(own)))
    others |= names_asked(problem.mayer) if problem.mayer else set()
    for event in _events(filter(_is_time, asked)):
        ends = [(trajectories[name], "final") for name in event.ending]
        ends += [(trajectories[name], "initial") for name in event.beginning]
        if any(own.costate is None or f"{own.phase.name}.t[{end}]" in others for own, end in ends):
            continue
        near = NEAR * sum(float(np.ptp(own.t)) for own, _ in ends)
        inside = all(
            _inside(own.phase.final_time, float(own.t[1]), near)
            if end == "final"
            else _inside(own.phase.initial_time, float(own.t[0]), near)
            for own, end in ends
        )
        named = {name for own, _ in ends for name in _asked_at_ends(own.phase)}
        lasting = min(float(np.ptp(own.t)) for own, _ in ends) > near
        if inside and lasting and not named & {"t[initial]", "t[final]"}:
            yield event


def _events(links: Iterable[set[str]]) -> list[_Event]:
    """The times that links of time tie together: where a phase has several successors, H is the sum of theirs."""
    events: list[_Event] = []
    for own in links:
        source = next(name.removesuffix(".t[final]") for name in own if name.endswith("[final]"))
        target = next(name.removesuffix(".t[initial]") for name in own if name.endswith("[initial]"))
        shared = [event for event in events if source in event.ending or target in event.beginning]
        ending = dict.fromkeys([name for event in shared for name in event.ending] + [source])
        beginning = dict.fromkeys([name for event in shared for name in event.beginning] + [target])
        events = [event for event in events if event not in shared] + [_Event((*ending,), (*beginning,))]
    return events


def _is_time(asked: set[str]) -> bool:
    """Whether a link is that time goes on from one phase to another; not one on the duration of a phase."""
    ends = sorted(name.partition(".")[2] for name in asked)
    return ends == ["t[final]", "t[initial]"] and len({name.partition(".")[0] for name in asked}) == 2


def _inside(bounds: Range, t: float, near: float) -> bool:
    return bounds.lower + near < t < bounds.upper - near


def _asked_at_ends(phase: Phase) -> set[str]:
    functions = [c.function for c in phase.boundary if not isinstance(c, Duration)] + (
        [phase.mayer] if phase.mayer else []
    )
    return set().union(*map(names_asked, functions))
