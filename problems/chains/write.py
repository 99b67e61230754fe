"""A chain written out in the data of a file: states, controls, residuals, named expressions and a drawing.

What is made of a value of the chain tells its mistakes there: `upper_mass` is `model.links.0.mass`.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import partial
from itertools import accumulate
from typing import Any

from pydantic import ValidationError

from ..expressions.signature import name_trouble
from ..names.symbols import UNKNOWN
from ..schema.fields import CALLED
from ..schema.model import BASE, CART, FLOATING, WELDED, ModelEntry, is_chain
from ..schema.tables import called_names
from ..yaml.document import Path
from ..yaml.locations import Finding
from .bodies import control_of
from .check import chain_mistakes
from .closed import AXES, Closed, forces_of, name_of_loop, with_loops
from .motion import ACROSS, ALL, CART_NAME, GRAVITY, UP, Chain, force_names
from .picture import drawing
from .robots import robot_of, write_chain
from .sections import list_in, mapping_in
from .step import Stride

_WORD = re.compile(r"\w+")
_GIVEN = {
    "mass": "mass of {}",
    "length": "length of {}",
    "com": "centre of mass of {}, from its joint",
    "inertia": "inertia of {} about its centre of mass",
    "at": "where {} hangs",
    "turn": "turn of {} where it is fixed",
    "torque": "torque on {} beside its motor's",
    "force": "force that pushes {} out, beside its motor's",
}
"""Keys of a link that become named expressions -> their notes."""


def write_out_chain(data: dict[str, Any]) -> tuple[dict[Path, Path], list[Finding]]:
    """Write the chain of a file out, if it has one.

    data: of the file, overrides applied; it is changed.

    Returns the path of each value that was made -> what it was made of in the file, and the mistakes that the schema
    cannot see. Where there are any, and where the schema refuses the chain, names alone are written out.
    """
    of_robot, found = write_chain(data, robot) if (robot := robot_of(data)) else ({}, [])
    if not is_chain(data.get("model")):
        return {}, []
    model: dict[str, Any] = data["model"]
    try:
        entry = ModelEntry.model_validate(model, context={CALLED: called_names(data)})
    except ValidationError:
        declare(data, model)
        return {}, []
    if found := [*found, *chain_mistakes(entry, data)]:
        declare(data, model)
        return of_robot, found
    short, found = _Writer(data, Chain(with_loops(entry))).write()
    return of_robot | short, found


def declare(data: dict[str, Any], model: Mapping[str, Any]) -> None:
    """Declare what a mistaken chain would, with unknown values, about which no check says anything; model: as given."""
    links = model.get("links")
    links = [own if isinstance(own, dict) else {} for own in (links if isinstance(links, list) else [])]
    numbers = list(accumulate(int(own.get("joint") != WELDED) for own in links))  # links that are fixed are not counted
    moving = [(i, own) for i, own in zip(numbers, links, strict=True) if own.get("joint") != WELDED]
    named = [str(own.get("angle") or own.get("distance") or f"q{i}") for i, own in moving]
    places = [q for q in named if not name_trouble(q)]
    coordinates = [*{CART: [ACROSS], FLOATING: [ACROSS, UP]}.get(str(model.get("base")), []), *places]
    states = mapping_in(data, "states")
    for name in (*coordinates, *(f"d{q}" for q in coordinates), *states):
        own = states.get(name) or {}
        if isinstance(own, dict) and not own.keys() & {"rate", "next", "accel", "velocity"}:
            states[name] = {**own, "rate": UNKNOWN}
    carts = [model["cart"]] if isinstance(model.get("cart"), dict) else []
    for number, own in [*((0, own) for own in carts), *moving]:
        motor = own.get("motor")
        name = control_of(motor, number) if isinstance(motor, str | bool) else ""
        if name not in states and not name_trouble(name):
            mapping_in(data, "controls").setdefault(name, {})
    names = "|".join(["com", *(re.escape(str(own.get("name") or f"link{i}")) for i, own in enumerate(links, start=1))])
    made = rf"({names})_([va]?[xy]|{'|'.join(_GIVEN)})"
    for word in filter(re.compile(made).fullmatch, words_of(data)):
        mapping_in(data, "expressions").setdefault(word, UNKNOWN)


def words_of(data: Mapping[str, Any]) -> set[str]:
    """All words in the expressions of a file."""
    return {*_WORD.findall(repr({key: own for key, own in data.items() if key not in ("name", "source", "note")}))}


class _Writer:
    """Puts a chain into the data of a file; `short` and `found` are what `write_out` returns."""

    def __init__(self, data: dict[str, Any], chain: Chain):
        self.data, self.chain = data, chain
        self.short: dict[Path, Path] = {}
        self.found: list[Finding] = []
        self.words = words_of(data)

    def write(self) -> tuple[dict[Path, Path], list[Finding]]:
        self.coordinates()
        self.controls()
        self.numbers()
        self.around()
        self.formulas()
        self.points()
        self.residuals()
        for number, loop in enumerate(self.chain.entry.loops, start=1):
            self.loop(Closed(self.chain, loop, number))
        if self.chain.entry.step:
            self.step(Stride(self.chain, self.chain.entry.step))
        if not self.data.get("drawing"):
            self.data["drawing"] = list(drawing(self.chain))
            self.short["drawing",] = ("model",)
        return self.short, self.found

    def section(self, name: str) -> dict[str, Any]:
        """A section of the file; where it is made here, it stands for the chain."""
        if self.data.get(name) is None:
            self.short[name,] = ("model",)
        return mapping_in(self.data, name)

    def define(self, name: str, value: Any, origin: Path, note: str = "of the chain") -> None:
        """A named expression; in a full file it is there already."""
        expressions = self.section("expressions")
        given = expressions.get(name, value)
        given = given.get("value") if isinstance(given, dict) else given
        if str(getattr(given, "text", given)) != str(getattr(value, "text", value)):
            self.found.append(Finding(("expressions", name), f"{name} is a name of the chain", "choose another name"))
            return
        expressions.setdefault(name, {"value": value, "note": note})
        self.short["expressions", name] = origin

    def coordinates(self) -> None:
        """The states, with what the file says of them at the top level and in phases."""
        links = {body.q: body for body in self.chain.bodies if body.q}
        phases = self.data.get("phases")
        for q in self.chain.coordinates:
            path: Path = ("model",)
            meant = {"unit": "m", "note": f"place of the {CART_NAME if self.chain.entry.cart else BASE} along {q}"}
            if body := links.get(q):
                path = ("model", "links", body.number)
                meant = {"unit": "rad", "note": f"angle of {body.name}, counter-clockwise"}
                if body.slides:
                    meant = {"unit": "m", "note": f"how far {body.name} has slid out"}
            self.state(self.section("states"), ("states",), q, path, meant)
            for name, phase in phases.items() if isinstance(phases, dict) else ():
                own = phase.get("states") if isinstance(phase, dict) else None
                if isinstance(own, dict) and own.keys() & {q, f"d{q}"}:
                    self.state(own, ("phases", name, "states"), q, path, {})

    def state(self, states: dict[str, Any], path: Path, q: str, origin: Path, meant: Mapping[str, str]) -> None:
        """A coordinate with its velocity dq, for which the file may have an entry of its own."""
        speed, own = f"d{q}", states.get(q) or {}
        if not isinstance(own, dict):
            return
        velocity = own.get("velocity") or {"name": speed}
        if speed in states:
            given = states.pop(speed) or {}
            velocity = {"name": speed, **given} if isinstance(given, dict) else given
            self.short[*path, q, "velocity"] = (*path, speed)
        if q not in states:
            self.short[*path, q] = origin
        states[q] = {**meant, **own, "velocity": velocity}

    def controls(self) -> None:
        """A control for each motor whose name is of nothing else."""
        others = [self.data.get(group) for group in ("states", "algebraic", "expressions", "parameters")]
        for name, unit, note in self.motors():
            if not any(isinstance(own, dict) and name in own for own in others):
                controls = self.section("controls")
                given = controls.get(name) or {}
                controls[name] = {"unit": unit, "note": note, **given} if isinstance(given, dict) else given

    def motors(self) -> Iterator[tuple[str, str, str]]:
        """Name, unit and note of the control of each motor."""
        cart = self.chain.entry.cart
        if cart and (name := control_of(cart.motor, 0)):
            yield name, "N", f"force on the {CART_NAME}"
        for body, number in zip(self.chain.bodies, self.chain.numbers, strict=True):
            if name := control_of(body.link.motor, number):
                yield name, *(("N", f"force on {body.name}") if body.slides else ("N*m", f"torque on {body.name}"))

    def numbers(self) -> None:
        """What the file gives of each link, and what a uniform rod has."""
        for i, body in enumerate(self.chain.bodies):
            path: Path = ("model", "links", i)
            for key, told in _GIVEN.items():
                note = told.format(body.name)
                if (own := getattr(body.link, key)) is not None:
                    self.define(body.constant(key), own, (*path, key), note)
                elif key in ("com", "inertia"):
                    mass, length = body.constant("mass"), body.constant("length")
                    rod = {"com": f"{length}/2", "inertia": f"{mass}*{length}**2/12"}
                    self.define(body.constant(key), rod[key], path, note)

    def around(self) -> None:
        """What the file gives of gravity, of the cart and of forces."""
        entry = self.chain.entry
        if entry.gravity.text != "0":
            self.define(GRAVITY, entry.gravity, ("model", "gravity"), "acceleration of gravity")
        for key in ("mass", "force") if entry.cart else ():
            if (own := getattr(entry.cart, key)) is not None:
                self.define(f"{CART_NAME}_{key}", own, ("model", "cart", key), f"{key} of the cart")
        given = len(entry.forces) - sum(map(len, map(forces_of, entry.loops)))
        for number, force in enumerate(entry.forces):
            path: Path = ("model", "forces", number) if number < given else ("model", "loops")
            for axis, name in zip((ACROSS, UP), force_names(force, number), strict=True):
                if name != "0":
                    own = (*path, axis) if number < given else path
                    self.define(name, getattr(force, axis), own, f"force on {force.link}")
            if force.at is not None:
                own = (*path, "at") if number < given else path
                self.define(f"force{number + 1}_at", force.at, own, "where it acts")

    def formulas(self) -> None:
        """Constants of the mass matrix, and the moments that several equations share."""
        for name, value in {**self.chain.constants(), **self.chain.named_moments}.items():
            self.define(name, value, ("model",))

    def points(self) -> None:
        """x and y of all tips; their rates, and the same of the centre of mass, where the file names them."""
        chain = self.chain
        places = [(body.name, (body.tip, ALL), f"the tip of {body.name}") for body in chain.bodies]
        for name, (point, share), what in [*places, ("com", chain.centre, "the centre of mass")]:
            asked = {
                "": ("", partial(chain.position, point)),
                "v": ("velocity of ", partial(chain.velocity, point, share=share)),
                "a": ("acceleration of ", partial(chain.acceleration, point, share=share)),
            }
            for axis in (ACROSS, UP):
                for kind, (told, coordinate) in asked.items():
                    if (output := f"{name}_{kind}{axis}") in self.words or not (kind or name == "com"):
                        self.define(output, coordinate(axis), ("model",), f"{axis} of {told}{what}")

    def residuals(self) -> None:
        given = list_in(self.data, "residuals")
        known = {own.get("name") for own in given if isinstance(own, dict)}
        own = [{"name": name, "expression": text} for name, text in self.chain.equations().items() if name not in known]
        self.short |= {("residuals", len(given) + i): ("model",) for i in range(len(own))}
        given += own

    def loop(self, loop: Closed) -> None:
        """The force that holds a loop together, what determines it, and that the loop is closed in the beginning."""
        path: Path = ("model", "loops", loop.number - 1)
        for key in ("at", "to_at", *AXES):
            if (own := getattr(loop.entry, key)) is not None:
                self.define(loop.constant(key), own, (*path, key), "where a loop is closed")
        algebraic, residuals = self.section("algebraic"), list_in(self.data, "residuals")
        boundary = list_in(self.section("constraints"), "boundary")
        known = {own.get("name") for own in (*residuals, *boundary) if isinstance(own, dict)}  # of a full file
        for axis in AXES:
            force, note = loop.force(axis), f"force on {loop.entry.link} that closes a loop"
            algebraic[force] = {"unit": "N", "note": note, **(algebraic.get(force) or {})}
            self.short.setdefault(("algebraic", force), path)
            if (name := f"{name_of_loop(loop.number)} {axis}") not in known:
                self.short["residuals", len(residuals)] = path
                residuals.append({"name": name, "expression": loop.residual(axis)})
            for gap, text in ((f"gap_{axis}", loop.gap(axis)), (f"gap_v{axis}", loop.closing(axis))):
                own = loop.constant(gap)
                self.define(own, text, path, "of a closed loop, zero")
                if own not in known:
                    self.short["constraints", "boundary", len(boundary)] = path
                    boundary.append({"name": own, "expression": f"{own}[initial]", "equals": 0})

    def step(self, step: Stride) -> None:
        for name, value in step.constants().items():
            self.define(name, value, ("model", "step"))
        boundary = list_in(self.section("constraints"), "boundary")
        known = {own.get("name") for own in boundary if isinstance(own, dict)}
        for name, text in step.conditions().items():
            if name not in known:
                self.short["constraints", "boundary", len(boundary)] = ("model", "step")
                boundary.append({"name": name, "expression": text, "equals": 0})
