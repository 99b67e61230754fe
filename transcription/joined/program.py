"""The nonlinear program of a transcription of several parts, with the callbacks of `program.contract`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace
from functools import partial

import numpy as np

from ...problems.problem import Problem
from ..collocation.forms import form_between
from ..engines.outcome import Outcome
from ..layout import BETWEEN, Transcription
from ..method_kind import TIMES, DataNumber, Numbers
from ..program.contract import NonlinearProgram, callback
from ..program.direct import Direct
from ..program.pointwise import PointFunctions
from .parts import JoinedTranscription, PartProgram, PartRows


class JoinedNLP:
    """The parts' programs side by side; links are the last rows, the objective of the whole is one function more."""

    def __init__(self, transcription: JoinedTranscription) -> None:
        self.parts: Sequence[PartProgram] = transcription.parts
        self.programs: list[NonlinearProgram] = [part.kind.compiled(part.transcription) for part in self.parts]
        problem = transcription.problem
        self.names = [phase.name for phase in problem.phases]
        self.n, self.sense = len(transcription.variables), problem.sense
        self.offsets = np.cumsum([0, *(program.m for program in self.programs)])
        self.m = int(self.offsets[-1]) + len(problem.links)
        self.cl = np.concatenate([*(p.cl for p in self.programs), [link.bounds.lower for link in problem.links]])
        self.cu = np.concatenate([*(p.cu for p in self.programs), [link.bounds.upper for link in problem.links]])
        parts = [program.seconds for program in self.programs]
        self.seconds = {part: sum(own[part] for own in parts) for part in parts[0]}
        self.has_mayer = problem.mayer is not None
        self.data = form_between(problem).data
        self.links = _between(problem, transcription, self.seconds, int(self.offsets[-1]), self.data)
        self._jacobian = self._places(self.links.rows[self.links.o], self.links.columns[self.links.j])
        self._link_rows = self.links.o < len(problem.links)
        a, b = self.links.columns[self.links.a], self.links.columns[self.links.b]
        self._hessian = [
            *(_lower(part.places, *p.hessianstructure()) for part, p in zip(self.parts, self.programs, strict=True)),
            (np.maximum(a, b), np.minimum(a, b)),
        ]

    def _places(self, rows: np.ndarray, columns: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """Where the derivatives of each part stand, and those of the links."""
        found = []
        for part, program, offset in zip(self.parts, self.programs, self.offsets, strict=False):
            own_rows, own_columns = program.jacobianstructure()
            found.append((own_rows + offset, part.places[own_columns]))
        linked = rows < self.m
        return [*found, (rows[linked], columns[linked])]

    def numbers(self) -> Numbers:
        """The given times and the parameters of the file that are data: those of the parts, and of the links."""
        found: dict[tuple[str, str], DataNumber] = {}
        for i, (part, program) in enumerate(zip(self.parts, self.programs, strict=True)):
            own = part.kind.numbers(part.transcription, program).items()
            found |= {key: DataNumber(number.value, partial(self._replaced, i, key, number)) for key, number in own}
        return found | {(BETWEEN, name): DataNumber(v, partial(self._linked, name)) for name, v in self.data.items()}

    def _replaced(self, part: int, key: tuple[str, str], number: DataNumber, value: float) -> JoinedNLP:
        phase, name = key
        other = self._linked(f"{phase}.{name}", value) if name in TIMES else copy(self)
        other.programs = [number.replaced(value) if i == part else own for i, own in enumerate(self.programs)]
        return other

    def _linked(self, name: str, value: float) -> JoinedNLP:
        other = copy(self)
        other.links = self.links.with_number(name, value)
        return other

    def rows(self, component: PartRows) -> np.ndarray:
        """The row numbers of the component of a family."""
        if component.part is None:
            return np.array([self.offsets[-1] + component.component])
        return self.offsets[component.part] + self.programs[component.part].rows(component.component)

    def row_name(self, row: int) -> tuple[str, int | None]:
        """(component name, index or None) of a row."""
        part = int(np.searchsorted(self.offsets, row, side="right")) - 1
        if part < len(self.programs):
            return self.programs[part].row_name(row - int(self.offsets[part]))
        return f"link{row - int(self.offsets[-1])}", None

    def move(self, z: np.ndarray) -> None:
        self.links.move(z)

    def culprits(self, kind: str, values: np.ndarray) -> list[tuple[str, int | None]]:
        """What is not finite in a callback; the parts tell their own before."""
        return [("a link between phases, or the terminal objective", None)]

    @callback
    def objective(self, z: np.ndarray) -> float:
        """f(z)."""
        own = sum(p.objective(z[part.places]) for part, p in zip(self.parts, self.programs, strict=True))
        return own + (self.sense * float(self.links.values()[-1]) if self.has_mayer else 0.0)

    @callback
    def gradient(self, z: np.ndarray) -> np.ndarray:
        """df/dz, shape (n,)."""
        found = np.zeros(self.n)
        for part, program in zip(self.parts, self.programs, strict=True):
            found += np.bincount(part.places, program.gradient(z[part.places]), self.n)
        last = ~self._link_rows
        columns = self.links.columns[self.links.j[last]]
        return found + self.sense * np.bincount(columns, self.links.jacobian()[last], self.n)

    @callback
    def constraints(self, z: np.ndarray) -> np.ndarray:
        """g(z), shape (m,)."""
        own = [p.constraints(z[part.places]) for part, p in zip(self.parts, self.programs, strict=True)]
        return np.concatenate([*own, self._links()])

    def constraints_unchecked(self, z: np.ndarray) -> np.ndarray:
        """g(z), shape (m,), with NaN and infinity where it is not finite."""
        self.move(z)
        own = [p.constraints_unchecked(z[part.places]) for part, p in zip(self.parts, self.programs, strict=True)]
        return np.concatenate([*own, self._links()])

    def _links(self) -> np.ndarray:
        return self.links.values()[: self.m - int(self.offsets[-1])]

    def jacobianstructure(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns of the nonzeros of dg/dz; those that stand twice are added."""
        rows, columns = zip(*self._jacobian, strict=True)
        return np.concatenate(rows), np.concatenate(columns)

    @callback
    def jacobian(self, z: np.ndarray) -> np.ndarray:
        """The nonzeros of dg/dz, in the order of jacobianstructure()."""
        own = [p.jacobian(z[part.places]) for part, p in zip(self.parts, self.programs, strict=True)]
        return np.concatenate([*own, self.links.jacobian()[self._link_rows]])

    def hessianstructure(self) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns (row >= column) of the nonzeros of the Hessian; those that stand twice are added."""
        rows, columns = zip(*self._hessian, strict=True)
        return np.concatenate(rows), np.concatenate(columns)

    @callback
    def hessian(self, z: np.ndarray, y: np.ndarray, sigma: float) -> np.ndarray:
        """The nonzeros of d2(sigma f + y g)/dz2, in the order of hessianstructure().

        z: (n,) unknowns.
        y: (m,) multipliers of g.
        sigma: of f.
        """
        parts = zip(self.parts, self.programs, self._slices(y), strict=True)
        own = [program.hessian(z[part.places], rows, sigma) for part, program, rows in parts]
        weights = np.append(y[self.offsets[-1] :], [self.sense * sigma] * self.has_mayer)
        return np.concatenate([*own, self.links.hessian(weights)])

    def _slices(self, y: np.ndarray) -> list[np.ndarray]:
        """The multipliers of each part."""
        return [y[start:end] for start, end in zip(self.offsets, self.offsets[1:], strict=False)]

    def costates(self, outcome: Outcome) -> dict[str, np.ndarray | None]:
        """Phase -> lambda at the slots of its mesh, shape (n_x, K + N - 1), or None, as its own method has it."""
        found: dict[str, np.ndarray | None] = {}
        for part, program, y in zip(self.parts, self.programs, self._slices(outcome.y), strict=True):
            at = part.places
            own = replace(outcome, z=outcome.z[at], y=y, z_lower=outcome.z_lower[at], z_upper=outcome.z_upper[at])
            costates = part.kind.costates(part.transcription, program, own)
            found |= {layout.phase.name: c for layout, c in zip(part.transcription.phases, costates, strict=True)}
        return found

    def integrals(self, z: np.ndarray) -> list[np.ndarray]:
        """As `shooting.program.ShootingNLP.integrals`; no rows for a phase whose integrals are sums over its points."""
        found: dict[str, np.ndarray] = {}
        for part, program in zip(self.parts, self.programs, strict=True):
            phases = part.transcription.phases
            simulated = getattr(program, "integrals", None)
            own = simulated(z[part.places]) if simulated else [np.zeros((0, p.mesh.segments)) for p in phases]
            found |= {layout.phase.name: rows for layout, rows in zip(phases, own, strict=True)}
        return [found[name] for name in self.names]


def _between(
    problem: Problem, transcription: Transcription, seconds: dict[str, float], first: int, data: Mapping[str, float]
) -> Direct:
    """The links, and the objective of the whole trajectory, as functions of the ends of all phases."""
    names: list[str] = []
    columns: list[int] = []
    fixed: list[float] = []
    for layout in transcription.phases:
        phase, nodes = layout.phase, layout.mesh.collocated
        own = [v.name for v in (*phase.states, *phase.inputs)]
        for end, point, node, time, bounds in (
            ("initial", 0, nodes[0], layout.t[0], phase.initial_time),
            ("final", -1, nodes[-1], layout.t[1], phase.final_time),
        ):
            places = [*layout.x[:, point].tolist(), *layout.u[:, node].tolist(), int(time)]
            names += [f"{phase.name}.{name}[{end}]" for name in (*own, "t")]
            columns += places
            fixed += [0.0] * len(own) + [bounds.lower if time < 0 else 0.0]
    names += [parameter.name for parameter in problem.parameters]
    columns += transcription.parameters.tolist()
    fixed += [0.0] * len(problem.parameters)
    functions = [*(link.function for link in problem.links), *([problem.mayer] if problem.mayer else [])]
    compiled = PointFunctions(functions, names, [], seconds, data)
    return Direct(compiled, np.array(columns), np.array(fixed), first + np.arange(len(functions)))


def _lower(places: np.ndarray, rows: np.ndarray, columns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The places of second derivatives among all unknowns, in the lower triangle."""
    a, b = places[rows], places[columns]
    return np.maximum(a, b), np.minimum(a, b)
