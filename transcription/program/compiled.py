"""A nonlinear program whose functions are compiled families: its callbacks, and other numbers in its data.

What it is made of has names only, and nothing of Pyomo, so that it can be kept and read again without it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from typing import Any

import numpy as np

from .contract import callback
from .family import CompiledFamily, Entries


class CompiledNLP:
    """The nonlinear program of compiled families.

    n, m: numbers of variables and rows. cl, cu: (m,) bounds of the rows, +-inf where there is none.
    seconds: differentiate (Pyomo to SymEngine included), compile, evaluate.
    slots: key -> where a number stands that is data, for `number` and `with_numbers`.
    Callbacks raise NotFinite.
    """

    def __init__(
        self,
        n: int,
        families: Sequence[Sequence[CompiledFamily]],
        bounds: np.ndarray,
        rows: Mapping[str, np.ndarray],
        data: Sequence[float],
        slots: Mapping[Any, int],
        seconds: dict[str, float],
    ) -> None:
        """A program of its parts.

        n: number of variables.
        families: those of rows, those whose values are added to rows, and those of the objective.
        bounds: (2, m) of the rows.
        rows: name of each component -> its row numbers, in the order of its index set.
        data: the numbers of all slots behind those of the variables.
        slots, seconds: as above.
        """
        self._row_families, self._sum_families, self._cost_families = map(list, families)
        self.n, self.m, (self.cl, self.cu) = n, bounds.shape[1], bounds
        self._rows, self.slots, self.seconds = rows, slots, seconds
        self._numbers = np.concatenate([np.full(n, np.nan), data])
        self._prepare()

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
        """The row numbers of a component, in the order of its index set.

        component: its name, or what has that as `name`.
        """
        return self._rows[getattr(component, "name", component)]

    def row_name(self, row: int) -> tuple[str, int | None]:
        """(component name, index or None) of a row."""
        family = next(f for f in self._row_families if f.rows[0, 0] <= row <= f.rows[-1, -1])
        s, o = divmod(row - family.rows[0, 0], len(family.components))
        return family.components[o], None if family.index is None else int(family.index[s])

    def move(self, z: np.ndarray) -> None:
        """Read z into the arguments of every family, unless it is there already."""
        if (z == self._numbers[: self.n]).all():
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
        """The nonzeros of d2(sigma f + y g)/dz2, in the order of hessianstructure().

        z: (n,) unknowns.
        y: (m,) multipliers of g.
        sigma: of f.
        """
        weights = np.concatenate([y, [sigma]])
        for f, _ in self._hessian:
            f.weights[:] = weights.take(f.rows)
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
                yield f.over, f.index, f.columns[:, j], raw * weights[f.rows[..., o]]

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
