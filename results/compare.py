"""Results of one problem, solved on different meshes or by different methods, side by side."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..problems.errors import Mistake, SpecError
from ..transcription.schemes.polynomials import lagrange_basis
from .file.read import PhaseCurves
from .file.read import read as read_result
from .file.summary import summarize

NO_PART = {
    "trajopt",
    "name",
    "source",
    "note",
    "tags",
    "reference",
    "mesh",
    "refine",
    "solver",
    "scaling",
    "guess",
    "drawing",
}
"""Keys of a problem file that do not change what the problem is."""
STENCIL = 6  # dense points
WHOLE = 2001  # times at which trajectories are compared that are cut into other phases
NO_PART_BELOW = {"name", "note", "guess", "unit"}  # of a constraint, a variable, a time


def compare(paths: Sequence[Path]) -> list[dict[str, Any]]:
    """One row for each result, measured against the first one.

    objective_error: its error bar, None where there is none. difference: of the objective from the first;
    state_difference: the largest distance of any state from the first's,
    relative to that state's range, at equal fractions of the duration of each phase (of the whole, where the phases are
    others), and that state's name; NaN if one of the two has
    no finite values. Without time it is that of the static parameters, relative to 1 + their size. objective and
    difference: None where there is none. other_problem: path in the problem file ->
    (the first's value, this one's), empty if both solved the same problem. Raises FileError if a file is no result,
    SpecError if it has no state or phase in common with the first.
    """
    first = read_result(paths[0])
    rows: list[dict[str, Any]] = []
    for path in paths:
        summary, result = summarize(path), read_result(path)
        mesh = summary["meshes"][-1]
        state, distance = _distance(path, first.phases, result.phases)
        rows.append({
            "file": str(path),
            "problem": summary["problem"],
            "solved": summary["solved"],
            "method": mesh["method"],
            "segments": mesh["segments"],
            "unknowns": mesh["unknowns"],
            "objective": summary["objective"],
            "objective_error": summary["objective_error"],
            "difference": _difference(summary["objective"], rows[0]["objective"] if rows else summary["objective"]),
            "state_difference": distance,
            "state": state,
            "max_eta": summary["error"]["max_eta"],
            "iterations": summary["iterations"],
            "seconds": summary["seconds"]["total"],
            "other_problem": differences(first.spec, result.spec),
        })  # fmt: skip
    return rows


def _difference(objective: float | None, first: float | None) -> float | None:
    return None if objective is None or first is None else objective - first


def differences(first: Mapping[str, Any], other: Mapping[str, Any]) -> dict[str, tuple[Any, Any]]:
    """Path -> both values, of all in two problem files that changes the problem; None is what one of them lacks."""
    a, b = (
        {".".join(path).removesuffix(".value"): value for path, value in _leaves(spec) if path[0] not in NO_PART}
        for spec in (first, other)
    )
    return {path: (a.get(path), b.get(path)) for path in dict.fromkeys([*a, *b]) if a.get(path) != b.get(path)}


def _leaves(node: Any, path: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Path -> value of what has nothing below it. Names that the user chose stand at depth two, keys below them."""
    if isinstance(node, Mapping | list):
        for key, value in node.items() if isinstance(node, Mapping) else enumerate(node):
            yield from _leaves(value, (*path, str(key)))
    elif len(path) < 3 or path[-1] not in NO_PART_BELOW:
        yield path, node


def _distance(path: Path, first: Sequence[PhaseCurves], other: Sequence[PhaseCurves]) -> tuple[str, float]:
    """The state that differs most, and by how much."""
    with np.errstate(invalid="ignore", over="ignore"):  # a failed solve may have no finite values: NaN, then
        if [phase.name for phase in first] != [phase.name for phase in other]:
            distances = _whole_distances(first, other)
        else:
            distances = {
                name: own
                for a, b in zip(first, other, strict=True)
                for name, own in (_state_distances(a, b) if a.curves["state"] else _parameter_distances(a, b)).items()
            }
    if not distances:
        kind = "state" if any(phase.curves["state"] for phase in first) else "parameter"
        what = f"it has no {kind} in common with the first result"
        raise SpecError(Mistake(str(path), what, "compare like with like"))
    worst = max(distances, key=lambda name: np.nan_to_num(distances[name], nan=np.inf))
    return worst, distances[worst]


