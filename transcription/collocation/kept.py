"""Programs that are kept, to be solved again with other numbers: in memory, and in the cache on the disk.

What a nonlinear program is depends on the form of the problem's functions, on the meshes, and on which bounds there
are. Everything else is numbers: the bounds themselves, given times, the parameters of the file (`problems.names.
structure` says which of them are data), and the first trajectory. So the next case of a sweep, another start, or the
same problem with its multipliers dropped has a program that differs in numbers from one that was made before.

A program is kept only if its numbers, put together here, are exactly those that Pyomo had when it was made. One that
is read from the disk has no Pyomo model: nothing in a solve needs it, and Pyomo is not even loaded.
"""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Hashable, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ...problems.expressions.expression import Expression
from ...problems.lean.records import dataclass, only_fields
from ...problems.problem import Curves, Problem
from ...problems.quantities import Range
from ..cache.kept import keep, load_kept, name_of_kept
from ..layout import Layout, Transcription, Unknowns, bounded_start, range_of_rows
from ..libraries.alone import LOCK
from ..method_kind import DataNumber, Numbers, Program
from ..program.compiled import CompiledNLP
from ..schemes.mesh import Mesh
from .forms import GROUPS, Forms, forms_of, numbers_as_data

MOST, UNKNOWNS = 16, 50_000
"""Programs that are kept in memory, and the unknowns of all of them: with its Pyomo model each takes 1 kB for an
unknown."""

ON_DISK = 200_000
"""Unknowns of a program that is kept on the disk, about 170 bytes for each of them. Read from there, a second solve
of the cart-pole takes 0.72 of the CPU seconds at 12,000 unknowns, and 0.68 at 120,000."""


@dataclass(frozen=True, eq=False)
class KeptProgram:
    """A program, and the transcription that it was made of; its numbers are replaced."""

    transcription: Transcription
    nlp: CompiledNLP


_kept: OrderedDict[Hashable, KeptProgram] = OrderedDict()


def kept_program(problem: Problem, meshes: Sequence[Mesh], guess: Sequence[Curves]) -> Program:
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
    on_disk = _name(problem, forms, meshes)
    stored = load_kept(on_disk)
    if stored is not None:
        kept = _restored(stored, problem, meshes)
        _remember(key, kept)
        return _again(kept, problem, forms, guess)
    return _made(problem, meshes, guess, forms, key, on_disk)


def _made(
    problem: Problem, meshes: Sequence[Mesh], guess: Sequence[Curves], forms: Forms, key: Hashable, on_disk: str | None
) -> Program:
    """A new program, kept if it can be made again of numbers alone."""
    from .model import by_model, compiled_model  # Pyomo

    transcription = by_model(problem, meshes, guess, templates=True)
    built = time.perf_counter()
    nlp = compiled_model(transcription)
    delays = any(phase.delayed for phase in problem.phases)  # their histories are numbers that no form tells
    if not delays and nlp.n <= ON_DISK and _is_told_by_numbers(transcription, nlp, forms, guess):
        kept = KeptProgram(transcription, nlp)
        _remember(key, kept)
        keep(on_disk, _stored(kept))
    return Program(transcription, nlp, built)


def _remember(key: Hashable, kept: KeptProgram) -> None:
    if kept.nlp.n > UNKNOWNS:
        return
    with LOCK:
        _kept[key] = kept
        while len(_kept) > MOST or sum(own.nlp.n for own in _kept.values()) > UNKNOWNS:
            _kept.popitem(last=False)


def _name(problem: Problem, forms: Forms, meshes: Sequence[Mesh]) -> str | None:
    """The name in the cache of the program; None where a function is no expression, and only itself knows its form."""
    phases = [own for phase in problem.phases for own in (*phase.over_time, *phase.at_ends)]
    between = [*(link.function for link in problem.links), *([problem.mayer] if problem.mayer else [])]
    if not all(isinstance(function, Expression) for function in (*phases, *between)):
        return None
    return name_of_kept("program", (repr(forms.key), [_told(mesh) for mesh in meshes]))


def _told(mesh: Mesh) -> tuple:
    """All that a mesh is, by value: its schemes, which of them each segment has, and the widths."""
    schemes = list(dict.fromkeys(mesh.schemes))
    values = [{key: _value(own) for key, own in only_fields(scheme).items()} for scheme in schemes]
    return values, [schemes.index(scheme) for scheme in mesh.schemes], mesh.widths.tobytes()


