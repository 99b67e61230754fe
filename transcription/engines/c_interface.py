"""IPOPT by its C interface: vectors and nonzeros are copied whole, where cyipopt makes an object of each nonzero.

The signatures are those of IpStdCInterface.h of IPOPT 3.14. The interpreter's lock is held during a solve, as MUMPS is
not made for several threads.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from ctypes import CFUNCTYPE, POINTER, c_bool, c_char_p, c_double, c_int, c_void_p
from typing import Any, NamedTuple

import numpy as np

from ..program.contract import NonlinearProgram, NotFinite
from .outcome import COLUMNS

FUNCTIONS: Mapping[str, tuple[Any, Sequence[Any]]] = {
    "CreateIpoptProblem": (c_void_p, (*[c_int, c_void_p, c_void_p] * 2, *[c_int] * 3, *[c_void_p] * 5)),
    "FreeIpoptProblem": (None, (c_void_p,)),
    "AddIpoptStrOption": (c_bool, (c_void_p, c_char_p, c_char_p)),
    "AddIpoptNumOption": (c_bool, (c_void_p, c_char_p, c_double)),
    "AddIpoptIntOption": (c_bool, (c_void_p, c_char_p, c_int)),
    "SetIpoptProblemScaling": (c_bool, (c_void_p, c_double, c_void_p, c_void_p)),
    "SetIntermediateCallback": (c_bool, (c_void_p, c_void_p)),
    "IpoptSolve": (c_int, (*[c_void_p] * 3, POINTER(c_double), *[c_void_p] * 4)),
}
"""Name -> what it gives and takes. Truths that callbacks give are whole numbers: IPOPT reads one byte of them."""

_AT = c_int, c_void_p, c_bool
"""Of each callback: n, z, and whether z is new."""
_MATRIX = c_int, *[c_void_p] * 4
"""Of a sparse one: the number of its nonzeros, rows, columns, values, and what a user gives."""
_OBJECTIVE = CFUNCTYPE(c_int, *_AT, c_void_p, c_void_p)
_CONSTRAINTS = CFUNCTYPE(c_int, *_AT, c_int, c_void_p, c_void_p)
_JACOBIAN = CFUNCTYPE(c_int, *_AT, c_int, *_MATRIX)
_HESSIAN = CFUNCTYPE(c_int, *_AT, c_double, c_int, c_void_p, c_bool, *_MATRIX)
_INTERMEDIATE = CFUNCTYPE(c_int, c_int, c_int, *[c_double] * 8, c_int, c_void_p)


class Found(NamedTuple):
    """What IPOPT gives back: its return code, the objective, z (n,), and the multipliers of rows and bounds."""

    code: int
    objective: float
    z: np.ndarray
    y: np.ndarray
    z_lower: np.ndarray
    z_upper: np.ndarray


def declared(library: ctypes.CDLL) -> ctypes.CDLL:
    """A library with IPOPT's functions, told what these take. Raises AttributeError if it has not got them."""
    for name, (gives, takes) in FUNCTIONS.items():
        function = getattr(library, name)
        function.restype, function.argtypes = gives, takes
    return library


class Problem:
    """A program as IPOPT has it, with its options."""

    def __init__(
        self, library: ctypes.CDLL, nlp: NonlinearProgram, lower: np.ndarray, upper: np.ndarray, watch: Watcher = None
    ) -> None:
        """A new problem.

        library: as of `declared`.
        nlp: gives the values, derivatives and bounds of the constraints.
        lower, upper: bounds of the unknowns, shape (n,).
        watch: as of `Callbacks`.
        """
        self.library, self.nlp, self.callbacks = library, nlp, Callbacks(nlp, watch)
        self._kept = self.callbacks.of_c()  # IPOPT calls them as long as there is a problem
        *functions, intermediate = (ctypes.cast(own, c_void_p) for own in self._kept)
        bounds = [np.ascontiguousarray(own, float) for own in (lower, upper, nlp.cl, nlp.cu)]
        lower_at, upper_at, cl_at, cu_at = (own.ctypes.data for own in bounds)
        nonzeros = [len(rows) for rows, _ in (nlp.jacobianstructure(), nlp.hessianstructure())]
        self._handle = library.CreateIpoptProblem(
            nlp.n, lower_at, upper_at, nlp.m, cl_at, cu_at, *nonzeros, 0, *functions
        )
        if not self._handle:
            raise ValueError("IPOPT refuses the sizes of this program")
        library.SetIntermediateCallback(self._handle, intermediate)

    def __del__(self) -> None:
        if handle := self.__dict__.pop("_handle", None):
            self.library.FreeIpoptProblem(handle)

    def takes(self, name: str, value: object) -> bool:
        """Whether IPOPT knows an option, of the kind of the value, and takes the value; it has it then."""
        key = name.encode()
        if isinstance(value, str):
            return bool(self.library.AddIpoptStrOption(self._handle, key, value.encode()))
        if type(value) is int:  # not bool
            return abs(value) < 2**31 and bool(self.library.AddIpoptIntOption(self._handle, key, value))
        return isinstance(value, float) and bool(self.library.AddIpoptNumOption(self._handle, key, value))

    def scale(self, objective: float, z: np.ndarray, g: np.ndarray) -> None:
        """What the objective, the unknowns (n,) and the rows (m,) are multiplied by, for `user-scaling`."""
        z, g = (np.ascontiguousarray(own, float) for own in (z, g))
        self.library.SetIpoptProblemScaling(self._handle, objective, z.ctypes.data, g.ctypes.data)

    def solve(self, z: np.ndarray, y: np.ndarray, z_lower: np.ndarray, z_upper: np.ndarray) -> Found:
        """Solve from z (n,), and from multipliers of the rows (m,) and the bounds (n,), which a warm start reads.

        Raises what a function of the program has raised, but NotFinite.
        """
        n, m, objective = self.nlp.n, self.nlp.m, c_double(0.0)
        g = np.zeros(m)
        found = [np.array(own, float) for own in (z, y, z_lower, z_upper)]
        if [own.shape for own in found] != [(n,), (m,), (n,), (n,)]:
            raise ValueError("a start has other sizes than the program")
        z, y, z_lower, z_upper = found
        code = self.library.IpoptSolve(
            self._handle, z.ctypes.data, g.ctypes.data, ctypes.byref(objective),
            *(own.ctypes.data for own in found[1:]), None,
        )  # fmt: skip
        if (error := self.callbacks.error) is not None:
            self.callbacks.error = None
            raise error
        return Found(code, objective.value, z, y, z_lower, z_upper)


