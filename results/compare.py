"""Results of one problem, solved on different meshes or by different methods, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..problems.errors import FileError, Mistake
from .curves import PhaseCurves
from .curves import read as read_result
from .summary import summarize


def compare(paths: Sequence[Path]) -> list[dict[str, Any]]:
    """One row for each result, measured against the first one.

    difference: of the objective from the first; state_difference: the largest distance of any state from the first's,
    relative to that state's range, at equal fractions of the duration, and where. Raises FileError if a file is no
    result, or has no state or phase in common with the first.
    """
    first, rows = read_result(paths[0]), []
    for path in paths:
        summary, result = summarize(path), read_result(path)
        mesh = summary["meshes"][-1]
        state, distance = _distance(path, first.phases, result.phases)
        rows.append({
            "file": str(path),
            "solved": summary["solved"],
            "method": mesh["method"],
            "segments": mesh["segments"],
            "unknowns": mesh["unknowns"],
            "objective": summary["objective"],
            "difference": summary["objective"] - rows[0]["objective"] if rows else 0.0,
            "state_difference": distance,
            "state": state,
            "max_eta": summary["error"]["max_eta"],
            "iterations": summary["iterations"],
            "seconds": summary["seconds"]["total"],
        })  # fmt: skip
    return rows


def _distance(path: Path, first: Sequence[PhaseCurves], other: Sequence[PhaseCurves]) -> tuple[str, float]:
    """The state that differs most, and by how much."""
    distances = {
        name: distance
        for a, b in zip(first, other, strict=False)
        if a.name == b.name
        for name, distance in _state_distances(a, b).items()
    }
    if not distances:
        raise FileError(Mistake(str(path), "it has no state in common with the first result", "compare like with like"))
    worst = max(distances, key=distances.get)
    return worst, distances[worst]


def _state_distances(a: PhaseCurves, b: PhaseCurves) -> dict[str, float]:
    s = np.union1d(_fractions(a), _fractions(b))
    distances = {}
    for name, curve in a.curves["state"].items():
        if name in b.curves["state"]:
            own = np.interp(s, _fractions(a), curve.dense)
            others = np.interp(s, _fractions(b), b.curves["state"][name].dense)
            distances[name] = float(np.abs(own - others).max() / (np.ptp(curve.dense) or 1.0))
    return distances


def _fractions(phase: PhaseCurves) -> np.ndarray:
    t = phase.dense_time
    return (t - t[0]) / (t[-1] - t[0])
