"""A failed solve in the user's terms: which constraint, which expression, which phase, when, by how much."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .builder import Family
from .transcribe import Transcription
from .compiler import CompiledNLP
from .trajectory import Trajectory, trajectories


@dataclass(frozen=True)
class Violation:
    """A constraint that an iterate violates by `amount`, between the times `start` and `end`."""

    phase: str
    kind: str
    name: str
    start: float
    end: float
    amount: float

    def __str__(self) -> str:
        what = {
            "defect": f"the dynamics of {self.name}",
            "path": f"path constraint '{self.name}'",
            "bound": f"the bounds of {self.name}",
            "boundary": f"boundary constraint '{self.name}'",
            "integral": f"integral constraint '{self.name}'",
        }[self.kind]
        if self.kind in ("boundary", "integral"):
            when = ""
        elif self.start == self.end:
            when = f" at t = {self.start:.6g}"
        else:
            when = f" between t = {self.start:.6g} and {self.end:.6g}"
        return f"{what}{when} missed by {self.amount:.2e}"


def violations(transcription: Transcription, nlp: CompiledNLP, z: np.ndarray, count: int = 5) -> list[Violation]:
    """The largest violation of each constraint family at z, shape (n,), worst first, at most `count`; [] where none."""
    g = nlp.constraints_unchecked(z)
    excess = np.maximum(np.maximum(nlp.cl - g, g - nlp.cu), 0.0)
    excess[np.isnan(excess)] = np.inf
    phases = {trajectory.phase.name: trajectory for trajectory in trajectories(transcription, z)}
    worst = [_worst(family, excess[nlp.rows(family.component)], phases) for family in transcription.families]
    return sorted((v for v in worst if v.amount > 0), key=lambda v: -v.amount)[:count]


def _worst(family: Family, excess: np.ndarray, phases: dict[str, Trajectory]) -> Violation:
    i = int(np.argmax(excess))
    start, end = _times(family, i, phases[family.phase])
    return Violation(family.phase, family.kind, family.name, start, end, float(excess[i]))


def _times(family: Family, i: int, trajectory: Trajectory) -> tuple[float, float]:
    start, end = trajectory.t[0] + (trajectory.t[1] - trajectory.t[0]) * family.span[i]
    return float(start), float(end)


def explain_non_finite(transcription: Transcription, nlp: CompiledNLP, failed: tuple) -> str:
    """Say which expression had no finite value at the point `failed[0]`, at which time and with which values.

    failed: (z, [(component name, index), ...]) as in `outcome.Outcome`.
    """
    z, places = failed
    for trajectory in trajectories(transcription, z):
        for owner, function, at_ends in _functions(trajectory.phase):
            values = _end_values(trajectory) if at_ends else _point_values(trajectory)
            found = getattr(function, "trouble", lambda values: None)(values)
            if found:
                text, i, there = found
                time = "" if at_ends else f" at t = {trajectory.times[i]:.6g}"
                names = ", ".join(f"{name} = {value:.6g}" for name, value in there.items() if name != "t")
                return f"{owner}: {text} has no finite value{time}" + (f", where {names}" if names else "")
    name, index = places[0]
    return f"a derivative has no finite value in {name}" + ("" if index is None else f", index {index}")


def _functions(phase):
    """(whose, function, whether it is one of the boundary values) for every function of the phase."""
    yield from ((f"rate of {state.name}", state.rate, False) for state in phase.states)
    if phase.lagrange:
        yield "integral objective", phase.lagrange, False
    yield from ((f"path constraint '{c.name}'", c.function, False) for c in phase.path)
    yield from ((f"integral constraint '{c.name}'", c.function, False) for c in phase.integral)
    if phase.mayer:
        yield "terminal objective", phase.mayer, True
    yield from ((f"boundary constraint '{c.name}'", c.function, True) for c in phase.boundary)


def _point_values(trajectory: Trajectory) -> dict:
    return trajectory.phase.values(trajectory.times, trajectory.x, trajectory.u, trajectory.parameters)


def _end_values(trajectory: Trajectory) -> dict:
    values = _point_values(trajectory)
    ends = {
        f"{name}[{end}]": np.array([values[name][k]])
        for name in ("t", *(s.name for s in trajectory.phase.states), *(c.name for c in trajectory.phase.controls))
        for end, k in (("initial", 0), ("final", -1))
    }
    return {**ends, **trajectory.parameters}
