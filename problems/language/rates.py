"""The rate of a state that the file gives, `v[rate]`, in other expressions: the expression that it is given by."""

from __future__ import annotations

from dataclasses import replace

from ..expressions.expression import Expression
from ..expressions.tree import Name, Node, placed, rate_of
from ..schema.spec import Spec
from ..yaml.document import Path
from .walk import changed, expressions_of, mapped

_OVER_TIME = (
    "expressions",
    "states",
    "residuals",
    "constraints",
    "objective",
    "complementarity",
    "integrals",
    "drawing",
)
MAX_INSIDE = 20  # rates in rates


def rates_written_out(spec: Spec) -> Spec:
    """The spec with given rates in place of their names; those at ends of time, and in circles, stay.

    spec: of one phase, calls of functions written out.
    """
    rates = _given(spec)
    if not any(leaf.name in rates for _, own in expressions_of(spec) for leaf in own.leaves):
        return spec

    def expression(path: Path, old: Expression) -> Expression:
        at_ends = path[:2] == ("constraints", "boundary") or path[-1] == "terminal" or path[0] not in _OVER_TIME
        if at_ends or not any(leaf.name in rates for leaf in old.leaves):
            return old
        within = frozenset([rate_of(str(path[1]))] if path[0] == "states" else [])
        return replace(old, root=_replaced(old.root, rates, within))

    return changed(spec, expression)


def _given(spec: Spec) -> dict[str, Node]:
    """The rates that a file gives, by their names."""
    found: dict[str, Node] = {}
    for name, entry in spec.states.items():
        if entry.rate is not None:
            found[rate_of(name)] = entry.rate.root
        elif entry.accel is not None:
            velocity = entry.velocity_of(name)
            found |= {rate_of(name): Name(0, 0, velocity, None), rate_of(velocity): entry.accel.root}
    return found


def _replaced(root: Node, rates: dict[str, Node], within: frozenset[str]) -> Node:
    def new(name: Name) -> Node:
        if name.name not in rates or name.name in within or len(within) > MAX_INSIDE:
            return name
        return _replaced(placed(rates[name.name], name.start, name.stop), rates, within | {name.name})

    return mapped(root, new)
