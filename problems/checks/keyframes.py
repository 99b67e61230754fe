"""Keyframes of a guess, those of one phase and those of the whole trajectory: of one length, at times that increase."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

from ..expressions.expression import Expression
from ..yaml.locations import Finding


def uneven(keyframes: Mapping[str, Sequence[Expression]]) -> Iterator[Finding]:
    """Rows that have not as many values as the first one."""
    first = next(iter(keyframes), "")
    for name, row in keyframes.items():
        if len(row) != len(keyframes[first]):
            what = f"{name} has {len(row)} keyframes, {first} has {len(keyframes[first])}"
            yield Finding(("guess", "keyframes", name), what, "give all of them the same number of values")


def unordered(times: Sequence[float]) -> Iterator[Finding]:
    """Times of keyframes that do not increase."""
    if any(later <= earlier for earlier, later in pairwise(times)):
        remedy = "sort them, each larger than the one before"
        yield Finding(("guess", "keyframes", "time"), "the times do not increase", remedy)
