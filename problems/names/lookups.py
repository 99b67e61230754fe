"""The tables of data of a problem, and what expressions ask of them."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from ..expressions.expression import Expression
from ..expressions.tree import Lookup, Name, Node, nodes, skeleton
from ..problem import Problem
from ..quantities import Function, Range
from ..schema.spec import Spec
from ..tables.choices import ERROR
from ..text import excerpt
from ..yaml.locations import Finding

if TYPE_CHECKING:  # tables import SciPy
    from ..tables.table import Table


def fitted_tables(spec: Spec, findings: list[Finding]) -> dict[str, Table]:
    """The tables by name; what is mistaken in one is added to the findings, and the table left out."""
    tables = {}
    for name, entry in spec.tables.items():
        if wrong := entry.mistakes():
            findings += [Finding(("tables", name, *path), what, remedy) for path, what, remedy in wrong]
        else:
            tables[name] = replace(entry.curve, name=name)
    return tables


def misused(expression: Expression, tables: Mapping[str, Table]) -> list[tuple[str, str] | None]:
    """What is wrong with each table that an expression cannot look up, and the remedy; None where the table is.

    expression: of the file.
    tables: those without mistakes.
    """
    found: list[tuple[str, str] | None] = []
    for node in expression.nodes:
        if not isinstance(node, Lookup):
            continue
        table = tables.get(node.table)
        if table is None:
            found.append(None)
        elif len(node.operands) != len(table.axes):
            where, many = excerpt(expression.text, node.start, node.stop), len(table.axes)
            wanted = f"{many} argument{'s' * (many > 1)}"
            found.append((f"{where}: {node.table} takes {wanted}, not {len(node.operands)}", f"write {table.called}"))
    return found


class KeptWithin(NamedTuple):
    """An argument of a table that has to stay within its points.

    name: the name that the argument is, and end: the end it is taken at; name is "" for any other expression.
    function: the argument. key: equal for arguments that are the same.
    """

    table: str
    argument: str
    points: Range
    name: str
    end: str | None
    function: Expression
    key: Hashable


def kept_within(function: Function) -> Iterator[KeptWithin]:
    """The arguments of tables in a function of a problem, and in what it refers to, that may not leave the points."""
    if not isinstance(function, Expression):
        return  # a model's
    steps = sorted(function.steps.items())  # in the same order at every call: the first gives a constraint its name
    for root, end in [(function.root, None), *((definition.root, end) for _, (definition, end) in steps)]:
        for node in (node for node in nodes(root) if isinstance(node, Lookup)):
            for axis, operand in zip(function.tables[node.table].axes, node.operands, strict=True):
                if axis.outside == ERROR:
                    key = skeleton(operand), end
                    plain = isinstance(operand, Name) and operand.name not in function.definitions
                    name, at = (operand.name, operand.end or end) if isinstance(operand, Name) and plain else ("", end)
                    yield KeptWithin(
                        node.table, axis.name, axis.points, name, at, _taken_at(function, operand, end), key
                    )


def _taken_at(function: Expression, operand: Node, end: str | None) -> Expression:
    """A part of what a function refers to as a function, taken at the end that is meant."""
    text = function.text[operand.start : operand.stop]
    part = replace(function, text=text, root=operand)
    return part if end is None else part.at(end)


def tables_of(problem: Problem) -> list[str]:
    """The names of the tables that the equations of a problem look up."""
    found: dict[str, None] = {}
    own = (function for phase in problem.phases for function in (*phase.over_time, *phase.at_ends))
    measured = (entry.function for phase in problem.phases for entry in phase.measured)
    for function in (*own, *measured, *problem.between):
        if isinstance(function, Expression):
            looked_up = (node for part in function.parts for node in part.nodes if isinstance(node, Lookup))
            found |= dict.fromkeys(node.table for node in looked_up)
    return list(found)


def as_called(name: str, tables: Mapping[str, Table]) -> str:
    """The remedy for the name of a table without arguments."""
    return f"write {tables[name].called if name in tables else f'{name}(...)'}"
