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

from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from typing import Any

import numpy as np
import symengine as se

from ..libraries.pyomo import ComponentMap, Constraint, Objective, minimize
from .backend import available_backend
from .contract import callback
from .family import CompiledFamily, Entries
from .machine_code import compile_family, timing
from .slots import Slots
from .symbolic import Arguments, placeholder_of, product_of, relation_of, without_sums
from .templates import TemplateError, template_of


class CompiledNLP:
    """The nonlinear program of a templated model, z being `variables` in the given order.

    n, m: numbers of variables and rows. cl, cu: (m,) bounds of the rows, +-inf where there is none.
    seconds: differentiate (Pyomo to SymEngine included), compile, evaluate. calls: evaluations by callback.
    A variable that is not in `variables` must be fixed; its value, like that of every parameter, is read here, once,
    and `with_numbers` makes a program with other ones.

    Raises TemplateError for a model the compiler cannot take. Callbacks raise NotFinite.
    """

    def __init__(self, model: Any, variables: Sequence, backend: str | None = None) -> None:
        self.seconds = dict.fromkeys(("differentiate", "compile", "evaluate"), 0.0)
        self.n, self.m = len(variables), 0
        self._backend = backend or available_backend()
        self._slots = Slots(variables)
        self._row_families: list[CompiledFamily] = []
        self._sum_families: list[CompiledFamily] = []
        self._rows = ComponentMap()
        sums = self._add_constraints(model)
        self._sum_families += self._add_sums(sums)
        self._cost_families = self._add_objective(model)
        self._numbers = np.concatenate([np.full(self.n, np.nan), self._slots.data])
        self._prepare()

    def _add_constraints(self, model: Any) -> list:
        groups = ComponentMap()
        for c in model.component_objects(Constraint, active=True):
            self._rows[c] = np.zeros(0, dtype=np.intp)
            if len(c):
                groups.setdefault(c.index_set() if c.is_indexed() else None, []).append(c)
        sums: list = []
        bounds = [self._add_rows(group, sums) for group in groups.values()]
        self.cl, self.cu = np.concatenate([np.zeros((2, 0)), *bounds], axis=1)
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
                self._rows[c] = rows[:, o]
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
            groups.setdefault(placeholder_of(term)._set, []).append(term)
        families = []
        for over, terms in groups.items():
            with timing(self.seconds, "differentiate"):
                arguments = self._arguments(over)
                outputs: dict[int, se.Basic] = {}
                for term in terms:
                    y = product_of(arguments, term.factors, term.expression, placeholder_of(term))
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
        code = compile_family(outputs, *sizes, self._backend, self.seconds, arguments.lookups)
        return CompiledFamily(components, over, arguments, rows, code, self._backend)

    def slot(self, leaf: Any) -> int:
        """Where the number of a fixed variable or of a parameter stands, for `number` and `with_numbers`."""
        slot = self._slots.single(leaf)
        if slot >= len(self._numbers):  # nothing reads it
            self._numbers = np.append(self._numbers, self._slots.data[len(self._numbers) - self.n :])
        return slot

    def number(self, slot: int) -> float:
        """The number in a slot."""
        return float(self._numbers[slot])

    def with_numbers(self, numbers: Mapping[int, float], cl: np.ndarray, cu: np.ndarray) -> CompiledNLP:
        """The same program with other numbers; it shares machine code and structure, and nothing that changes.

        numbers: by slot, in place of those that are there.
        cl, cu: (m,) bounds of the rows.
        """
        other = copy(self)
        other.seconds, other.cl, other.cu = dict.fromkeys(self.seconds, 0.0), cl, cu
        other._numbers = self._numbers.copy()
        other._numbers[: self.n] = np.nan
        other._numbers[list(numbers)] = list(numbers.values())
        new = {id(f): f.with_data(other._numbers) for f in self._families}
        for name in ("_row_families", "_sum_families", "_cost_families", "_families"):
            setattr(other, name, [new[id(f)] for f in getattr(self, name)])
        other._jacobian, other._hessian = (
            [(new[id(f)], entries) for f, entries in pieces] for pieces in (self._jacobian, self._hessian)
        )
        other._asked = {kind: [new[id(f)] for f in asked] for kind, asked in self._asked.items()}
        return other

    def _prepare(self) -> None:
        self._families = self._row_families + self._sum_families + self._cost_families
        for f in self._families:
            f.set_data(self._numbers)
        n = self.n
        self._jacobian = [
            (f, f.jacobian_entries(n)) for f in self._row_families + self._sum_families if f.code.jacobian
        ]
        self._hessian = [(f, f.hessian_entries(n)) for f in self._families if f.code.hessian]
        self._asked = {
            "objective": self._cost_families,
            "gradient": self._cost_families,
            "constraints": self._row_families + self._sum_families,
            "jacobian": [f for f, _ in self._jacobian],
            "hessian": [f for f, _ in self._hessian],
        }
        self._gradient_columns = [
            np.minimum(f.columns[:, f.code.jacobian_at[:, 1]], n).ravel() for f in self._cost_families
        ]

    @property
    def degrees(self) -> tuple[int, int]:
        """Of the constraints and of the objective: 1 for linear, 2 for quadratic, 3 for others."""
        rows, costs = self._row_families + self._sum_families, self._cost_families
        return max((f.code.degree for f in rows), default=1), max((f.code.degree for f in costs), default=1)

    def rows(self, component: Any) -> np.ndarray:
        """The row numbers of a Constraint, in the order of its index set."""
        return self._rows[component]

    def row_name(self, row: int) -> tuple[str, int | None]:
        """(component name, index or None) of a row."""
        family = next(f for f in self._row_families if f.rows[0, 0] <= row <= f.rows[-1, -1])
        s, o = divmod(row - family.rows[0, 0], len(family.components))
        return family.components[o].name, None if family.index is None else int(family.index[s])

    def move(self, z: np.ndarray) -> None:
        """Read z into the arguments of every family, unless it is there already."""
        if np.array_equal(z, self._numbers[: self.n]):
            return
        self._numbers[: self.n] = z
        for f in self._families:
            f.move(self._numbers)

    def culprits(self, kind: str, values: np.ndarray) -> list[tuple[str, int | None]]:
        """What is not finite in a callback: (component name, index) each."""
        derivative = {"objective": "constraints", "gradient": "jacobian"}.get(kind, kind)
        return [name for f in self._asked[kind] for name in f.culprits(derivative)]

    @callback
    def objective(self, z: np.ndarray) -> float:
        """f(z)."""
        return sum(float(f.code.value(f.arguments).sum()) for f in self._cost_families)

    @callback
    def gradient(self, z: np.ndarray) -> np.ndarray:
        """df/dz, shape (n,)."""
        g = np.zeros(self.n + 1)
        for f, columns in zip(self._cost_families, self._gradient_columns, strict=True):
            if f.code.jacobian:
                g += np.bincount(columns, f.code.jacobian(f.arguments).ravel(), minlength=self.n + 1)
        return g[: self.n]

    @callback
    def constraints(self, z: np.ndarray) -> np.ndarray:
        """g(z), shape (m,)."""
        return self.constraints_unchecked(z)

    def constraints_unchecked(self, z: np.ndarray) -> np.ndarray:
        """g(z), shape (m,), with NaN and infinity where it is not finite."""
        self.move(z)
        g = np.empty(self.m)
        for f in self._row_families:
            f.code.value(f.arguments, out=g[f.rows[0, 0] : f.rows[-1, -1] + 1])
        for f in self._sum_families:
            g[f.rows] += f.code.value(f.arguments).sum(axis=0)
        return g

    def jacobianstructure(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns of the nonzeros of dg/dz; those that stand twice (in rows with several sums) are added."""
        return _structure(self._jacobian)

    @callback
    def jacobian(self, z: np.ndarray) -> np.ndarray:
        """The nonzeros of dg/dz, in the order of jacobianstructure()."""
        return self._derivatives("jacobian", self._jacobian)

    def hessianstructure(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns (row >= column) of the nonzeros of the Hessian; those that stand twice are added."""
        return _structure(self._hessian)

    @callback
    def hessian(self, z: np.ndarray, y: np.ndarray, sigma: float) -> np.ndarray:
        """The nonzeros of d2(sigma f + y g)/dz2, in the order of hessianstructure(). y: (m,) multipliers."""
        weights = np.append(y, sigma)
        for f, _ in self._hessian:
            f.weights[:] = weights[f.rows]
        return self._derivatives("hessian", self._hessian)

    def lagrangian_terms(self, z: np.ndarray, y: np.ndarray) -> Iterator[tuple]:
        """The gradient of f + y g term by term: (Set, its indices (S,), columns (S, K), terms (S, K)) of each family.

        Term k of index s is a derivative by z[columns[s, k]], or by a fixed variable where columns[s, k] >= n. The
        Set is told by its name; it and the indices are None for what has no index (S = 1).
        """
        self.move(z)
        weights = np.append(y, 1.0)
        for f in self._families:
            if f.code.jacobian:
                o, j = f.code.jacobian_at.T
                raw = f.code.jacobian(f.arguments).reshape(len(f.arguments), -1)
                yield None if f.over is None else f.over.name, f.index, f.columns[:, j], raw * weights[f.rows[..., o]]

    def _derivatives(self, kind: str, pieces: list[tuple[CompiledFamily, Entries]]) -> np.ndarray:
        out, start = np.empty(sum(len(e.rows) for _, e in pieces)), 0
        for f, entries in pieces:
            stop = start + len(entries.rows)
            entries.evaluate(f.functions[kind], f.arguments, out[start:stop])
            start = stop
        return out


def _structure(pieces: list[tuple[CompiledFamily, Entries]]) -> tuple[np.ndarray, np.ndarray]:
    none = np.zeros(0, dtype=np.intp)
    entries = [own for _, own in pieces]
    return np.concatenate([none, *(e.rows for e in entries)]), np.concatenate([none, *(e.cols for e in entries)])
