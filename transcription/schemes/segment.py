"""What every method says of one segment, whatever kind of method it is; and the segments of one method on a mesh."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, NamedTuple, Protocol

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.problem import Phase
from ...problems.text import short_repr

KindOfMethod = Literal["collocation", "differences", "shooting"]
"""The kinds of methods, whose programs are built in different ways; see `transcribe`."""


class Interpolant(NamedTuple):
    """x(tau) = X x_i + h F f_j, dx/dt = dX x_i / h + dF f_j, u(tau) = U u_j at m values of tau.

    X, dX: (m, d + 1) on the state nodes; F, dF, U: (m, n) on the collocation nodes.
    """

    X: np.ndarray
    F: np.ndarray
    dX: np.ndarray
    dF: np.ndarray
    U: np.ndarray


class Segment(Protocol):
    """A method on one segment; the table of methods has one object for each choice of degree, form and substeps.

    kind: how programs of this method are built. name, family, source: as in the table of methods.
    order: of convergence of the state at the knots. error_order: eta of a part of a segment falls as h^(this + 1).
    sigma: (d + 1,) state nodes. collocated: the index in sigma of each of the n collocation nodes c; b: (n,) their
    quadrature weights. rows: the defects that are constraints. degree: within a family of methods, else None.
    options: what else the method was asked for, as attributes of a mesh file. differential: the form of the defects.
    quadrature: nodes and weights of integrals on the unit segment, or None where they are no sum over segments.

    equal: whether a mesh must have equal segments. coarsens: whether a few long segments still solve most problems.
    has_costates: whether costates follow from the multipliers. densities: whether each point with an unknown has a
    quadrature weight, so that its multipliers are densities. simulated: whether the states inside are simulated.
    """

    @property
    def kind(self) -> KindOfMethod: ...
    @property
    def name(self) -> str: ...
    @property
    def family(self) -> str: ...
    @property
    def source(self) -> str: ...
    @property
    def order(self) -> int: ...
    @property
    def error_order(self) -> int: ...
    @property
    def sigma(self) -> np.ndarray: ...
    @property
    def c(self) -> np.ndarray: ...
    @property
    def b(self) -> np.ndarray: ...
    @property
    def collocated(self) -> tuple[int, ...]: ...
    @property
    def rows(self) -> tuple[int, ...]: ...
    @property
    def degree(self) -> int | None: ...
    @property
    def differential(self) -> bool: ...
    @property
    def options(self) -> Mapping[str, int | str]: ...
    @property
    def quadrature(self) -> tuple[np.ndarray, np.ndarray] | None: ...
    @property
    def equal(self) -> bool: ...
    @property
    def coarsens(self) -> bool: ...
    @property
    def has_costates(self) -> bool: ...
    @property
    def densities(self) -> bool: ...
    @property
    def simulated(self) -> bool: ...
    @property
    def state_interpolant(self) -> str:
        """The degree of the state's interpolant, in words."""
        ...

    @property
    def control_interpolant(self) -> str:
        """The degree of the control's interpolant, in words."""
        ...

    def interpolant(self, tau: np.ndarray) -> Interpolant:
        """States and controls between the nodes, at tau, shape (m,)."""
        ...

    def control_basis(self, tau: np.ndarray) -> np.ndarray:
        """U of the interpolant alone, at tau, shape (m,): shape (m, n)."""
        ...

    def costate_basis(self, tau: np.ndarray) -> np.ndarray:
        """Weights of the costates at the state nodes for those at tau, shape (m, d + 1)."""
        ...

    def complete(self, points: Points, group: SegmentGroup) -> None:
        """Write the states of a group of segments that are no unknowns into points.x."""
        ...

    def defect_multipliers(self, costate: np.ndarray) -> np.ndarray:
        """mu of the rows (..., rows), from the costates at the state nodes of a segment, (..., d + 1)."""
        ...


@short_repr
@dataclass(frozen=True, eq=False)
class SegmentGroup:
    """The segments of one method: their numbers (G,), state nodes (G, d + 1), collocation points (G, n), slots (G, d +
    1).
    """

    scheme: Segment
    segments: np.ndarray
    nodes: np.ndarray
    collocated: np.ndarray
    slots: np.ndarray


class Points(Protocol):
    """What is known at the points of a mesh when it is completed: a `trajectory.Trajectory`."""

    @property
    def phase(self) -> Phase: ...
    @property
    def times(self) -> np.ndarray: ...
    @property
    def knots(self) -> np.ndarray: ...
    @property
    def h(self) -> np.ndarray: ...
    @property
    def x(self) -> np.ndarray: ...
    @property
    def u(self) -> np.ndarray: ...
    @property
    def parameters(self) -> Mapping[str, float]: ...
