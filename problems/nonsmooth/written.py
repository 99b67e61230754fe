"""Slack variables of abs, min and max written out: the same problem with controls and constraints of its own.

Their arcs are then arcs as any other: where |y| = s1 + s2 has no kink, one of s1 and s2 is on its bound, and where y
stays at the kink, both are.
"""

from __future__ import annotations

from itertools import chain
from typing import Any

import yaml

from ..expressions.expression import Expression
from ..expressions.tree import skeleton
from ..names.symbols import Symbols
from ..phases.merge import phase_specs
from ..phases.order import ALONE
from ..phases.split import plain_file
from ..schema.spec import Spec
from ..yaml.document import Path
from .rewrite import Relation, consistent
from .spelled import spelled


def with_slack(spec: Spec) -> str:
    """A problem file with slack variables of its own, named as in the problem, in place of abs, min and max, as text.

    spec: without phases.
    """
    own = phase_specs(spec)[ALONE]
    symbols = Symbols(own)
    found, data = consistent(own, symbols), plain_file(own)
    data.pop("nonsmooth")
    given = {use.path: use.expression for use in symbols.uses}
    named: dict[Path, Expression] = {
        ("expressions", name): expression for name, expression in found.definitions.items()
    }
    for path, expression in chain(found.expressions.items(), named.items()):
        before = given.get(path)
        if before is not None and skeleton(before.root) != skeleton(expression.root):
            _place(data, path, expression)
    for group, variables in (("controls", found.controls), ("optimize", found.parameters)):
        if variables:
            data.setdefault(group, {}).update({variable.name: {"lower": 0} for variable in variables})
    for kind, relations in (("path", found.path), ("boundary", found.boundary)):
        if relations:
            data.setdefault("constraints", {}).setdefault(kind, []).extend(map(_told, relations))
    return yaml.safe_dump(data, sort_keys=False, allow_unicode=True, width=118)


def _told(relation: Relation) -> dict[str, Any]:
    key = "equals" if relation.bounds.lower == relation.bounds.upper else "upper"
    return {"name": relation.name, "expression": spelled(relation.expression.root), key: relation.bounds.upper}


def _place(data: Any, path: Path, expression: Expression) -> None:
    """Write an expression in the place of another, which may be a text or a section with it as `value`."""
    *way, last = path
    for step in way:
        data = data[step]
    if isinstance(data[last], dict):
        data, last = data[last], "value"
    data[last] = spelled(expression.root)
