"""Functions of the values at one point, in machine code with first and second derivatives, for many points at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy

import numpy as np
import symengine as se

from .backend import available_backend
from .lookups import CompiledLookup, Filled
from .machine_code import Code, compile_family, compile_values, timing


class PointFunctions:
    """y = F(v, d), v: variables and d: data, by name.

    functions: each called with the values by name and Pyomo's functions, as `problems.problem.Function`.
    numbers: data that are the same at all points, name -> value: the code is compiled once for all values of them.
    Arrays of arguments have the variables first, then the data: shape (..., n_v + n_d), without the numbers.
    """

    def __init__(
        self,
        functions: Sequence[Callable],
        variables: Sequence[str],
        data: Sequence[str],
        seconds: dict,
        numbers: Mapping[str, float] | None = None,
    ) -> None:
        self.names, self.size = (*variables, *data), len(variables)
        self.given, self.numbers = tuple(numbers or ()), np.array([*(numbers or {}).values()], float)
        data = (*data, *self.given)
        with timing(seconds, "differentiate"):
            outputs, lookups = _translate(functions, variables, data)
        self.outputs = len(outputs)
        self.code: Code | None = None
        self.looked_up = sum(len(own.symbols) for own in lookups)
        if outputs:
            backend = available_backend()
            self.code = compile_family(outputs, len(variables), len(data), backend, seconds, lookups)
            self.tables = Filled(lookups, self.code.passes, len(self.names) + len(self.numbers), backend)

    def with_number(self, name: str, value: float) -> PointFunctions:
        """The same functions with another number of that name."""
        other = copy(self)
        other.numbers = np.where([own == name for own in self.given], value, self.numbers)
        return other

    def values(self, arguments: np.ndarray) -> np.ndarray:
        """y, shape (..., n_y)."""
        if not self.code:
            return np.zeros((*arguments.shape[:-1], 0))
        return self._call(self.code.value, arguments)

    def jacobian(self, arguments: np.ndarray) -> np.ndarray:
        """dy/dv, shape (..., n_y, n_v)."""
        out = np.zeros((*arguments.shape[:-1], self.outputs, self.size))
        if self.code and self.code.jacobian:
            o, j = self.code.jacobian_at.T
            out[..., o, j] = self._call(self.code.jacobian, arguments)
        return out

    def hessian(self, arguments: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """The second derivatives of weights . y, with weights (..., n_y): shape (..., n_v, n_v)."""
        out = np.zeros((*arguments.shape[:-1], self.size, self.size))
        if self.code and self.code.hessian:
            i, j = self.code.hessian_at.T
            out[..., i, j] = out[..., j, i] = self._call(self.code.hessian, arguments, weights)
        return out

    def _call(self, function: Callable, arguments: np.ndarray, weights: np.ndarray | None = None) -> np.ndarray:
        """One call for all points; the compiled functions take the weights as their last arguments, used or not."""
        own, numbers = arguments.shape[-1], len(self.numbers)
        given = own + numbers + self.looked_up
        full = np.zeros((*arguments.shape[:-1], given + self.outputs))
        full[..., :own], full[..., own : own + numbers] = arguments, self.numbers
        if weights is not None:
            full[..., given:] = weights
        flat = full.reshape(-1, full.shape[-1])
        self.tables.fill(flat)
        return function(flat).reshape(*arguments.shape[:-1], -1)


def compiled_values(functions: Sequence[Callable], variables: Sequence[str], data: Sequence[str]) -> Callable:
    """The functions' values alone, (n_f,), as one function of a row of arguments: variables, data, then a number for
    each function that is not used.

    functions: as `PointFunctions` takes them.
    variables: names.
    data: names.
    """
    outputs, lookups = _translate(functions, variables, data)
    if not lookups:
        return compile_values(outputs, len(variables), len(data), available_backend())
    full = PointFunctions(functions, variables, data, {"differentiate": 0.0, "compile": 0.0})
    return lambda row: full.values(row[: -len(outputs)])


def _translate(
    functions: Sequence[Callable], variables: Sequence[str], data: Sequence[str]
) -> tuple[list[se.Basic], list[CompiledLookup]]:
    """The functions in the symbols v0, v1, ... and d0, d1, ... that `compile_family` takes, and what they look up."""
    from ..libraries.pyomo import pyomo  # only here: what is compiled already needs no Pyomo
    from .slots import Slots
    from .symbolic import Arguments

    model = pyomo.ConcreteModel()
    model.variable = pyomo.Var(range(len(variables)))
    model.data = pyomo.Var(range(len(data)), initialize=0.0)
    model.data.fix()
    leaves: Mapping = dict(zip((*variables, *data), (*model.variable.values(), *model.data.values()), strict=True))
    arguments = Arguments(Slots(list(model.variable.values())), np.zeros(1, int))
    for leaf in leaves.values():  # symbols are numbered in the order of first use
        arguments.leaf(leaf, None)
    outputs = [se.sympify(arguments.translate(function(leaves, pyomo), None)) for function in functions]
    return outputs, arguments.lookups
