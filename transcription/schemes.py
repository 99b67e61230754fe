"""A collocation scheme is data: the nodes of one segment and the linear combinations that make its defects.

On a segment of duration h the states live at the nodes sigma_0 = 0 < ... < sigma_d = 1 and the dynamics are collocated
at the nodes c_j, a subset of sigma. With x_i the state at sigma_i and f_j the dynamics at c_j, every scheme asks that

    sum_i L[r, i] x_i  =  h  sum_j R[r, j] f_j,      r = 0, 1, ..., d - 1                             (the defects)

and everything else follows from the same nodes:

    b_j      = integral of l_j over [0, 1]                               quadrature weights
    u(tau)   = sum_j u_j l_j(tau)                                        control interpolant
    x(tau)   = x_0 + h sum_j f_j (integral of l_j over [0, tau])         state interpolant

where l_j are the Lagrange polynomials of c. So nothing is ever interpolated by another rule than the one that was solved.
Methods that are no collocation schemes stand in the same table, with an interpolant of their own.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..problems.errors import Mistake, SpecError
from .polynomials import integrated_basis, lagrange_basis


class Interpolant(NamedTuple):
    """x(tau) = X x_i + h F f_j, dx/dt = dX x_i / h + dF f_j, u(tau) = U u_j at m values of tau.

    X, dX: (m, d + 1) on the state nodes; F, dF, U: (m, n) on the collocation nodes.
    """

    X: np.ndarray
    F: np.ndarray
    dX: np.ndarray
    dF: np.ndarray
    U: np.ndarray


@dataclass(frozen=True, eq=False)
class Scheme:
    """One row of the table of methods.

    name: as written in a problem file. order: of convergence of the state at the knots.
    sigma: (d + 1,) state nodes. c: (n,) collocation nodes. L: (d, d + 1) and R: (d, n), the defects.
    eliminated: {node: row}; the state at that node is no variable, it is the solution of defect `row`, which must not
    contain the dynamics at the node itself. Raises ValueError where the data contradict each other.
    """

    name: str
    family: str
    order: int
    sigma: np.ndarray
    c: np.ndarray
    L: np.ndarray
    R: np.ndarray
    source: str
    eliminated: tuple[tuple[int, int], ...] = ()

    def __post_init__(self):
        d, n = len(self.sigma) - 1, len(self.c)
        if self.L.shape != (d, d + 1) or self.R.shape != (d, n):
            raise ValueError(f"{self.name}: L and R have shapes {self.L.shape} and {self.R.shape}")
        if self.sigma[0] != 0 or self.sigma[-1] != 1 or not np.isin(self.c, self.sigma).all():
            raise ValueError(f"{self.name}: state nodes must run from 0 to 1 and include the collocation nodes")
        # A defect vanishes for every polynomial the state interpolant can be: x = tau^k has f = k tau^(k-1).
        for k in range(n + 1):
            slope = k * self.c ** (k - 1) if k else np.zeros(n)
            if not np.allclose(self.L @ self.sigma**k, self.R @ slope, atol=1e-13):
                raise ValueError(f"{self.name}: the defects are not exact for tau^{k}")
        for node, row in self.eliminated:
            own = self.c == self.sigma[node]
            if self.L[row, node] == 0 or self.R[row, own].any():
                raise ValueError(f"{self.name}: defect {row} does not give the state at node {node} explicitly")

    @cached_property
    def b(self) -> np.ndarray:
        """Quadrature weights on the unit segment, shape (n,)."""
        return integrated_basis(self.c, np.ones(1))[0]

    @property
    def state_interpolant(self) -> str:
        return f"degree {len(self.c)}"

    @property
    def control_interpolant(self) -> str:
        return f"degree {len(self.c) - 1}"

    @cached_property
    def collocated(self) -> tuple[int, ...]:
        """The index in sigma of each collocation node."""
        return tuple(int(np.flatnonzero(self.sigma == c)[0]) for c in self.c)

    @cached_property
    def rows(self) -> tuple[int, ...]:
        """The defects that are constraints of the nonlinear program: those that do not define an eliminated state."""
        used = {row for _, row in self.eliminated}
        return tuple(r for r in range(len(self.L)) if r not in used)

    def eliminate(self, node: int, row: int, x, f, h):
        """State at an eliminated node from x[i] and f[j] at the other nodes: numbers, arrays or Pyomo expressions."""
        combination = sum(h * (float(r) * f[j]) for j, r in enumerate(self.R[row]) if r)
        combination -= sum(float(a) * x[i] for i, a in enumerate(self.L[row]) if a and i != node)
        return combination / float(self.L[row, node])

    def interpolant(self, tau: np.ndarray) -> Interpolant:
        """The polynomial with the collocated slopes, at tau, shape (m,)."""
        basis = lagrange_basis(self.c, tau)
        X = np.zeros((len(tau), len(self.sigma)))
        X[:, 0] = 1
        return Interpolant(X, integrated_basis(self.c, tau), np.zeros_like(X), basis, basis)


@dataclass(frozen=True, eq=False)
class FiniteDifference:
    """Second-order central differences for positions; see `finite_difference` for its equations.

    Between the points the state is the cubic Hermite polynomial of its values and slopes, the control is linear.
    """

    name: str = "finite-difference"
    family: str = "differences, second order"
    order: int = 2
    sigma: np.ndarray = field(default_factory=lambda: np.array([0.0, 1.0]))
    c: np.ndarray = field(default_factory=lambda: np.array([0.0, 1.0]))
    source: str = "An introduction to direct collocation, section 6, (40)-(42)"
    collocated: tuple[int, ...] = (0, 1)
    b: np.ndarray = field(default_factory=lambda: np.array([0.5, 0.5]))
    state_interpolant: str = "degree 3"
    control_interpolant: str = "degree 1"

    def interpolant(self, tau: np.ndarray) -> Interpolant:
        t = np.asarray(tau, float)
        X = np.stack([(1 + 2 * t) * (1 - t) ** 2, t**2 * (3 - 2 * t)], axis=1)
        F = np.stack([t * (1 - t) ** 2, t**2 * (t - 1)], axis=1)
        dX = np.stack([6 * t * (t - 1), 6 * t * (1 - t)], axis=1)
        dF = np.stack([(1 - t) * (1 - 3 * t), t * (3 * t - 2)], axis=1)
        return Interpolant(X, F, dX, dF, lagrange_basis(self.c, t))


# fmt: off
TRAPEZOID = Scheme(
    name="trapezoid", family="Lobatto, 2 points", order=2, source="Kelly 2017, section 3",
    sigma=np.array([0.0, 1.0]), c=np.array([0.0, 1.0]),
    L=np.array([[-1.0, 1.0]]),
    R=np.array([[1.0, 1.0]]) / 2,                                  # (3.3)
)

# Defect 1 is (4.4), the integral form of 3-point Lobatto with half of defect 0 taken off: fewer dynamics in it.
_SIMPSON = {
    "sigma": np.array([0.0, 0.5, 1.0]), "c": np.array([0.0, 0.5, 1.0]),
    "L": np.array([[-1.0, 0.0, 1.0],
                   [-0.5, 1.0, -0.5]]),
    "R": np.array([[1.0, 4.0, 1.0],                                # (4.3)
                   [0.75, 0.0, -0.75]]) / 6,                       # (4.4)
}
HERMITE_SIMPSON = Scheme(
    name="hermite-simpson", family="Lobatto, 3 points", order=4,
    source="Kelly 2017, section 4, separated form", **_SIMPSON,
)
HERMITE_SIMPSON_COMPRESSED = Scheme(
    name="hermite-simpson-compressed", family="Lobatto, 3 points", order=4,
    source="Kelly 2017, section 4.2, compressed form: midpoint states eliminated", eliminated=((1, 1),), **_SIMPSON,
)
# fmt: on

FINITE_DIFFERENCE = FiniteDifference()

TABLE = {s.name: s for s in (TRAPEZOID, HERMITE_SIMPSON, HERMITE_SIMPSON_COMPRESSED, FINITE_DIFFERENCE)}
COLLOCATION = {name: scheme for name, scheme in TABLE.items() if isinstance(scheme, Scheme)}


def find(name: str) -> Scheme | FiniteDifference:
    """The scheme of that name; raises SpecError with the nearest names otherwise."""
    if name in TABLE:
        return TABLE[name]
    near = get_close_matches(name, TABLE, n=1, cutoff=0.3)
    hint = f"did you mean '{near[0]}'? " if near else ""
    raise SpecError(Mistake("method", f"there is no method '{name}'", hint + "'trajopt methods' lists them all"))
