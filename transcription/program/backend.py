"""SymEngine's compiler: LLVM where there is one, else its interpreter."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from functools import cache
from typing import Any

import symengine as se

LOG = logging.getLogger(__name__)
# SymEngine eliminates common subexpressions before LLVM sees them. After that its optimizer costs more than it gains:
# the biped compiles in 0.23 s instead of 0.06 s, to evaluate 1.3 times as fast what is 3 % of a solve.
OPT_LEVEL = 0

LLVM = "llvm"


NO_VALUE = {se.zoo: se.nan}
"""What SymEngine makes of a division by zero, which LLVM does not take -> what it gives when it is evaluated."""


@cache
def available_backend() -> str:
    """ "llvm" where SymEngine was built with it, else "lambda", its interpreter: slower, the same numbers."""
    if not se.have_llvm:
        LOG.warning("this SymEngine has no LLVM: derivatives are interpreted, which is slower but as exact")
        return "lambda"
    return LLVM


def lambdify(
    inputs: Sequence[se.Symbol], expressions: Sequence[se.Basic], backend: str, opt_level: int = OPT_LEVEL
) -> Any:
    """Compiled code of expressions, called with rows of inputs.

    inputs: the symbols, in the order of a row.
    expressions: at least one.
    backend: "llvm" or "lambda", of SymEngine's Lambdify.
    opt_level: how hard LLVM tries, from 0 to 3.
    """
    options = {"backend": backend, "cse": True, **({"opt_level": opt_level} if backend == LLVM else {})}
    try:
        return se.Lambdify(inputs, expressions, **options)
    except RuntimeError:
        return se.Lambdify(inputs, [own.xreplace(NO_VALUE) for own in expressions], **options)


def told_apart(expressions: Sequence[se.Basic]) -> list[str]:
    """A text for each expression, the same in all processes; equal texts are of equal expressions.

    SymEngine writes floats to 15 digits, and its pickles have addresses of memory in them; so each float is replaced by
    a symbol whose name has all of its bits.

    expressions: in symbols whose names are letters, digits and underscores, none of them with a dot.
    """
    return [str(own.xreplace({x: se.Symbol(float(x).hex()) for x in own.atoms(se.Float)})) for own in expressions]
