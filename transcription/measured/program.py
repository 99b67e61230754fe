"""A nonlinear program whose objective has the residuals of measurements added: any program, of any methods."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..layout import Transcription
from ..program.contract import NonlinearProgram, WithTerm, callback
from .means import MeanResiduals
from .residuals import Residuals


def with_residuals(transcription: Transcription, nlp: NonlinearProgram) -> NonlinearProgram:
    """The program with the residuals of the measurements of all phases; itself where there are none.

    transcription: that the program is of.
    nlp: without measurements.
    """
    phases = [layout for layout in transcription.phases if layout.phase.measured]
    if not phases:
        return nlp
    names = [parameter.name for parameter in transcription.problem.parameters]
    measured = [
        kind(own, transcription.parameters, names, nlp.seconds)
        for own in phases
        for kind, of_means in ((Residuals, False), (MeanResiduals, True))
        if any((one.spans is not None) == of_means for one in own.phase.measured)
    ]
    return WithTerm(nlp, _Sum(measured, nlp.seconds))


class _Sum:
    """The residuals of all phases, an `ObjectiveTerm`; what is not finite is raised as by a program."""

    def __init__(self, measured: Sequence[Residuals | MeanResiduals], seconds: dict[str, float]) -> None:
        self.measured, self.seconds = measured, seconds
        rows, columns = zip(*(own.rows_columns for own in measured), strict=True)
        self.structure = np.concatenate(rows), np.concatenate(columns)

    def move(self, z: np.ndarray) -> None:
        """Nothing is kept of a point."""

    def culprits(self, kind: str, values: np.ndarray) -> list[tuple[str, int | None]]:
        """What is not finite in a callback."""
        return [("what is compared with the measurements", None)]

    @callback
    def objective(self, z: np.ndarray) -> float:
        """The sum of squares at z, shape (n,)."""
        return sum(own.value(z) for own in self.measured)

    @callback
    def gradient(self, z: np.ndarray) -> np.ndarray:
        """Its derivatives, shape (n,)."""
        found: np.ndarray = np.sum([own.gradient(z) for own in self.measured], axis=0)
        return found

    @callback
    def hessian(self, z: np.ndarray) -> np.ndarray:
        """The nonzeros of its second derivatives, phase by phase."""
        return np.concatenate([own.hessian(z) for own in self.measured])
