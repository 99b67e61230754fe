r"""A chain as a tree of rigid links: which angle each points at, and how far its points are along the links before it.

    c_ka   the distance along link a on the way from the base to the centre of mass of link k (0 if a is not on it)
    e(phi) = (cos phi, sin phi), phi_a the direction of link a, counter-clockwise from the x axis

    G_k = base + sum_a c_ka e(phi_a)                    its centre of mass
    phi_k = sum of the angles q_i for i in S_k + a constant

S_k has one angle where angles are absolute, all on the way from the base where they are relative; a link that is fixed
has those of the link before it, and so has one that slides: its coordinate q_a is part of each distance c_ka along it.
What depends on lengths and masses is written by name: `upper_length`, `upper_mass`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import field

from ..lean.records import dataclass
from ..schema.model import BASE, PRISMATIC, RELATIVE, REVOLUTE, WELDED, ChainLink, ModelEntry
from .angles import Angle, grouped

TURNS = {"right": 0, "up": 1, "left": 2, "down": 3}
"""Right angles from the x axis, counter-clockwise."""

Reach = dict[int, str]
"""Number of a link -> a distance along it: the point base + sum_a c_a e(phi_a)."""


@dataclass(frozen=True)
class Body:
    """A link with its place in the tree.

    number: from 0. before: the number of the link that it hangs on, None for the base. q: its angle, or how far it has
    slid out, "" if it is fixed. turning: the angles of S_k. phi: its direction. joint: where its joint is.
    """

    number: int
    name: str
    link: ChainLink
    before: int | None
    q: str
    turning: tuple[str, ...]
    phi: Angle
    joint: Reach = field(repr=False)

    def along(self, distance: str) -> Reach:
        """The point of the link at a distance from its end at the joint."""
        if not self.slides:
            return dict(self.joint) if distance == "0" else {**self.joint, self.number: distance}
        return {**self.joint, self.number: grouped([distance if distance != "0" else "", self.q])}

    @property
    def slides(self) -> bool:
        return self.link.joint == PRISMATIC

    @property
    def tip(self) -> Reach:
        return self.along(self.constant("length"))

    @property
    def centre(self) -> Reach:
        return self.along(self.constant("com"))

    @property
    def rates(self) -> list[str]:
        """The rates whose sum is its angular velocity."""
        return [f"d{q}" for q in self.turning]

    def constant(self, key: str) -> str:
        """The name of one of its numbers: "upper_mass"."""
        return f"{self.name}_{key}"


def name_of_body(link: ChainLink, number: int) -> str:
    return link.name or f"link{number + 1}"


def names_of_bodies(links: Sequence[ChainLink]) -> list[str]:
    """The name of each link."""
    return [name_of_body(link, number) for number, link in enumerate(links)]


def coordinate_names(links: Sequence[ChainLink]) -> Iterator[str]:
    """The name of each link's angle or distance, "" for those that are fixed; they are counted without these."""
    moving = 0
    for link in links:
        moving += link.joint != WELDED
        yield (link.angle or link.distance or f"q{moving}") if link.joint != WELDED else ""


def control_of(motor: bool | str | None, number: int) -> str:
    """The control of a motor, "" if there is none; number: of its angle, 0 for a cart."""
    return f"u{number}" if motor is True else motor or ""


def bodies(entry: ModelEntry) -> list[Body]:
    """The links of a chain without mistakes, each after the one that it hangs on."""
    names, found = names_of_bodies(entry.links), list[Body]()
    for number, (link, q) in enumerate(zip(entry.links, coordinate_names(entry.links), strict=True)):
        on = link.parent or (names[number - 1] if number else BASE)
        before = None if on == BASE else names.index(on)
        carrier = None if before is None else found[before]
        zero = TURNS[link.zero or entry.zero]
        angle = q if link.joint == REVOLUTE else ""
        if carrier and (not angle or entry.angles == RELATIVE):
            turning, start = (*carrier.turning, *filter(None, [angle])), carrier.phi
        else:
            turning, start = (angle,) if angle else (), Angle({}, zero)
        turned = angle or (f"{names[number]}_turn" if link.turn else "")
        phi = Angle({**start.parts, **({turned: 1} if turned else {})}, start.turns)
        joint = _joint_on(carrier, link, names[number]) if carrier else {}
        found.append(Body(number, names[number], link, before, q, turning, phi, joint))
    return found


def _joint_on(carrier: Body, link: ChainLink, name: str) -> Reach:
    """Where a link hangs on another: at its joint, where it says so, or at its tip."""
    if link.at is None:
        return carrier.tip
    return carrier.along("0" if link.at.text == "0" else f"{name}_at")
