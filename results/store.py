"""A solution -> one HDF5 file, which h5py, xarray and every netCDF-4 tool can read.

    /                          attributes: format, format_version, problem, status, solved, message, remedy, trouble,
                               objective, sense, created, command, trajopt_version, pyomo_version, ipopt_version
    /spec/                     text: the problem file as given; full: the same with every default, as JSON
    /phase/<name>/             time (point), knots (knot)
        state/<name>           (point)         control/<name>    (point)
        costate/<name>         (point)         parameter/<name>  scalar, optimised static parameters
        dense/                 time, state/, control/, costate/: the same on a fine grid, by the scheme's interpolant
        error/                 epsilon/<state> (dense time), eta (segment, state)
    /mesh/<k>/                 edges; attributes: method, segments, tolerance, status, objective, max_eta, iterations,
                               unknowns, constraints, seconds_<part>
    /solver/                   iterations/<quantity> (iteration); z, z_lower, z_upper (unknown); y (constraint);
                               attributes: every option, seconds_<part> over all meshes, violations

Arrays carry `units` and `long_name`, and their dimensions are HDF5 dimension scales, so that
`xarray.open_datatree(file)` shows times as coordinates. The file is written under another name in the same folder,
flushed to disk, and renamed: there is never half a result under the final name, and an older one stays whole until then.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

import h5py
import numpy as np

from ..problems.errors import FileError, Mistake
from ..problems.files import check_writable, replacing
from ..transcription.solve import MeshRecord, Solution
from ..transcription.trajectory import Trajectory

FORMAT, FORMAT_VERSION = "trajopt result", 1


def check_target(path: Path, problem: str, force: bool = False) -> None:
    """Refuse, before any work is done, a path that `write` could not or should not write.

    An existing file is replaced only if it is an earlier result of the same problem, or if `force`.
    Raises FileError.
    """
    check_writable(path)
    if path.exists() and not force and (owner := _problem_of(path)) != problem:
        what = f"it is a result of another problem, '{owner}'" if owner else "it exists and is no trajopt result"
        raise FileError(Mistake(str(path), what, "choose another file with -o, or replace it with --force"))


def _problem_of(path: Path) -> str | None:
    try:
        with open_result(path) as file:
            return file.attrs["problem"]
    except FileError:
        return None


@contextmanager
def open_result(path: Path) -> Iterator[h5py.File]:
    """A result file, open for reading. Raises FileError if it cannot be read or is no result of this version."""
    try:
        file = h5py.File(path, "r")
    except OSError as error:
        reason = "it cannot be read as HDF5" if path.is_file() else "there is no such file"
        raise FileError(Mistake(str(path), reason, "give a result written by 'trajopt solve'")) from error
    with file:
        if file.attrs.get("format") != FORMAT:
            raise FileError(Mistake(str(path), "it is no trajopt result", "give a file written by 'trajopt solve'"))
        if file.attrs["format_version"] > FORMAT_VERSION:
            what = f"it has format version {file.attrs['format_version']}, this trajopt reads up to {FORMAT_VERSION}"
            raise FileError(Mistake(str(path), what, "update trajopt"))
        yield file


def write(path: Path, solution: Solution, spec_text: str, spec_full: str, command: str) -> None:
    """Write a solution, solved or not; see the module's docstring for the layout. Raises FileError."""
    with replacing(path) as temporary, h5py.File(temporary, "w") as file:
        _write_head(file, solution, command)
        file["spec/text"], file["spec/full"] = spec_text, spec_full
        for trajectory, error in zip(solution.trajectories, solution.errors, strict=True):
            _write_phase(file.create_group(f"phase/{trajectory.phase.name}"), trajectory, error)
        for number, record in enumerate(solution.meshes):
            _write_mesh(file.create_group(f"mesh/{number}"), record)
        _write_solver(file.create_group("solver"), solution)


def _write_head(file: h5py.File, solution: Solution, command: str) -> None:
    status = solution.status
    file.attrs.update({
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "problem": solution.problem.name,
        "status": status.name.lower(),
        "solved": solution.solved,
        "message": status.message,
        "remedy": status.remedy,
        "trouble": solution.trouble,
        "objective": solution.objective,
        "sense": "minimize" if solution.problem.sense > 0 else "maximize",
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "command": command,
        "trajopt_version": version("trajopt"),
        "pyomo_version": version("pyomo"),
        "ipopt_version": solution.outcome.solver["ipopt"],
    })  # fmt: skip


