"""The variables of a problem, in whichever form the file gives its dynamics: rates, accelerations, residuals, a model.

Whatever the form, every state ends up with a rate. That of a velocity's position is the velocity; that of an implicit
state v is an algebraic variable, v[rate], which the residuals determine; that of a model's state is the model's.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TypeVar

from ..expressions.expression import Expression
from ..expressions.tree import Name, rate_of
from ..lean.records import dataclass
from ..models import find_model
from ..models.model import Quantity
from ..schema.declarations import Algebraic, Control, IntegralState, StateEntry, Velocity
from ..schema.fields import Bounded
from ..schema.spec import Spec
from ..yaml.document import Path


@dataclass(frozen=True)
class Declared:
    """A control or an algebraic variable. path: where the file declares it. entry: its lower and upper."""

    name: str
    path: Path
    unit: str
    entry: Bounded


@dataclass(frozen=True)
class DeclaredState(Declared):
    """A state; its entry holds initial and final too.

    rate: an expression of the file or made here, in discrete time of the next value; None where a model gives the rate.
    rate_path: where it would stand.
    velocity_of: the state whose rate this one is, else "".
    """

    entry: StateEntry | Velocity
    rate: Expression | None = None
    rate_path: Path = ()
    velocity_of: str = ""

    @property
    def implicit(self) -> bool:
        return self.rate == reference(rate_of(self.name))


def reference(name: str) -> Expression:
    """The expression that is one name."""
    return Expression(name, Name(0, len(name), name, None))


def states(spec: Spec) -> tuple[DeclaredState, ...]:
    """The states of the model, those of the file in its order, then the velocities of those given by accel."""
    of_model = _of_model(spec.states, StateEntry(), find_model(spec.shipped).states) if spec.shipped else ()
    positions = [
        DeclaredState(name, ("states", name), entry.unit or quantity.unit, entry) for name, entry, quantity in of_model
    ]
    velocities = []
    own = {name: state for name, state in spec.states.items() if not spec.shipped or isinstance(state, IntegralState)}
    for name, state in own.items():
        path = ("states", name)
        if not state.second_order:
            rate = state.next or state.rate or reference(rate_of(name))
            key = "rate" if state.next is None else "next"
            positions.append(DeclaredState(name, path, state.unit, state, rate, (*path, key)))
            continue
        velocity = state.velocity or Velocity()
        speed = state.velocity_of(name)
        unit = velocity.unit or _per_time(state.unit, spec)
        rate = state.accel or reference(rate_of(speed))
        positions.append(DeclaredState(name, path, state.unit, state, reference(speed)))
        accel = (*path, "accel")
        velocities.append(DeclaredState(speed, (*path, "velocity"), unit, velocity, rate, accel, velocity_of=name))
    return (*positions, *velocities)


def controls(spec: Spec) -> tuple[Declared, ...]:
    """The controls of the file, or of its model."""
    quantities = find_model(spec.shipped).controls if spec.shipped else None
    return _inputs(("controls",), spec.controls, Control(), quantities)


def algebraic(spec: Spec) -> tuple[Declared, ...]:
    """The algebraic variables, and after them the rates of the implicit states."""
    quantities = find_model(spec.shipped).algebraic if spec.shipped else None
    rates = (
        Declared(rate_of(state.name), state.path, _per_time(state.unit, spec), Algebraic())
        for state in states(spec)
        if state.implicit
    )
    return (*_inputs(("algebraic",), spec.algebraic, Algebraic(), quantities), *rates)


AnInput = TypeVar("AnInput", Control, Algebraic)
AnEntry = TypeVar("AnEntry", Control, Algebraic, StateEntry)


def _inputs(
    section: Path, given: Mapping[str, AnInput], empty: AnInput, quantities: Mapping[str, Quantity] | None
) -> tuple[Declared, ...]:
    """The controls or the algebraic variables.

    section: the path of their section. given: its entries. empty: the entry of what the file leaves to the model.
    quantities: those of the model, None without one.
    """
    if quantities is None:
        return tuple(Declared(name, (*section, name), entry.unit, entry) for name, entry in given.items())
    return tuple(
        Declared(name, (*section, name), entry.unit or quantity.unit, entry)
        for name, entry, quantity in _of_model(given, empty, quantities)
    )


def _of_model(
    given: Mapping[str, AnEntry], empty: AnEntry, quantities: Mapping[str, Quantity]
) -> Iterator[tuple[str, AnEntry, Quantity]]:
    """(name, entry of the file, quantity of the model) for each quantity."""
    return ((name, given.get(name, empty), quantity) for name, quantity in quantities.items())


def _per_time(unit: str, spec: Spec) -> str:
    return f"{unit}/{spec.time.unit}" if unit else ""
