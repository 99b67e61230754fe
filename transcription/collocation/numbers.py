"""The numbers of a templated model: those in the slots of its program."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

from ..layout import BETWEEN, Transcription
from ..method_kind import TIMES, Number, Numbers
from ..program.compiler import CompiledNLP
from .forms import Forms, forms_of
from .model import by_model


def numbers(transcription: Transcription, nlp: CompiledNLP) -> Numbers:
    """The given times and the parameters of the file that are data of the machine code.

    transcription: by collocation schemes and finite differences.
    nlp: its compiled program.

    What is literal in the program is data in one of values only, which is made if there is anything literal.
    """
    problem = transcription.problem
    forms, most = forms_of(problem), forms_of(problem, values_only=True)
    found = _numbers(transcription, nlp, forms)
    if any(all_.data.keys() - own.data.keys() for own, all_ in zip(_each(forms), _each(most), strict=True)):
        meshes, guess = [layout.mesh for layout in transcription.phases], [phase.guess for phase in problem.phases]
        other = by_model(problem, meshes, guess, templates=True, values_only=True)
        found = _numbers(other, CompiledNLP(other.model, other.variables, "lambda"), most) | found
    return found


def _each(forms: Forms) -> tuple:
    return (*forms.phases, forms.links)


def _numbers(transcription: Transcription, nlp: CompiledNLP, forms: Forms) -> dict[tuple[str, str], Number]:
    leaves = _leaves(transcription, forms)
    return {key: Number(value, partial(_replaced, nlp, nlp.slot(leaf))) for key, value, leaf in leaves}


def _leaves(transcription: Transcription, forms: Forms) -> Iterator[tuple[tuple[str, str], float, Any]]:
    """(key, value, Param or fixed variable of the model) each."""
    model, problem = transcription.model, transcription.problem
    for phase, form in zip(problem.phases, forms.phases, strict=True):
        block = model.phase[phase.name]
        yield from (((phase.name, name), value, block.number[name]) for name, value in form.data.items())
        ends = (block.t0, phase.initial_time), (block.tF, phase.final_time)
        for name, (leaf, bounds) in zip(TIMES, ends, strict=True):
            if leaf.fixed:
                yield (phase.name, name), bounds.lower, leaf
    yield from (((BETWEEN, name), value, model.number[name]) for name, value in forms.links.data.items())


def _replaced(nlp: CompiledNLP, slot: int, value: float) -> CompiledNLP:
    return nlp.with_numbers({slot: value}, nlp.cl, nlp.cu)