def _value(of: Any) -> Any:
    return (of.shape, of.dtype.str, of.tobytes()) if isinstance(of, np.ndarray) else repr(of)


def _stored(kept: KeptProgram) -> tuple:
    """What is kept on the disk: without the model, the problem and the meshes, which the next one has itself."""
    t = kept.transcription
    families = tuple(replace(family, component=family.component.name) for family in t.families)
    layouts = [{key: own for key, own in vars(layout).items() if key not in ("phase", "mesh")} for layout in t.phases]
    return t.parameters, families, layouts, kept.nlp


def _restored(stored: tuple, problem: Problem, meshes: Sequence[Mesh]) -> KeptProgram:
    parameters, families, layouts, nlp = stored
    every = zip(problem.phases, meshes, layouts, strict=True)
    placed = tuple(Layout(phase, mesh, **rest) for phase, mesh, rest in every)
    return KeptProgram(Transcription(problem, None, (), placed, parameters, families), nlp)


def _again(kept: KeptProgram, problem: Problem, forms: Forms, guess: Sequence[Curves]) -> Program:
    """A kept program with the numbers of a problem, whose form is `forms`."""
    old = kept.transcription
    layouts = tuple(replace(own, phase=phase) for own, phase in zip(old.phases, problem.phases, strict=True))
    variables = Unknowns(*_unknowns(problem, layouts, old.parameters, guess))
    built = time.perf_counter()
    values = numbers_as_data(problem, forms)
    numbers = {slot: values[key] for key, slot in kept.nlp.slots.items()}
    nlp = kept.nlp.with_numbers(numbers, *_bounds(problem, old, kept.nlp))
    return Program(replace(old, problem=problem, variables=variables, phases=layouts), nlp, built)


def _is_told_by_numbers(transcription: Transcription, nlp: CompiledNLP, forms: Forms, guess: Sequence[Curves]) -> bool:
    """Whether a new program can be made again of numbers alone."""
    problem = transcription.problem
    if not _told_apart(problem):
        return False
    told = [*_unknowns(problem, transcription.phases, transcription.parameters, guess)]
    told += _bounds(problem, transcription, nlp)
    had = [*bounded_start(transcription), nlp.cl, nlp.cu]
    values = numbers_as_data(problem, forms)
    return all(map(np.array_equal, told, had)) and all(values[key] == nlp.number(k) for key, k in nlp.slots.items())


def _told_apart(problem: Problem) -> bool:
    """Whether every constraint can be found by its name."""
    groups = [problem.links, *(getattr(p, kind) for p in problem.phases for kind in GROUPS)]
    return all(len({own.name for own in group}) == len(group) for group in groups)


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


# -- other numbers in a program ------------------------------------------------------------------------------------


def numbers(transcription: Transcription, nlp: CompiledNLP) -> Numbers:
    """The given times and the parameters of the file that are data of the machine code.

    transcription: by collocation schemes and finite differences.
    nlp: its compiled program.

    What is literal in the program is data in one of values only, which is made if there is anything literal.
    """
    problem = transcription.problem
    forms, most = forms_of(problem), forms_of(problem, values_only=True)
    found = _in_slots(transcription, nlp, forms)
    if any(all_.data.keys() - own.data.keys() for own, all_ in zip(_each(forms), _each(most), strict=True)):
        from .model import by_model, compiled_model  # Pyomo

        meshes, guess = [layout.mesh for layout in transcription.phases], [phase.guess for phase in problem.phases]
        other = by_model(problem, meshes, guess, templates=True, values_only=True)
        found = _in_slots(other, compiled_model(other, "lambda"), most) | found
    return found


def _each(forms: Forms) -> tuple:
    return (*forms.phases, forms.links)


def _in_slots(transcription: Transcription, nlp: CompiledNLP, forms: Forms) -> dict[tuple[str, str], DataNumber]:
    values = numbers_as_data(transcription.problem, forms)
    return {key: DataNumber(values[key], partial(_replaced, nlp, slot)) for key, slot in nlp.slots.items()}


def _replaced(nlp: CompiledNLP, slot: int, value: float) -> CompiledNLP:
    return nlp.with_numbers({slot: value}, nlp.cl, nlp.cu)
