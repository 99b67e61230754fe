"""The table of methods: each is a `Scheme`, or a family of schemes with a degree to choose.

Adding a method is adding a row; its defects, interpolants, quadrature, costates and error estimate follow, and the
tests of exactness, order and costates run over the table.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from ...problems.errors import Mistake, SpecError
from ...problems.schema.fields import MAX_DEGREE
from ...problems.schema.solving import MAX_SUBSTEPS, MeshEntry
from ...problems.sets import distinct
from ...problems.text import did_you_mean
from ..program.alone import LOCK
from .finite_difference import FiniteDifference
from .polynomials import differentiation_matrix, integrated_basis, jacobi_nodes
from .runge_kutta import CONTROLS, TABLES, Shooting, Table
from .scheme import Scheme
from .segment import Segment

DEFAULT_DEGREE = 4
DEFAULT_SUBSTEPS = 1
INTEGRAL_DEGREE = 3  # up to here the integral form has few enough dynamics in a defect to be the cheaper one


@dataclass(frozen=True)
class Method:
    """A row of the table. nodes: degree -> collocation nodes, for a family; scheme: for a method of one degree; table:
    of a shooting method.

    ends: which ends of a segment are collocated. order: of the states at the knots and of integrals, in words, n being
    the degree. note: what else to know about it.
    """

    name: str
    family: str
    ends: str
    order: str
    source: str
    nodes: Callable[[int], np.ndarray] | None = None
    scheme: Segment | None = None
    table: Table | None = None
    note: str = ""

    @property
    def state(self) -> str:
        """The degree of the state's interpolant, in words."""
        if self.table is not None:
            return self.shooting().state_interpolant
        if self.scheme is not None:
            return self.scheme.state_interpolant
        return "n + 1" if self.ends == "both" else "n"

    @property
    def control(self) -> str:
        """The degree of the control's interpolant, in words."""
        if self.table is not None:
            return ", ".join(str(len(CONTROLS[control]) - 1) for control in self.table.controls)
        if self.scheme is not None:
            return self.scheme.control_interpolant
        return "n" if self.ends == "both" else "n - 1"

    def of_degree(self, degree: int | None = None, form: str | None = None) -> Segment:
        """The scheme; raises SpecError for a degree or a form that it does not have."""
        if self.table is not None and degree is None and form is None:
            return self.shooting()
        if self.nodes is None and (degree is not None or form is not None):
            what = f"'{self.name}' has one degree and one form"
            raise SpecError(Mistake("mesh", what, "leave out degree: and form:, or take another method"))
        if self.scheme is not None:
            return self.scheme
        degree = DEFAULT_DEGREE if degree is None else degree
        if not 1 <= degree <= MAX_DEGREE:
            raise SpecError(Mistake("mesh.degree", f"degree {degree} is out of range", f"write 1 to {MAX_DEGREE}"))
        with LOCK:  # segments are grouped by the object: two threads must not make two of one scheme
            return _orthogonal(self, degree, form or ("integral" if degree <= INTEGRAL_DEGREE else "differential"))

    def shooting(self, substeps: int | None = None, control: str | None = None) -> Shooting:
        """The scheme of a shooting method; raises SpecError for substeps or a control that it does not have."""
        if self.table is None:
            key = "substeps" if substeps is not None else "control"
            what = f"'{self.name}' is no shooting method: it has no substeps and one control polynomial"
            raise SpecError(Mistake(f"mesh.{key}", what, f"leave {key}: out, or take runge-kutta-4"))
        substeps = DEFAULT_SUBSTEPS if substeps is None else substeps
        if not 1 <= substeps <= MAX_SUBSTEPS:
            what = f"{substeps} substeps are out of range"
            raise SpecError(Mistake("mesh.substeps", what, f"write 1 to {MAX_SUBSTEPS}"))
        control = self.table.controls[-1] if control is None else control
        if control not in self.table.controls:
            what = f"'{self.name}' cannot have {control} controls: it evaluates too few of their nodes"
            raise SpecError(Mistake("mesh.control", what, "write " + " or ".join(self.table.controls)))
        with LOCK:
            return _shooting(self.table, substeps, control)


@cache
def _shooting(table: Table, substeps: int, control: str) -> Shooting:
    """One object for one scheme: segments are grouped by it."""
    return Shooting(table, substeps, control)


