"""Phases by methods of different kinds, or by shooting with links: a transcription of several.

The phases of each kind are transcribed by themselves, as a part; the unknowns of the parts stand one after the other,
and static parameters, which are shared, once. Links and the objective of the whole trajectory are functions of the
unknowns at the ends.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.problem import Curves, Problem
from ...problems.text import short_repr
from ..constraint_kinds import kind_between
from ..layout import BETWEEN, Family, Layout, Transcription
from ..method_kind import MethodKind
from ..schemes.mesh import Mesh


@short_repr
@dataclass(frozen=True, eq=False)
class PartProgram:
    """The phases of one kind of method. places: (n,) where its unknowns stand among all."""

    kind: MethodKind
    transcription: Transcription
    places: np.ndarray


@short_repr
@dataclass(frozen=True, eq=False)
class PartRows:
    """A component of a part's families; part is None for the links, of which component is the number."""

    part: int | None
    component: Any


@short_repr
@dataclass(frozen=True)
class JoinedTranscription(Transcription):
    """A transcription made of parts; it has no Pyomo model."""

    parts: tuple[PartProgram, ...] = ()


def by_parts(
    kind_of: Callable[[Mesh], MethodKind], problem: Problem, meshes: Sequence[Mesh], guess: Sequence[Curves]
) -> JoinedTranscription:
    """The program of phases of any kinds.

    kind_of: the kind of the method of a mesh.
    problem: one that no method refuses.
    meshes: one for each phase.
    guess: one for each phase.
    """
    simulated = [mesh.schemes[0].simulated for mesh in meshes]
    parts: list[PartProgram] = []
    variables: list[Any] = []
    layouts: dict[int, Layout] = {}
    parameters = np.zeros(0, int)
    for kind in dict.fromkeys(simulated):
        numbers = [i for i, own in enumerate(simulated) if own == kind]
        own = replace(problem, phases=tuple(problem.phases[i] for i in numbers), links=(), mayer=None)
        method, chosen = kind_of(meshes[numbers[0]]), [meshes[i] for i in numbers]
        part = method.transcribe(own, chosen, [guess[i] for i in numbers], True)
        places = np.full(len(part.variables), -1)
        if variables:
            places[part.parameters] = parameters
        new = np.flatnonzero(places < 0)
        places[new] = len(variables) + np.arange(len(new))
        variables += [part.variables[k] for k in new.tolist()]
        parameters = places[part.parameters]
        parts.append(PartProgram(method, part, places))
        layouts |= {i: _moved(layout, places) for i, layout in zip(numbers, part.phases, strict=True)}
    families = [
        replace(family, component=PartRows(number, family.component))
        for number, part in enumerate(parts)
        for family in part.transcription.families
    ]
    span, one = np.array([[0.0, 1.0]]), np.ones(1)
    families += [
        Family(PartRows(None, i), BETWEEN, kind_between(link), link.name, span, one)
        for i, link in enumerate(problem.links)
    ]
    phases = tuple(layouts[i] for i in range(len(meshes)))
    return JoinedTranscription(problem, None, tuple(variables), phases, parameters, tuple(families), tuple(parts))


def _moved(layout: Layout, places: np.ndarray) -> Layout:
    """The layout of a phase among the unknowns of all."""
    x, u, t = (np.where(own >= 0, places[own], -1) for own in (layout.x, layout.u, layout.t))
    return replace(layout, x=x, u=u, t=t)
