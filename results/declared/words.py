"""Words to declare a file in: groups, arrays and attributes, of which kind and size.

A group has members and attributes; `Each` is one of them repeated, under the names of states, say, or under 0, 1, 2.
Sizes are symbols: wherever one stands within a phase, a mesh or the solver, it is the same number. A name that ends
with * stands for all that begin so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

from ...problems.lean.records import dataclass

TEXT, TEXTS, NUMBER, WHOLE, FLAG, OPTION = (
    "a text",
    "a row of texts",
    "a number",
    "a whole number",
    "true or false",
    "an option",
)
"""Kinds of value. TEXTS: an attribute with any number of them. OPTION: a text or a number."""


@dataclass(frozen=True)
class Size:
    """The size of one axis: that of the symbol, with `plus` more, and at least `least` of it.

    steps: several for each of it, always as many.
    """

    symbol: str
    plus: int = 0
    steps: bool = False
    least: int = 1


@dataclass(frozen=True)
class Attribute:
    """One attribute. optional: whether it may be missing; along: the attribute without which it is.

    finite: whether it is a finite number. above: what it must exceed, unless it is NaN. one_of: the texts that it may
    be. size: what it repeats.
    """

    kind: str
    optional: bool = False
    along: str = ""
    finite: bool = False
    above: float | None = None
    one_of: tuple[str, ...] = ()
    size: Size | None = None

    @property
    def limited(self) -> bool:
        """Whether not every value of its kind is allowed."""
        return self.finite or self.above is not None or bool(self.one_of or self.size)


@dataclass(frozen=True)
class Array:
    """One dataset, with one size for each axis; none for a single value. optional, along: as of an attribute.

    unless: the member that may stand in its place.
    ordered: "" for any values; "times": finite, and none before another; "edges": from 0 to 1, each beyond the one
    before. finite: whether all are finite numbers. names: the symbol whose names its texts are. limits: the least and
    the largest value; NaN is neither.
    """

    kind: str
    sizes: tuple[Size, ...] = ()
    optional: bool = False
    along: str = ""
    unless: str = ""
    ordered: str = ""
    finite: bool = False
    names: str = ""
    limits: tuple[float, float] | None = None


@dataclass(frozen=True)
class Group:
    """A group: name -> what stands in it, and its attributes, by name. optional: whether it may be missing."""

    members: Mapping[str, Array | Group | Each] = field(default_factory=dict)
    attributes: Mapping[str, Attribute] = field(default_factory=dict)
    optional: bool = False


@dataclass(frozen=True)
class Each:
    """A group of things that are alike: its members have the names of a symbol, or the numbers 0, 1, 2 and so on.

    least: of them. or_none: whether there may be none of the names. own: whether sizes within one are not those within
    another. optional: whether the group may be missing.
    """

    member: Array | Group
    names: str = ""
    numbered: bool = False
    least: int = 0
    or_none: bool = False
    own: bool = False
    optional: bool = False
