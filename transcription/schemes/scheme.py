"""A collocation scheme is data: the nodes of one segment and the linear combinations that make its defects.

On a segment of duration h the states live at the nodes sigma_0 = 0 < ... < sigma_d = 1 and the dynamics are collocated
at the nodes c_j, a subset of sigma. With x_i the state at sigma_i and f_j the dynamics at c_j, every scheme asks that

    sum_i L[r, i] x_i  =  h  sum_j R[r, j] f_j,      r = 0, 1, ..., d - 1                             (the defects)

and everything else follows from the same nodes:

    b_j      = integral of l_j over [0, 1]                               quadrature weights
    u(tau)   = sum_j u_j l_j(tau)                                        control interpolant
    x(tau)   = x_0 + h sum_j f_j (integral of l_j over [0, tau])         state interpolant

where l_j are the Lagrange polynomials of c. So nothing is ever interpolated by another rule than the one that was
solved. Methods that are no collocation schemes stand in the same table, with an interpolant of their own: what all of
them say of a segment is the protocol `segment.Segment`.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from types import MappingProxyType
from typing import Any, ClassVar, cast

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.sets import distinct
from ...problems.text import short_repr
from .polynomials import integrated_basis, lagrange_basis
from .segment import Interpolant, KindOfMethod, Points, Segment, SegmentGroup


def collocation_scheme(segment: Segment) -> Scheme:
    """A segment of a mesh whose kind of method is collocation, as the scheme that it is."""
    return cast(Scheme, segment)


@short_repr
@dataclass(frozen=True, eq=False)
class Scheme:
    """One row of the table of methods, at one degree: a `segment.Segment`.

    name: as written in a problem file. order: of convergence of the state at the knots.
    sigma: (d + 1,) state nodes. c: (n,) collocation nodes. L: (d, d + 1) and R: (d, n), the defects.
    eliminated: (node, row) pairs; the state at that node is no variable, it is the solution of defect `row`, which must
    not contain the dynamics at the node itself. differential: whether the defects are written in differential form,
    with the dynamics of two nodes in each at most. degree: within a family of schemes, else None. Raises ValueError
    where the data contradict each other.
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
    differential: bool = False
    degree: int | None = None

    kind: ClassVar[KindOfMethod] = "collocation"
    options: ClassVar[Mapping[str, int | str]] = MappingProxyType({})
    equal: ClassVar[bool] = False
    coarsens: ClassVar[bool] = True
    has_costates: ClassVar[bool] = True
    densities: ClassVar[bool] = True
    simulated: ClassVar[bool] = False

    def __post_init__(self) -> None:
        d, n = len(self.sigma) - 1, len(self.c)
        if self.L.shape != (d, d + 1) or self.R.shape != (d, n):
            raise ValueError(f"{self.name}: L and R have shapes {self.L.shape} and {self.R.shape}")
        if self.sigma[0] != 0 or self.sigma[-1] != 1 or not np.isin(self.c, self.sigma).all():
            raise ValueError(f"{self.name}: state nodes must run from 0 to 1 and include the collocation nodes")
        # A defect vanishes for every polynomial the state interpolant can be: x = tau^k has f = k tau^(k-1).
        for k in range(n + 1):
            slope = k * self.c ** (k - 1) if k else np.zeros(n)
            if not np.allclose(self.L @ self.sigma**k, self.R @ slope, rtol=1e-10, atol=1e-13 * n**2):
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
    def error_order(self) -> int:
        """eta of a part of a segment falls as h^(this + 1)."""
        return len(self.c)

    @property
    def quadrature(self) -> tuple[np.ndarray, np.ndarray]:
        """Nodes and weights, shape (n,), on the unit segment: how integrals are taken."""
        return self.c, self.b

    @property
    def state_interpolant(self) -> str:
        return str(len(self.c))

    @property
    def control_interpolant(self) -> str:
        return str(len(self.c) - 1)

    @cached_property
    def collocated(self) -> tuple[int, ...]:
        """The index in sigma of each collocation node."""
        return tuple(int(np.flatnonzero(self.sigma == c)[0]) for c in self.c)

    @cached_property
    def rows(self) -> tuple[int, ...]:
        """The defects that are constraints of the nonlinear program: those that do not define an eliminated state."""
        used = {row for _, row in self.eliminated}
        return tuple(r for r in range(len(self.L)) if r not in used)

    @cached_property
    def point_rows(self) -> list[tuple[int, list[int]]] | None:
        """In differential form, the rows by the number of nodes whose dynamics they contain: (number, rows)."""
        if not self.differential:
            return None
        counts = np.count_nonzero(self.R, axis=1)
        return [(int(n), np.flatnonzero(counts == n).tolist()) for n in distinct(counts)]

    def eliminate(self, node: int, row: int, x: Any, f: Any, h: Any) -> Any:
        """The state at an eliminated node: a number, an array or a Pyomo expression, as the values are.

        node: its number among the state nodes.
        row: the defect that gives it.
        x: state node -> value of the state, for the others.
        f: collocation node -> rate of the state.
        h: duration of the segment.
        """
        combination = sum(h * (float(r) * f[j]) for j, r in enumerate(self.R[row]) if r)
        combination -= sum(float(a) * x[i] for i, a in enumerate(self.L[row]) if a and i != node)
        return combination / float(self.L[row, node])

    def interpolant(self, tau: np.ndarray) -> Interpolant:
        """The polynomial with the collocated slopes, at tau, shape (m,)."""
        basis = self.control_basis(tau)
        X = np.zeros((len(tau), len(self.sigma)))
        X[:, 0] = 1
        return Interpolant(X, integrated_basis(self.c, tau), np.zeros_like(X), basis, basis)

    def control_basis(self, tau: np.ndarray) -> np.ndarray:
        """The Lagrange polynomials of the collocation nodes at tau, shape (m,): shape (m, n)."""
        return lagrange_basis(self.c, tau)

    def costate_basis(self, tau: np.ndarray) -> np.ndarray:
        """Weights of the costates at the state nodes for those at tau, shape (m, d + 1): one polynomial."""
        return lagrange_basis(self.sigma, tau)

    def complete(self, points: Points, group: SegmentGroup) -> None:
        """The states that are eliminated, from the defects that define them."""
        x = points.x
        for node, row in self.eliminated:
            f = points.phase.dynamics(points.times, x, points.u, points.parameters)
            at_nodes, rates = [x[:, k] for k in group.nodes.T], [f[:, k] for k in group.collocated.T]
            x[:, group.nodes[:, node]] = self.eliminate(node, row, at_nodes, rates, points.h[group.segments])

    def defect_multipliers(self, costate: np.ndarray) -> np.ndarray:
        """In the least-squares sense, mu R = -b lambda at the collocation nodes; and, where an end of the segment is
        none, so that its state stands in the left sides only, mu L = -lambda at the end and mu L = lambda at the start.
        """
        matrix, target = [self.R], [-self.b * costate[..., self.collocated]]
        for node, sign in ((0, 1.0), (len(self.sigma) - 1, -1.0)):
            if node not in self.collocated:
                matrix.append(self.L[:, [node]])
                target.append(sign * costate[..., [node]])
        return np.concatenate(target, axis=-1) @ np.linalg.pinv(np.hstack(matrix)[list(self.rows)])
