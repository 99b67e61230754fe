"""What engines ask of a nonlinear program, whoever makes it.

minimise f(z)   subject to   cl <= g(z) <= cu
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import wraps
from math import isfinite
from typing import Any, Protocol

import numpy as np


class NotFinite(ArithmeticError):  # noqa: N818  (a state of the iterate, not a mistake)
    """A function or derivative is NaN or infinite at this z.

    kind: the callback. names: the culprits, a list of (component name, index or None).
    """

    def __init__(self, kind: str, names: list[tuple[str, int | None]]) -> None:
        self.kind, self.names = kind, names
        shown = ", ".join(name if index is None else f"{name}[{index}]" for name, index in names[:3])
        super().__init__(f"{kind}: not finite in {shown}" + (f" and {len(names) - 3} more" if names[3:] else ""))


class NonlinearProgram(Protocol):
    """n, m: numbers of variables and rows. cl, cu: (m,) bounds of the rows, +-inf where there is none.

    seconds: by part: differentiate, compile, evaluate. All callbacks but `constraints_unchecked` raise NotFinite.
    """

    n: int
    m: int
    cl: np.ndarray
    cu: np.ndarray
    seconds: dict[str, float]

    def rows(self, component: Any) -> np.ndarray:
        """The row numbers of the component of a `layout.Family`, in the order of its index."""
        ...

    def row_name(self, row: int) -> tuple[str, int | None]:
        """(component name, index or None) of a row."""
        ...

    def objective(self, z: np.ndarray) -> float:
        """f(z)."""
        ...

    def gradient(self, z: np.ndarray) -> np.ndarray:
        """df/dz, shape (n,)."""
        ...

    def constraints(self, z: np.ndarray) -> np.ndarray:
        """g(z), shape (m,)."""
        ...

    def constraints_unchecked(self, z: np.ndarray) -> np.ndarray:
        """g(z), shape (m,), with NaN and infinity where it is not finite."""
        ...

    def jacobianstructure(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns of the nonzeros of dg/dz; those that stand twice are added."""
        ...

    def jacobian(self, z: np.ndarray) -> np.ndarray:
        """The nonzeros of dg/dz, in the order of jacobianstructure()."""
        ...

    def hessianstructure(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns (row >= column) of the nonzeros of the Hessian; those that stand twice are added."""
        ...

    def hessian(self, z: np.ndarray, y: np.ndarray, sigma: float) -> np.ndarray:
        """The nonzeros of d2(sigma f + y g)/dz2, in the order of hessianstructure().

        z: (n,) unknowns.
        y: (m,) multipliers of g.
        sigma: of f.
        """
        ...


class ObjectiveTerm(Protocol):
    """A part of an objective: its values and derivatives at z, shape (n,).

    structure: rows and columns (row >= column) of the nonzeros of its Hessian; those that stand twice are added.
    """

    @property
    def structure(self) -> tuple[np.ndarray, np.ndarray]: ...

    def objective(self, z: np.ndarray) -> float: ...

    def gradient(self, z: np.ndarray) -> np.ndarray: ...

    def hessian(self, z: np.ndarray) -> np.ndarray: ...


class WithTerm:
    """The callbacks, numbers and names of a program, with one term more in its objective: f(z) + term(z).

    What it does not say itself the program says: rows, constraints and their derivatives, what costates are made of.
    """

    def __init__(self, nlp: NonlinearProgram, term: ObjectiveTerm) -> None:
        self.nlp, self.term = nlp, term

    def __getattr__(self, name: str) -> Any:
        if name == "nlp" or name.startswith("__"):  # asked for before it is there, as by `copy`
            raise AttributeError(name)
        return getattr(self.nlp, name)

    def objective(self, z: np.ndarray) -> float:
        """f(z)."""
        return self.nlp.objective(z) + self.term.objective(z)

    def gradient(self, z: np.ndarray) -> np.ndarray:
        """df/dz, shape (n,)."""
        return self.nlp.gradient(z) + self.term.gradient(z)

    def hessianstructure(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns (row >= column) of the nonzeros of the Hessian; those that stand twice are added."""
        (rows, columns), (more_rows, more_columns) = self.nlp.hessianstructure(), self.term.structure
        return np.append(rows, more_rows), np.append(columns, more_columns)

    def hessian(self, z: np.ndarray, y: np.ndarray, sigma: float) -> np.ndarray:
        """The nonzeros of d2(sigma f + y g)/dz2, in the order of hessianstructure().

        z: (n,) unknowns.
        y: (m,) multipliers of g.
        sigma: of f.
        """
        return np.concatenate([self.nlp.hessian(z, y, sigma), sigma * self.term.hessian(z)])


def _finite(values: Any) -> bool:
    """Whether a number, or all of an array, are finite: so is the sum of their squares, but for an overflow."""
    return isfinite(np.dot(values, values)) or bool(np.isfinite(values).all())


def callback(method: Callable) -> Callable:
    """A function of z of a nonlinear program: its class has `move` to z, and `culprits` of what is not finite."""
    name = method.__name__

    @wraps(method)
    def call(self: Any, z: np.ndarray, *args: Any) -> Any:
        start = time.perf_counter()
        try:
            with np.errstate(all="ignore"):  # what is not finite is raised
                self.move(z)
                values = method(self, z, *args)
                finite = _finite(values)
            if not finite:
                raise NotFinite(name, self.culprits(name, values))
            return values
        finally:
            self.seconds["evaluate"] += time.perf_counter() - start

    return call


def cross_factor(a: np.ndarray, b: np.ndarray, different: np.ndarray) -> np.ndarray:
    """What a second derivative by two arguments counts, shape that of a and b.

    a, b: the column of the unknown that each of the two arguments reads.
    different: whether these are two arguments, not one twice; broadcast against a and b.

    Two different arguments may read one unknown: then the cross derivative counts for (a, b) and for (b, a).
    """
    return np.where((a == b) & different, 2.0, 1.0)
