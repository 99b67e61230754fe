"""SymEngine expressions -> machine code of the values and of their first and second derivatives."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import contextmanager
from functools import partial
from typing import Any

import numpy as np
import symengine as se

from ...problems.lean.records import dataclass
from ..cache.kept import made
from .backend import LLVM, OPT_LEVEL, lambdify, told_apart
from .lookups import ChainRule, CompiledLookup, in_order, levels

CODE_LIMIT = 256  # compiled families kept for the next mesh

_code: dict[tuple, Code] = {}
_values: dict[tuple, Callable] = {}


@dataclass(frozen=True)
class Code:
    """Machine code of y = F(v, d) and of its derivatives, each called with rows of arguments (v, d, t, w).

    t: what is looked up in tables of data, see lookups.py; `passes` is the code of the arguments of each level of them.

    value: the outputs. jacobian: dy[o]/dv[j] for (o, j) in `jacobian_at`. hessian: the second derivatives of
    sum_o w[o] y[o] by v[i] and v[j], i >= j, for (i, j) in `hessian_at`. Zeros are left out; None if all are zero.
    degree: 1 if the outputs are linear in v, 2 if they are quadratic, 3 for all others.
    """

    outputs: tuple[se.Basic, ...]
    value: Callable
    jacobian: Callable | None
    hessian: Callable | None
    jacobian_at: np.ndarray
    hessian_at: np.ndarray
    passes: tuple[Callable, ...]
    degree: int


def compile_family(
    outputs: Sequence[se.Basic],
    n_variables: int,
    n_data: int,
    backend: str,
    seconds: dict,
    lookups: Sequence[CompiledLookup] = (),
) -> Code:
    """Differentiate and compile, or take from memory or from the cache what was compiled before.

    outputs: y in the symbols v0, v1, ... (variables) and d0, d1, ... (data).
    n_variables, n_data: the numbers of these symbols, used or not.
    backend: "llvm" or "lambda", of SymEngine's Lambdify.
    seconds: the time taken is added to its "differentiate" and "compile"; nothing for what was in memory.
    lookups: of tables of data, whose symbols may stand in the outputs and in the arguments of later ones; the code is
        the same for all tables of as many arguments.
    """
    key = (
        tuple(outputs),
        n_variables,
        n_data,
        backend,
        tuple((own.number, own.arguments) for own in in_order(lookups)),
    )
    if key not in _code:
        if len(_code) >= CODE_LIMIT:
            _code.pop(next(iter(_code)))
        _code[key] = _made(key, partial(_compile, *key[:4], seconds, lookups))
    return _code[key]


def compile_values(outputs: Sequence[se.Basic], n_variables: int, n_data: int, backend: str) -> Callable:
    """Machine code of the outputs alone, without derivatives.

    outputs, n_variables, n_data, backend: as `compile_family` takes them.
    """
    key = (tuple(outputs), n_variables, n_data, backend)
    if key not in _values:
        if len(_values) >= CODE_LIMIT:
            _values.pop(next(iter(_values)))
        _values[key] = _made(key, partial(_compile_values, *key))
    return _values[key]


def _made(key: tuple, make: Callable[[], Any]) -> Any:
    """What has this key, from the cache or made: only SymEngine's machine code can be kept there."""
    outputs, n_variables, n_data, backend, *lookups = key
    if backend != LLVM:
        return make()
    arguments = [(number, told_apart(own)) for number, own in (lookups[0] if lookups else ())]
    return made(
        "values" if not lookups else "family", (told_apart(outputs), n_variables, n_data, arguments, OPT_LEVEL), make
    )


def _compile_values(outputs: Sequence[se.Basic], n_variables: int, n_data: int, backend: str) -> Callable:
    v, d, w = _symbols(n_variables, n_data, len(outputs))
    return lambdify(v + d + w, list(outputs), backend)


def _symbols(*numbers: int) -> list[list[se.Symbol]]:
    """Variables, data and weights, as many as asked for."""
    return [[se.Symbol(f"{x}{i}") for i in range(k)] for x, k in zip("vdw", numbers, strict=True)]


def _compile(
    outputs: Any,
    n_variables: int,
    n_data: int,
    backend: str,
    seconds: dict[str, float],
    lookups: Sequence[CompiledLookup],
) -> Code:
    with timing(seconds, "differentiate"):
        v, d, w = _symbols(n_variables, n_data, len(outputs))
        t = [symbol for own in in_order(lookups) for symbol in own.symbols]
        chain = ChainRule({symbol: j for j, symbol in enumerate(v)}, lookups)
        jacobian = [(o, j, e) for o, y in enumerate(outputs) for j, e in chain.derivatives(y)]
        gradient: dict[int, se.Basic] = {}
        for o, j, e in jacobian:
            gradient[j] = gradient.get(j, 0) + w[o] * e
        hessian = [(i, j, e) for i, g in sorted(gradient.items()) for j, e in chain.derivatives(g) if j <= i]
    with timing(seconds, "compile"):
        inputs, asked = v + d + t + w, (list(outputs), [e for *_, e in jacobian], [e for *_, e in hessian])
        value, d_value, d2_value = (lambdify(inputs, own, backend) if own else None for own in asked)
        asked_of = ([a for group in groups for own in group for a in own.arguments] for groups in levels(lookups))
        passes = [lambdify(inputs, own, backend) for own in asked_of]
    first, second = (np.array([t[:2] for t in e], dtype=np.intp).reshape(-1, 2) for e in (jacobian, hessian))
    assert value is not None  # a family has outputs
    degree = 1 if not hessian else 2 if all(_is_constant(e) for *_, e in hessian) else 3
    return Code(tuple(outputs), value, d_value, d2_value, first, second, tuple(passes), degree)


def _is_constant(derivative: se.Basic) -> bool:
    """Whether neither variables nor what is looked up stand in a derivative: data and weights do not count."""
    return all(str(symbol)[0] in "dw" for symbol in derivative.free_symbols)


@contextmanager
def timing(seconds: dict, part: str) -> Any:
    start = time.perf_counter()
    try:
        yield
    finally:
        seconds[part] += time.perf_counter() - start
