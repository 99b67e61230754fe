"""Programs that are kept, to be solved again with other numbers.

What a nonlinear program is depends on the form of the problem's functions, on the meshes, and on which bounds there
are. Everything else is numbers: the bounds themselves, given times, the parameters of the file (`problems.expressions.
structure` says which of them are data), and the first trajectory. So the next case of a sweep, another start, or the
same problem with its multipliers dropped has a program that differs in numbers from one that was made before.

A program is kept only if its numbers, put together here, are exactly those that Pyomo had when it was made.
"""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import isfinite
from typing import Any

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.problem import Curves, Problem
from ...problems.quantities import Range
from ..layout import Layout, Transcription, Unknown, bounded_start, range_of_rows
from ..method_kind import Program
from ..program.alone import LOCK
from ..program.compiler import CompiledNLP
from ..schemes.mesh import Mesh
from .forms import GROUPS, Forms, forms_of
from .model import by_model, compiled_model

MOST, UNKNOWNS = 16, 50_000
"""Programs that are kept, and the unknowns of all of them: with its Pyomo model each takes 1 kB for an unknown."""


@dataclass(frozen=True, eq=False)
class Kept:
    """A program and where its numbers are. data: slot -> the number of a problem that stands in it."""

    transcription: Transcription
    nlp: CompiledNLP
    data: Mapping[int, Callable[[Problem, Forms], float]]


_kept: OrderedDict[Hashable, Kept] = OrderedDict()


def program(problem: Problem, meshes: Sequence[Mesh], guess: Sequence[Curves]) -> Program:
    """The transcription of a problem and its program, from one that is kept where there is one.

    problem: one that no method refuses.
    meshes: one for each phase, of collocation schemes.
    guess: one for each phase.
    """
    forms = forms_of(problem)
    key = forms.key, tuple((mesh.schemes, mesh.widths.tobytes()) for mesh in meshes)
    with LOCK:
        kept = _kept.get(key)
        if kept is not None:
            _kept.move_to_end(key)
    if kept is not None:
        return _again(kept, problem, forms, guess)
    transcription = by_model(problem, meshes, guess, templates=True)
    built = time.perf_counter()
    nlp = compiled_model(transcription)
    delays = any(phase.delayed for phase in problem.phases)  # their histories are numbers that no form tells
    if not delays and nlp.n <= UNKNOWNS and (new := _kept_as(transcription, nlp, forms, guess)):
        with LOCK:
            _kept[key] = new
            while len(_kept) > MOST or sum(own.nlp.n for own in _kept.values()) > UNKNOWNS:
                _kept.popitem(last=False)
    return Program(transcription, nlp, built)


def _again(kept: Kept, problem: Problem, forms: Forms, guess: Sequence[Curves]) -> Program:
    """A kept program with the numbers of a problem, whose form is `forms`."""
    old = kept.transcription
    layouts = tuple(replace(own, phase=phase) for own, phase in zip(old.phases, problem.phases, strict=True))
    z, lower, upper = _unknowns(problem, layouts, old.parameters, guess)
    variables = tuple(map(Unknown, z.tolist(), zip(*map(_or_none, (lower, upper)), strict=True)))
    built = time.perf_counter()
    numbers = {slot: number(problem, forms) for slot, number in kept.data.items()}
    nlp = kept.nlp.with_numbers(numbers, *_bounds(problem, old, kept.nlp))
    return Program(replace(old, problem=problem, variables=variables, phases=layouts), nlp, built)


def _or_none(bounds: np.ndarray) -> list[float | None]:
    return [bound if isfinite(bound) else None for bound in bounds.tolist()]


