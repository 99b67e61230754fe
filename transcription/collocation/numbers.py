"""The numbers of a templated model: those in the slots of its program."""

from __future__ import annotations

from functools import partial

from ..layout import Transcription
from ..method_kind import DataNumber, Numbers
from ..program.compiled import CompiledNLP
from .forms import Forms, data_of, forms_of


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
        from .model import by_model, compiled_model  # Pyomo

        meshes, guess = [layout.mesh for layout in transcription.phases], [phase.guess for phase in problem.phases]
        other = by_model(problem, meshes, guess, templates=True, values_only=True)
        found = _numbers(other, compiled_model(other, "lambda"), most) | found
    return found


def _each(forms: Forms) -> tuple:
    return (*forms.phases, forms.links)


def _numbers(transcription: Transcription, nlp: CompiledNLP, forms: Forms) -> dict[tuple[str, str], DataNumber]:
    values = data_of(transcription.problem, forms)
    return {key: DataNumber(values[key], partial(_replaced, nlp, slot)) for key, slot in nlp.slots.items()}


def _replaced(nlp: CompiledNLP, slot: int, value: float) -> CompiledNLP:
    return nlp.with_numbers({slot: value}, nlp.cl, nlp.cu)