def _state_distances(a: PhaseCurves, b: PhaseCurves) -> dict[str, float]:
    s = np.union1d(_fractions(a.dense_time), _fractions(b.dense_time))
    distances = {}
    for name, curve in a.curves["state"].items():
        if name in b.curves["state"]:
            own, others = _values(a, curve.dense, s), _values(b, b.curves["state"][name].dense, s)
            distances[name] = float(np.abs(own - others).max() / (np.ptp(curve.dense) or 1.0))
    return distances


def _whole_distances(first: Sequence[PhaseCurves], other: Sequence[PhaseCurves]) -> dict[str, float]:
    """Of states that all phases have, where a trajectory is cut into phases in two ways; at equal fractions of all."""
    common = [name for name in first[0].curves["state"] if all(name in own.curves["state"] for own in (*first, *other))]
    s = np.linspace(0.0, 1.0, WHOLE)
    distances = {}
    for name in common:
        own, others = (_over_phases(phases, name, s) for phases in (first, other))
        distances[name] = float(np.abs(own - others).max() / (np.ptp(own) or 1.0))
    return distances


def _over_phases(phases: Sequence[PhaseCurves], name: str, s: np.ndarray) -> np.ndarray:
    """A state at fractions s of the time of all phases, NaN in a gap between them."""
    first, last = phases[0].dense_time[0], phases[-1].dense_time[-1]
    t = np.clip(first + s * (last - first), first, last)  # at s = 1 rounding may lead beyond the end
    values = np.full(len(s), np.nan)
    for phase in phases:
        start, end = phase.dense_time[[0, -1]]
        within = (t >= start) & (t <= end)
        if end > start and within.any():
            values[within] = _values(phase, phase.curves["state"][name].dense, (t[within] - start) / (end - start))
    return values


def _parameter_distances(a: PhaseCurves, b: PhaseCurves) -> dict[str, float]:
    common = [name for name in a.parameters if name in b.parameters and not b.curves["state"]]
    return {name: abs(a.parameters[name] - b.parameters[name]) / (1 + abs(a.parameters[name])) for name in common}


def _values(phase: PhaseCurves, dense: np.ndarray, s: np.ndarray) -> np.ndarray:
    """A continuous curve at fractions s of the duration, by the polynomial through STENCIL dense points around each.

    All of them are of the segment, on which the dense points are equally spaced: curves have kinks at its ends. A
    straight line between them would differ from the curve by more than good results differ from one another.
    """
    edges = _fractions(phase.knots)
    segments = len(edges) - 1
    count = (len(dense) - 1) // segments
    on_segment = np.column_stack([dense[:-1].reshape(segments, count), dense[count::count]])
    segment = np.clip(np.searchsorted(edges, s, side="right") - 1, 0, segments - 1)
    place = (s - edges[segment]) / np.diff(edges)[segment] * count
    nodes = np.arange(min(STENCIL, count + 1))
    first = np.clip(place.astype(int) - len(nodes) // 2 + 1, 0, count + 1 - len(nodes))
    basis = lagrange_basis(nodes.astype(float), place - first)
    return (basis * on_segment[segment[:, None], first[:, None] + nodes]).sum(axis=1)


def _fractions(t: np.ndarray) -> np.ndarray:
    """Times as fractions of the duration; at equal distances in a phase that has shrunk to nothing."""
    return (t - t[0]) / (t[-1] - t[0]) if t[-1] > t[0] else np.linspace(0, 1, len(t))
