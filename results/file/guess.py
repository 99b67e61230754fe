"""An earlier result as the guess of a new solve."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import h5py
import numpy as np

from ...problems.errors import Mistake, SpecError
from ...problems.problem import Guess, Phase, Problem
from .door import open_result

GUESSED_KINDS = ("state", "control", "algebraic")


def guess_from(source: Path | bytes, problem: Problem) -> list[Guess]:
    """The trajectories of a result file, or of the content of one, as one guess for each phase, on the dense grid.

    States, controls and parameters that the file does not have keep the problem's own guess, so that a result of a
    simpler problem can start a richer one; `lacking` tells which. Raises FileError if the file is no result, SpecError
    if it has none of the states.
    """
    name = "the solution" if isinstance(source, bytes) else str(source)
    with open_result(source) as file:
        return [_guess(name, file, phase) for phase in problem.phases]


def lacking(path: Path, problem: Problem) -> list[Mistake]:
    """A warning for each phase with names that the result file does not have, and what they start from instead.

    Raises FileError if the file is no result.
    """
    found = []
    with open_result(path) as file:
        for phase in problem.phases:
            known = _names(file.get(f"phase/{phase.name}", {}))
            names = [*_told(phase.guess.values, known), *_told(phase.guess.parameters, known)]
            if names:
                where = "" if len(problem.phases) == 1 else f" in phase {phase.name}"
                what = f"it does not have {', '.join(names)}{where}"
                found.append(Mistake(str(path), what, "these start from the guess of the problem file"))
    return found


def _names(group: Mapping) -> set[str]:
    """Everything that a phase of a result file can give to a guess."""
    places = (*(f"dense/{kind}" for kind in GUESSED_KINDS), "parameter")
    return {name for place in places for name in group.get(place, {})}


def _told(values: Mapping, known: set[str]) -> list[str]:
    """The names that are not known, each with its first and last guess."""
    ends = {name: np.ravel(value)[[0, -1]] for name, value in values.items() if name not in known}
    return [f"{name} ({a:.4g})" if a == b else f"{name} ({a:.4g} to {b:.4g})" for name, (a, b) in ends.items()]


def _guess(source: str, file: h5py.File, phase: Phase) -> Guess:
    group = file.get(f"phase/{phase.name}", {})
    if not any(state.name in group.get("dense/state", {}) for state in phase.states):
        names = ", ".join(state.name for state in phase.states)
        raise SpecError(Mistake(source, f"it has none of the states {names}", "give a result of a similar problem"))
    dense = group["dense"]
    time = dense["time"][:]
    known = {name: np.nan_to_num(values[:]) for kind in GUESSED_KINDS for name, values in dense.get(kind, {}).items()}
    parameters = {name: float(np.nan_to_num(value[()])) for name, value in group["parameter"].items()}
    if not time[-1] > time[0]:
        raise SpecError(Mistake(source, "its duration is zero", "give another result"))
    s = (time - time[0]) / (time[-1] - time[0])
    return adapted(Guess(float(time[0]), float(time[-1]), s, known, parameters), phase)


def adapted(found: Guess, phase: Phase) -> Guess:
    """The curves of another problem as a guess of this phase, whose own guess gives what they lack."""
    own = phase.guess
    return Guess(
        initial_time=phase.initial_time.clip(found.initial_time),
        final_time=phase.final_time.clip(found.final_time),
        s=found.s,
        values={
            **own.samples(found.s),
            **{name: values for name, values in found.values.items() if name in own.values},
        },
        parameters={**own.parameters, **found.parameters},
    )