# -- orthogonal collocation (paper, 9.7 and appendix D) ------------------------------------------------------------


def gauss(n: int) -> np.ndarray:
    """Roots of the Legendre polynomial of degree n, shape (n,)."""
    return jacobi_nodes(n, 0, 0)


def radau(n: int) -> np.ndarray:
    """n points with the right end among them."""
    return np.append(jacobi_nodes(n - 1, 1, 0), 1.0)


def radau_left(n: int) -> np.ndarray:
    """n points with the left end among them."""
    return np.append(0.0, jacobi_nodes(n - 1, 0, 1))


def lobatto(n: int) -> np.ndarray:
    """n + 1 points with both ends among them."""
    return np.concatenate([[0.0], jacobi_nodes(n - 1, 1, 1), [1.0]])


def chebyshev(n: int) -> np.ndarray:
    """n + 1 extreme points of the Chebyshev polynomial of degree n, both ends among them."""
    return (1 - np.cos(np.pi * np.arange(n + 1) / n)) / 2


def quadrature_order(c: np.ndarray) -> int:
    """The number of leading powers that the interpolatory quadrature on the nodes c integrates exactly."""
    b = integrated_basis(c, np.ones(1))[0]
    order = len(c)
    while order <= 2 * len(c) and abs(b @ _legendre(order, c)) < 1e-12:
        order += 1
    return order


def _legendre(k: int, c: np.ndarray) -> np.ndarray:
    """The Legendre polynomial of degree k on [0, 1]; orthogonal to 1, so its exact integral is 0."""
    return np.polynomial.legendre.Legendre.basis(k, domain=[0, 1])(c)


@cache
def _orthogonal(method: Method, degree: int, form: str) -> Scheme:
    """The scheme with the collocation nodes of a family.

    Integral form: x_i = x_0 + h sum_j A_ij f_j for every state node after the first, A_ij the integral of l_j.
    Differential form, which has the same solutions: the slope of the state polynomial is h f_j at every node (Gauss and
    Radau, (D.6)); for Lobatto points, whose state polynomial has one degree more than there are nodes to carry it,
    the rows are solved for f_1, f_2, ..., which leaves f_0 in each.
    """
    assert method.nodes is not None
    c = method.nodes(degree)
    sigma = distinct(np.append(c, [0.0, 1.0]))
    d, n = len(sigma) - 1, len(c)
    A = integrated_basis(c, sigma[1:])
    L, R = np.hstack([-np.ones((d, 1)), np.eye(d)]), A
    if form == "differential":
        L, R = _differential(sigma, c, A, L)
    return Scheme(
        name=method.name,
        family=f"{method.family}, {n} points",
        order=quadrature_order(c),
        sigma=sigma,
        c=c,
        L=L,
        R=R,
        source=method.source,
        differential=form == "differential",
        degree=degree,
    )


