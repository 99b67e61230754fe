"""Which bounds and path constraints of a result do not hold between its points, as `trajopt verify` would find."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ...problems.problem import Phase
from ...problems.quantities import TOLERATED_EXCESS, Range
from ..file.bounds import beyond, bounds_beside
from ..file.read import Result
from ..file.reload import reload
from .trajectory import between_points

TOLERANCE = 5e-2
"""Relative error that passes, as in `verify`."""


@np.errstate(all="ignore")
def broken_bounds(result: Result, bounds: Mapping[str, Mapping[str, Range]]) -> dict[str, frozenset[str]]:
    """Phase -> names whose bounds a check fails: of variables, of path constraints, and of what these are about.

    result: its problem is transcribed anew only where a bound is exceeded by what refinement counts.
    bounds: as `bounds_of` gives them.

    Raises FileError for a result that does not tell its problem.
    """
    return _failing(result.path) if _any_exceeded(result, bounds) else {}


def _any_exceeded(result: Result, bounds: Mapping[str, Mapping[str, Range]]) -> bool:
    for phase in result.phases:
        for kind, curves in phase.curves.items():
            for name, curve in () if kind == "costate" else curves.items():
                for _, value, upper, _ in bounds_beside([phase], kind, name, bounds):
                    if beyond(curve.dense, value, upper) > TOLERATED_EXCESS * (1 + abs(value)):
                        return True
    return False


def _failing(path: Path) -> dict[str, frozenset[str]]:
    found: dict[str, frozenset[str]] = {}
    whole = reload(path)
    if not np.isfinite(whole.outcome.z).all():  # as `verify`, which looks at nothing else then
        return found
    for trajectory in whole.trajectories:
        if trajectory.phase.exact:  # which has nothing between its points
            continue
        names = _names(trajectory.phase)
        failed = [own.name for own in between_points(trajectory, TOLERANCE) if not own.passed]
        found[trajectory.phase.name] = frozenset(name for own in failed for name in names[own])
    return found


def _names(phase: Phase) -> dict[str, set[str]]:
    """Name of a check -> what pictures call that which it is about."""
    names = {f"bounds of {own.name}": {own.name} for own in (*phase.states, *phase.inputs)}
    for own in phase.path:
        names[f"path constraint '{own.name}'"] = {own.name, str(getattr(own.function, "text", own.name))}
    return {f"{name} between the points": found for name, found in names.items()}
