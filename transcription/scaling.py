"""Automatic scaling of the nonlinear program: one rule.

    variable     divided by its typical size: half the distance of its bounds where both are given, else the largest
                 magnitude along the guess, else 1; one size for a state or control at all times
    defect       divided by the size of its state, so that 1e-8 means the same relative error everywhere
    constraint   divided by the largest entry of its Jacobian row, where that exceeds 1
    objective    divided by the largest entry of its gradient / 100, where that exceeds 1

Jacobian and gradient are those by the scaled variables. Sizes are kept within 1e-4 and 1e4. A file may give the size
of any variable itself. IPOPT unscales its results, so that objective, multipliers and costates are those of the problem
as stated.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from ..problems.lean.records import dataclass
from ..problems.quantities import Range, Variable
from ..problems.text import short_repr
from .layout import Transcription
from .program.contract import NonlinearProgram, NotFinite

SIZES = (1e-4, 1e4)
TIME = "t"
"""The name of the size of free times; no variable is called so."""
LARGE_GRADIENT = 100.0  # IPOPT's own nlp_scaling_max_gradient


@short_repr
@dataclass(frozen=True)
class Scaling:
    """Factors that IPOPT multiplies with: objective, z (n,), g (m,); and the sizes they come from, by name.

    With several phases the name of a variable of one of them is phase.name.
    """

    objective: float
    z: np.ndarray
    g: np.ndarray
    sizes: Mapping[str, float]


def scale(transcription: Transcription, nlp: NonlinearProgram, z: np.ndarray, given: Mapping[str, float]) -> Scaling:
    """The scaling of a nonlinear program at its initial values.

    transcription: what stands where.
    nlp: its compiled program, asked for its gradient and Jacobian once.
    z: initial values of the unknowns, shape (n,).
    given: sizes by name, in the unit of each variable, from the problem file or as IPOPT needs them; they go before the
        automatic ones. That of free times is 1 unless it is given.
    """
    sizes = dict(_sizes(transcription, z, given))
    factors = np.ones(nlp.n)
    for layout in transcription.phases:
        for variables, rows in ((layout.phase.states, layout.x), (layout.phase.inputs, layout.u)):
            for variable, places in zip(variables, rows, strict=True):
                factors[places[places >= 0]] = 1 / sizes[_told(transcription, layout.phase.name, variable.name)]
        factors[layout.t[layout.t >= 0]] = 1 / given.get(TIME, 1.0)
    for parameter, place in zip(transcription.problem.parameters, transcription.parameters, strict=True):
        factors[place] = 1 / sizes[parameter.name]
    return Scaling(_objective(nlp, z, factors), factors, _rows(transcription, nlp, z, factors, sizes), sizes)


def _sizes(transcription: Transcription, z: np.ndarray, given: Mapping[str, float]) -> Iterator[tuple[str, float]]:
    for layout in transcription.phases:
        for variables, rows in ((layout.phase.states, layout.x), (layout.phase.inputs, layout.u)):
            for variable, places in zip(variables, rows, strict=True):
                size = given.get(variable.name) or _size(variable, z[places[places >= 0]])
                yield _told(transcription, layout.phase.name, variable.name), size
    for parameter, place in zip(transcription.problem.parameters, transcription.parameters, strict=True):
        yield parameter.name, given.get(parameter.name) or _size(parameter, z[[place]])


def _told(transcription: Transcription, phase: str, name: str) -> str:
    """The name under which the size of a variable is kept."""
    return name if len(transcription.phases) == 1 else f"{phase}.{name}"


def _size(variable: Variable, values: np.ndarray) -> float:
    bounds: Range = variable.bounds
    if np.isfinite(bounds.lower) and np.isfinite(bounds.upper) and bounds.upper > bounds.lower:
        size = (bounds.upper - bounds.lower) / 2
    else:
        size = float(np.abs(values).max(initial=0.0)) or 1.0
    return float(np.clip(size, *SIZES))


def _rows(
    transcription: Transcription, nlp: NonlinearProgram, z: np.ndarray, factors: np.ndarray, sizes: Mapping[str, float]
) -> np.ndarray:
    g = np.ones(nlp.m)
    largest = np.zeros(nlp.m)
    try:
        rows, cols = nlp.jacobianstructure()
        np.maximum.at(largest, rows, np.abs(nlp.jacobian(z)) / factors[cols])
    except NotFinite:
        largest[:] = 1.0
    for family in transcription.families:
        rows = family.rows(nlp)
        if family.kind.sized:
            g[rows] = 1 / sizes[_told(transcription, family.phase, family.name)]
        else:
            g[rows] = 1 / np.clip(largest[rows].max(initial=1.0), 1.0, SIZES[1])
    return g


def _objective(nlp: NonlinearProgram, z: np.ndarray, factors: np.ndarray) -> float:
    try:
        largest = float((np.abs(nlp.gradient(z)) / factors).max(initial=0.0))
    except NotFinite:
        return 1.0
    return LARGE_GRADIENT / largest if largest > LARGE_GRADIENT else 1.0
