"""A templated Pyomo model -> the callbacks of a nonlinear program, in machine code.

    minimise f(z)   subject to   cl <= g(z) <= cu

Constraints that share an index set are one family: y[s] = F(z[columns[s]], data[s]) for every s in the set. SymEngine
differentiates F once, its LLVM backend compiles F, its Jacobian and its weighted Hessian, and each is evaluated for
all s in one call. A sum over a Set, in the objective or in a scalar constraint, is a family whose values are added
into one row. Rows of a family are contiguous and run over its components first, then over s:

    row = first row + s * (number of components) + component,

which keeps the KKT matrix banded when the variables are ordered point by point.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import symengine as se

from ..libraries.pyomo import ComponentMap, Constraint, Objective, minimize
from .backend import available_backend
from .compiled import CompiledNLP
from .family import CompiledFamily
from .machine_code import compile_family, timing
from .slots import Slots
from .symbolic import Arguments, product_of, without_sums
from .templates import TemplateError, relation_of, template_of


def compile_model(
    model: Any, variables: Sequence, backend: str | None = None, named: Mapping[Any, Any] | None = None
) -> CompiledNLP:
    """The nonlinear program of a templated model.

    model: of Pyomo, with one objective to minimise.
    variables: z, in this order. A variable that is not among them must be fixed; its value, like that of every
        parameter, is read here, once, and `CompiledNLP.with_numbers` makes a program with other ones.
    backend: of SymEngine; None for the best there is.
    named: key -> a fixed variable or a parameter: where its number stands is told by `CompiledNLP.slots`.

    Raises TemplateError for a model the compiler cannot take.
    """
    return _Compiler(model, variables, backend or available_backend()).program(named or {})


class _Compiler:
    """The families of a model, added one after the other."""

    def __init__(self, model: Any, variables: Sequence, backend: str) -> None:
        self.seconds = dict.fromkeys(("differentiate", "compile", "evaluate"), 0.0)
        self.n, self.m, self.backend = len(variables), 0, backend
        self._slots = Slots(variables)
        self._row_families: list[CompiledFamily] = []
        self._sum_families: list[CompiledFamily] = []
        self._rows: dict[str, np.ndarray] = {}
        sums = self._add_constraints(model)
        self._sum_families += self._add_sums(sums)
        self._cost_families = self._add_objective(model)

    def program(self, named: Mapping[Any, Any]) -> CompiledNLP:
        """All of it. named: as of `compile_model`."""
        slots = {key: self._slots.single(leaf) for key, leaf in named.items()}
        families = self._row_families, self._sum_families, self._cost_families
        return CompiledNLP(self.n, families, self._bounds, self._rows, self._slots.data, slots, self.seconds)

    def _add_constraints(self, model: Any) -> list:
        groups = ComponentMap()
        for c in model.component_objects(Constraint, active=True):
            self._rows[c.name] = np.zeros(0, dtype=np.intp)
            if len(c):
                groups.setdefault(c.index_set() if c.is_indexed() else None, []).append(c)
        sums: list = []
        bounds = [self._add_rows(group, sums) for group in groups.values()]
        self._bounds = np.concatenate([np.zeros((2, 0)), *bounds], axis=1)
        return sums

    def _add_rows(self, components: list, sums: list) -> np.ndarray:
        """Append one family; returns its bounds (2, rows) and adds the sums over Sets it contains to `sums`."""
        over = components[0].index_set() if components[0].is_indexed() else None
        with timing(self.seconds, "differentiate"):
            arguments = self._arguments(over)
            size, width = len(arguments.values), len(components)
            rows = self.m + np.arange(size * width, dtype=np.intp).reshape(size, width)
            self.m += size * width
            outputs, bounds = [], np.empty((2, size, width))
            for o, c in enumerate(components):
                self._rows[c.name] = rows[:, o]
                sides, lower, upper, template = relation_of(c)
                bounds[:, :, o] = arguments.numbers(lower, template), arguments.numbers(upper, template)
                if over is None:
                    outputs.append(without_sums(sides, arguments, c, rows[0, o], sums))
                else:
                    outputs.append(sum(sign * arguments.translate(e, template) for sign, e in sides))
        self._row_families.append(self._family(components, over, arguments, outputs, rows))
        return bounds.reshape(2, -1)

    def _add_sums(self, sums: list) -> list[CompiledFamily]:
        """A family for each Set that is summed over, with one output for each row it adds to."""
        groups = ComponentMap()
        for term in sums:
            groups.setdefault(term.placeholder._set, []).append(term)
        families = []
        for over, terms in groups.items():
            with timing(self.seconds, "differentiate"):
                arguments = self._arguments(over)
                outputs: dict[int, se.Basic] = {}
                for term in terms:
                    y = product_of(arguments, term.factors, term.expression, term.placeholder)
                    outputs[term.row] = outputs.get(term.row, 0) + y
                components = {term.row: term.component for term in terms}
                rows = np.array(list(components), dtype=np.intp)
            families.append(self._family(list(components.values()), over, arguments, list(outputs.values()), rows))
        return families

    def _add_objective(self, model: Any) -> list[CompiledFamily]:
        objectives = list(model.component_objects(Objective, active=True))
        if len(objectives) != 1 or objectives[0].is_indexed() or objectives[0].sense != minimize:
            raise TemplateError(f"one scalar objective to minimise is wanted, found {[c.name for c in objectives]}")
        cost = objectives[0]
        sums: list = []
        with timing(self.seconds, "differentiate"):
            arguments = self._arguments(None)
            plain = without_sums([(1, template_of(cost)[0])], arguments, cost, self.m, sums)
        families = self._add_sums(sums)
        if plain != 0:
            families.append(self._family([cost], None, arguments, [plain], np.array([self.m])))
        return families

    def _arguments(self, over: Any) -> Arguments:
        return Arguments(self._slots, np.zeros(1, int) if over is None else np.array(list(over)))

    def _family(self, components: Any, over: Any, arguments: Any, outputs: Any, rows: np.ndarray) -> CompiledFamily:
        sizes = len(arguments.variables), len(arguments.data)
        outputs = [se.sympify(y) for y in outputs]
        code = compile_family(outputs, *sizes, self.backend, self.seconds, arguments.lookups)
        names, own_set = [component.name for component in components], None if over is None else over.name
        return CompiledFamily(names, own_set, arguments, rows, code, self.backend)
