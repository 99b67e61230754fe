"""An earlier result as the guess of a new solve."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np

from ...problems.errors import Mistake, SpecError
from ...problems.problem import Guess, Phase, Problem
from .door import open_result

SAMPLES = 201
"""Of the part of a result that becomes the guess of a phase of another name."""

GUESSED_KINDS = ("state", "control", "algebraic")


def guess_from(source: Path | bytes, problem: Problem) -> list[Guess]:
    """The trajectories of a result file, or of the content of one, as one guess for each phase, on the dense grid.

    States, controls and parameters that the file does not have keep the problem's own guess, so that a result of a
    simpler problem can start a richer one; `lacking` tells which. Raises FileError if the file is no result, SpecError
    if it has none of the states.
    """
    name = "the solution" if isinstance(source, bytes) else str(source)
    with open_result(source) as file:
        return [_guess(name, file, problem, phase) for phase in problem.phases]


def lacking(path: Path, problem: Problem) -> list[Mistake]:
    """A warning for each phase with names that the result file does not have, and what they start from instead.

    Raises FileError if the file is no result.
    """
    found = []
    with open_result(path) as file:
        for phase in problem.phases:
            groups = file["phase"]
            named = [groups[phase.name]] if phase.name in groups else list(groups.values())
            known = set.intersection(*map(_names, named))
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


def _guess(source: str, file: h5py.File, problem: Problem, phase: Phase) -> Guess:
    names = [phase.name] if phase.name in file["phase"] else list(file["phase"])
    curves = [_stored(source, file["phase"][name]) for name in names]
    if phase.static:
        if not curves[0].parameters.keys() & phase.guess.parameters.keys():
            missing = ", ".join(phase.guess.parameters)
            raise SpecError(Mistake(source, f"it has none of {missing}", "give a result of a similar problem"))
        return replace(phase.guess, parameters={**phase.guess.parameters, **curves[0].parameters})
    if not any(state.name in own.values for own in curves for state in phase.states):
        missing = ", ".join(state.name for state in phase.states)
        raise SpecError(Mistake(source, f"it has none of the states {missing}", "give a result of a similar problem"))
    return adapted(curves[0] if phase.name in file["phase"] else _part(curves, problem, phase), phase)


def _stored(source: str, group: h5py.Group) -> Guess:
    """The curves of a stored phase."""
    dense = group["dense"]
    time = dense["time"][:]
    known = {name: np.nan_to_num(values[:]) for kind in GUESSED_KINDS for name, values in dense.get(kind, {}).items()}
    parameters = {name: float(np.nan_to_num(value[()])) for name, value in group["parameter"].items()}
    if not time[-1] > time[0] and known:
        raise SpecError(Mistake(source, "its duration is zero", "give another result"))
    s = (time - time[0]) / ((time[-1] - time[0]) or 1.0)  # a result without time has parameters only
    return Guess(float(time[0]), float(time[-1]), s, known, parameters)


def _part(curves: Sequence[Guess], problem: Problem, phase: Phase) -> Guess:
    """The part of a result of other phases that a phase is, by its guessed times: the phases one after the other, what
    some of them lack left out."""
    starts = [own.guess.initial_time for own in problem.phases]
    whole = min(starts), max(own.guess.final_time for own in problem.phases)
    first, last = min(own.initial_time for own in curves), max(own.final_time for own in curves)
    own = phase.guess
    places = [(t - whole[0]) / (whole[1] - whole[0]) for t in (own.initial_time, own.final_time)]
    begin, end = (first + place * (last - first) for place in places)
    ordered = sorted(curves, key=lambda curve: curve.initial_time)
    times = np.concatenate(
        [curve.initial_time + curve.s * (curve.final_time - curve.initial_time) for curve in ordered]
    )
    shared = set.intersection(*(set(curve.values) for curve in ordered))
    s = np.linspace(0.0, 1.0, SAMPLES)
    at = begin + s * (end - begin)
    values = {name: np.interp(at, times, np.concatenate([c.values[name] for c in ordered])) for name in shared}
    return Guess(begin, end, s, values, ordered[0].parameters)


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
