"""Named integrals, `integrals: {work: F*v}`, as states that start at zero.

The value at the end, `integral.work`, is then that of a state, and any function of it may be an objective or a
constraint: the costate of the state is the derivative by the integral, a number, and the error estimate, the error bar
and `verify` treat it as any state. Over time `work` is the integral so far.
"""

from __future__ import annotations

from dataclasses import replace

from ..expressions.expression import Expression
from ..expressions.tree import Name, Node, Number
from ..names.troubles import INTEGRAL
from ..schema.declarations import EndValue, IntegralState
from ..schema.phases import PhaseEntry
from ..schema.spec import Spec
from ..yaml.document import Path
from ..yaml.locations import Finding
from .walk import changed, mapped

ZERO = EndValue.model_construct(value=Expression("0", Number(0, 1, 0.0)))


def integrals_as_states(spec: Spec) -> tuple[Spec, list[Finding]]:
    """The spec of one phase with a state for each of its integrals, and those that cannot be.

    spec: as the schema has passed it, calls of functions written out.
    """
    if not spec.integrals:
        return spec, []
    mistaken = [
        Finding(("integrals", name), f"{name} is already declared under states", "give every name once, in one section")
        for name in spec.integrals
        if name in spec.states
    ]
    added = {
        name: IntegralState.model_construct(rate=entry.value, unit=entry.unit, note=entry.note, initial=ZERO)
        for name, entry in spec.integrals.items()
        if name not in spec.states
    }

    def expression(path: Path, old: Expression) -> Expression:
        at_ends = path[:2] == ("constraints", "boundary") or path[-1] == "terminal"
        if not at_ends or not any(_value_of(name, spec) for name in old.leaves):
            return old
        return replace(old, root=mapped(old.root, lambda name: _at_end(name) if _value_of(name, spec) else name))

    spec = changed(spec, expression)
    return spec.model_copy(update={"states": {**spec.states, **added}}), mistaken


def is_integral(name: Name) -> bool:
    """Whether a name is written as that of the value of an integral."""
    return name.name.startswith(INTEGRAL)


def where_written(spec: Spec | PhaseEntry, path: Path) -> Path:
    """Where in the file something is told of that concerns the state of an integral.

    spec: that declares the integral, as it was written.
    path: in its plain form.
    """
    if path[:1] != ("states",) or len(path) < 2 or path[1] not in spec.integrals or path[1] in spec.states:
        return path
    return ("integrals", path[1], "value") if path[2:] == ("rate",) else ("integrals", path[1])


def _value_of(name: Name, spec: Spec) -> bool:
    return is_integral(name) and not name.end and name.name.removeprefix(INTEGRAL) in spec.integrals


def _at_end(name: Name) -> Node:
    return replace(name, name=name.name.removeprefix(INTEGRAL), end="final")
