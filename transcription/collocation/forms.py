"""The form of a problem: what its nonlinear program depends on besides numbers."""

from __future__ import annotations

from collections.abc import Hashable
from math import isfinite
from typing import NamedTuple

from ...problems.names.structure import Form, form_of
from ...problems.probe import depends_on
from ...problems.problem import Phase, Problem
from ...problems.quantities import Range
from ..constraint_kinds import kind_between
from ..layout import BETWEEN
from ..method_kind import TIMES

GROUPS = ("residuals", "path", "boundary", "integral")
"""The attributes of a phase that hold constraints."""


class Forms(NamedTuple):
    """The form of a problem's functions: key, equal where one program serves; phases, links: with their data."""

    key: Hashable
    phases: tuple[Form, ...]
    links: Form


def forms_of(problem: Problem, values_only: bool = False) -> Forms:
    """The form of a problem and the data of its functions, for each phase and for what is between phases.

    problem: any.
    values_only: as of `structure.form_of`.
    """
    phases = tuple(form_of_phase(phase, values_only) for phase in problem.phases)
    links = form_between(problem, values_only)
    shape = [
        problem.sense,
        *((own.name, _shape(own.bounds)) for own in problem.parameters),
        *((kind_between(link).name, link.name, _shape(link.bounds)) for link in problem.links),
        *(_shape_of_phase(phase) for phase in problem.phases),
    ]
    return Forms((tuple(shape), *(form.form for form in (*phases, links))), phases, links)


def numbers_as_data(problem: Problem, forms: Forms) -> dict[tuple[str, str], float]:
    """The numbers of a problem that may be data of its program: (phase, or BETWEEN; name of a parameter, or of a time).

    problem: any.
    forms: of it.
    """
    found = {
        (phase.name, name): bounds.lower
        for phase in problem.phases
        for name, bounds in zip(TIMES, (phase.initial_time, phase.final_time), strict=True)
    }
    for phase, form in zip(problem.phases, forms.phases, strict=True):
        found |= {(phase.name, name): number for name, number in form.data.items()}
    return found | {(BETWEEN, name): number for name, number in forms.links.data.items()}


def form_of_phase(phase: Phase, values_only: bool = False) -> Form:
    """The form of the functions of a phase; values_only: as of `structure.form_of`."""
    constraints = [own for kind in GROUPS for own in getattr(phase, kind)]
    rates = (state.rate for state in phase.states)
    return form_of([*rates, *(own.function for own in constraints), phase.lagrange, phase.mayer], values_only)


def form_between(problem: Problem, values_only: bool = False) -> Form:
    """The form of the functions of the ends of several phases; values_only: as of `structure.form_of`."""
    return form_of([*(link.function for link in problem.links), problem.mayer], values_only)


def _shape(bounds: Range) -> tuple[bool, bool, bool]:
    return isfinite(bounds.lower), isfinite(bounds.upper), bounds.fixed


def _shape_of_phase(phase: Phase) -> Hashable:
    inputs = {variable.name for variable in phase.inputs}
    groups = [getattr(phase, kind) for kind in GROUPS]
    return (
        phase.name,
        (_shape(phase.initial_time), _shape(phase.final_time)),
        tuple((s.name, s.velocity_of, *map(_shape, (s.bounds, s.initial, s.final))) for s in phase.states),
        tuple((own.name, _shape(own.bounds)) for own in phase.controls),
        tuple((own.name, _shape(own.bounds)) for own in phase.algebraic),
        tuple(tuple((c.name, _shape(c.bounds)) for c in group) for group in groups),
        # (p - q) u depends on u for most numbers p and q, and then says nothing of an end without a value of u.
        tuple(depends_on(c.function, inputs) for c in phase.path),
    )