def _differential(sigma: np.ndarray, c: np.ndarray, A: np.ndarray, L: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    d, n = len(sigma) - 1, len(c)
    if n == d + 1:  # Lobatto: R = A has a row for each f but f_0
        solve = np.linalg.inv(A[:, 1:])
        return solve @ L, np.hstack([solve @ A[:, :1], np.eye(d)])
    # The state polynomial has degree n: Radau's nodes carry it, and Gauss's without the end.
    D = np.hstack([differentiation_matrix(sigma[: n + 1], c), np.zeros((n, d - n))])
    if n == d:  # Radau
        return D, np.eye(n)
    end = L[-1] - A[-1] @ D  # Gauss: x_d = x_0 + h b f, with h f_j = (D x)_j
    return np.vstack([D, end]), np.vstack([np.eye(n), np.zeros((1, n))])


# -- the table ------------------------------------------------------------------------------------------------------

# fmt: off
TRAPEZOID = Scheme(
    name="trapezoid", family="Lobatto, 2 points", order=2, source="Kelly 2017, section 3",
    sigma=np.array([0.0, 1.0]), c=np.array([0.0, 1.0]),
    L=np.array([[-1.0, 1.0]]),
    R=np.array([[1.0, 1.0]]) / 2,                                  # (3.3)
)

# Defect 1 is (4.4), the integral form of 3-point Lobatto with half of defect 0 taken off: fewer dynamics in it.
_SIMPSON: dict[str, Any] = {
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

_LEGENDRE = "Kelly 2017, section 9.7 and appendix D; Garg et al., Automatica 46, 2010"


def _fixed(scheme: Segment, ends: str) -> Method:
    return Method(scheme.name, scheme.family, ends, str(scheme.order), scheme.source, scheme=scheme)


def _simulated(table: Table) -> Method:
    return Method(table.name, "shooting", "-", str(table.order), table.source, table=table)


def _low_order(name: str, nodes: Callable[[int], np.ndarray], ends: str, source: str) -> Method:
    """The lowest member of a family under its own name."""
    scheme = _orthogonal(Method(name, "one point", ends, "", source, nodes=nodes), 1, "integral")
    return _fixed(replace(scheme, family="one point", degree=None), ends)


METHODS = {
    method.name: method
    for method in (
        _low_order("explicit-euler", radau_left, "left", "Euler 1768"),
        _low_order("implicit-euler", radau, "right", "Kelly 2017, appendix D.1: the lowest Radau method"),
        _low_order("midpoint", gauss, "none", "Kelly 2017, appendix D.1: the lowest Gauss method"),
        _fixed(TRAPEZOID, "both"),
        _fixed(HERMITE_SIMPSON, "both"),
        _fixed(HERMITE_SIMPSON_COMPRESSED, "both"),
        Method("gauss", "Legendre-Gauss", "none", "2n", _LEGENDRE, nodes=gauss),
        Method("radau", "Legendre-Gauss-Radau", "right", "2n - 1", _LEGENDRE, nodes=radau),
        Method("radau-left", "Legendre-Gauss-Radau", "left", "2n - 1", _LEGENDRE, nodes=radau_left),
        Method("lobatto", "Legendre-Gauss-Lobatto", "both", "2n", _LEGENDRE, nodes=lobatto,
               note="neighbours share the control at their knot: where it is optimal, states and costates have at most "
               "order 4 at the knots, and the objective 2n"),
        Method("chebyshev", "Chebyshev-Lobatto", "both", "n + 1 or n + 2",
               "Kelly 2017, appendix D.2 to D.5; Vlassenbroeck and Van Dooren, IEEE TAC 33, 1988", nodes=chebyshev,
               note="its order holds for given controls; optimal ones have order 2 (n odd) or 4 (n even), as its "
               "costates obey a scheme of lower order (Hager, Numerische Mathematik 87, 2000), whatever n is"),
        *map(_simulated, TABLES),
        _fixed(FINITE_DIFFERENCE, "both"),
    )
}  # fmt: skip


def find(
    name: str,
    degree: int | None = None,
    form: str | None = None,
    substeps: int | None = None,
    control: str | None = None,
) -> Segment:
    """The scheme of a method; the same arguments give the same object.

    name: of a row of METHODS.
    degree: of a family; None for DEFAULT_DEGREE, and for a method of one degree.
    form: of the defects of a family, "integral" or "differential"; None for the cheaper one.
    substeps: on each segment of a shooting method; None for DEFAULT_SUBSTEPS.
    control: polynomial of the controls on each substep of a shooting method, a name in CONTROLS; None for that of the
        highest degree that its table allows.

    Raises SpecError, with the nearest name, for an unknown one, and for what the method does not have.
    """
    if name in METHODS:
        scheme = METHODS[name].of_degree(degree, form)
        return scheme if substeps is None and control is None else METHODS[name].shooting(substeps, control)
    remedy = did_you_mean(name, METHODS, always="'trajopt methods' lists them all", likeness=0.3)
    raise SpecError(Mistake("method", f"there is no method '{name}'", remedy))


def check_schedule(schedule: Sequence[MeshEntry]) -> list[Mistake]:
    """What only the methods know: the degrees, forms, substeps and controls they have; each at its place."""
    mistakes = []
    for number, entry in enumerate(schedule):
        for degree in set(entry.degree) if isinstance(entry.degree, tuple) else {entry.degree}:
            try:
                find(entry.method, degree, entry.form, entry.substeps, entry.control)
            except SpecError as error:
                mistakes += [_in_entry(mistake, number) for mistake in error.mistakes]
    return mistakes


def _in_entry(mistake: Mistake, number: int) -> Mistake:
    """A mistake of the methods at its place in the schedule."""
    key = mistake.where.removeprefix("mesh.")
    return replace(mistake, where=f"mesh.{number}.{key if key in ('substeps', 'control') else 'degree'}")
