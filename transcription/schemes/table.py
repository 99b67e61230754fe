"""The table of methods: each is a `Scheme`, or a family of schemes with a degree to choose.

Adding a method is adding a row; its defects, interpolants, quadrature, costates and error estimate follow, and the
tests of exactness, order and costates run over the table.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from ...problems.errors import Mistake, SpecError
from ...problems.lean.records import dataclass
from ...problems.quantities import MAX_DEGREE, MAX_SUBSTEPS
from ...problems.text import did_you_mean
from ..libraries.alone import LOCK
from .discrete import EXACT
from .finite_difference import FiniteDifference
from .orthogonal import chebyshev, collocated_at, gauss, lobatto, radau, radau_left
from .runge_kutta import CONTROLS, TABLES, ButcherTable
from .scheme import Scheme
from .segment import Segment
from .shooting import Shooting

if TYPE_CHECKING:  # pydantic
    from ...problems.schema.solving import MeshEntry

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
    table: ButcherTable | None = None
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
def _shooting(table: ButcherTable, substeps: int, control: str) -> Shooting:
    """One object for one scheme: segments are grouped by it."""
    return Shooting(table, substeps, control)


@cache
def _orthogonal(method: Method, degree: int, form: str) -> Scheme:
    """One object for one scheme of a family."""
    assert method.nodes is not None
    c = method.nodes(degree)
    family = f"{method.family}, {len(c)} points"
    return collocated_at(c, form, name=method.name, family=family, source=method.source, degree=degree)


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


def _simulated(table: ButcherTable) -> Method:
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

    name: of a row of METHODS, or of what is no method: discrete time, or none.
    degree: of a family; None for DEFAULT_DEGREE, and for a method of one degree.
    form: of the defects of a family, "integral" or "differential"; None for the cheaper one.
    substeps: on each segment of a shooting method; None for DEFAULT_SUBSTEPS.
    control: polynomial of the controls on each substep of a shooting method, a name in CONTROLS; None for that of the
        highest degree that its table allows.

    Raises SpecError, with the nearest name, for an unknown one, and for what the method does not have.
    """
    if name in EXACT:
        return EXACT[name]
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
