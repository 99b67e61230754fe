"""The initial and the final time of a phase in what holds over time: `t[final]` in rates, integrals, path constraints.

Each becomes a static parameter, `final_time`, with the boundary constraint that it is the time: every method has exact
derivatives by static parameters, and they stand in the error bar, in the conditions that `verify` looks at, and in
simulations. The multiplier of that constraint is what the time is worth beside the Hamiltonian at its end; so it is for
a time that is given, by which the objective has a sensitivity as well.
"""

from __future__ import annotations

from dataclasses import replace

from ..expressions.expression import Expression
from ..expressions.slips import ENDS
from ..expressions.tree import Link, Name, Node, OperatorChain
from ..names.variables import free_name
from ..schema.declarations import Static
from ..schema.spec import Spec
from ..yaml.document import Path
from .walk import changed, expressions_of, mapped

TIME = "t"


class TimeParameter(Static):
    """A static parameter that is the time at an end of its phase: "initial" or "final"."""

    end: str


def times_as_parameters(spec: Spec, suffix: str) -> Spec:
    """The spec of one phase without `t[initial]` and `t[final]` in its expressions over time.

    spec: as the schema has passed it, calls of functions written out.
    suffix: of the names of the parameters that take their place, different for each phase.
    """
    ends = {end for path, e in expressions_of(spec) if _over_time(path) for end in ENDS if _stands_in(e, end)}
    if not ends:
        return spec
    names = {end: free_name(f"{end}_time{suffix}", spec) for end in sorted(ends)}

    def instead(name: Name) -> Node:
        return replace(name, name=names[name.end], end=None) if name.name == TIME and name.end else name

    def expression(path: Path, old: Expression) -> Expression:
        if not _over_time(path) or not any(_stands_in(old, end) for end in ends):
            return old
        return replace(old, root=mapped(old.root, instead))

    added = {name: TimeParameter.model_construct(end=end, unit=spec.time.unit) for end, name in names.items()}
    return changed(spec, expression).model_copy(update={"optimize": {**spec.optimize, **added}})


def beyond_parameter(parameter: str, end: str) -> Expression:
    """The time at an end less the static parameter that a boundary constraint makes that time.

    parameter: its name.
    end: "initial" or "final".
    """
    text = f"{TIME}[{end}]"
    span = 0, len(text)
    return Expression(
        text, OperatorChain(*span, Name(*span, TIME, end), (Link(*span, "-", Name(*span, parameter, None)),))
    )


def _stands_in(expression: Expression, end: str) -> bool:
    return any(name.name == TIME and name.end == end for name in expression.leaves)


def _over_time(path: Path) -> bool:
    """Whether the expression at a path is about values at every time; the named ones may be."""
    if path[0] == "constraints":
        return path[1] in ("path", "integral") and path[-1] == "expression"
    return path[0] in ("expressions", "residuals") or path[-1] in ("rate", "next", "accel", "integral")
