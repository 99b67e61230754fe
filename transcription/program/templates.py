"""Pyomo's templates: making them, reading them, and taking sums over Sets out of them."""

from __future__ import annotations

import builtins
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from math import inf
from typing import Any, NamedTuple

from ..libraries.alone import LOCK
from ..libraries.pyomo import (
    Constraint,
    GetItemExpression,
    IndexTemplate,
    NPV_Numeric_GetItemExpression,
    Numeric_GetItemExpression,
    Objective,
    TemplateSumExpression,
    Var,
    native_numeric_types,
    native_types,
    template_context,
)
from ..libraries.pyomo import constraint as pyomo_constraint
from ..libraries.pyomo import numeric_expr as ne
from ..libraries.pyomo import objective as pyomo_objective
from ..libraries.pyomo import relational_expr as relation

_SUM, _OF_PYOMO = builtins.sum, template_context.sum_template
_THREAD = threading.local()  # `templated` is true in the one that makes templates


def _sum(context: template_context, *args: Any, **kwargs: Any) -> Any:
    """The `sum` of the whole process while Pyomo makes a template: Pyomo's own for the builder, Python's for others."""
    if getattr(_THREAD, "templated", False):
        return _OF_PYOMO(context, *args, **kwargs)
    return _SUM(*args, **kwargs)


template_context.sum_template = _sum


class TemplateError(RuntimeError):
    """The model is not of the form the compiler takes: a bug in what built it, not a mistake of the user."""


@contextmanager
def templated() -> Iterator[None]:
    """While this is open, Pyomo calls each rule once, with an index placeholder, and keeps the one expression.

    The two switches are private to Pyomo (not documented, off by default), and so is the `sum` that it puts in place of
    Python's for all threads; hence the narrow version range of Pyomo in pyproject.toml. A rule must neither loop over a
    Set nor branch on its index: Pyomo would silently write one expression an index, which `template_of` refuses.
    """
    with LOCK:
        _THREAD.templated = True
        before = pyomo_constraint.TEMPLATIZE_CONSTRAINTS, pyomo_objective.TEMPLATIZE_OBJECTIVES
        pyomo_constraint.TEMPLATIZE_CONSTRAINTS = pyomo_objective.TEMPLATIZE_OBJECTIVES = True
        try:
            yield
        finally:
            _THREAD.templated = False
            pyomo_constraint.TEMPLATIZE_CONSTRAINTS, pyomo_objective.TEMPLATIZE_OBJECTIVES = before


def item(component: Any, *index: Any) -> Any:
    """component[index] of a Var or Param; where the index holds a placeholder, the node that Pyomo makes of it.

    Pyomo finds out the kind of node by walking over the component and the index, which took a third of the time that a
    model takes to build; here it is known.
    """
    if all(i.__class__ in native_types for i in index):
        return component[index]
    node = Numeric_GetItemExpression if component.ctype is Var else NPV_Numeric_GetItemExpression
    return node((component, *index))


def table_of(e: Any) -> tuple[Any, Sequence[Any]] | None:
    """The table of data that an external function looks up, and its operands; None for another function."""
    table = getattr(e._fcn, "table", None)
    return None if table is None else (table, e.args[:-1])  # Pyomo adds the number of the function as the last


def template_of(component: Any) -> tuple[Any, IndexTemplate | None]:
    """The one expression of a Constraint or Objective, and its index placeholder (None if it has no index).

    Raises TemplateError if the component is not a template.
    """
    template = next((d.template_expr for d in component.values() if hasattr(d, "template_expr")), None)
    if template is None:
        raise TemplateError(
            f"{component.name} is not a template: its rule loops over a Set, branches on its index, was called outside "
            "templated(), or has been expanded by reading .expr"
        )
    expression, indices = template()
    if len(indices) > 1:
        raise TemplateError(f"{component.name} has {len(indices)} indices; a template has one or none")
    return expression, (indices[0] if indices else None)


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
    expression: Any

    @property
    def placeholder(self) -> Any:
        """The index of the sum."""
        return self.total.template_iters()[0][0]


def linear_parts(e: Any) -> list[tuple[TemplateSumExpression | None, list, Any]]:
    """Split a body into terms (sum, factors, expression): body = sum of product(factors) * expression.

    A term with a sum runs over its Set; `factors` are Pyomo expressions or numbers without a sum in them.
    """
    return _Splitter().split(e)


class _Splitter:
    def __init__(self) -> None:
        self.known: dict[int, bool] = {}

    def has_sum(self, e: Any) -> bool:
        if e.__class__ in native_types or not e.is_expression_type() or isinstance(e, GetItemExpression):
            return False
        if id(e) not in self.known:
            self.known[id(e)] = isinstance(e, TemplateSumExpression) or any(map(self.has_sum, e.args))
        return self.known[id(e)]

    def split(self, e: Any) -> list:
        if not self.has_sum(e):
            return [(None, [], e)]
        if isinstance(e, TemplateSumExpression):
            return [_only_index(e)]
        if isinstance(e, ne.SumExpressionBase):
            return [term for a in e.args for term in self.split(a)]
        if isinstance(e, ne.NegationExpression):
            return self.scaled(-1, e.args[0])
        if isinstance(e, ne.ProductExpression) and not all(map(self.has_sum, e.args)):
            inside, factor = sorted(e.args, key=self.has_sum, reverse=True)
            return self.scaled(factor, inside)
        if isinstance(e, ne.DivisionExpression) and not self.has_sum(e.args[1]):
            return self.scaled(1 / e.args[1], e.args[0])
        raise TemplateError(f"a sum over a Set stands in a nonlinear term: {e}")

    def scaled(self, factor: Any, e: Any) -> list:
        return [(total, [factor, *factors], x) for total, factors, x in self.split(e)]


def _only_index(e: TemplateSumExpression) -> tuple:
    if len(e.template_iters()) != 1 or len(e.template_iters()[0]) != 1:
        raise TemplateError(f"{e} runs over more than one index")
    return e, [], e._local_args_[0]