Watcher = Callable[[dict[str, float]], bool] | None
"""Told of each iteration, name in COLUMNS -> number; false ends the solve."""


class Callbacks:
    """The functions that IPOPT calls: each gives 1, or 0 where there is no value.

    failed: the last evaluation that was not finite, as (point z, list of (component name, index)), or None.
    error: what a function has raised besides; the solve ends after the iteration.
    """

    def __init__(self, nlp: NonlinearProgram, watch: Watcher) -> None:
        self.nlp, self.watch = nlp, watch
        self.failed: tuple[np.ndarray, list[tuple[str, int | None]]] | None = None
        self.error: BaseException | None = None
        self._vector, self._row = c_double * nlp.n, c_double * nlp.m

    def of_c(self) -> tuple[Any, ...]:
        """As C calls them, in the order of CreateIpoptProblem, and the one of each iteration."""
        return (
            _OBJECTIVE(self.objective),
            _CONSTRAINTS(self.constraints),
            _OBJECTIVE(self.gradient),
            _JACOBIAN(self.jacobian),
            _HESSIAN(self.hessian),
            _INTERMEDIATE(self.intermediate),
        )

    def _value(self, function: Callable[..., Any], at: int, *more: Any) -> Any:
        """The value of a function of the program; None where there is none.

        function: of z.
        at: where z is.
        more: arguments after z.
        """
        if self.error is not None:
            return None
        z = np.array(np.frombuffer(self._vector.from_address(at)))
        try:
            return function(z, *more)
        except NotFinite as error:
            self.failed = (z, error.names)
        except BaseException as error:
            self.error = error
        return None

    def objective(self, n: int, at: int, new: bool, out: int, _: int) -> int:
        if (value := self._value(self.nlp.objective, at)) is None:
            return 0
        c_double.from_address(out).value = value
        return 1

    def gradient(self, n: int, at: int, new: bool, out: int, _: int) -> int:
        return _given(self._value(self.nlp.gradient, at), self._vector, out)

    def constraints(self, n: int, at: int, new: bool, m: int, out: int, _: int) -> int:
        return _given(self._value(self.nlp.constraints, at), self._row, out)

    def jacobian(
        self, n: int, at: int, new: bool, m: int, count: int, rows: int, columns: int, out: int | None, _: int
    ) -> int:
        if out is None:
            return _written(self.nlp.jacobianstructure(), count, rows, columns)
        return _given(self._value(self.nlp.jacobian, at), c_double * count, out)

    def hessian(
        self, n: int, at: int, new: bool, sigma: float, m: int, y: int, newer: bool,
        count: int, rows: int, columns: int, out: int | None, _: int,
    ) -> int:  # fmt: skip
        if out is None:
            return _written(self.nlp.hessianstructure(), count, rows, columns)
        multipliers = np.array(np.frombuffer(self._row.from_address(y))) if m else np.zeros(0)
        return _given(self._value(self.nlp.hessian, at, multipliers, sigma), c_double * count, out)

    def intermediate(self, *values: Any) -> int:
        if self.error is not None:
            return 0
        try:
            return int(self.watch is None or self.watch(dict(zip(COLUMNS, values[:-1], strict=True))))
        except BaseException as error:
            self.error = error
        return 0


def _given(values: np.ndarray | None, vector: type[ctypes.Array[Any]], out: int) -> int:
    """Copy values to where IPOPT reads them."""
    if values is None:
        return 0
    if len(values):
        np.frombuffer(vector.from_address(out))[:] = values
    return 1


def _written(structure: tuple[np.ndarray, np.ndarray], count: int, rows: int, columns: int) -> int:
    """Copy rows and columns of nonzeros to where IPOPT reads them."""
    for own, out in zip(structure, (rows, columns), strict=True) if count else ():
        np.frombuffer((c_int * count).from_address(out), np.intc)[:] = own
    return 1


class Nothing:
    """The least program: minimise 0 over one unknown. It has no rows, and nobody asks for their names."""

    START = np.array([0.5]), np.zeros(0), np.zeros(1), np.zeros(1)
    """Arguments of `Problem.solve`."""

    n, m = 1, 0
    cl = cu = np.zeros(0)

    def objective(self, z: np.ndarray) -> float:
        return 0.0

    def gradient(self, z: np.ndarray) -> np.ndarray:
        return np.zeros(1)

    def constraints(self, z: np.ndarray) -> np.ndarray:
        return np.zeros(0)

    def jacobianstructure(self) -> tuple[np.ndarray, np.ndarray]:
        return np.zeros(0, int), np.zeros(0, int)

    def hessianstructure(self) -> tuple[np.ndarray, np.ndarray]:
        return np.zeros(0, int), np.zeros(0, int)

    def jacobian(self, z: np.ndarray) -> np.ndarray:
        return np.zeros(0)

    def hessian(self, z: np.ndarray, y: np.ndarray, sigma: float) -> np.ndarray:
        return np.zeros(0)
