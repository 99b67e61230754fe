"""One constraint family, evaluated for all of its indices at once, and where its derivatives go."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from typing import TYPE_CHECKING, Any

import numpy as np

from .contract import cross_factor
from .lookups import Filled
from .machine_code import Code, compile_family

if TYPE_CHECKING:  # Pyomo
    from .symbolic import Arguments


class Entries:
    """Where the derivatives of one family go: `rows` and `cols` of its nonzeros, as triplets without duplicates.

    Raw derivatives by a fixed variable (`free` is false) are dropped, and those at one place are added.
    """

    def __init__(
        self, rows: np.ndarray, cols: np.ndarray, free: np.ndarray, n: int, factor: np.ndarray | None = None
    ) -> None:
        self.rows, self.cols, self._factor, self._places = rows.ravel(), cols.ravel(), factor, None
        key = np.where(free, rows * n + cols, -1).ravel()
        distinct, places = np.unique(key, return_inverse=True)
        if len(distinct) < len(key) or (key < 0).any():
            self._places, self._dropped = places, int(distinct[0] < 0)
            self.rows, self.cols = np.divmod(distinct[self._dropped :], n)

    def evaluate(self, function: Callable | None, arguments: np.ndarray, out: np.ndarray) -> None:
        """Write the derivatives into an array.

        function: machine code of them; None if there are none.
        arguments: (S, a) rows of what the function takes.
        out: (len(rows),) gets them.
        """
        if function is None:
            return
        if self._places is None and self._factor is None:
            function(arguments, out=out)
            return
        raw = function(arguments)
        if self._factor is not None:
            raw *= self._factor
        out[:] = raw.ravel() if self._places is None else np.bincount(self._places, raw.ravel())[self._dropped :]


class CompiledFamily:
    """Outputs y[s, o] for every index value s of the Set named `over` (None: one value without an index).

    components: names of the O components that the outputs belong to. rows: (S, O) row of each value; or (O,) if the
    values of one output are added up into one row.
    """

    def __init__(
        self, components: list[str], over: str | None, arguments: Arguments, rows: np.ndarray, code: Code, backend: str
    ) -> None:
        self.components, self.over, self.rows, self.code = components, over, rows, code
        self.index = None if over is None else arguments.values
        size = len(arguments.values)
        self.columns = np.array(arguments.variable_slots, dtype=np.intp).reshape(-1, size).T.copy()
        self.data_slots = np.array(arguments.data_slots, dtype=np.intp).reshape(-1, size).T
        given = self.columns.shape[1] + self.data_slots.shape[1]
        self.lookups = arguments.lookups
        looked_up = sum(len(own.symbols) for own in self.lookups)
        self.tables = Filled(self.lookups, code.passes, given, backend)
        self.arguments = np.zeros((size, given + looked_up + len(components)))
        self._view()
        self.functions = {"constraints": code.value, "jacobian": code.jacobian, "hessian": code.hessian}

    def __getstate__(self) -> dict[str, Any]:
        """Without the arguments, of which parts are views: whoever reads it gives them their numbers."""
        views = "arguments", "variables", "weights"
        kept = {name: own for name, own in vars(self).items() if name not in views}
        return {**kept, "shape": self.arguments.shape}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.arguments = np.zeros(state.pop("shape"))
        vars(self).update(state)
        self._view()

    def _view(self) -> None:
        self.variables = self.arguments[:, : self.columns.shape[1]]
        self.weights = self.arguments[:, -len(self.components) :]

    def with_data(self, numbers: np.ndarray) -> CompiledFamily:
        """The same family with arguments of its own, whose data are read from `numbers`."""
        other = copy(self)
        other.arguments = self.arguments.copy()
        other._view()
        other.set_data(numbers)
        return other

    def set_data(self, numbers: np.ndarray) -> None:
        """Read the data of every index from the vector of all numbers."""
        k = self.columns.shape[1]
        self.arguments[:, k : k + self.data_slots.shape[1]] = numbers[self.data_slots]

    def move(self, numbers: np.ndarray) -> None:
        """Take the variables from z and what stands behind it, shape (slots,), and look up what depends on them."""
        self.variables[:] = numbers.take(self.columns)
        self.tables.fill(self.arguments)

    def jacobian_entries(self, n: int) -> Entries:
        o, j = self.code.jacobian_at.T
        cols = self.columns[:, j]
        return Entries(np.broadcast_to(self.rows[..., o], cols.shape), cols, cols < n, n)

    def hessian_entries(self, n: int) -> Entries:
        i, j = self.code.hessian_at.T
        a, b = self.columns[:, i], self.columns[:, j]
        factor = cross_factor(a, b, i != j)
        rows, cols = np.maximum(a, b), np.minimum(a, b)
        return Entries(rows, cols, rows < n, n, factor if (factor > 1).any() else None)

    def culprits(self, kind: str) -> list[tuple[str, int | None]]:
        """(component name, index) of what is not finite at the present arguments."""
        pairs = self._not_finite(kind)
        return [(self.components[o], None if self.index is None else int(self.index[s])) for s, o in pairs]

    def _not_finite(self, kind: str) -> list[tuple[int, int]]:
        function = self.functions[kind]
        if function is None:
            return []
        s, entry = np.nonzero(~np.isfinite(function(self.arguments).reshape(len(self.arguments), -1)))
        if kind == "constraints":
            return list(zip(s, entry, strict=True))
        if kind == "jacobian":
            return sorted(set(zip(s, self.code.jacobian_at[entry, 0], strict=True)))
        return sorted((k, o) for o in range(len(self.components)) for k in self._bad_hessians(o))

    def _bad_hessians(self, o: int) -> set[int]:
        """The s where output o alone has a Hessian that is not finite; the compiled one is a sum over the outputs."""
        last = self.arguments.shape[1] - len(self.components)
        n, m, seconds = self.columns.shape[1], self.data_slots.shape[1], {"differentiate": 0.0, "compile": 0.0}
        one = compile_family([self.code.outputs[o]], n, m, "lambda", seconds, self.lookups)
        if one.hessian is None:
            return set()
        arguments = np.column_stack([self.arguments[:, :last], np.ones(len(self.arguments))])
        return set(np.nonzero(~np.isfinite(one.hessian(arguments).reshape(len(arguments), -1)))[0])