def _write_phase(group: h5py.Group, trajectory: Trajectory, error) -> None:
    phase, sample = trajectory.phase, trajectory.dense
    time = _scale(group, "time", trajectory.times, phase.time_unit, "time of the points of the mesh")
    _scale(group, "knots", trajectory.knots, phase.time_unit, "time of the segments' edges")
    _write_curves(group, trajectory, time, trajectory.x, trajectory.u, trajectory.point_costate)
    for name, value in trajectory.parameters.items():
        group[f"parameter/{name}"] = value
    dense = group.create_group("dense")
    dense_time = _scale(dense, "time", sample.t, phase.time_unit, "time")
    _write_curves(dense, trajectory, dense_time, sample.x, sample.u, sample.costate)
    errors = group.create_group("error")
    for state, epsilon in zip(phase.states, error.epsilon, strict=True):
        unit = _per(state.unit, phase.time_unit)
        _array(errors, f"epsilon/{state.name}", epsilon, [dense_time], unit, "dx/dt - f between collocation points")
    names = _scale(errors, "state", [state.name for state in phase.states], "", "state")
    segment = _scale(errors, "segment", np.arange(trajectory.mesh.segments), "", "segment")
    _array(errors, "eta", error.eta.T, [segment, names], "", "integral of |epsilon| over a segment, in the state's unit")


def _write_curves(group: h5py.Group, trajectory: Trajectory, time, x, u, costate) -> None:
    for kind in ("state", "costate", "control"):
        group.create_group(kind, track_order=True)  # listed in the problem file's order
    for state, values, dual in zip(trajectory.phase.states, x, costate, strict=True):
        _array(group, f"state/{state.name}", values, [time], state.unit, f"state {state.name}")
        _array(group, f"costate/{state.name}", dual, [time], "", f"costate of {state.name}, objective per unit of it")
    for control, values in zip(trajectory.phase.controls, u, strict=True):
        _array(group, f"control/{control.name}", values, [time], control.unit, f"control {control.name}")


def _write_mesh(group: h5py.Group, record: MeshRecord) -> None:
    _scale(group, "edges", record.mesh.edges, "1", "segment edges as fractions of the phase's duration")
    group.attrs.update({
        "method": record.step.method,
        "segments": record.mesh.segments,
        "tolerance": record.step.tolerance,
        "status": record.status.name.lower(),
        "objective": record.objective,
        "max_eta": record.max_eta,
        "iterations": record.iterations,
        "unknowns": record.unknowns,
        "constraints": record.constraints,
        **_seconds(record.seconds),
    })  # fmt: skip


def _write_solver(group: h5py.Group, solution: Solution) -> None:
    outcome = solution.outcome
    iteration = _scale(group, "iteration", np.arange(len(outcome.iterations["iteration"])), "", "iteration")
    for name, values in outcome.iterations.items():
        _array(group, f"iterations/{name}", values, [iteration], "", name.replace("_", " "))
    unknown = _scale(group, "unknown", np.arange(len(outcome.z)), "", "unknown of the nonlinear program")
    constraint = _scale(group, "constraint", np.arange(len(outcome.y)), "", "constraint of the nonlinear program")
    for name, values in (("z", outcome.z), ("z_lower", outcome.z_lower), ("z_upper", outcome.z_upper)):
        _array(group, name, values, [unknown], "", "unknowns" if name == "z" else "multipliers of the bounds")
    _array(group, "y", outcome.y, [constraint], "", "multipliers of the constraints")
    parts = {part: sum(record.seconds[part] for record in solution.meshes) for part in solution.meshes[0].seconds}
    group.attrs.update({**outcome.solver, **_seconds(parts)})
    group.attrs["violations"] = [str(violation) for violation in solution.violations]


def _seconds(parts: Mapping[str, float]) -> dict[str, float]:
    return {f"seconds_{part.replace(' ', '_')}": value for part, value in parts.items()}


def _per(unit: str, time_unit: str) -> str:
    return f"{unit or '1'}/{time_unit}"


def _scale(group: h5py.Group, name: str, values, unit: str, long_name: str) -> h5py.Dataset:
    dataset = _array(group, name, values, [], unit, long_name)
    dataset.make_scale(name)
    return dataset


def _array(group: h5py.Group, name: str, values, scales: Sequence[h5py.Dataset], unit: str, long_name: str) -> h5py.Dataset:
    dataset = group.create_dataset(name, data=values)
    dataset.attrs["long_name"] = long_name
    if unit:
        dataset.attrs["units"] = unit
    for axis, scale in enumerate(scales):
        dataset.dims[axis].attach_scale(scale)
    return dataset
