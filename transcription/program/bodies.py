"""The body of a Pyomo constraint or objective: its sides and bounds, and the sums over Sets in it."""

from __future__ import annotations

from math import inf, prod
from typing import Any, NamedTuple

import symengine as se
from pyomo.core import Constraint, Objective
from pyomo.core.expr import relational_expr as relation
from pyomo.core.expr.numvalue import native_numeric_types
from pyomo.core.expr.template_expr import TemplateSumExpression

from .symbolic import Arguments
from .templates import TemplateError, linear_parts, template_of


def relation_of(c: Any) -> tuple[list, object, object, object]:
    """A constraint as lower <= sum of sign * side <= upper; returns ([(sign, side)], lower, upper, template)."""
    e, template = template_of(c)
    if getattr(e, "strict", False) not in (False, (False, False)):
        raise TemplateError(f"{c.name} is a strict inequality, which no solver can tell from the other")
    if isinstance(e, relation.RangedExpression):
        lower, body, upper = e.args
        return [(1, body)], lower, upper, template
    if not isinstance(e, relation.EqualityExpression | relation.InequalityExpression):
        raise TemplateError(f"the rule of {c.name} gives no relation but {e}")
    left, right = e.args
    equal = isinstance(e, relation.EqualityExpression)
    if right.__class__ in native_numeric_types:
        return [(1, left)], right if equal else -inf, right, template
    if left.__class__ in native_numeric_types:
        return [(1, right)], left, left if equal else inf, template
    return [(1, left), (-1, right)], 0.0 if equal else -inf, 0.0, template


class SumTerm(NamedTuple):
    """product(factors) * sum of expression over the Set of `total`, in one row."""

    component: Constraint | Objective
    row: int
    total: TemplateSumExpression
    factors: list
    expression: object


def placeholder_of(term: SumTerm) -> Any:
    """The index placeholder of a sum."""
    return term.total.template_iters()[0][0]


def product_of(arguments: Arguments, factors: list, e: Any, template: Any) -> se.Basic:
    """product(factors) * e in SymEngine.

    arguments: of the family that the product belongs to.
    factors: Pyomo expressions or numbers.
    e: a Pyomo expression.
    template: its index placeholder, or None.
    """
    return prod((arguments.translate(f, template) for f in factors), start=arguments.translate(e, template))


def without_sums(sides: list, arguments: Arguments, c: Any, row: int, sums: list) -> se.Basic:
    """The terms of a scalar row that stand in no sum over a Set; the others are put down in `sums`.

    sides: (sign, Pyomo expression) each.
    arguments: of the family of the row.
    c: the component that the row is of.
    row: its number.
    sums: gets a SumTerm for each sum.
    """
    plain = se.Integer(0)
    for sign, side in sides:
        for total, factors, e in linear_parts(side):
            if total is None:
                plain += product_of(arguments, [sign, *factors], e, None)
            else:
                sums.append(SumTerm(c, int(row), total, [sign, *factors], e))
    return plain
