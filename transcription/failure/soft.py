"""What of a problem may be relaxed: values and times at the ends, bounds, parameters, constraints."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import isfinite

import numpy as np

from ...problems.problem import Phase, Problem
from ...problems.quantities import Range, State, Variable
from ..constraint_kinds import BOUND, ConstraintKind, Multiplier
from ..layout import Family, Layout, Transcription
from ..program.contract import NonlinearProgram
from ..solution.violation import constraint_named, of_phase
from .elastic import Soft

NEGLIGIBLE = 1e-100
"""A bound that is smaller says nothing of the size of what it bounds, and its inverse is no number to count with."""


def soft_constraints(problem: Problem, transcription: Transcription, nlp: NonlinearProgram) -> Iterator[Soft]:
    """All that may be relaxed.

    problem: with the ranges as they were meant.
    transcription: of the same problem with free times.
    nlp: its compiled program.
    """
    bounded: dict[tuple[str, str], list[Family]] = {}  # rows that hold states which are no unknowns
    for family in transcription.families:
        if family.kind is BOUND:
            bounded.setdefault((family.phase, family.name), []).append(family)
    for phase, layout in zip(problem.phases, transcription.phases, strict=True):
        yield from _ends(phase, layout)
        for variable, places in zip((*phase.states, *phase.controls), (*layout.x, *layout.u), strict=False):
            rows = [
                (row, start)
                for own in bounded.get((phase.name, variable.name), ())
                for row, start in zip(own.rows(nlp), own.span[:, 0], strict=True)
            ]
            yield from _bounds(variable, layout, places, rows)
    for parameter, place in zip(problem.parameters, transcription.parameters.tolist(), strict=True):
        if parameter.bounds != Range():
            yield _once("", f"the bounds of {parameter.name}", parameter, np.array([place]), parameter.bounds)
    yield from _constraints(transcription, nlp)


def _ends(phase: Phase, layout: Layout) -> Iterator[Soft]:
    whose = of_phase(phase.name)
    for state, places in zip(phase.states, layout.x, strict=True):
        ends = ("initial", places[0], state.initial), ("final", places[-1], state.final)
        for (end, place, bounds), own in zip(ends, state.own_ends, strict=True):
            if own and place >= 0:
                yield _once(phase.name, f"the {end} value of {state.name}{whose}", state, np.array([place]), bounds)
    time = Variable("t", phase.time_unit, Range())
    if layout.t[1] >= 0 and phase.final_time != Range():
        yield replace(_once(phase.name, f"the final time{whose}", time, layout.t[[1]], phase.final_time), of_time=True)


def _once(phase: str, what: str, variable: Variable, places: np.ndarray, bounds: Range) -> Soft:
    size = _size(variable.bounds if variable.bounds != Range() else bounds, bounds)
    of_unknowns = np.ones(len(places), bool)
    return Soft(phase, what, variable.unit, of_unknowns, False, places, np.zeros(1), bounds.lower, bounds.upper, size)


def _bounds(variable: Variable, layout: Layout, places: np.ndarray, rows: list[tuple[int, float]]) -> Iterator[Soft]:
    """Of unknowns, and of rows (number, normalised time) where the state is none."""
    phase, inside = layout.phase.name, places.copy()
    if isinstance(variable, State):
        inside[[0, -1]] = np.where(variable.own_ends, -1, inside[[0, -1]])  # these have a name of their own
    at = np.flatnonzero(inside >= 0)
    if variable.bounds == Range() or not (len(at) or rows):
        return
    what, bounds = f"the bounds of {variable.name}{of_phase(phase)}", variable.bounds
    size = _size(bounds, bounds)
    every = [*zip(inside[at].tolist(), layout.mesh.fractions[at].tolist(), strict=True), *rows]
    numbers, s = np.array([own[0] for own in every], int), np.array([own[1] for own in every])
    of_unknowns = np.arange(len(every)) < len(at)
    yield Soft(phase, what, variable.unit, of_unknowns, True, numbers, s, bounds.lower, bounds.upper, size)


def _constraints(transcription: Transcription, nlp: NonlinearProgram) -> Iterator[Soft]:
    named: dict[tuple[str, str, str], list[Family]] = {}
    for family in transcription.families:
        if not (family.kind.model or family.kind is BOUND):
            named.setdefault((family.phase, family.kind.phrase, family.name), []).append(family)
    for (phase, _, name), same in named.items():
        kind: ConstraintKind = same[0].kind
        rows = np.concatenate([family.rows(nlp) for family in same])
        s = np.concatenate([family.span[:, 0] for family in same])
        lower, upper = float(nlp.cl[rows].max()), float(nlp.cu[rows].min())
        over_time = kind.multiplier is Multiplier.DENSITY
        size = _size(Range(lower, upper), Range(lower, upper))
        what = constraint_named(phase, kind, name)
        yield Soft(phase, what, "", np.zeros(len(rows), bool), over_time, rows, s, lower, upper, size)


def _size(of_values: Range, bounds: Range) -> float:
    """Of what a relaxation is relative to: the range of the values, else their bounds, else 1."""
    width = of_values.upper - of_values.lower
    if isfinite(width) and width > 0:
        return width
    sizes = [abs(end) for end in (bounds.lower, bounds.upper) if isfinite(end)]
    largest = max(sizes, default=0.0)
    return largest if largest > NEGLIGIBLE else 1.0
