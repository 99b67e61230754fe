"""Mistakes of a chain that its schema cannot see: links on nothing, motors where nothing turns, masses below zero."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

from ..names.symbols import Symbols
from ..schema.model import (
    BASE,
    CART,
    CHAIN,
    FIXED,
    FLOATING,
    PRISMATIC,
    RELATIVE,
    REVOLUTE,
    WELDED,
    ChainLink,
    ModelEntry,
)
from ..schema.spec import Spec
from ..text import brief, did_you_mean
from ..yaml.document import Path
from ..yaml.locations import Finding
from .bodies import coordinate_names, names_of_bodies
from .closed import AXES
from .motion import CART_NAME, GRAVITY, TOTAL, Chain
from .sliding import mass
from .step import Stride

_TAKEN = (BASE, CART_NAME, "com", CHAIN)
"""Names that no link may have: those of outputs and constants begin with them."""

_POSITIVE = ("mass", "length", "inertia")
_CONSTANT = (*_POSITIVE, "com", "at", "turn")
"""Keys of a link whose values do not vary in time."""

_DYNAMICS = ("rate", "next", "accel")

_OF_JOINTS = {
    "motor": (REVOLUTE, PRISMATIC),
    "torque": (REVOLUTE,),
    "angle": (REVOLUTE,),
    "zero": (REVOLUTE, PRISMATIC),
    "force": (PRISMATIC,),
    "distance": (PRISMATIC,),
    "turn": (WELDED, PRISMATIC),
}
"""Key of a link -> the joints that have it."""


def chain_mistakes(entry: ModelEntry, data: Mapping[str, Any]) -> list[Finding]:
    """Every mistake of a chain that the schema has passed.

    entry: the section `model:` of the file.
    data: of the file.
    """
    names = names_of_bodies(entry.links)
    found = [*_base(entry), *_names(entry, names), *_angles(entry, data)]
    for number, link in enumerate(entry.links):
        path: Path = ("model", "links", number)
        found += [*_hangs(entry, names, number, path), *_joint(entry, link, path), *_rod(link, path)]
    for number, force in enumerate(entry.forces):
        if force.link not in names:
            remedy = did_you_mean(force.link, names, f"the links are {', '.join(names)}")
            found.append(Finding(("model", "forces", number, "link"), f"there is no link {brief(force.link)}", remedy))
    found += [finding for number in range(len(entry.loops)) for finding in _loop(entry, names, number)]
    return [*found, *_loops(entry, data), *_step(entry, names)]


def _loop(entry: ModelEntry, names: list[str], number: int) -> Iterator[Finding]:
    """One closed loop: its links, and what says where on them."""
    loop, path = entry.loops[number], ("model", "loops", number)
    for key in ("link", "to"):
        own, known = getattr(loop, key), names if key == "link" else [BASE, *names]
        if own not in known:
            remedy = did_you_mean(own, known, f"the links are {', '.join(names)}")
            yield Finding((*path, key), f"there is no link {brief(own)}", remedy)
    if loop.link == loop.to:
        yield Finding((*path, "to"), f"{loop.to} is pinned to itself", "name the link that it is pinned to, or base")
    for key in ("x", "y") if loop.to != BASE else ("to_at",):
        if getattr(loop, key) is not None:
            other = "a point of the base" if key in AXES else "a point of a link"
            remedy = f"remove {key}:, or write to: {BASE if key in AXES else 'with the name of a link'}"
            yield Finding((*path, key), f"this is {other}, and the loop goes to {brief(loop.to)}", remedy)


def _loops(entry: ModelEntry, data: Mapping[str, Any]) -> Iterator[Finding]:
    """What all closed loops together leave of a chain, and where they have no place."""
    if not entry.loops:
        return
    path: Path = ("model", "loops")
    free = sum(map(bool, coordinate_names(entry.links))) + {CART: 1, FLOATING: 2}.get(entry.base, 0)
    if free <= 2 * len(entry.loops):
        what = f"each loop holds two of the {free} ways in which the chain can move, so that nothing is left"
        yield Finding(path, what, "leave out a loop, or add a link that turns")
    for key in (key for key in ("phases", "waypoints") if data.get(key)):
        what = f"a loop is closed at the initial time of one phase, and there are {key}"
        yield Finding(path, what, f"remove {key}:")
    if entry.step:
        yield Finding(path, "a walker with step: has no closed loops", "leave out step:, or the loops")


def _base(entry: ModelEntry) -> Iterator[Finding]:
    if entry.cart and entry.base != CART:
        yield Finding(
            ("model", "cart"), f"the base is {entry.base}, so there is no cart", "write base: cart, or remove cart:"
        )
    if entry.base == CART and not entry.cart:
        yield Finding(("model", "base"), "the mass of the cart is missing", "add cart: {mass: 1, motor: u}")


def _names(entry: ModelEntry, names: list[str]) -> Iterator[Finding]:
    for number, name in enumerate(names):
        path: Path = ("model", "links", number, "name")
        if name in _TAKEN:
            yield Finding(
                path, f"the name {name} has a meaning of its own in a chain", f"choose another, such as {name}1"
            )
        elif name in names[:number]:
            yield Finding(path, f"two links are called {name}", "give each a name of its own")


def _angles(entry: ModelEntry, data: Mapping[str, Any]) -> Iterator[Finding]:
    """One name for each angle, and no dynamics for it but those of the chain."""
    angles = list(coordinate_names(entry.links))
    moving = [q for q in angles if q]
    if not moving and entry.base != FLOATING:
        yield Finding(("model", "links"), "no link of this chain can move", "remove joint: fixed from one of them")
    base = ("x", "y")[: {CART: 1, FLOATING: 2}.get(entry.base, 0)]
    rates = {f"d{q}" for q in (*moving, *base)}
    chain = {*moving, *base, *rates}
    for q, count in Counter(moving).items():
        what = f"two coordinates are called {q}" if count > 1 else f"{q} is another state of the chain"
        if count > 1 or q in base or q in rates:
            number = len(angles) - 1 - angles[::-1].index(q)
            key = "distance" if entry.links[number].joint == PRISMATIC else "angle"
            yield Finding(("model", "links", number, key), what, "give each a name of its own")
    states = data.get("states")
    for name, own in states.items() if isinstance(states, dict) else ():
        given = own if isinstance(own, dict) else {}
        if name in chain:
            for key in (key for key in _DYNAMICS if given.get(key) is not None):
                yield Finding(("states", name, key), f"the dynamics of {name} are those of the chain", f"remove {key}:")
        elif not any(given.get(key) is not None for key in (*_DYNAMICS, "velocity")) and not data.get("residuals"):
            others = f"its states are {', '.join(sorted(chain))}; a state of the file's own needs rate:"
            yield Finding(
                ("states", name), f"the chain has no {brief(name)} among its states", did_you_mean(name, chain, others)
            )


def _hangs(entry: ModelEntry, names: list[str], number: int, path: Path) -> Iterator[Finding]:
    """Each link hangs on the base, or on a link before it."""
    on, before = entry.links[number].parent, names[:number]
    if on in ("", BASE, *before):
        if entry.links[number].at is not None and (on == BASE or number == 0):
            yield Finding((*path, "at"), "all that hangs on the base hangs at one point", "remove at:")
        return
    if on in names:
        what = (
            f"{names[number]} hangs on {on}, which comes after it" if on != names[number] else f"{on} hangs on itself"
        )
        yield Finding(
            (*path, "parent"), what, "write the links from the base outwards, each after the one that it hangs on"
        )
        return
    known = [BASE, *before]
    yield Finding(
        (*path, "parent"),
        f"there is no link {brief(on)}",
        did_you_mean(on, known, f"it may hang on {' or '.join(known)}"),
    )


def _joint(entry: ModelEntry, link: ChainLink, path: Path) -> Iterator[Finding]:
    """What a joint has, as `_OF_JOINTS` says, and what it has on the base."""
    on_base = link.parent == BASE or (not link.parent and path[-1] == 0)
    for key, joints in _OF_JOINTS.items():
        if link.joint not in joints and getattr(link, key) not in (None, False, ""):
            remedy = f"remove {key}:, or write joint: {' or joint: '.join(joints)}"
            yield Finding((*path, key), f"the joint is {link.joint}, which has no {key}", remedy)
    if link.joint == PRISMATIC and on_base and entry.base == FLOATING:
        what = "the base is floating, so this link would move along itself by two states"
        yield Finding((*path, "joint"), what, "hang it on a link that turns, or write base: fixed")
    if link.joint == PRISMATIC and link.zero and not on_base:
        what = "a link that slides points as the one before it, or a turn from there"
        yield Finding((*path, "zero"), what, "write turn:, the angle between both")
    if link.joint == REVOLUTE and link.zero and entry.angles == RELATIVE and not on_base:
        what = "a relative angle is zero where the link goes on straight from the one before it"
        yield Finding((*path, "zero"), what, "remove zero:, or write angles: absolute")
    for key in ("motor", "torque") if entry.base == FLOATING and on_base and link.joint == REVOLUTE else ():
        if getattr(link, key) not in (None, False):
            what = f"the base is floating, so there is nothing that this {key} could push against"
            yield Finding((*path, key), what, f"remove {key}:, or write base: fixed")


def _rod(link: ChainLink, path: Path) -> Iterator[Finding]:
    for given, lacking, example in (("com", "inertia", "0 for a point mass"), ("inertia", "com", "half its length")):
        if getattr(link, given) is not None and getattr(link, lacking) is None:
            what = f"{given} is given without {lacking}; only a uniform rod has both by itself"
            yield Finding((*path, given), what, f"add {lacking}:, such as {example}, or remove {given}:")


def value_mistakes(spec: Spec, symbols: Symbols) -> Iterator[Finding]:
    """Numbers of a chain that no body has; spec: of a phase."""
    if spec.model.kind != CHAIN or TOTAL not in symbols.roles:
        return
    chain = Chain(spec.model)
    for name, key in _given(chain):
        path: Path = ("expressions", name)
        value = symbols.fixed.get(name)
        if symbols.varies(name):
            what = f"the {key} of a chain is one number, and this varies in time"
            yield Finding(path, what, "make it of numbers and parameters")
        elif key in _POSITIVE and value is not None and (value < 0 if key != "length" else value <= 0):
            remedy = "write a length above zero" if key == "length" else "write a value that is not negative"
            yield Finding(path, f"the {key} is {value:g}", remedy)
    for body in chain.bodies:
        turned = [own for own in chain.bodies if body.q and body.q in own.turning]
        if turned and all(symbols.fixed.get(chain.mass(own, own), 1.0) == 0 for own in turned):
            what = f"nothing that turns with {body.q} has a mass at a distance or an inertia, so nothing holds it back"
            yield Finding(("model", "links", body.number), what, "give a mass and a length, or an inertia, above zero")
        if body.slides and symbols.fixed.get(mass(body), 1.0) == 0:
            what = f"nothing that slides with {body.q} has a mass, so nothing holds it back"
            yield Finding(("model", "links", body.number), what, "give a mass above zero")
    yield from _goes_on(chain, symbols)


def _given(chain: Chain) -> Iterator[tuple[str, str]]:
    """(name, key) of what the file gives that is one number: masses, lengths, gravity."""
    if chain.entry.gravity.text != "0":
        yield GRAVITY, "gravity"
    if chain.entry.cart:
        yield f"{CART_NAME}_mass", "mass"
    for body in chain.bodies:
        yield from ((body.constant(key), key) for key in _CONSTANT if getattr(body.link, key) is not None)


def _step(entry: ModelEntry, names: list[str]) -> Iterator[Finding]:
    """A step is for a walker that stands on one point, and swaps links that it has."""
    if entry.step is None:
        return
    path: Path = ("model", "step")
    for wrong, what, remedy in (
        (entry.base != FIXED, f"the base is {entry.base}", "write base: fixed: the foot that stands is the base"),
        (entry.angles == RELATIVE, "angles are relative", "write angles: absolute, which the legs can swap"),
        (
            any(link.joint != REVOLUTE for link in entry.links),
            "one of its joints does not turn",
            "make one link of both",
        ),
    ):
        if wrong:
            yield Finding(path, f"a step is for walkers that swap their legs, and {what}", remedy)
    swapped = [name for pair in entry.step.swap for name in pair]
    given = [((*path, "foot"), entry.step.foot)]
    given += [((*path, "swap", i, j), name) for i, pair in enumerate(entry.step.swap) for j, name in enumerate(pair)]
    for place, name in given:
        if name not in names:
            yield Finding(
                place, f"there is no link {brief(name)}", did_you_mean(name, names, f"the links are {', '.join(names)}")
            )
    for name in (name for name, count in Counter(swapped).items() if count > 1):
        yield Finding((*path, "swap"), f"{brief(name)} is swapped more than once", "name each link once")


def _goes_on(chain: Chain, symbols: Symbols) -> Iterator[Finding]:
    """After a step each link is where one was before it."""
    if chain.entry.step is None or not all(name in symbols.fixed for name in _measures(chain)):
        return
    if found := Stride(chain, chain.entry.step).misplaced(symbols.fixed):
        new, old = found
        what = f"after a step {new} is not what and where {old} was before it" if new != old else f"a step moves {new}"
        remedy = "give both legs the same numbers; com: is from the joint that is nearer to the standing foot"
        yield Finding(("model", "step"), what, remedy)


def _measures(chain: Chain) -> Iterator[str]:
    """The names of all that places and masses of links are made of."""
    for body in chain.bodies:
        yield from (*body.tip.values(), *body.centre.values(), body.constant("mass"), body.constant("inertia"))
