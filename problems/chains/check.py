"""Mistakes of a chain that its schema cannot see: links that hang on nothing, motors where nothing turns, masses below zero."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

from ..names.symbols import Symbols
from ..schema.model import BASE, CART, CHAIN, FLOATING, RELATIVE, REVOLUTE, ChainLink, ModelEntry
from ..schema.spec import Spec
from ..text import brief, did_you_mean
from ..yaml.document import Path
from ..yaml.locations import Finding
from .bodies import angle_names, names_of
from .motion import CART_NAME, TOTAL, Chain

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_TAKEN = (BASE, CART_NAME, "com", CHAIN)
"""Names that no link may have: those of outputs and constants begin with them."""

_DYNAMICS = ("rate", "next", "accel")


def mistakes(entry: ModelEntry, data: Mapping[str, Any]) -> list[Finding]:
    """Every mistake of a chain that the schema has passed.

    entry: the section `model:` of the file.
    data: of the file.
    """
    names = names_of(entry.links)
    found = [*_base(entry), *_names(entry, names), *_angles(entry, data)]
    for number, link in enumerate(entry.links):
        path: Path = ("model", "links", number)
        found += [*_hangs(entry, names, number, path), *_joint(entry, link, path), *_rod(link, path)]
    for number, force in enumerate(entry.forces):
        if force.on not in names:
            remedy = did_you_mean(force.on, names, f"the links are {', '.join(names)}")
            found.append(Finding(("model", "forces", number, "on"), f"there is no link {brief(force.on)}", remedy))
    return found


def _base(entry: ModelEntry) -> Iterator[Finding]:
    if entry.cart and entry.base != CART:
        yield Finding(("model", "cart"), f"the base is {entry.base}, so there is no cart", "write base: cart, or remove cart:")
    if entry.base == CART and not entry.cart:
        yield Finding(("model", "base"), "the mass of the cart is missing", "add cart: {mass: 1, motor: u}")


def _names(entry: ModelEntry, names: list[str]) -> Iterator[Finding]:
    for number, name in enumerate(names):
        path: Path = ("model", "links", number, "name")
        if not _NAME.fullmatch(name):
            yield Finding(path, f'"{brief(name)}" cannot be the name of a link', "use a letter, then letters, digits and _")
        elif name in _TAKEN:
            yield Finding(path, f"the name {name} has a meaning of its own in a chain", f"choose another, such as {name}1")
        elif name in names[:number]:
            yield Finding(path, f"two links are called {name}", "give each a name of its own")


def _angles(entry: ModelEntry, data: Mapping[str, Any]) -> Iterator[Finding]:
    """One name for each angle, and no dynamics for it but those of the chain."""
    angles = list(angle_names(entry.links))
    moving = [q for q in angles if q]
    if not moving and entry.base != FLOATING:
        yield Finding(("model", "links"), "no link of this chain can turn", "remove joint: fixed from one of them")
    for q, count in Counter(moving).items():
        if count > 1:
            number = len(angles) - 1 - angles[::-1].index(q)
            yield Finding(("model", "links", number, "angle"), f"two angles are called {q}", "give each a name of its own")
    states = data.get("states")
    chain = {*moving, *("x", "y")[: {CART: 1, FLOATING: 2}.get(entry.base, 0)]}
    chain |= {f"d{q}" for q in chain}
    for name, own in states.items() if isinstance(states, dict) else ():
        given = own if isinstance(own, dict) else {}
        if name in chain:
            for key in (key for key in _DYNAMICS if given.get(key) is not None):
                yield Finding(("states", name, key), f"the dynamics of {name} are those of the chain", f"remove {key}:")
        elif not any(given.get(key) is not None for key in (*_DYNAMICS, "velocity")) and not data.get("residuals"):
            others = f"its states are {', '.join(sorted(chain))}; a state of the file's own needs rate:"
            yield Finding(("states", name), f"the chain has no {brief(name)} among its states", did_you_mean(name, chain, others))


def _hangs(entry: ModelEntry, names: list[str], number: int, path: Path) -> Iterator[Finding]:
    """Each link hangs on the base, or on a link before it."""
    on, before = entry.links[number].on, names[:number]
    if on in ("", BASE, *before):
        if entry.links[number].at is not None and (on == BASE or number == 0):
            yield Finding((*path, "at"), "all that hangs on the base hangs at one point", "remove at:")
        return
    if on in names:
        what = f"{names[number]} hangs on {on}, which comes after it" if on != names[number] else f"{on} hangs on itself"
        yield Finding((*path, "on"), what, "write the links from the base outwards, each after the one that it hangs on")
        return
    known = [BASE, *before]
    yield Finding((*path, "on"), f"there is no link {brief(on)}", did_you_mean(on, known, f"it may hang on {' or '.join(known)}"))


def _joint(entry: ModelEntry, link: ChainLink, path: Path) -> Iterator[Finding]:
    """What a joint has: motor, torque and angle where it turns, turn where it is fixed."""
    on_base = link.on == BASE or (not link.on and path[-1] == 0)
    if link.joint != REVOLUTE:
        for key in ("motor", "torque", "angle", "zero"):
            if getattr(link, key) not in (None, False, ""):
                yield Finding((*path, key), f"a fixed joint does not turn, so it has no {key}", f"remove {key}:, or joint: fixed")
        return
    if link.turn is not None:
        yield Finding((*path, "turn"), "turn is of fixed joints, and this one turns", "remove it, or write joint: fixed")
    if link.zero and entry.angles == RELATIVE and not on_base:
        what = "a relative angle is zero where the link goes on straight from the one before it"
        yield Finding((*path, "zero"), what, "remove zero:, or write angles: absolute")
    for key in ("motor", "torque") if entry.base == FLOATING and on_base else ():
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
    constants = [name for name in spec.expressions if name in _constants(chain)]
    for name in constants:
        path: Path = ("expressions", name)
        value, key = symbols.fixed.get(name), name.rpartition("_")[2]
        if symbols.varies(name):
            what = f"the {key} of a chain is one number, and this varies in time"
            yield Finding(path, what, "make it of numbers and parameters")
        elif value is not None and (value < 0 if key != "length" else value <= 0):
            what = f"the {key} is {value:g}"
            yield Finding(path, what, f"write a {key} {'above zero' if key == 'length' else 'that is not negative'}")
    for body in chain.bodies:
        turned = [own for own in chain.bodies if body.q and body.q in own.turning]
        if turned and all(symbols.fixed.get(chain.M(own, own), 1.0) == 0 for own in turned):
            what = f"nothing that turns with {body.q} has a mass at a distance or an inertia, so nothing holds it back"
            yield Finding(("model", "links", body.number), what, "give a mass and a length, or an inertia, above zero")


def _constants(chain: Chain) -> set[str]:
    """The names of masses, lengths and inertias."""
    own = {body.constant(key) for body in chain.bodies for key in ("mass", "length", "inertia")}
    return own | ({f"{CART_NAME}_mass"} if chain.entry.cart else set())
