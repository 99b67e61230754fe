"""The variables of a problem, in whichever form the file gives its dynamics: rates, accelerations, residuals.

Whatever the form, every state ends up with a rate. That of a velocity's position is the velocity; that of an implicit
state v is an algebraic variable, v[rate], which the residuals determine.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

from ..expressions.expression import Expression
from ..expressions.tree import Name, rate_of
from ..lean.records import dataclass
from ..schema.declarations import Algebraic, Control, StateEntry, Velocity
from ..schema.fields import Bounded
from ..schema.spec import Spec
from ..yaml.document import Path

_DECLARING = ("parameters", "expressions", "states", "controls", "algebraic", "optimize", "integrals", "tables")
"""Sections whose keys are names."""


@dataclass(frozen=True)
class DeclaredVariable:
    """A control or an algebraic variable. path: where the file declares it. entry: its lower and upper."""

    name: str
    path: Path
    unit: str
    entry: Bounded


@dataclass(frozen=True)
class DeclaredState(DeclaredVariable):
    """A state; its entry holds initial and final too.

    rate: an expression of the file or made here, in discrete time of the next value.
    rate_path: where it would stand.
    velocity_of: the state whose rate this one is, else "".
    """

    entry: StateEntry | Velocity
    rate: Expression
    rate_path: Path = ()
    velocity_of: str = ""

    @property
    def implicit(self) -> bool:
        return self.rate == reference(rate_of(self.name))


def free_name(wanted: str, spec: Spec, added: Collection[str] = ()) -> str:
    """A name that nothing has: the one that is wanted, made longer until that is so.

    wanted: a word.
    spec: of the file or of a phase, all whose names are meant.
    added: further names.
    """
    taken = {*added, *(name for section in _DECLARING for name in getattr(spec, section))}
    taken |= {entry.velocity_of(name) for name, entry in spec.states.items() if entry.second_order}
    while wanted in taken:
        wanted += "_"
    return wanted


def reference(name: str) -> Expression:
    """The expression that is one name."""
    return Expression(name, Name(0, len(name), name, None))


def states(spec: Spec) -> tuple[DeclaredState, ...]:
    """The states of the file in its order, then the velocities of those given by accel."""
    positions, velocities = [], []
    for name, state in spec.states.items():
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


def controls(spec: Spec) -> tuple[DeclaredVariable, ...]:
    """The controls."""
    return _inputs(("controls",), spec.controls)


def algebraic(spec: Spec) -> tuple[DeclaredVariable, ...]:
    """The algebraic variables, and after them the rates of the implicit states."""
    rates = (
        DeclaredVariable(rate_of(state.name), state.path, _per_time(state.unit, spec), Algebraic())
        for state in states(spec)
        if state.implicit
    )
    return (*_inputs(("algebraic",), spec.algebraic), *rates)


def _inputs(section: Path, given: Mapping[str, Control] | Mapping[str, Algebraic]) -> tuple[DeclaredVariable, ...]:
    """The controls or the algebraic variables; section: the path of where they stand."""
    return tuple(DeclaredVariable(name, (*section, name), entry.unit, entry) for name, entry in given.items())


def _per_time(unit: str, spec: Spec) -> str:
    return f"{unit}/{spec.time.unit}" if unit else ""
