"""Which phases there are, which goes on in which, and what goes on."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

from ..lean.records import dataclass
from ..names.variables import states
from ..schema.phases import LinkEntry, PhaseEntry
from ..schema.spec import Spec
from .observed import observed_phases

ALONE = "main"
"""The name of the phase of a file without phases."""

TIME = "t"


@dataclass(frozen=True)
class Passage:
    """One phase goes on in another: time, unless it is a circle, and every state of one name, but for `left_out`.

    number: of the entry of links: that says so, None for what is so between neighbours.
    """

    source: str
    target: str
    left_out: frozenset[str]
    number: int | None = None


def own_entries(spec: Spec) -> dict[str, PhaseEntry]:
    """The phases of a file in order, or those that its waypoints or its measurements make; none without any."""
    if not spec.waypoints:
        return dict(spec.phases) or observed_phases(spec)
    owners = {state.name: state.velocity_of for state in states(spec)}
    legs: dict[str, PhaseEntry] = {}
    for number, waypoint in enumerate(spec.waypoints, start=1):
        ends: dict[str, dict[str, Any]] = {}
        for name, value in waypoint.states.items():
            if owner := owners.get(name, ""):
                ends.setdefault(owner, {})["velocity"] = {"final": value}
            else:
                ends.setdefault(name, {})["final"] = value
        own = PhaseEntry.model_validate({"time": {"final": waypoint.time}, "states": ends})
        legs[waypoint.name or f"leg{number}"] = own
    return legs | {f"leg{len(legs) + 1}": PhaseEntry()}


def passages(spec: Spec) -> list[Passage]:
    """What goes on where: as links: say, and from each phase to the next one where they say nothing of that."""
    names = list(own_entries(spec))
    given = [
        Passage(link.source, link.target, frozenset(link.left_out), i)
        for i, link in enumerate(spec.links)
        if link.expression is None and not link.apart
    ]
    if any(link.apart for link in spec.links):
        return given
    said = {own.target for own in given if _forward(names, own)}
    neighbours = (Passage(before, after, frozenset()) for before, after in pairwise(names) if after not in said)
    return [*neighbours, *given]


def forward(spec: Spec) -> dict[str, str]:
    """Phase -> the phase before it, where it goes on from one."""
    names = list(own_entries(spec))
    return {own.target: own.source for own in reversed(passages(spec)) if _forward(names, own)}


def with_left_out(spec: Spec) -> dict[str, tuple[str, frozenset[str]]]:
    """Phase -> the phase before it, and the states that do not go on, where it goes on from one."""
    before = forward(spec)
    return {own.target: (own.source, own.left_out) for own in passages(spec) if before.get(own.target) == own.source}


def goes_on_in_time(spec: Spec, own: Passage) -> bool:
    """Whether the time goes on too: not where a circle closes."""
    return TIME not in own.left_out and _forward(list(own_entries(spec)), own)


def before_in_time(spec: Spec) -> dict[str, str]:
    """Phase -> the phase whose time goes on in it, where there is one."""
    before = forward(spec)
    on = [own for own in passages(spec) if goes_on_in_time(spec, own)]
    return {own.target: own.source for own in on if before.get(own.target) == own.source}


def expression_links(spec: Spec) -> Iterator[tuple[int, LinkEntry]]:
    """The links that are expressions, with their numbers in the file."""
    return ((i, link) for i, link in enumerate(spec.links) if link.expression is not None)


def _forward(names: list[str], own: Passage) -> bool:
    """Whether the target comes after the source in the file."""
    return own.source in names and own.target in names and names.index(own.source) < names.index(own.target)
