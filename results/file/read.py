"""A result file as arrays: everything that the pictures are drawn from. Reads the file and nothing else."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from ...problems.lean.records import dataclass
from ...problems.problem import Problem
from ...problems.text import printable, short_repr
from ..declared.layout import SOLVER
from .arrays import NO_BAR_YET, accuracy_of, bar_of, stored_meshes, unit_of
from .door import open_result, stored_problem
from .summary import DISCRETE

if TYPE_CHECKING:
    from ...problems.schema.spec import Spec

CURVE_KINDS = ("state", "control", "algebraic", "output", "path", "costate")
NEAR = 1e-9  # of the duration: a point of the mesh this near to a knot is that knot


@short_repr
@dataclass(frozen=True)
class Curve:
    """One quantity of a phase: its unit, its values (K,) at the points of the mesh and (M,) on the dense grid."""

    unit: str
    points: np.ndarray
    dense: np.ndarray


@short_repr
@dataclass(frozen=True)
class MeasuredPoints:
    """Measurements of one quantity: what it is compared with, its unit, and (M,) times, values, deviations, and the
    solution there."""

    name: str
    expression: str
    unit: str
    time: np.ndarray
    value: np.ndarray
    deviation: np.ndarray
    model: np.ndarray


@short_repr
@dataclass(frozen=True)
class PhaseCurves:
    """One phase of a result.

    time: (K,) of the points, dense_time: (M,), knots: (N + 1,) times of the segments' edges, all in `time_unit`.
    curves: kind, one of CURVE_KINDS -> name -> curve; a kind may be missing or empty.
    epsilon: state -> curve without points. eta: state -> (N,). parameters: optimised static parameters.
    relative: (N,) the largest relative error of each segment. shares: (N,) what it adds to the error bar of the
    objective; empty where there is none. measured: the measurements, quantity by quantity. discrete: whether its time
    is: values hold from one point to the next.
    """

    name: str
    time_unit: str
    time: np.ndarray
    dense_time: np.ndarray
    knots: np.ndarray
    curves: Mapping[str, Mapping[str, Curve]]
    epsilon: Mapping[str, Curve]
    eta: Mapping[str, np.ndarray]
    parameters: Mapping[str, float]
    relative: np.ndarray = field(default_factory=lambda: np.empty(0))
    shares: np.ndarray = field(default_factory=lambda: np.empty(0))
    discrete: bool = False
    measured: tuple[MeasuredPoints, ...] = ()

    @property
    def at_knot(self) -> np.ndarray:
        """Which of the points are knots, shape (K,); the others lie inside a segment."""
        nearest = np.abs(self.time[:, None] - self.knots[self._nearest_knot()]).min(axis=1)
        return nearest <= NEAR * abs(self.knots[-1] - self.knots[0])

    def _nearest_knot(self) -> np.ndarray:
        """The indices of the knots before and after each point, shape (K, 2)."""
        after = np.clip(np.searchsorted(self.knots, self.time), 1, len(self.knots) - 1)
        return np.stack([after - 1, after], axis=1)

    def values(self, kind: str, t: np.ndarray) -> dict[str, np.ndarray]:
        """Every curve of a kind at times t, from the dense grid: fine enough for a picture."""
        return {name: np.interp(t, self.dense_time, c.dense) for name, c in self.curves.get(kind, {}).items()}


def beside_each_other(phases: Sequence[PhaseCurves]) -> bool:
    """Whether one begins before the one before it ends, as branches and separate experiments do."""
    duration = max(phase.knots[-1] for phase in phases) - min(phase.knots[0] for phase in phases)
    return any(after.knots[0] < before.knots[-1] - NEAR * duration for before, after in pairwise(phases))


@short_repr
@dataclass(frozen=True)
class StoredMesh:
    """One mesh of the schedule, and what the solve on it gave.

    edges: for each phase (N + 1,), as fractions of its duration. objective_error: the error bar of the objective, NaN
    where there is none.
    """

    method: str
    edges: tuple[np.ndarray, ...]
    unknowns: int
    objective: float
    objective_error: float
    max_eta: float

    @property
    def segments(self) -> int:
        """Of all phases together."""
        return sum(len(edges) - 1 for edges in self.edges)


@short_repr
@dataclass(frozen=True)
class Result:
    """A result file. `message` says in words how the solve ended; `spec` is the full problem file as plain data.

    objective_error: the error bar of the objective, NaN where there is none; `objective_error_missing` then says why.
    inaccurate: why a solved result is not as accurate as was asked; "" where nothing is wrong.
    text: of the problem file; overrides: the paths that the command line changed. iterations: quantity -> its value at
    each record of the solver, (R,). options: what the solver was told, and its seconds by part.
    """

    path: Path
    problem: str
    solved: bool
    message: str
    objective: float
    objective_error: float
    objective_error_missing: str
    phases: tuple[PhaseCurves, ...]
    meshes: tuple[StoredMesh, ...]
    inaccurate: str
    spec: Mapping[str, Any] = field(repr=False)
    text: str = ""
    overrides: tuple[str, ...] = ()
    iterations: Mapping[str, np.ndarray] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)

    def names(self, kind: str) -> list[str]:
        """The names of all curves of a kind, in the order of the problem file."""
        return list(dict.fromkeys(name for phase in self.phases for name in phase.curves.get(kind, {})))

    @property
    def states(self) -> list[str]:
        return self.names("state")

    @property
    def verdict(self) -> str:
        """ "solved", "solved, tolerance missed" or "not solved"."""
        return "not solved" if not self.solved else "solved, tolerance missed" if self.inaccurate else "solved"

    @property
    def static(self) -> bool:
        """Whether nothing in it varies in time."""
        return not any(self.names(kind) for kind in CURVE_KINDS)

    def stated(self) -> tuple[Spec, Problem]:
        """The problem file that was solved, and the problem that it states.

        Raises FileError if this version of trajopt cannot read it.
        """
        from ...problems.build import build
        from ...problems.load import load_stored

        spec = load_stored(self.spec, str(self.path))
        return spec, build(spec)

    def build(self) -> tuple[Problem, dict[str, float]]:
        """The problem that was solved, and the numbers of its parameters, fixed and optimised.

        Raises FileError if this version of trajopt cannot read the problem.
        """
        from ...problems.language.plain import shared_in_plain
        from ...problems.names.symbols import Symbols

        spec, problem = self.stated()
        return problem, {**Symbols(shared_in_plain(spec)[0]).numbers, **self.phases[0].parameters}


def read(path: Path) -> Result:
    """Read a result file. Raises FileError if it cannot be read or is no result of trajopt."""
    with open_result(path) as file:
        return Result(
            path=Path(path),
            problem=printable(file.attrs["problem"]),
            solved=bool(file.attrs["solved"]),
            message=printable(file.attrs["message"]),
            objective=float(file.attrs["objective"]),
            objective_error=bar_of(file.attrs)["objective_error"],
            objective_error_missing=printable(file.attrs.get("objective_error_missing", NO_BAR_YET)),
            phases=tuple(map(_phase, *zip(*file["phase"].items(), strict=True), _methods(file))),
            inaccurate=accuracy_of(file),
            meshes=tuple(_stored_mesh(file["mesh"][str(k)]) for k in range(len(file["mesh"]))),
            spec=stored_problem(file),
            text=file["spec/text"].asstr()[()],
            overrides=tuple(file["spec"].attrs["overrides"]),
            iterations={name: values[:] for name, values in file["solver/iterations"].items()},
            options={name: value for name, value in file["solver"].attrs.items() if name not in SOLVER.attributes},
        )


def _methods(file: h5py.File) -> list[str]:
    """The method of each phase on the last mesh."""
    return [str(own.attrs["method"]) for own in stored_meshes(file["mesh"][str(len(file["mesh"]) - 1)])]


def _phase(name: str, group: h5py.Group, method: str) -> PhaseCurves:
    points, dense, time = group["points"], group["dense"], group["points/time"]
    eta, empty = group["error/eta"][:], np.empty(0)
    return PhaseCurves(
        name=name,
        time_unit=unit_of(time),
        time=time[:],
        dense_time=dense["time"][:],
        knots=group["knots"][:],
        curves={kind: _curve_of_each(points.get(kind, {}), dense.get(kind, {})) for kind in CURVE_KINDS},
        epsilon={state: Curve(unit_of(d), np.empty(0), d[:]) for state, d in dense.get("epsilon", {}).items()},
        eta={state: eta[:, i] for i, state in enumerate(group["error/state"].asstr()[:])},
        parameters={name: float(value[()]) for name, value in group.get("parameter", {}).items()},
        relative=group["error"].get("relative", empty)[:],
        shares=group["error"].get("objective", empty)[:],
        discrete=method == DISCRETE,
        measured=tuple(_measured(name, own) for name, own in group.get("measured", {}).items()),
    )


def _measured(name: str, group: h5py.Group) -> MeasuredPoints:
    arrays = (group[key][:] for key in ("time", "value", "deviation", "model"))
    return MeasuredPoints(name, printable(group.attrs["expression"]), unit_of(group["value"]), *arrays)


def _curve_of_each(points: Mapping[str, h5py.Dataset], dense: Mapping[str, h5py.Dataset]) -> dict[str, Curve]:
    return {name: Curve(unit_of(dense[name]), points[name][:], dense[name][:]) for name in points if name in dense}


def _stored_mesh(group: h5py.Group) -> StoredMesh:
    a = group.attrs
    return StoredMesh(
        method=", ".join(dict.fromkeys(printable(own.attrs["method"]) for own in stored_meshes(group))),
        edges=tuple(own["edges"][:] for own in stored_meshes(group)),
        unknowns=int(a["unknowns"]),
        objective=float(a["objective"]),
        objective_error=bar_of(a)["objective_error"],
        max_eta=float(a["max_eta"]),
    )
