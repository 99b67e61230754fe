"""What a kind of method is to the rest: how it transcribes phases, and how costates are read from its multipliers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..problems.errors import Mistake
from ..problems.lean.records import dataclass
from ..problems.problem import Curves, Phase, Problem
from .engines.outcome import Outcome
from .layout import Transcription
from .program.contract import NonlinearProgram
from .schemes.mesh import Mesh

Transcribe = Callable[[Problem, Sequence[Mesh], Sequence[Curves], bool], Transcription]


TIMES = ("t[initial]", "t[final]")
"""Names of the times of a phase, where they are given."""


class DataNumber(NamedTuple):
    """A number that a program reads beside its unknowns.

    value: as the problem has it.
    replaced: the same program with another number in its place; good for values at one point.
    """

    value: float
    replaced: Callable[[float], NonlinearProgram]


Numbers = Mapping[tuple[str, str], DataNumber]
"""(phase, or BETWEEN; name of a parameter of the file that is data, or one of TIMES) -> number."""


class Program(NamedTuple):
    """A problem ready to be solved. built: `time.perf_counter` when the transcription was there, but not yet nlp."""

    transcription: Transcription
    nlp: NonlinearProgram
    built: float


@dataclass(frozen=True)
class MethodKind:
    """refused: why a phase cannot be transcribed on its mesh. transcribe: as `transcribe.transcribe`, all of its
    arguments given. compiled: the nonlinear program. costates: lambda of each phase, shape (n_x, K + N - 1), or None.
    numbers: what a program reads beside its unknowns. kept: a transcription and its program at once, where programs are
    kept for the next problem that differs in numbers only.
    """

    refused: Callable[[Problem, Phase, Mesh], Iterable[Mistake]]
    transcribe: Transcribe
    compiled: Callable[[Any], NonlinearProgram]
    costates: Callable[[Transcription, Any, Outcome], Sequence[np.ndarray | None]]
    numbers: Callable[[Any, Any], Numbers]
    kept: Callable[[Problem, Sequence[Mesh], Sequence[Curves]], Program] | None = None


def no_delays(problem: Problem, method: str) -> Iterable[Mistake]:
    """Why a problem is none for a method that takes no delays.

    problem: refused if any of its phases has states at earlier times, which may be in the one before.
    method: its name.
    """
    if late := next((own.name for phase in problem.phases for own in phase.delayed), ""):
        what = f"{method} cannot take a state at an earlier time, and {late} is one"
        yield Mistake("mesh", what, "write a collocation method, such as hermite-simpson or radau")
