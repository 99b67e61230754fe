"""The arcs of a solution in words: "u: max until 13.73, singular until 21.99, then 0"."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from .printing import print_field

FEW, SHORT = 3, 8
"""Quantities that the short table tells, and arcs of each."""


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
    """A text for each quantity, of at most so many arcs each."""
    of_kind = [
        (own, name) for kind in ("control", "state", "path") for name in phases for own in _of(phases[name], kind)
    ]
    for own, phase in of_kind:
        where = f"{phase}, " if len(phases) > 1 else ""
        yield f"{where}{own['name']}: {_sentence(own['arcs'], most)}"


def _of(phase: Mapping[str, Any], kind: str) -> list[dict[str, Any]]:
    return [own for own in phase["arcs"] if own["kind"] == kind]


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
