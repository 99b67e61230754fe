"""Explicit Runge-Kutta methods as data: their Butcher tables."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.text import short_repr

CONTROLS = {"constant": (0.5,), "linear": (0.0, 1.0), "quadratic": (0.0, 0.5, 1.0)}
"""Name of a control polynomial -> its nodes on a substep."""


@short_repr
@dataclass(frozen=True, eq=False)
class ButcherTable:
    """A Butcher table. A: (r, r) strictly lower triangular, b: (r,). controls: the polynomials it can tell apart."""

    name: str
    order: int
    A: np.ndarray
    b: np.ndarray
    source: str
    controls: tuple[str, ...] = tuple(CONTROLS)

    def __post_init__(self) -> None:
        if self.A.shape != (len(self.b),) * 2 or np.triu(self.A).any():
            raise ValueError(f"{self.name}: A must be square and strictly lower triangular")

    @cached_property
    def c(self) -> np.ndarray:
        """The times of the stages on the unit step, shape (r,)."""
        return self.A.sum(axis=1)

    @cached_property
    def middle(self) -> np.ndarray:
        """The weights of the state in the middle of a step, shape (r,): the shortest that meet the order conditions."""
        rows, sides = order_conditions(self.A, max(self.order - 1, 2), 0.5)
        return np.linalg.lstsq(rows, sides, rcond=None)[0]


def order_conditions(A: np.ndarray, order: int, theta: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """rows (q, r) and sides (q,): weights w with rows @ w = sides give x(t + theta H) to the order asked for.

    A: of the Butcher table, shape (r, r).
    order: at most 5.
    theta: where on the step, 1 for its end.

    One condition for each rooted tree (Hairer, Norsett, Wanner: Solving Ordinary Differential Equations I, II.2).
    """
    c = A.sum(axis=1)
    trees = {
        1: [(np.ones_like(c), 1)],
        2: [(c, 2)],
        3: [(c**2, 3), (A @ c, 6)],
        4: [(c**3, 4), (c * (A @ c), 8), (A @ c**2, 12), (A @ A @ c, 24)],
        5: [
            (c**4, 5), (c**2 * (A @ c), 10), (c * (A @ c**2), 15), (c * (A @ A @ c), 30), ((A @ c) ** 2, 20),
            (A @ c**3, 20), (A @ (c * (A @ c)), 40), (A @ A @ c**2, 60), (A @ A @ A @ c, 120),
        ],
    }  # fmt: skip
    chosen = [(row, theta**n / gamma) for n in range(1, order + 1) for row, gamma in trees[n]]
    rows, sides = zip(*chosen, strict=True)
    return np.array(rows), np.array(sides)


def _lower(*rows: tuple[float, ...]) -> np.ndarray:
    A = np.zeros((len(rows) + 1,) * 2)
    for i, row in enumerate(rows, start=1):
        A[i, : len(row)] = row
    return A


# fmt: off
HEUN = ButcherTable(
    "runge-kutta-2", 2, _lower((1.0,)), np.array([1, 1]) / 2,
    "Kelly 2017, sections 9.5, 9.6; Heun 1900", controls=("constant", "linear"),
)
CLASSICAL = ButcherTable(
    "runge-kutta-4", 4, _lower((1 / 2,), (0, 1 / 2), (0, 0, 1)), np.array([1, 2, 2, 1]) / 6,
    "Kelly 2017, sections 9.5, 9.6 and its supplement; Kutta 1901",
)
DORMAND_PRINCE = ButcherTable(
    "dormand-prince", 5,
    _lower(
        (1 / 5,),
        (3 / 40, 9 / 40),
        (44 / 45, -56 / 15, 32 / 9),
        (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
        (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    ),
    np.array([35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84]),
    "Dormand and Prince, J. Comp. Appl. Math. 6, 1980, without its step control",
)
# fmt: on
TABLES = (HEUN, CLASSICAL, DORMAND_PRINCE)
