"""What of a function is its form, and which of its numbers may change without changing that.

The parameters of a file are data of the machine code that is made of its expressions, so that one compilation serves
every value of theirs. Some must stay literal numbers, and belong to the form: those in an exponent (x**2 is x*x, and
has another derivative at zero than exp(2 log x)), those under abs, min and max, which have no derivative, those that a
model in Python is given, and those that are zero (0*sqrt(x) has no derivative at zero unless it is left out).
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from ..expressions.expression import Expression
from ..expressions.functions import is_inconsistent
from ..expressions.tree import Lookup, Node, Operation, below, leaves
from ..quantities import Function


class Form(NamedTuple):
    """The form of several functions that are evaluated with the same data.

    form: equal for functions that differ in `data` only. data: name -> number.
    """

    form: Hashable
    data: Mapping[str, float]


def form_of(functions: Iterable[Function | None], values_only: bool = False) -> Form:
    """The form of functions, and the parameters in them that are data.

    functions: of one phase, or of what is between phases.
    values_only: whether no derivatives are taken, so that zeros and exponents may be data too.

    A function that is no expression is its own form. What is one number here and another there is literal.
    """
    shapes: list[Any] = []
    numbers: dict[str, float] = {}
    literal: set[str] = set()
    for function in functions:
        if not isinstance(function, Expression):
            shapes.append(function)
            continue
        shapes.append((function.root, *((key, d.root) for key, (d, _) in function.steps.items())))
        looked_up = {node.table for part in function.parts for node in part.nodes if isinstance(node, Lookup)}
        shapes += [(name, function.tables[name].content) for name in sorted(looked_up)]
        for name in sorted(function.constants):
            value = function.parameters[name]
            if numbers.setdefault(name, value) != value or not (value or values_only):
                literal.add(name)
                shapes.append((name, value))
        literal |= _literal(function, [part.root for part in function.parts], values_only)
    data = {name: value for name, value in numbers.items() if name not in literal}
    fixed = tuple((name, numbers[name]) for name in sorted(literal & numbers.keys()))
    return Form((tuple(shapes), fixed, tuple(sorted(data))), data)


def _literal(function: Expression, roots: Iterable[Node], values_only: bool) -> set[str]:
    """The names that must be numbers, and those in the definitions of such names."""
    waiting = [name for root in roots for part in _constant_parts(root, values_only) for name in _names(part)]
    found: set[str] = set()
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            if name in function.definitions:
                waiting += _names(function.definitions[name].root)
    return found


def _names(root: Node) -> list[str]:
    return [leaf.name for leaf in leaves(root)]


def _constant_parts(node: Node, values_only: bool) -> Iterator[Node]:
    """The largest parts of a tree whose parameters must be numbers."""
    match node:
        case Operation(symbol=symbol) if is_inconsistent(symbol):
            yield node
        case Operation(symbol="**", operands=(base, exponent)) if not values_only:
            yield exponent
            yield from _constant_parts(base, values_only)
        case _:
            for part in below(node):
                yield from _constant_parts(part, values_only)
