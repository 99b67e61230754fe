"""Walks over the tree of an expression, for its first part without a value, and for the value of a constant.

What is computed again and again has a tape (see `tape`). Both do the same operations in the same order at every call,
so that every function is consistent in the sense of the paper, section 5.5.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from .functions import FUNCTIONS
from .slips import MAX_EXPONENT
from .smooth import STAND_INS
from .tree import Lookup, Name, Node, Number, Operation, OperatorChain

if TYPE_CHECKING:  # tables import SciPy
    from ..tables.table import Table


class Evaluated(Protocol):
    """What a walk needs of an expression, see `expression.Expression`."""

    @property
    def text(self) -> str: ...
    @property
    def root(self) -> Node: ...
    @property
    def parameters(self) -> Mapping[str, float]: ...
    @property
    def definitions(self) -> Mapping[str, Evaluated]: ...
    @property
    def static(self) -> frozenset[str]: ...
    @property
    def tables(self) -> Mapping[str, Table]: ...
    @property
    def leaves(self) -> tuple[Name, ...]: ...
    @property
    def constants(self) -> frozenset[str]: ...
    @property
    def steps(self) -> Mapping[str, tuple[Evaluated, str | None]]: ...
    def key(self, name: str, end: str | None) -> str: ...


class Fault(NamedTuple):
    """The innermost sub-expression without a finite value.

    text: the sub-expression. at: index into the array of values, 0 for scalars. values: each of its names -> its value
    there. why: one phrase, such as "divides by zero".
    """

    text: str
    at: int
    values: dict[str, float]
    why: str


def _power(base: Any, exponent: Any) -> Any:
    """base ** exponent; a whole exponent stays whole, so that x**2 is x*x and not exp(2 log x)."""
    if isinstance(exponent, float) and exponent.is_integer():
        exponent = int(exponent)
    return base**exponent


_ARITHMETIC: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "**": _power,
}


Work = Callable[[Any, Sequence[Any]], Any]
"""(functions, operands) -> value; functions as of `Expression.__call__`."""


def work_of(symbol: str, operands: int) -> Work:
    """What an operation does.

    symbol: of a function, of what stands in for one, or of arithmetic.
    operands: how many there are.
    """
    if symbol in FUNCTIONS:
        return FUNCTIONS[symbol].evaluate
    if symbol in STAND_INS:
        return STAND_INS[symbol]
    if operands == 1:
        return lambda _, values: -values[0]
    own = _ARITHMETIC[symbol]
    return lambda _, values: own(values[0], values[1])


class Walk:
    """One evaluation: `scope` grows by parameters and definitions as they are needed, over the values that are given.

    The values may be made when they are asked for, so only what stands in the expression is asked for.
    """

    def __init__(self, values: Mapping[str, Any], functions: Any, number: Any = float):
        self.values, self.functions, self.number = values, functions, number
        self.scope: dict[str, Any] = {}

    def evaluate(self, expression: Evaluated) -> Any:
        self.key, self.tables = expression.key, expression.tables
        numbers, given = expression.parameters, self.values
        self.scope = {n: given[n] if n in given else self.number(numbers[n]) for n in expression.constants}
        for key, (definition, end) in expression.steps.items():
            self.scope[key] = self.start(definition, end)
        return self.start(expression, None)

    def start(self, expression: Evaluated, end: str | None) -> Any:
        self.expression, self.end = expression, end
        return self.visit(expression.root)

    def visit(self, node: Node) -> Any:
        match node:
            case Number():
                return self.number(node.value)
            case Name():
                return self.lookup(node)
            case Operation(symbol=symbol, operands=operands):
                return self.apply(symbol, node, [self.visit(operand) for operand in operands])
            case Lookup(operands=operands):
                return self.look_up(node, [self.visit(operand) for operand in operands])
            case OperatorChain(first=first, links=links):
                result = self.visit(first)
                for link in links:
                    result = self.apply(link.symbol, link, [result, self.visit(link.operand)])
                return result
        raise TypeError(f"{type(node).__name__} is no node of an expression")

    def lookup(self, node: Name) -> Any:
        key = self.key(node.name, node.end or self.end)
        return self.scope[key] if key in self.scope else self.values[key]

    def apply(self, symbol: str, node: Node, operands: list[Any]) -> Any:
        """The value of an operation.

        symbol: of the operator or the name of the function.
        node: the operation.
        operands: their values, numbers or arrays of one shape.
        """
        return work_of(symbol, len(operands))(self.functions, operands)

    def look_up(self, node: Lookup, operands: list[Any]) -> Any:
        return self.tables[node.table].evaluate(self.functions, operands)


def first_fault(expression: Evaluated, values: Mapping[str, Any]) -> Fault | None:
    """The innermost sub-expression without a finite value, see `Expression.fault`."""
    walk = _Audit(values, np)
    try:
        with np.errstate(all="ignore"):
            walk.evaluate(expression)
    except _Found as found:
        return found.fault
    return None


class _Found(Exception):  # noqa: N818 - it ends a walk and is no error
    def __init__(self, fault: Fault):
        self.fault = fault


class _Audit(Walk):
    """An evaluation with NumPy that stops at the first value that is not finite; None stands for unknown."""

    def __init__(self, values: Mapping[str, Any], functions: Any):
        arrays = {name: np.asarray(value, float) for name, value in values.items()}
        super().__init__(arrays, functions, np.float64)
        self.constants_only = not values

    def lookup(self, node: Name) -> Any:
        value = self.known(self.key(node.name, node.end or self.end))
        if value is not None:
            self.refuse(node, ~np.isfinite(value), "is not finite")
        return value

    def apply(self, symbol: str, node: Node, operands: list[Any]) -> Any:
        """The value of an operation.

        symbol: of the operator or the name of the function.
        node: the operation.
        operands: their values, numbers or arrays of one shape.
        """
        second = operands[-1]
        if second is not None and symbol == "/":
            self.refuse(node, second == 0, "divides by zero")
        if second is not None and symbol == "**" and self.constants_only:
            self.refuse(node, np.abs(second) > MAX_EXPONENT, f"has an exponent larger than {MAX_EXPONENT}")
        if second is not None and symbol in FUNCTIONS and FUNCTIONS[symbol].width is not None:
            self.refuse(node, second <= 0, "has a width that is not positive")
        if symbol == "*" and any(operand is not None and not np.any(operand) for operand in operands):
            return np.float64(0.0)  # whatever the other one is
        if any(operand is None for operand in operands):
            return None
        result = super().apply(symbol, node, list(np.broadcast_arrays(*operands)))
        return self.finite(node, result)

    def look_up(self, node: Lookup, operands: list[Any]) -> Any:
        if node.table not in self.tables or any(operand is None for operand in operands):
            return None
        if self.constants_only:
            self.refuse(node, self.tables[node.table].outside(operands), f"is outside of the points of {node.table}")
        return self.finite(node, super().look_up(node, operands))

    def known(self, key: str) -> Any:
        return self.scope.get(key, self.values.get(key))

    def finite(self, node: Node, result: Any) -> Any:
        if isinstance(node, Operation) and node.symbol in FUNCTIONS:
            row = FUNCTIONS[node.symbol]
            self.refuse(node, np.isnan(result), row.not_a_number)
            self.refuse(node, np.isneginf(result), row.minus_infinity)
        self.refuse(node, np.isnan(result), "is not a real number")
        self.refuse(node, np.isinf(result), "is too large a number")
        return result

    def refuse(self, node: Node, bad: Any, why: str) -> None:
        """End the walk if any element is bad: report the first one."""
        if not np.any(bad):
            return
        index, values = int(np.argmax(bad)), {}
        for name in self.expression.leaves:
            key = self.key(name.name, name.end or self.end)
            if node.start <= name.start and name.stop <= node.stop and self.known(key) is not None:
                array = np.ravel(self.known(key))
                values[key] = float(array[index if len(array) > 1 else 0])
        raise _Found(Fault(self.expression.text[node.start : node.stop], index, values, why))
