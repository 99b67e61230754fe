"""A solution -> one HDF5 file, which h5py, xarray and every netCDF-4 tool can read.

    /                          attributes: format, format_version, problem, status, solved, message, remedy, trouble,
                               objective, objective_error (|J - J*| is at most that), objective_corrected,
                               objective_error_missing (why there is none), sense, created, command,
                               trajopt_version, pyomo_version, ipopt_version
    /spec/                     text: the problem file as given; full: the same with every default, as JSON;
                               parameter/<name>: the numbers of the parameters that are given;
                               attributes: overrides (the paths that the command line changed), override_values
                               (JSON)
    /phase/<name>/             knots (knot), the times of the segments' edges
        points/                time, at the points of the mesh, and over it
            state/<name>, costate/<name>, control/<name>, algebraic/<name>,
            output/<name> (named expressions that vary in time), path/<name> (path constraints that are no equations)
        dense/                 time and the same on a fine grid, by the scheme's own interpolants; and
            epsilon/<state>    dx/dt - f
        error/                 eta (segment, state): indices of the segments, from 0, and names of the states;
                               relative (segment) and excess (segment) of bounds, what refinement looks at;
                               attributes overshoot_<key>: what exceeds its bounds most between the points;
                               objective (segment), the parts of objective_error
        parameter/<name>       scalar, optimised static parameters
        price/<name>           scalar, the change of the objective with the bound of a constraint that holds once
        arcs/                  arc, and over it name and kind (control, state, path), start, end, on (lower, upper,
                               inside), bound, by (singular, or held by NAME; of controls inside their bounds)
        complementarity/<name>/  product, the largest a*b of a pair at the points, its time, and allowed
        measured/<set>.<column>/   measurement, and over it time, value, deviation, model (the solution there);
                               with expression, that of the model
    /price/<name>              the same of conditions on the ends of several phases, links and boundary constraints
    /estimates/                where something was measured: parameter and other (names), value, standard_error,
                               correlation; with residuals (the sum of weighted squares), measurements and free (their
                               number, and that of unknowns), scale (of the deviations), given (whether these were),
                               missing (why there are no standard errors)
    /mesh/<k>/                 edges; segment, and over it degree and differential, of methods with a choice (with
                               several phases these are in phase/<name>/);
                               attributes: method, segments, tolerance, status, objective, objective_error,
                               objective_corrected (NaN where there is no bar), max_eta, relative_error,
                               iterations, unknowns, constraints, seconds_<part>; substeps and control of shooting
    /solver/                   iterations/<quantity> (number); z, z_lower, z_upper (unknown); y (constraint);
                               attributes: engine, every option, seconds_<part> (over all meshes), violations,
                               involved (names of all that cannot hold at once, or says the same),
                               unmet_count and unmet (segments that refinement left above its tolerance), stopped
                               (why a mesh after the last is missing), notes (what was done beyond what was asked, as
                               another start), relief (what would have to give way, of a problem that contradicts
                               itself), program (what kind of program it is, if linear or quadratic), scaling
                               (sizes of the automatic one, JSON), continuation (the solves on the way, in words),
                               discarded (meshes whose solves were not kept, in words), discarded_iterations;
                               seconds_elsewhere is what other starts, discarded meshes and the way have taken
    /sensitivity/              number, the path of a number of the problem file, and over it value, unit,
                               derivative (of the objective by it; NaN where there is none) and note (why, or
                               what to know); attribute: missing (why there are none at all)

Arrays carry `long_name`, and `units` where the problem file gives them (costates have none: the objective has none).
Their dimensions are HDF5 dimension scales, so that `xarray.open_datatree(file)` shows times as coordinates. (xarray
wants a dimension to have one size in a group and all groups below it; hence points/ and dense/ stand side by side.)
What is listed keeps the order of the problem file. The file is written under another name in the same folder, flushed
to disk, and renamed: there is never half a result under the final name, and an older one stays whole until then.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from datetime import UTC, datetime
from itertools import count
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import h5py
import numpy as np

from ...problems.errors import FileError, Mistake
from ...problems.files import check_not_protected, check_writable, write_whole
from ...problems.lean.versions import version
from .arrays import array_of, content_of, file_in_memory, group_of, scale_of, tell, texts
from .door import FORMAT, FORMAT_VERSION, head_of_file
from .write_measured import write_estimates, write_sensitivities
from .write_phase import write_phase, write_prices

if TYPE_CHECKING:  # `trajopt show` reads results without the time it takes to load Pyomo
    from ...transcription.schemes.mesh import Mesh
    from ...transcription.solution.solution import MeshRecord, Solution

MAX_UNMET = 20  # segments told one by one


def check_target(path: Path, problem: str, force: bool = False) -> None:
    """Refuse, before any work is done, a path that `write` could not or should not write.

    path: of the result file to come.
    problem: name of the problem; an earlier result of the same problem may be replaced.
    force: whether any other file may be replaced too.

    Raises FileError.
    """
    check_writable(path)
    if not force:
        check_not_protected(path)
    if path.exists() and not force and (owner := head_of_file(path).get("problem")) != problem:
        what = f"it is a result of another problem, '{owner}'" if owner else "it exists and is no trajopt result"
        raise FileError(Mistake(str(path), what, "choose another file with -o, or replace it with --force"))


def place_for(path: Path, problem: str, solved: bool) -> Path:
    """Where the result of a problem goes so that no solution is lost: `path`, or a name beside it.

    path: where it should go.
    problem: its name.
    solved: whether the result is a solution.

    Only a solution replaces a solution. What is none goes to NAME-unsolved.h5, in place of an earlier one like it;
    if something else is there, to NAME-unsolved-2.h5 and so on.
    """
    if solved or not head_of_file(path).get("solved"):
        return path
    names = (path.with_stem(f"{path.stem}-unsolved" + (f"-{n}" if n > 1 else "")) for n in count(1))
    return next(
        beside
        for beside in names
        if not beside.exists() or head_of_file(beside) == {"problem": problem, "solved": False}
    )


def write(
    path: Path,
    solution: Solution,
    spec_text: str,
    spec_full: str,
    command: str,
    overrides: Mapping[str, Any] = MappingProxyType({}),
) -> None:
    """Write a solution, solved or not; see the module's docstring for the layout.

    path: of the result file; a file that is there is replaced.
    solution, spec_text, spec_full, command, overrides: as of `image_of`.

    Raises FileError.
    """
    write_whole(path, image_of(solution, spec_text, spec_full, command, overrides))


def image_of(
    solution: Solution,
    spec_text: str,
    spec_full: str,
    command: str,
    overrides: Mapping[str, Any] = MappingProxyType({}),
) -> bytes:
    """The content of the result file of a solution.

    solution: solved or not.
    spec_text: the problem file as it was given.
    spec_full: the same with every default, as JSON.
    command: what the user typed.
    overrides: path that the command line changed -> its value; the file's reference is then none of this result.
    """
    with file_in_memory() as file:
        _write_head(file, solution, command)
        spec = group_of(file, "spec")
        spec["text"], spec["full"] = spec_text, spec_full
        values = map(json.dumps, overrides.values())
        tell(spec, {"overrides": texts(overrides), "override_values": texts(values)})
        numbers = group_of(spec, "parameter")
        for name, number in solution.problem.numbers.items():
            array_of(numbers, name, float(number), [], f"parameter {name}")
        phases = group_of(file, "phase")
        for number, trajectory in enumerate(solution.trajectories):
            write_phase(group_of(phases, trajectory.phase.name), solution, number)
        if solution.prices_between:
            write_prices(group_of(file, "price"), solution.prices_between)
        if solution.estimates:
            write_estimates(group_of(file, "estimates"), solution.problem, solution.estimates)
        meshes = group_of(file, "mesh")
        for number, record in enumerate(solution.meshes):
            _write_mesh(group_of(meshes, str(number)), solution, record)
        _write_solver(group_of(file, "solver"), solution)
        write_sensitivities(group_of(file, "sensitivity"), solution.sensitivities)
        return content_of(file)


def _write_head(file: h5py.File, solution: Solution, command: str) -> None:
    status = solution.status
    tell(
        file,
        {
            "format": FORMAT,
            "format_version": FORMAT_VERSION,
            "problem": solution.problem.name,
            "status": status.name.lower(),
            "solved": solution.solved,
            "message": status.message,
            "remedy": solution.remedy,
            "trouble": solution.trouble,
            "objective": solution.objective,
            "objective_error": solution.objective_error.bar,
            "objective_corrected": solution.objective + solution.objective_error.correction,
            "objective_error_missing": solution.objective_error.why_not,
            "sense": "minimize" if solution.problem.sense > 0 else "maximize",
            "created": datetime.now(UTC).isoformat(timespec="seconds"),
            "command": command.encode(
                errors="backslashreplace"
            ).decode(),  # names of files may hold bytes that are no text
            "trajopt_version": version("trajopt"),
            "pyomo_version": version("pyomo"),
            "ipopt_version": solution.outcome.solver.get("ipopt", ""),  # none for another engine
        },
    )


def _write_mesh(group: h5py.Group, solution: Solution, record: MeshRecord) -> None:
    tell(
        group,
        {
            "method": record.mesh.schemes[0].name,
            "segments": record.segments,
            "tolerance": record.tolerance,
            "status": record.status.name.lower(),
            "objective": record.objective,
            "objective_error": record.objective_error,
            "objective_corrected": record.objective_corrected,
            "max_eta": record.max_eta,
            "relative_error": record.relative_error,
            "iterations": record.iterations,
            "unknowns": record.unknowns,
            "constraints": record.constraints,
            **_seconds(record.seconds),
        },
    )
    if len(record.grids) == 1:
        _write_grid(group, record.mesh)
        return
    phases = group_of(group, "phase")
    for trajectory, mesh in zip(solution.trajectories, record.grids, strict=True):
        own = group_of(phases, trajectory.phase.name)
        tell(own, {"method": mesh.schemes[0].name, "segments": mesh.segments})
        _write_grid(own, mesh)


def _write_grid(group: h5py.Group, mesh: Mesh) -> None:
    """The mesh of one phase; methods of one degree store none."""
    scale_of(group, "edges", mesh.edges, "segment edges as fractions of the phase's duration", "1")
    tell(group, mesh.schemes[0].options)
    if any(scheme.degree is not None for scheme in mesh.schemes):
        segment = scale_of(group, "segment", np.arange(mesh.segments), "index of the segment, from 0")
        degrees = [scheme.degree or 0 for scheme in mesh.schemes]
        forms = [int(scheme.differential) for scheme in mesh.schemes]
        array_of(group, "degree", degrees, [segment], "degree of the method")
        array_of(group, "differential", forms, [segment], "whether the defects are in differential form")


def _write_solver(group: h5py.Group, solution: Solution) -> None:
    outcome = solution.outcome
    records = group_of(group, "iterations")
    iteration = scale_of(records, "number", np.arange(len(outcome.iterations["iteration"])), "number of the record")
    for name, values in outcome.iterations.items():
        array_of(records, name, values, [iteration], name.replace("_", " "))
    unknown = scale_of(group, "unknown", np.arange(len(outcome.z)), "unknown of the nonlinear program")
    constraint = scale_of(group, "constraint", np.arange(len(outcome.y)), "constraint of the nonlinear program")
    array_of(group, "z", outcome.z, [unknown], "unknowns")
    array_of(group, "z_lower", outcome.z_lower, [unknown], "multipliers of the lower bounds")
    array_of(group, "z_upper", outcome.z_upper, [unknown], "multipliers of the upper bounds")
    array_of(group, "y", outcome.y, [constraint], "multipliers of the constraints")
    parts = {part: sum(record.seconds[part] for record in solution.meshes) for part in solution.meshes[0].seconds}
    parts["elsewhere"] = solution.elsewhere
    listed = {
        "discarded": map(_discarded, solution.discarded),
        "violations": map(str, solution.violations),
        "involved": solution.involved,
        "unmet": solution.unmet[:MAX_UNMET],
        "notes": solution.notes,
        "relief": solution.relief,
        "continuation": map(str, solution.continuation),
    }
    told = {
        "discarded_iterations": sum(record.iterations for record in solution.discarded),
        "unmet_count": len(solution.unmet),
        "stopped": solution.stopped,
        "program": solution.program,
    }
    of_lists = {name: texts(own) for name, own in listed.items()}
    tell(group, {**outcome.solver, **_seconds(parts), **told, **of_lists})


def _discarded(record: MeshRecord) -> str:
    """A mesh whose solve was not kept, in words."""
    spent = sum(record.seconds.values())
    return f"{record.segments} segments, {record.iterations} iterations, {spent:.3f} s: {record.status.message}"


def _seconds(parts: Mapping[str, float]) -> dict[str, float]:
    return {f"seconds_{part.replace(' ', '_')}": value for part, value in parts.items()}
