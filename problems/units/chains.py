"""The units of a chain of links: what does not fit is told where the file gives it, not in the equations that are made.

Equations in which units clash have a mass, a length or a force in a unit of another system than the rest. The system
is taken in which the fewest of these are wrong: that of metres, kilograms and seconds first.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

from ..chains.bodies import control_of
from ..chains.motion import CART_NAME, GRAVITY, TOTAL, Chain, force_names
from ..schema.model import CHAIN
from ..schema.spec import Spec
from ..yaml.document import Path
from ..yaml.locations import Finding
from .infer import mended
from .measure import Measure, angle, measure_of, same
from .phase import PhaseUnits

MASS, LENGTH, INERTIA = (1, 0, 0), (0, 1, 0), (1, 2, 0)
FORCE, TORQUE, GRAVITATION = (1, 1, -2), (1, 2, -2), (0, 1, -2)
DEFAULTS = ("m", "rad", "N", "N*m")
"""Units that states and controls of a chain have where the file says nothing."""


class ChainValue(NamedTuple):
    """A value of a chain. power: of mass, length and time; None for an angle."""

    path: Path
    told: str
    unit: Measure
    power: tuple[int, int, int] | None


def in_chain(spec: Spec, units: PhaseUnits, findings: list[Finding]) -> list[Finding]:
    """The findings in a phase, with those in equations of a chain told of the values that make them.

    spec: of the phase.
    units: of its names.
    findings: of all its expressions.
    """
    if spec.model.kind != CHAIN or TOTAL not in units.symbols.roles:
        return findings
    chain = Chain(spec.model)
    made = _made(chain, spec)
    others = [finding for finding in findings if finding.path[:2] not in made]
    if len(others) == len(findings):
        return findings
    given = list(_given(chain, units))
    if any(units.symbols.varies(str(own.path[1])) and not _may_vary(own) for own in given):
        return others  # that is told, and its unit may follow from it
    return others + _wrong(given, units) or findings[:1]


def _made(chain: Chain, spec: Spec) -> set[Path]:
    """The paths of what a chain makes: constants, moments, tips and equations."""
    points = (f"{name}_{kind}{axis}" for name in _points(chain) for kind in ("", "v", "a") for axis in "xy")
    names = (*chain.constants(), *chain.named_moments, *points)
    equations = chain.equations()
    residuals = (i for i, residual in enumerate(spec.residuals) if residual.name in equations)
    return {("expressions", name) for name in names} | {("residuals", i) for i in residuals}


def _points(chain: Chain) -> list[str]:
    return [*(body.name for body in chain.bodies), "com"]


def _wrong(given: list[ChainValue], units: PhaseUnits) -> list[Finding]:
    """What is in a unit of another system than most of a chain."""
    time = units.time if isinstance(units.time, Measure) else measure_of("s")
    masses, lengths = _candidates("kg", MASS, given), _candidates("m", LENGTH, given)
    best: tuple[int, list[Finding]] | None = None
    for mass, length, second in product(masses, lengths, [time, measure_of("s")]):
        system = [own for own in (mass, length, second) if own is not None]
        clashes = [own for own in given if not same(own.unit, _wanted(own, system))]
        weight = sum(1 + (own.unit.text in DEFAULTS) for own in clashes)
        found = [_clash(own, _wanted(own, system)) for own in clashes]
        if time is not None and not same(time, system[2]):
            weight += 1
            found.append(_clash(ChainValue(("time", "unit"), "the time", time, None), system[2]))
        if best is None or weight < best[0]:
            best = weight, found
    return best[1] if best else []


def _may_vary(own: ChainValue) -> bool:
    return own.power in (FORCE, TORQUE) or own.path[0] != "expressions"


def _candidates(first: str, power: tuple[int, int, int], given: list[ChainValue]) -> list[Measure]:
    """The units that values of a kind are in."""
    found = [own for own in [measure_of(first)] if own is not None]
    for own in given:
        if own.power == power and not any(same(own.unit, other) for other in found):
            found.append(own.unit)
    return found


def _wanted(own: ChainValue, system: list[Measure]) -> Measure:
    """The unit of a value in a system of mass, length and time."""
    wanted = angle()
    if own.power is not None:
        mass, length, time = (unit.power(power) for unit, power in zip(system, own.power, strict=True))
        wanted = mass.times(length).times(time)
    known = map(measure_of, (*DEFAULTS, "kg", "m/s^2", "kg*m^2"))
    return next((unit for unit in known if unit is not None and same(unit, wanted)), wanted)


def _clash(own: ChainValue, wanted: Measure) -> Finding:
    what = f"{own.told} is {own.unit.told}, and the chain needs it {wanted.told}"
    return Finding(own.path, what, mended(own.unit, wanted))


def _given(chain: Chain, units: PhaseUnits) -> Iterator[ChainValue]:
    """All of a chain that has a unit."""
    for path, told, name, power in (*_of_links(chain), *_around(chain), *_coordinates(chain)):
        unit = units.of(name)
        if isinstance(unit, Measure):
            yield ChainValue(path, told, unit, power)


Row = tuple[Path, str, str, tuple[int, int, int] | None]


def _of_links(chain: Chain) -> Iterator[Row]:
    kinds = {"mass": MASS, "length": LENGTH, "com": LENGTH, "at": LENGTH, "inertia": INERTIA, "turn": None}
    for body, number in zip(chain.bodies, chain.numbers, strict=True):
        pushed = FORCE if body.slides else TORQUE
        for key, power in {**kinds, "torque": TORQUE, "force": FORCE}.items():
            if getattr(body.link, key) is not None:
                name = body.constant(key)
                yield ("expressions", name), f"the {key} of {body.name}", name, power
        if control := control_of(body.link.motor, number):
            yield ("controls", control, "unit"), f"the motor {control}", control, pushed


def _around(chain: Chain) -> Iterator[Row]:
    entry = chain.entry
    if entry.gravity.text != "0":
        yield ("expressions", GRAVITY), "the gravity", GRAVITY, GRAVITATION
    for key, power in {"mass": MASS, "force": FORCE}.items() if entry.cart else ():
        if getattr(entry.cart, key) is not None:
            yield ("expressions", f"{CART_NAME}_{key}"), f"the {key} of the cart", f"{CART_NAME}_{key}", power
    if entry.cart and (control := control_of(entry.cart.motor, 0)):
        yield ("controls", control, "unit"), f"the motor {control}", control, FORCE
    for number, force in enumerate(entry.forces):
        names = [name for name in force_names(force, number) if name != "0"]
        yield from ((("expressions", name), f"the force on {force.link}", name, FORCE) for name in names)
        if force.at is not None:
            yield ("expressions", f"force{number + 1}_at"), "where a force acts", f"force{number + 1}_at", LENGTH


def _coordinates(chain: Chain) -> Iterator[Row]:
    angles = {body.q for body in chain.bodies if body.q and not body.slides}
    for q in chain.coordinates:
        yield ("states", q, "unit"), f"the state {q}", q, None if q in angles else LENGTH
