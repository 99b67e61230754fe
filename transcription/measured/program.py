"""A nonlinear program whose objective has the residuals of measurements added: any program, of any methods."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..layout import Transcription
from ..program.contract import NonlinearProgram, callback
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
    return MeasuredNLP(nlp, [Residuals(own, transcription.parameters, names, nlp.seconds) for own in phases])


class MeasuredNLP:
    """The callbacks, numbers and names of a program, with residuals in the objective.

    What it does not say itself the program says: rows, constraints and their derivatives, and what costates are made
    of; measurements are no part of a segment.
    """

    def __init__(self, nlp: NonlinearProgram, measured: Sequence[Residuals]) -> None:
        self.nlp, self.measured = nlp, _Sum(measured, nlp.seconds)
        structure = [nlp.hessianstructure(), *(own.rows_columns for own in measured)]
        self._structure = tuple(np.concatenate(part) for part in zip(*structure, strict=True))

    def __getattr__(self, name: str) -> Any:
        return getattr(self.nlp, name)

    def objective(self, z: np.ndarray) -> float:
        """f(z)."""
        return self.nlp.objective(z) + self.measured.objective(z)

    def gradient(self, z: np.ndarray) -> np.ndarray:
        """df/dz, shape (n,)."""
        return self.nlp.gradient(z) + self.measured.gradient(z)

    def hessianstructure(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns (row >= column) of the nonzeros of the Hessian; those that stand twice are added."""
        rows, columns = self._structure
        return rows, columns

    def hessian(self, z: np.ndarray, y: np.ndarray, sigma: float) -> np.ndarray:
        """The nonzeros of d2(sigma f + y g)/dz2, in the order of hessianstructure(). y: (m,) multipliers."""
        return np.concatenate([self.nlp.hessian(z, y, sigma), sigma * self.measured.hessian(z)])


class _Sum:
    """The residuals of all phases; what is not finite is raised as by a program."""

    def __init__(self, measured: Sequence[Residuals], seconds: dict[str, float]) -> None:
        self.measured, self.seconds = measured, seconds

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
