"""A result file -> the problem it solved and its trajectories, as they were in memory."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np

from ...problems.build import build
from ...problems.errors import FileError, Mistake, SpecError
from ...problems.lean.records import dataclass
from ...problems.load import load_stored
from ...problems.problem import Problem
from ...problems.schema.spec import Spec
from ...problems.text import short_repr
from ...transcription.engines.outcome import Outcome, Status
from ...transcription.layout import Transcription
from ...transcription.program.contract import NonlinearProgram
from ...transcription.schemes.mesh import Mesh
from ...transcription.schemes.table import find
from ...transcription.solution.solution import MeshRecord
from ...transcription.solution.trajectory import Trajectory, trajectories
from ...transcription.starts.settled import has_moving
from ...transcription.transcribe import compiled, transcribe, with_costates
from .arrays import bar_of, stored_meshes
from .door import DAMAGED, open_result, stored_problem


@short_repr
@dataclass(frozen=True)
class Reloaded:
    """What was solved, transcribed anew on the last mesh, with the stored unknowns and multipliers.

    objective: as the problem file writes it; that of `outcome` is the minimised one. records: of every mesh solved.
    """

    spec: Spec
    problem: Problem
    transcription: Transcription
    nlp: NonlinearProgram
    outcome: Outcome
    trajectories: tuple[Trajectory, ...]
    objective: float
    solved: bool
    overrides: tuple[str, ...]
    records: tuple[MeshRecord, ...]


def _mesh(group: h5py.Group) -> Mesh:
    """The mesh of one phase: of a group /mesh/<k>, or /mesh/<k>/phase/<name>; methods of one degree store none."""
    method, widths = group.attrs["method"], np.diff(group["edges"][:])
    if "substeps" in group.attrs:
        how = {"substeps": int(group.attrs["substeps"]), "control": group.attrs["control"]}
        return Mesh.of(find(method, **how), widths.tolist())
    if "degree" not in group:
        return Mesh.of(find(method), widths.tolist())
    forms = ["differential" if differential else "integral" for differential in group["differential"][:]]
    schemes = (find(method, int(n), form) for n, form in zip(group["degree"][:], forms, strict=True))
    return Mesh(tuple(schemes), widths)


def _record(group: h5py.Group) -> MeshRecord:
    """How the solve on the mesh of a group /mesh/<k> went."""
    told, prefix = group.attrs, "seconds_"
    parts = {key.removeprefix(prefix): float(value) for key, value in told.items() if key.startswith(prefix)}
    return MeshRecord(
        grids=tuple(map(_mesh, stored_meshes(group))),
        status=Status[told["status"].upper()],
        tolerance=float(told["tolerance"]),
        objective=float(told["objective"]),
        **bar_of(told),
        max_eta=float(told["max_eta"]),
        relative_error=float(told["relative_error"]),
        iterations=int(told["iterations"]),
        unknowns=int(told["unknowns"]),
        constraints=int(told["constraints"]),
        seconds={part.replace("_", " "): value for part, value in parts.items()},
    )


def _outcome(file: h5py.File, sense: int) -> Outcome:
    solver = file["solver"]
    return Outcome(
        status=Status[file.attrs["status"].upper()],
        **{name: solver[name][:] for name in ("z", "y", "z_lower", "z_upper")},
        objective=sense * float(file.attrs["objective"]),
        iterations={},
    )


def stored_spec(path: Path) -> Spec:
    """The spec of the problem that a result holds, overrides applied. Raises FileError if it is no result."""
    with open_result(path) as file:
        data = stored_problem(file)
    return load_stored(data, str(path))


def reload(path: Path) -> Reloaded:
    """Read a result file back; overrides of the solve are in it.

    Raises FileError if it is no result, or one whose arrays are not of its problem and its mesh.
    """
    spec = stored_spec(path)
    with _fitting(path), open_result(path) as file:
        problem = build(spec)
        records = tuple(_record(file["mesh"][str(number)]) for number in range(len(file["mesh"])))
        outcome = _outcome(file, problem.sense)
        objective, solved = float(file.attrs["objective"]), bool(file.attrs["solved"])
        overrides, phase_names = tuple(file["spec"].attrs["overrides"]), set(file["phase"])
    with _fitting(path):
        transcription = transcribe(problem, records[-1].grids)
        nlp = compiled(transcription)
        if phase_names != {phase.name for phase in problem.phases}:
            raise _unlike(path, "its phases are not those of its problem")
        if (len(outcome.z), len(outcome.y)) != (len(transcription.variables), len(nlp.cl)):
            raise _unlike(path, "the solver's point is not one of its problem on its mesh")
        if has_moving(problem):  # the rows are those of the times that were found
            transcription = transcribe(problem, records[-1].grids, trajectories(transcription, outcome.z))
            nlp = compiled(transcription)
    with np.errstate(all="ignore"):  # a point that is not finite is told by what looks at it
        phases = with_costates(transcription, nlp, outcome, trajectories(transcription, outcome.z))
    return Reloaded(spec, problem, transcription, nlp, outcome, phases, objective, solved, overrides, records)


@contextmanager
def _fitting(path: Path) -> Iterator[None]:
    """A block in which mistakes are the result's: a mesh of no method, a problem that the method cannot take."""
    try:
        yield
    except SpecError as error:
        raise _unlike(path, f"its mesh is not one of its problem: {error.mistakes[0].what}") from error


def _unlike(path: Path, what: str) -> FileError:
    return FileError(Mistake(str(path), what, DAMAGED))
