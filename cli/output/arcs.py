"""The arcs of a solution in words: "u: max until 13.73, singular until 21.99, then 0"."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import chain, pairwise
from math import isclose
from typing import Any

from .printing import print_field

ORDER = ("control", "state", "path")
"""What has arcs, in the order in which it is told."""

FEW, SHORT = 3, 8
"""Quantities that the short table tells, and arcs of each."""

SAME = 1e-9  # relative difference of times that a solver holds equal


def few_arcs(phases: Mapping[str, Any]) -> Iterator[str]:
    """The arcs of the first quantities that have some, controls before all; how many more there are.

    phases: of a summary, by name.
    """
    told = list(_told(phases, SHORT))
    yield from told[:FEW]
    if len(told) > FEW:
        yield f"and {len(told) - FEW} more: trajopt show"


def print_arcs(phases: Mapping[str, Any]) -> None:
    """All arcs of all quantities, as far as the short table does not tell them. phases: of a summary, by name."""
    every, few = list(_told(phases)), list(_told(phases, SHORT))[:FEW]
    if every != few:
        print()
        for text in every:
            print_field("arcs", text)


def _told(phases: Mapping[str, Any], most: int | None = None) -> Iterator[str]:
    """A text for each quantity, of at most so many arcs each; one for all phases, where it has arcs in all of them."""
    names = {(own["kind"], own["name"]): None for phase in phases.values() for own in phase["arcs"]}
    for kind, name in sorted(names, key=lambda key: ORDER.index(key[0])):
        found = {phase: own["arcs"] for phase in phases for own in phases[phase]["arcs"] if _is(own, kind, name)}
        if len(found) == len(phases) and _consecutive(phases):
            yield f"{name}: {_sentence(_joined(found.values()), most)}"
        else:
            yield from (f"{phase}, {name}: {_sentence(arcs, most)}" for phase, arcs in found.items())


def _is(own: Mapping[str, Any], kind: str, name: str) -> bool:
    return own["kind"] == kind and own["name"] == name


def _consecutive(phases: Mapping[str, Any]) -> bool:
    """Whether each phase begins when the one before it ends."""
    times = [phase["time"] for phase in phases.values()]
    return all(isclose(before["final"], after["initial"], rel_tol=SAME) for before, after in pairwise(times))


def _joined(phases: Iterable[list[dict[str, Any]]]) -> list[dict[str, Any]]:
    """The arcs of phases one after the other; what goes on as it was is one arc."""
    found: list[dict[str, Any]] = []
    for arc in chain.from_iterable(phases):
        if found and all(found[-1][key] == arc[key] for key in ("on", "by", "bound")) and arc["end"] > arc["start"]:
            found[-1] = {**found[-1], "end": arc["end"]}
        else:
            found.append(arc)
    return found


def _sentence(arcs: list[dict[str, Any]], most: int | None) -> str:
    if most and len(arcs) > most:
        return f"{len(arcs)} arcs, on its bounds and off them"
    if len(arcs) == 1:
        return f"{_where(arcs[0])} throughout"
    parts = [_part(arc) for arc in arcs[:-1]]
    return f"{', '.join(parts)}, then {_where(arcs[-1])}"


def _part(arc: dict[str, Any]) -> str:
    """One arc that is not the last; what has no duration is a touch."""
    if arc["start"] == arc["end"]:
        return f"touching {_where(arc)} there"
    return f"{_where(arc)} until {arc['end']:.5g}"


def _where(arc: dict[str, Any]) -> str:
    """What a quantity does on an arc."""
    if arc["on"] == "inside":
        return arc["by"] or "inside"
    return "0" if arc["bound"] == 0 else "max" if arc["on"] == "upper" else "min"
