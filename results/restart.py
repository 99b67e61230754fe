"""An earlier result as the guess of a new solve."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import h5py
import numpy as np

from ..problems.errors import FileError, Mistake
from ..problems.problem import Guess, Phase, Problem
from .store import open_result


def guess_from(path: Path, problem: Problem) -> list[Guess]:
    """The trajectories of a result file as one guess for each phase, on the file's dense grid.

    States, controls and parameters that the file does not have keep the problem's own guess, so that a result of a
    simpler problem can start a richer one. Raises FileError if the file is no result or has none of the states.
    """
    with open_result(path) as file:
        return [_guess(path, file, phase) for phase in problem.phases]


def _guess(path: Path, file: h5py.File, phase: Phase) -> Guess:
    group = file.get(f"phase/{phase.name}", {})
    if not any(state.name in group.get("dense/state", {}) for state in phase.states):
        names = ", ".join(state.name for state in phase.states)
        raise FileError(Mistake(str(path), f"it has none of the states {names}", "give a result of a similar problem"))
    dense, own = group["dense"], phase.guess
    time = dense["time"][:]
    s = (time - time[0]) / (time[-1] - time[0])
    known = {name: values for kind in ("state", "control", "algebraic") for name, values in _curves(dense[kind])}
    return Guess(
        initial_time=phase.initial_time.clip(float(time[0])),
        final_time=phase.final_time.clip(float(time[-1])),
        s=s,
        values={**own.samples(s), **{name: values for name, values in known.items() if name in own.values}},
        parameters={**own.parameters, **{name: float(value[()]) for name, value in group["parameter"].items()}},
    )


def _curves(group: h5py.Group) -> Iterator[tuple[str, np.ndarray]]:
    return ((name, np.nan_to_num(values[:])) for name, values in group.items())
