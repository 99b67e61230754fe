"""Functions of vectors that a file calls and the language does not have: what to write in their place."""

from __future__ import annotations

from collections.abc import Iterable

from ..expressions.functions import FUNCTIONS as OF_VALUES
from ..expressions.lacking import ALIASES, LACKING
from ..text import did_you_mean
from .algebra import FUNCTIONS

_ROWS = "write its rows, as in [[1, 0], [0, 1]]"
_NO_SOLVE = "declare what A @ x = b determines under algebraic: with its size, and write A @ x - b under residuals:"
_MEANT = {
    **dict.fromkeys(["matmul", "mtimes", "mul", "multiply", "matvec", "mdot"], "write A @ x"),
    **dict.fromkeys(["inner", "vdot", "innerprod", "inner_product", "dotprod", "scalar_product"], "write dot(a, b)"),
    **dict.fromkeys(["vecnorm", "norm2", "norm_2", "magnitude", "length", "mag"], "write norm(a)"),
    **dict.fromkeys(["normalize", "normalise", "unit"], "write a/norm(a)"),
    **dict.fromkeys(["sumsqr", "sum_square", "norm_sq"], "write dot(a, a)"),
    **dict.fromkeys(["mean", "average"], "write sum(a)/3 for a vector of 3"),
    **dict.fromkeys(["quat_inv", "quat_inverse", "quatinv", "quatconj", "conj"], "write quat_conj(q), q of length 1"),
    **dict.fromkeys(["quat_rot", "quatrotate", "quat_apply", "qrot", "rotate_vector"], "write rotate(q, v)"),
    **dict.fromkeys(["quatmultiply", "qmul", "quat_prod", "quat_product", "hamilton"], "write quat_mul(p, q)"),
    **dict.fromkeys(["inv", "inverse", "solve", "linsolve", "pinv", "det"], _NO_SOLVE),
    **dict.fromkeys(["skew", "hat", "wedge"], "write cross(a, b) for hat(a) @ b"),
    **dict.fromkeys(["vertcat", "horzcat", "concat", "concatenate", "hstack", "vstack"], "write [a[1], a[2], b]"),
    **dict.fromkeys(["eye", "identity", "zeros", "ones", "diag", "outer", "kron"], _ROWS),
}
"""Names of functions that exist elsewhere -> the remedy."""

_SMOOTHED = ("min", "max", "abs")


def unknown_function(name: str, called: Iterable[str]) -> tuple[str, str] | None:
    """What is said of a function that is given vectors, and the remedy; None for one that there is.

    name: as it is called.
    called: the names that have arguments in the file.
    """
    if name in OF_VALUES or name in _SMOOTHED or name in called or name in FUNCTIONS:
        return None
    known = [*FUNCTIONS, *OF_VALUES, *_SMOOTHED, *called]
    if name in ALIASES or name in LACKING:
        return None  # of which the reader of expressions knows more
    others = f"those of vectors are {' '.join(FUNCTIONS)}; others, such as sin, go component by component"
    return f"there is no function {name}", _MEANT.get(name) or did_you_mean(name, known, others)
