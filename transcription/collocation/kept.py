"""Programs that are kept, to be solved again with other numbers.

What a nonlinear program is depends on the form of the problem's functions, on the meshes, and on which bounds there
are. Everything else is numbers: the bounds themselves, given times, the parameters of the file (`problems.expressions.
structure` says which of them are data), and the first trajectory. So the next case of a sweep, another start, or the
same problem with its multipliers dropped has a program that differs in numbers from one that was made before.

A program is kept only if its numbers, put together here, are exactly those that Pyomo had when it was made.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from ...problems.expressions.structure import Form, form_of
from ...problems.probe import depends_on
from ...problems.problem import Curves, Function, Phase, Problem, Range
from ..constraint_kinds import BOUND, DEFECT, PATH, PATH_END, ConstraintKind
from ..layout import Layout, Transcription, Unknown, bounded_start
from ..program.alone import LOCK
from ..program.compiler import CompiledNLP
from ..schemes.mesh import Mesh

MOST, LARGEST = 16, 20_000
"""Programs that are kept, and unknowns of one: each holds its Pyomo model, some 2 kB for each unknown."""

EQUAL = Range(0.0, 0.0)
_GROUPS = ("residuals", "path", "boundary", "integral")


class Forms(NamedTuple):
    """The form of a problem's functions: key, equal where one program serves; phases, links: with their data."""

    key: Hashable
    phases: tuple[Form, ...]
    links: Form


def forms_of(problem: Problem) -> Forms:
    """The form of a problem and the data of its functions, for each phase and for what is between phases."""
    phases = tuple(form_of(_functions(phase)) for phase in problem.phases)
    links = form_of([*(link.function for link in problem.links), problem.mayer])
    shape = [
        problem.sense,
        *((own.name, _shape(own.bounds)) for own in problem.parameters),
        *((link.name, _shape(link.bounds)) for link in problem.links),
        *(_shape_of_phase(phase) for phase in problem.phases),
    ]
    return Forms((tuple(shape), *(form.form for form in (*phases, links))), phases, links)


def _functions(phase: Phase) -> list[Function | None]:
    constraints = [own for kind in _GROUPS for own in getattr(phase, kind)]
    return [*(state.rate for state in phase.states), *(c.function for c in constraints), phase.lagrange, phase.mayer]


def _shape(bounds: Range) -> tuple[bool, bool, bool]:
    return isfinite(bounds.lower), isfinite(bounds.upper), bounds.fixed


def _shape_of_phase(phase: Phase) -> Hashable:
    inputs = {variable.name for variable in phase.inputs}
    groups = [getattr(phase, kind) for kind in _GROUPS]
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


@dataclass(frozen=True, eq=False)
class Kept:
    """A program and where its numbers are. data: slot -> the number of a problem that stands in it."""

    transcription: Transcription
    nlp: CompiledNLP
    data: Mapping[int, Callable[[Problem, Forms], float]]


class Ready(NamedTuple):
    """What `Transcription.program` is: of a new transcription, how it is kept; of a known one, its program."""

    forms: Forms
    key: Hashable
    guess: Sequence[Curves]
    nlp: CompiledNLP | None


_kept: OrderedDict[Hashable, Kept] = OrderedDict()


def key_of(forms: Forms, meshes: Sequence[Mesh]) -> Hashable:
    """What programs have in common that differ in numbers only.

    forms: of the problem.
    meshes: one for each phase.
    """
    return forms.key, tuple((mesh.schemes, mesh.widths.tobytes()) for mesh in meshes)


def known(problem: Problem, forms: Forms, key: Hashable, guess: Sequence[Curves]) -> Transcription | None:
    """The transcription of a problem whose program is kept, with its own numbers; None if none is.

    problem: to be solved.
    forms: of it.
    key: of it and its meshes.
    guess: one for each phase.
    """
    with LOCK:
        kept = _kept.get(key)
        if kept is None:
            return None
        _kept.move_to_end(key)
    old = kept.transcription
    layouts = tuple(replace(own, phase=phase) for own, phase in zip(old.phases, problem.phases, strict=True))
    z, lower, upper = _unknowns(problem, layouts, old.parameters, guess)
    variables = tuple(map(Unknown, z.tolist(), zip(*map(_or_none, (lower, upper)), strict=True)))
    numbers = {slot: number(problem, forms) for slot, number in kept.data.items()}
    nlp = kept.nlp.with_numbers(numbers, *_bounds(problem, old, kept.nlp))
    return replace(old, problem=problem, variables=variables, phases=layouts, program=Ready(forms, key, guess, nlp))


def _or_none(bounds: np.ndarray) -> list[float | None]:
    return [bound if isfinite(bound) else None for bound in bounds.tolist()]


def keep(transcription: Transcription, ready: Ready, nlp: CompiledNLP) -> None:
    """Keep the program of a transcription, if it can be made again of numbers alone.

    transcription: new.
    ready: its form, its key and where it starts.
    nlp: its program.
    """
    problem = transcription.problem
    if nlp.n > LARGEST or not _told_apart(problem):
        return
    data = dict(_data(transcription, nlp, ready.forms))
    told = [*_unknowns(problem, transcription.phases, transcription.parameters, ready.guess)]
    told += _bounds(problem, transcription, nlp)
    had = [*bounded_start(transcription), nlp.cl, nlp.cu]
    if not all(map(np.array_equal, told, had)):
        return
    if any(number(problem, ready.forms) != nlp.number(slot) for slot, number in data.items()):
        return
    with LOCK:
        _kept[ready.key] = Kept(replace(transcription, program=None), nlp, data)
        while len(_kept) > MOST:
            _kept.popitem(last=False)


def _told_apart(problem: Problem) -> bool:
    """Whether every constraint can be found by its name."""
    groups = [problem.links, *(getattr(p, kind) for p in problem.phases for kind in _GROUPS)]
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
    return forms.phases[i].data[name]


def _between(name: str, problem: Problem, forms: Forms) -> float:
    return forms.links.data[name]


def _time(i: int, end: str, problem: Problem, forms: Forms) -> float:
    bounds: Range = getattr(problem.phases[i], end)
    return bounds.lower


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
    for place, own in zip(parameters, problem.parameters, strict=True):
        put(np.array([place]), guess[0].parameters[own.name], own.bounds)
    z, lower, upper = table
    return z, lower, upper


def _bounds(problem: Problem, transcription: Transcription, nlp: CompiledNLP) -> tuple[np.ndarray, np.ndarray]:
    """The bounds of the rows of a problem's program, (m,) each. transcription, nlp: of another with the same rows."""
    phases = {phase.name: phase for phase in problem.phases}
    lower, upper = np.zeros((2, nlp.m))
    for family in transcription.families:
        bounds = _range(problem, phases.get(family.phase), family.kind, family.name)
        rows = family.rows(nlp)
        lower[rows], upper[rows] = bounds.lower, bounds.upper
    return lower, upper


def _range(problem: Problem, phase: Phase | None, kind: ConstraintKind, name: str) -> Range:
    """The range of what a family holds."""
    if phase is None:  # of several
        return next(link.bounds for link in problem.links if link.name == name)
    if kind is BOUND:
        return next(state.bounds for state in phase.states if state.name == name)
    if kind is DEFECT:
        return EQUAL
    constraints = getattr(phase, PATH.functions if kind is PATH_END else kind.functions)
    return next(own.bounds for own in constraints if own.name == name)
