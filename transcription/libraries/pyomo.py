"""What is used of Pyomo, loaded without scipy.stats and pyplot: no other module loads Pyomo.

Pyomo would load these, for up to a second, where it finds SciPy or Matplotlib loaded, and whenever anyone imports a
part of them later; and where it finds multiprocessing, as in a worker of a sweep, it makes a lock that a killed process
leaves behind. It asks for what it needs of them by other ways. How it does all that is private to it.
"""

from __future__ import annotations

from ...problems.lean.hidden import hidden

HIDDEN = ("scipy", "matplotlib", "multiprocessing")

with hidden(*HIDDEN):
    from pyomo import core as pyomo
    from pyomo.common.collections import ComponentMap
    from pyomo.common.dependencies import DeferredImportCallbackFinder
    from pyomo.core import Any as AnyValue
    from pyomo.core import Block, ConcreteModel, Constraint, Objective, Param, RangeSet, Set, Var, minimize
    from pyomo.core.base import constraint, objective
    from pyomo.core.base.var import VarData
    from pyomo.core.expr import numeric_expr, relational_expr
    from pyomo.core.expr.numvalue import native_numeric_types, native_types, value
    from pyomo.core.expr.template_expr import (
        GetItemExpression,
        IndexTemplate,
        NPV_Numeric_GetItemExpression,
        Numeric_GetItemExpression,
        TemplateSumExpression,
        _template_iter_context,
    )
    from pyomo.core.expr.visitor import StreamBasedExpressionVisitor

for _library in HIDDEN:
    DeferredImportCallbackFinder._callbacks.pop(_library, None)

template_context = _template_iter_context

__all__ = [
    "AnyValue", "Block", "ComponentMap", "ConcreteModel", "Constraint", "GetItemExpression", "IndexTemplate",
    "NPV_Numeric_GetItemExpression", "Numeric_GetItemExpression", "Objective", "Param", "RangeSet", "Set",
    "StreamBasedExpressionVisitor", "TemplateSumExpression", "Var", "VarData", "constraint", "minimize",
    "native_numeric_types", "native_types", "numeric_expr", "objective", "pyomo", "relational_expr",
    "template_context", "value",
]  # fmt: skip