def _kept_as(transcription: Transcription, nlp: CompiledNLP, forms: Forms, guess: Sequence[Curves]) -> Kept | None:
    """A new program with the places of its numbers; None if it cannot be made again of numbers alone."""
    problem = transcription.problem
    if not _told_apart(problem):
        return None
    data = dict(_data(transcription, nlp, forms))
    told = [*_unknowns(problem, transcription.phases, transcription.parameters, guess)]
    told += _bounds(problem, transcription, nlp)
    had = [*bounded_start(transcription), nlp.cl, nlp.cu]
    if not all(map(np.array_equal, told, had)):
        return None
    if any(number(problem, forms) != nlp.number(slot) for slot, number in data.items()):
        return None
    return Kept(transcription, nlp, data)


def _told_apart(problem: Problem) -> bool:
    """Whether every constraint can be found by its name."""
    groups = [problem.links, *(getattr(p, kind) for p in problem.phases for kind in GROUPS)]
    return all(len({own.name for own in group}) == len(group) for group in groups)


def _data(
    transcription: Transcription, nlp: CompiledNLP, forms: Forms
) -> Iterator[tuple[int, Callable[[Problem, Forms], float]]]:
    """The slots of given times and of parameters, and how to read them off a problem."""
    model = transcription.model
    for i, phase in enumerate(transcription.problem.phases):
        block = model.phase[phase.name]
        yield from ((nlp.slot(block.number[name]), partial(_of_phase, i, name)) for name in forms.phases[i].data)
        for leaf, end in ((block.t0, "initial_time"), (block.tF, "final_time")):
            if leaf.fixed:
                yield nlp.slot(leaf), partial(_time, i, end)
    yield from ((nlp.slot(model.number[name]), partial(_between, name)) for name in forms.links.data)


def _of_phase(i: int, name: str, problem: Problem, forms: Forms) -> float:
    return float(forms.phases[i].data[name])


def _between(name: str, problem: Problem, forms: Forms) -> float:
    return float(forms.links.data[name])


def _time(i: int, end: str, problem: Problem, forms: Forms) -> float:
    bounds: Range = getattr(problem.phases[i], end)
    return float(bounds.lower)


def _unknowns(
    problem: Problem, layouts: Sequence[Layout], parameters: np.ndarray, guess: Sequence[Curves]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """As `layout.bounded_start`: first values, lower and upper bounds of the unknowns, (n,) each."""
    places = [parameters, *(own for layout in layouts for own in (layout.x, layout.u, layout.t))]
    table = np.zeros((3, 1 + max(int(own.max(initial=-1)) for own in places)))

    def put(places: np.ndarray, values: Any, bounds: Range) -> None:
        free = places >= 0
        table[0, places[free]] = np.broadcast_to(values, places.shape)[free]
        table[1:, places[free]] = [[bounds.lower], [bounds.upper]]

    for layout, start in zip(layouts, guess, strict=True):
        phase, curves = layout.phase, start.samples(layout.mesh.fractions)
        for places, state in zip(layout.x, phase.states, strict=True):
            put(places, curves[state.name], state.bounds)
            for k, ends in ((0, state.initial), (-1, state.final)):
                put(places[[k]], curves[state.name][k], ends)
        for places, variable in zip(layout.u, phase.inputs, strict=True):
            put(places, curves[variable.name], variable.bounds)
        put(layout.t[:1], start.initial_time, phase.initial_time)
        put(layout.t[1:], start.final_time, phase.final_time)
    start_of = problem.start_of_parameters(guess)
    for place, own in zip(parameters, problem.parameters, strict=True):
        put(np.array([place]), start_of[own.name], own.bounds)
    z, lower, upper = table
    return z, lower, upper


def _bounds(problem: Problem, transcription: Transcription, nlp: CompiledNLP) -> tuple[np.ndarray, np.ndarray]:
    """The bounds of the rows of a problem's program, (m,) each. transcription, nlp: of another with the same rows."""
    lower, upper = np.zeros((2, nlp.m))
    for family in transcription.families:
        bounds = range_of_rows(problem, family)
        rows = family.rows(nlp)
        lower[rows], upper[rows] = bounds.lower, bounds.upper
    return lower, upper
