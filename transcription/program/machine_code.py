"""SymEngine expressions -> machine code of the values and of their first and second derivatives."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import symengine as se

LOG = logging.getLogger(__name__)
# SymEngine eliminates common subexpressions before LLVM sees them. After that its optimizer costs more than it gains:
# the biped compiles in 0.23 s instead of 0.06 s, to evaluate 1.3 times as fast what is 3 % of a solve.
OPT_LEVEL = 0
CODE_LIMIT = 256  # compiled families kept for the next mesh

_code: dict[tuple, Code] = {}
_values: dict[tuple, Callable] = {}


@cache
def available_backend() -> str:
    """ "llvm" where SymEngine was built with it, else "lambda", its interpreter: slower, the same numbers."""
    x = se.Symbol("x")
    try:
        se.Lambdify([x], [x], backend="llvm")
    except (ValueError, RuntimeError):
        LOG.warning("this SymEngine has no LLVM: derivatives are interpreted, which is slower but as exact")
        return "lambda"
    return "llvm"


@dataclass(frozen=True)
class Code:
    """Machine code of y = F(v, d) and of its derivatives, each called with rows of arguments (v, d, w).

    value: the outputs. jacobian: dy[o]/dv[j] for (o, j) in `jacobian_at`. hessian: the second derivatives of
    sum_o w[o] y[o] by v[i] and v[j], i >= j, for (i, j) in `hessian_at`. Zeros are left out; None if all are zero.
    """

    outputs: tuple[se.Basic, ...]
    value: Callable
    jacobian: Callable | None
    hessian: Callable | None
    jacobian_at: np.ndarray
    hessian_at: np.ndarray


def compile_family(outputs: Sequence[se.Basic], n_variables: int, n_data: int, backend: str, seconds: dict) -> Code:
    """Differentiate and compile, or take from memory what was compiled before.

    outputs: y in the symbols v0, v1, ... (variables) and d0, d1, ... (data).
    n_variables, n_data: the numbers of these symbols, used or not.
    backend: "llvm" or "lambda", of SymEngine's Lambdify.
    seconds: the time taken is added to its "differentiate" and "compile"; nothing for what was in memory.
    """
    key = (tuple(outputs), n_variables, n_data, backend)
    if key not in _code:
        if len(_code) >= CODE_LIMIT:
            _code.pop(next(iter(_code)))
        _code[key] = _compile(outputs, n_variables, n_data, backend, seconds)
    return _code[key]


def compile_values(outputs: Sequence[se.Basic], n_variables: int, n_data: int, backend: str) -> Callable:
    """Machine code of the outputs alone, without derivatives.

    outputs, n_variables, n_data, backend: as `compile_family` takes them.
    """
    key = (tuple(outputs), n_variables, n_data, backend)
    if key not in _values:
        if len(_values) >= CODE_LIMIT:
            _values.pop(next(iter(_values)))
        v, d, w = _symbols(n_variables, n_data, len(outputs))
        _values[key] = se.Lambdify(v + d + w, list(outputs), **_options(backend))
    return _values[key]


def _symbols(*numbers: int) -> list[list[se.Symbol]]:
    """Variables, data and weights, as many as asked for."""
    return [[se.Symbol(f"{x}{i}") for i in range(k)] for x, k in zip("vdw", numbers, strict=True)]


def _options(backend: str) -> dict[str, Any]:
    return {"backend": backend, "cse": True, **({"opt_level": OPT_LEVEL} if backend == "llvm" else {})}


def _compile(outputs: Any, n_variables: int, n_data: int, backend: str, seconds: dict[str, float]) -> Code:
    with timing(seconds, "differentiate"):
        v, d, w = _symbols(n_variables, n_data, len(outputs))
        place = {symbol: j for j, symbol in enumerate(v)}
        jacobian = [(o, j, e) for o, y in enumerate(outputs) for j, e in _derivatives(y, place)]
        gradient: dict[int, se.Basic] = {}
        for o, j, e in jacobian:
            gradient[j] = gradient.get(j, 0) + w[o] * e
        hessian = [(i, j, e) for i, g in sorted(gradient.items()) for j, e in _derivatives(g, place) if j <= i]
    with timing(seconds, "compile"):

        def function(expressions: list) -> Any:
            return se.Lambdify(v + d + w, expressions, **_options(backend)) if expressions else None

        functions = [function(e) for e in (list(outputs), [e for *_, e in jacobian], [e for *_, e in hessian])]
    first, second = (np.array([t[:2] for t in e], dtype=np.intp).reshape(-1, 2) for e in (jacobian, hessian))
    value, d_value, d2_value = functions
    return Code(tuple(outputs), value, d_value, d2_value, first, second)


def _derivatives(y: se.Basic, place: dict) -> list[tuple[int, se.Basic]]:
    present = sorted(place[s] for s in y.free_symbols if s in place)
    symbols = {j: s for s, j in place.items()}
    return [(j, e) for j in present if (e := y.diff(symbols[j])) != 0]


@contextmanager
def timing(seconds: dict, part: str) -> Any:
    start = time.perf_counter()
    try:
        yield
    finally:
        seconds[part] += time.perf_counter() - start
