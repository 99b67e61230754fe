"""The nonlinear program of a shooting method, with the callbacks of `compiled.CompiledNLP`."""

from __future__ import annotations

from copy import copy
from functools import partial

import numpy as np

from ...problems.quantities import Range
from ..collocation.forms import form_of_phase
from ..engines.outcome import Outcome
from ..method_kind import TIMES, DataNumber, Numbers
from ..program.contract import callback
from .phase import PhaseProgram
from .rows import ConstraintRows, ShootingTranscription


class ShootingNLP:
    """The callbacks, numbers and names of `compiled.CompiledNLP`, for a transcription by shooting.

    values_only: as of `structure.form_of`.
    """

    def __init__(self, transcription: ShootingTranscription, values_only: bool = False) -> None:
        self.transcription, self.values_only = transcription, values_only
        self.seconds = dict.fromkeys(("differentiate", "compile", "evaluate"), 0.0)
        self.n, self.sense = len(transcription.variables), transcription.problem.sense
        self._components: list[ConstraintRows] = [family.component for family in transcription.families]
        self.m = sum(component.rows.size for component in self._components)
        self.cl, self.cu = np.empty((2, self.m))
        for component in self._components:
            bounds: Range = component.bounds
            self.cl[component.rows], self.cu[component.rows] = bounds.lower, bounds.upper
        names = [p.name for p in transcription.problem.parameters]
        self._phases = [
            PhaseProgram(layout, rows, transcription.parameters, names, self.seconds, self.m, values_only)
            for layout, rows in zip(transcription.phases, transcription.rows, strict=True)
        ]
        self._z = np.full(self.n, np.nan)
        self._jacobian = _Places([place for phase in self._phases for place in phase.jacobian_places()])
        self._hessian = _Places([place for phase in self._phases for place in phase.hessian_places()])

    def numbers(self) -> Numbers:
        """The given times of each phase, and the parameters of the file that are data; what is literal, is data in a
        program of values only."""
        found: dict[tuple[str, str], DataNumber] = {}
        most = [form_of_phase(own.phase, values_only=True).data.keys() - own.numbers.keys() for own in self._phases]
        if any(most) and not self.values_only:
            found |= ShootingNLP(self.transcription, values_only=True).numbers()
        for i, own in enumerate(self._phases):
            times = zip(TIMES, (own.phase.initial_time, own.phase.final_time), own.layout.t, strict=True)
            values = {**own.numbers, **{name: bounds.lower for name, bounds, place in times if place < 0}}
            for name, value in values.items():
                found[own.phase.name, name] = DataNumber(value, partial(self._replaced, i, name))
        return found

    def _replaced(self, phase: int, name: str, value: float) -> ShootingNLP:
        other = copy(self)
        other._z = np.full(self.n, np.nan)
        other._phases = [p.with_number(name, value) if i == phase else copy(p) for i, p in enumerate(self._phases)]
        return other

    def rows(self, component: ConstraintRows) -> np.ndarray:
        """The row numbers of one group of constraints, in the order of their times."""
        return component.rows

    def row_name(self, row: int) -> tuple[str, int | None]:
        """(name, index) of a row."""
        component = next(c for c in self._components if (c.rows == row).any())
        return component.name, int(np.flatnonzero(component.rows == row)[0]) if component.rows.size > 1 else None

    def move(self, z: np.ndarray) -> None:
        if not np.array_equal(z, self._z):
            self._z = np.array(z)
            for phase in self._phases:
                phase.move(self._z)

    def culprits(self, kind: str, values: np.ndarray) -> list[tuple[str, int | None]]:
        """What is not finite in a callback: (name, index) each."""
        if kind == "constraints":
            return [self.row_name(row) for row in np.flatnonzero(~np.isfinite(values))[:10].tolist()]
        return [
            (f"the simulation of segment {segment + 1}", None)
            for phase in self._phases
            for s, group in zip(phase.groups, phase.layout.mesh.groups, strict=True)
            for segment in group.segments[~np.isfinite(s.x).all(axis=(1, 2))].tolist()
        ] or [("the " + kind, None)]

    @callback
    def objective(self, z: np.ndarray) -> float:
        """f(z)."""
        return self.sense * sum(phase.cost() for phase in self._phases)

    @callback
    def gradient(self, z: np.ndarray) -> np.ndarray:
        """df/dz, shape (n,)."""
        return self.sense * np.sum([phase.gradient(self.n + 1) for phase in self._phases], axis=0)[: self.n]

    @callback
    def constraints(self, z: np.ndarray) -> np.ndarray:
        """g(z), shape (m,)."""
        return self.constraints_unchecked(z)

    def constraints_unchecked(self, z: np.ndarray) -> np.ndarray:
        """g(z), shape (m,), with NaN and infinity where it is not finite."""
        self.move(z)
        g = np.empty(self.m)
        for phase in self._phases:
            phase.constraints(g)
        return g

    def jacobianstructure(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns of the nonzeros of dg/dz; those that stand twice are added."""
        return self._jacobian.rows, self._jacobian.columns

    @callback
    def jacobian(self, z: np.ndarray) -> np.ndarray:
        """The nonzeros of dg/dz, in the order of jacobianstructure()."""
        return self._jacobian.gather([block for phase in self._phases for block in phase.jacobian_blocks()])

    def hessianstructure(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns (row >= column) of the nonzeros of the Hessian; those that stand twice are added."""
        return self._hessian.rows, self._hessian.columns

    @callback
    def hessian(self, z: np.ndarray, y: np.ndarray, sigma: float) -> np.ndarray:
        """The nonzeros of d2(sigma f + y g)/dz2, in the order of hessianstructure().

        z: (n,) unknowns.
        y: (m,) multipliers of g.
        sigma: of f.
        """
        weight = self.sense * sigma
        return self._hessian.gather([block for phase in self._phases for block in phase.hessian_blocks(y, weight)])

    def costates(self, outcome: Outcome) -> list[np.ndarray]:
        """lambda of each phase at the slots of its mesh, shape (n_x, K + N - 1), in objective per unit of state."""
        self.move(outcome.z)
        return [self.sense * phase.costate(outcome.y, self.sense) for phase in self._phases]

    def integrals(self, z: np.ndarray) -> list[np.ndarray]:
        """The objective's integral and the constrained ones on each segment, for each phase: shape (integrals, N)."""
        self.move(z)
        return [phase.integrals() for phase in self._phases]


class _Places:
    """Where the entries of blocks of derivatives stand, without those that are none."""

    def __init__(self, blocks: list[tuple[np.ndarray, np.ndarray, np.ndarray]]) -> None:
        none = np.zeros(0, int)
        self.kept = [mask.ravel() for *_, mask in blocks]
        self.rows = np.concatenate([none, *(rows.ravel()[k] for (rows, *_), k in zip(blocks, self.kept, strict=True))])
        columns = (columns.ravel()[k] for (_, columns, _), k in zip(blocks, self.kept, strict=True))
        self.columns = np.concatenate([none, *columns])

    def gather(self, blocks: list[np.ndarray]) -> np.ndarray:
        return np.concatenate([np.zeros(0), *(b.ravel()[k] for b, k in zip(blocks, self.kept, strict=True))])
