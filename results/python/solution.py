"""A solution as functions of time, whether it was just solved or read from a file."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Iterator, Mapping
from functools import cached_property, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...problems.errors import FileError, Mistake
from ...problems.files import write_whole
from ...problems.lean.records import dataclass
from ...problems.quantities import Variable
from ...problems.text import did_you_mean, shorten, tidy
from ...transcription.solution.solution import MeshRecord
from ...transcription.solution.trajectory import Sample, Trajectory
from ..file.write import check_target, place_for
from .messages import python_words
from .problem import LoadedProblem
from .time_function import Array, TimeFunction


class Estimate(NamedTuple):
    """A static parameter that was estimated from measurements; standard_error: NaN where there is none."""

    value: float
    standard_error: float


class ErrorEstimate(NamedTuple):
    """The error of a solution, as it was measured on the last mesh.

    max_eta: the largest integral of |dx/dt - f| over a segment, in the unit of the state (paper, section 5.3).
    relative: the largest one relative to 1 + the size of the state, or the error of an integral if that is larger.
    objective: the objective is at most this far from the optimum; NaN where that cannot be told.
    """

    max_eta: float
    relative: float
    objective: float


class _Named(Mapping[str, Any]):
    """Name -> what has that name. An unknown name is told with the one most like it."""

    __hash__ = object.__hash__
    __eq__ = object.__eq__

    @abstractmethod
    def _members(self) -> Mapping[str, Any]:
        """All that has a name."""

    def __getitem__(self, name: str) -> Any:
        members = self._members()
        if name not in members:
            known = f"there are {shorten(', '.join(members), 400)}" if members else "there are none"
            raise KeyError(f"there is no {name!r}: {did_you_mean(name, members, always=known)}")
        return members[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._members())

    def __len__(self) -> int:
        return len(self._members())

    def _ipython_key_completions_(self) -> list[str]:
        """What IPython and Jupyter propose after an opening bracket."""
        return list(self)


class Costates(_Named):
    """State -> its costate, a `TimeFunction`; empty for a method without costates."""

    def __init__(self, functions: Mapping[str, TimeFunction]) -> None:
        self._functions = functions

    def _members(self) -> Mapping[str, TimeFunction]:
        return self._functions

    def __repr__(self) -> str:
        return f"<costates of {shorten(', '.join(self))}>" if self else "<no costates with this method>"


class SensitivitiesView(_Named):
    """Path of a number of the problem file, such as "parameters.m1" or "controls.u.upper" -> the derivative of the
    objective by it, as `trajopt show --sensitivities` prints it; NaN where there is none.

    missing: why there are none at all, or "". notes: path -> why there is no derivative, or what to know of it.
    """

    def __init__(self, derivatives: Mapping[str, float], notes: Mapping[str, str], missing: str) -> None:
        self._derivatives, self.notes, self.missing = derivatives, notes, missing

    def _members(self) -> Mapping[str, float]:
        return self._derivatives

    def __repr__(self) -> str:
        told = f"<sensitivities to {shorten(', '.join(self))}>"
        return f"<no sensitivities: {self.missing}>" if self.missing else told


@dataclass(frozen=True, repr=False, eq=False)
class PhaseView(_Named):
    """One phase: name -> `TimeFunction` of each state, control, algebraic variable and output, and the value of each
    static parameter.

    trajectory: its values at the points of the mesh.
    """

    trajectory: Trajectory

    @property
    def name(self) -> str:
        return self.trajectory.phase.name

    @property
    def time(self) -> Array:
        """The times of the points of the mesh, shape (K,), in `time_unit`."""
        return self.trajectory.times

    @property
    def time_unit(self) -> str:
        return self.trajectory.phase.time_unit

    @cached_property
    def functions(self) -> Mapping[str, TimeFunction]:
        """Everything that varies in time, by name."""
        phase, x, u = self.trajectory.phase, self.trajectory.x, self.trajectory.u
        kinds = (
            ("state", phase.states),
            ("control", phase.controls),
            ("algebraic", phase.inputs[len(phase.controls) :]),
        )
        varying = [(kind, variable) for kind, variables in kinds for variable in variables]
        found = {
            variable.name: self._function(kind, variable, values, partial(_row, number=number))
            for number, ((kind, variable), values) in enumerate(zip(varying, np.vstack([x, u]), strict=True))
        }
        points = Sample(self.trajectory.times, x, u, x, None)
        for name, own in phase.outputs.items():
            output = partial(self._output, name)
            values: Array = np.broadcast_to(output(points), points.t.shape)
            found[name] = self._function("output", Variable(name, own.unit), values, output)
        return found

    @cached_property
    def costate(self) -> Costates:
        """State -> its costate: how the objective changes with the state."""
        if self.trajectory.costate is None:
            return Costates({})
        states, values = self.trajectory.phase.states, self.trajectory.point_costate
        return Costates({
            state.name: self._function("costate", Variable(state.name), values[i], partial(_dual, number=i))
            for i, state in enumerate(states)
        })  # fmt: skip

    def _function(self, kind: str, variable: Variable, values: Array, rows: Callable[[Sample], Array]) -> TimeFunction:
        return TimeFunction(variable.name, kind, variable.unit, values, self.trajectory, rows)

    def _output(self, name: str, sample: Sample) -> Array:
        phase, parameters = self.trajectory.phase, self.trajectory.parameters
        with np.errstate(all="ignore"):
            values: Array = phase.outputs[name].function(phase.arguments(sample.t, sample.x, sample.u, parameters), np)
        return values

    def _members(self) -> Mapping[str, Any]:
        return {**self.functions, **self.trajectory.parameters}

    def __repr__(self) -> str:
        first, last = self.trajectory.initial_time, self.trajectory.final_time
        names: dict[str, list[str]] = {}
        for function in self.functions.values():
            names.setdefault(function.kind, []).append(function.name)
        if self.trajectory.parameters:
            names["parameter"] = list(self.trajectory.parameters)
        told = "; ".join(f"{kind} {shorten(', '.join(own))}" for kind, own in names.items())
        return f"<Phase {self.name}, t = {first:.6g} to {last:.6g} {self.time_unit}: {told}>"


def _row(sample: Sample, number: int) -> Array:
    """A state, or an input after the states, at the times of a sample."""
    values: Array = sample.x[number] if number < len(sample.x) else sample.u[number - len(sample.x)]
    return values


def _dual(sample: Sample, number: int) -> Array:
    costate = sample.costate
    if costate is None:
        raise ValueError("this method gives no costates")
    values: Array = costate[number]
    return values


@dataclass(frozen=True, repr=False, eq=False)
class SolutionView(_Named):
    """What `trajopt.solve` and `trajopt.read` give, solved or not.

    solution["q1"](t) is short for solution.phases["main"]["q1"](t) where a problem has one phase; so are `time` and
    `costate`.

    problem: what was solved.
    solved: whether the last mesh ended with an optimal point, or with one as good as `solver: {accept: ...}` asks for.
    status: one word, such as "solved" or "max_iterations"; message: the same in words.
    remedy: what to do about it; "" if it is solved.
    causes: why it is not solved, as far as is known; sentences, the most telling one first.
    notes: what was done besides, and what to know of the solution; sentences.
    objective: as the problem file writes it.
    meshes: how the solve on each mesh went, in turn.
    error: of the last mesh.
    phases: name -> phase.
    estimates: static parameter -> its estimate, where something was measured.
    """

    problem: LoadedProblem
    solved: bool
    status: str
    message: str
    remedy: str
    causes: tuple[str, ...]
    notes: tuple[str, ...]
    objective: float
    error: ErrorEstimate
    meshes: tuple[MeshRecord, ...]
    phases: Mapping[str, PhaseView]
    _make_image: Callable[[], bytes]
    _make_sensitivities: Callable[[], SensitivitiesView]
    estimates: Mapping[str, Estimate]

    @cached_property
    def sensitivities(self) -> SensitivitiesView:
        """Path of a number of the file -> the derivative of the objective by it."""
        return self._make_sensitivities()

    @property
    def time(self) -> Array:
        """The times of the points of the mesh, shape (K,)."""
        return self._phase.time

    @property
    def costate(self) -> Costates:
        """State -> its costate, a function of time."""
        return self._phase.costate

    @property
    def _phase(self) -> PhaseView:
        """The only phase."""
        if len(self.phases) > 1:
            raise ValueError(f"there are several phases: say which, such as phases[{next(iter(self.phases))!r}]")
        return next(iter(self.phases.values()))

    def _members(self) -> Mapping[str, Any]:
        return self._phase._members()

    @cached_property
    def image(self) -> bytes:
        """The content of its result file."""
        return self._make_image()

    def save(self, path: str | Path, force: bool = False) -> Path:
        """Write the result file, as `trajopt solve` does; `trajopt.read` reads it back.

        path: an earlier result of the same problem is replaced, unless that is solved and this is not.
        force: replace whatever there is.

        Raises FileError if the file cannot be written, or if it should not be replaced.
        """
        target = Path(path)
        with python_words():
            check_target(target, self.problem.name, force)
            if not force and place_for(target, self.problem.name, self.solved) != target:
                what = "it holds a solution, and this result is none"
                raise FileError(Mistake(str(target), what, "choose another file, or replace it with --force"))
            write_whole(target, self.image)
        return target

    def __repr__(self) -> str:
        """How the solve ended, its error, and the names of each phase, in a few lines."""
        lines = [f"<Solution {shorten(tidy(self.problem.name))}: {'solved' if self.solved else 'NOT SOLVED'}, "
                 f"objective {self.objective:.10g}"]  # fmt: skip
        if not self.solved:
            lines.append(shorten("; ".join([self.message, *self.causes[:1], self.remedy]), 400))
        mesh, count = self.meshes[-1].mesh, len(self.meshes)
        iterations = sum(record.iterations for record in self.meshes)
        lines.append(
            f"error relative {self.error.relative:.2e}, max eta {self.error.max_eta:.2e}; {mesh.schemes[0].name}, "
            f"{mesh.segments} segments; {iterations} iterations" + (f" on {count} meshes" if count > 1 else "")
        )
        return "\n  ".join([*lines, *map(repr, self.phases.values())]) + ">"
