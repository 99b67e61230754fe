"""The three kinds of methods: how a problem is transcribed by each, and how costates are read from its multipliers.

What a method says of one segment is in `schemes.segment.Segment`; here is what is made of a whole problem. Shooting is
imported when it is used, and so is Pyomo.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..problems.errors import Mistake, SpecError
from ..problems.problem import Curves, Phase, Problem
from .collocation import kept
from .collocation.refused import refused_by_collocation, refused_by_differences
from .dual.end_masses import without_end_masses
from .engines.outcome import Outcome
from .layout import Transcription
from .libraries.alone import building
from .measured.program import with_residuals
from .method_kind import MethodKind, Numbers, Program
from .program.contract import NonlinearProgram
from .schemes.mesh import Mesh
from .schemes.segment import KindOfMethod
from .settings import Step, meshes_of
from .solution.costate import costates
from .solution.trajectory import Trajectory

MAX_UNKNOWNS = 5_000_000  # some 10 GB of Pyomo variables and matrix factors: refused before any memory is taken

Schedule = Sequence[Step | Sequence[Step]]
"""What to solve on in turn: one step for all phases, or one for each."""

Planned = tuple[Problem, list[Mesh], float]
"""The problem, the mesh of each phase and the tolerance of a solve."""


def _by_model(problem: Problem, meshes: Sequence[Mesh], guess: Sequence[Curves], templates: bool) -> Transcription:
    from .collocation.model import by_model  # Pyomo, which a program that is kept does not need

    return by_model(problem, meshes, guess, templates)


def _compiled_model(transcription: Transcription) -> NonlinearProgram:
    from .collocation.model import compiled_model

    return compiled_model(transcription)


def _shooting() -> MethodKind:
    from .shooting.program import ShootingNLP
    from .shooting.rows import by_shooting, refused_by_shooting

    def costates_of(transcription: Transcription, nlp: ShootingNLP, outcome: Outcome) -> list[np.ndarray]:
        return nlp.costates(outcome)

    return MethodKind(refused_by_shooting, by_shooting, ShootingNLP, costates_of, _own_numbers)


def _own_numbers(transcription: Transcription, nlp: Any) -> Numbers:
    numbers: Numbers = nlp.numbers()
    return numbers


def _nothing_refused(problem: Problem, phase: Phase, mesh: Mesh) -> Iterable[Mistake]:
    return ()


METHOD_KINDS: dict[KindOfMethod, Callable[[], MethodKind]] = {
    "collocation": lambda: MethodKind(
        refused_by_collocation, _by_model, _compiled_model, costates, kept.numbers, kept.kept_program
    ),
    "differences": lambda: MethodKind(refused_by_differences, _by_model, _compiled_model, costates, kept.numbers),
    "shooting": _shooting,
}


def kind_of(mesh: Mesh) -> MethodKind:
    """The kind of the method of a mesh; all its segments are of one."""
    return METHOD_KINDS[mesh.schemes[0].kind]()


def _kind_of_all(problem: Problem, meshes: Sequence[Mesh]) -> MethodKind:
    """How phases are transcribed together: by the kind that all have, or joined, where that makes no links."""
    simulated = {mesh.schemes[0].kind == "shooting" for mesh in meshes}
    linked = problem.links or problem.mayer
    return _joined() if len(simulated) > 1 or (linked and simulated == {True}) else kind_of(meshes[0])


def _joined() -> MethodKind:
    from .joined.parts import JoinedTranscription, by_parts
    from .joined.program import JoinedNLP

    def transcribe_parts(
        problem: Problem, meshes: Sequence[Mesh], guess: Sequence[Curves], templates: bool
    ) -> JoinedTranscription:
        if not templates:
            what = "phases by methods of different kinds, or by shooting, have no equations to write down together"
            raise SpecError(Mistake("mesh", what, "export with one method, as --method hermite-simpson"))
        return by_parts(kind_of, problem, meshes, guess)

    def costates_of(transcription: Transcription, nlp: JoinedNLP, outcome: Outcome) -> list[np.ndarray | None]:
        found = nlp.costates(outcome)
        return [found[phase.name] for phase in transcription.problem.phases]

    return MethodKind(_nothing_refused, transcribe_parts, JoinedNLP, costates_of, _own_numbers)


@building()
def transcribe(
    problem: Problem, meshes: Sequence[Mesh], guess: Sequence[Curves] | None = None, templates: bool = True
) -> Transcription:
    """Transcribe a problem on one mesh for each of its phases.

    problem: of one phase or more.
    meshes: one for each phase, of any method.
    guess: one for each phase, with the methods of `problems.problem.Guess`; by default the problem's own.
    templates: False gives an ordinary, expanded Pyomo model, for Pyomo's writers.

    Raises SpecError if there is no such nonlinear program, or it would be too large to hold.
    """
    if mistakes := list(refused(problem, meshes)):
        raise SpecError(mistakes)
    start = guess or [phase.guess for phase in problem.phases]
    return _kind_of_all(problem, meshes).transcribe(problem, meshes, start, templates)


def _kind_of(transcription: Transcription) -> MethodKind:
    return _kind_of_all(transcription.problem, [layout.mesh for layout in transcription.phases])


@building()
def compiled(transcription: Transcription) -> NonlinearProgram:
    """The nonlinear program of a transcription."""
    return with_residuals(transcription, _kind_of(transcription).compiled(transcription))


@building()
def program(problem: Problem, meshes: Sequence[Mesh], guess: Sequence[Curves] | None = None) -> Program:
    """The transcription of a problem and its nonlinear program, as of `transcribe` and `compiled`.

    problem, meshes, guess: as `transcribe` takes them.

    What was compiled for a problem that differs in numbers only serves again: then the Pyomo model of the transcription
    has the numbers of that one, and is good for names alone.
    """
    if mistakes := list(refused(problem, meshes)):
        raise SpecError(mistakes)
    start, kind = guess or [phase.guess for phase in problem.phases], _kind_of_all(problem, meshes)
    if kind.kept:
        found = kind.kept(problem, meshes, start)
    else:
        transcription = kind.transcribe(problem, meshes, start, True)
        found = Program(transcription, built=time.perf_counter(), nlp=kind.compiled(transcription))
    return found._replace(nlp=with_residuals(found.transcription, found.nlp))


def with_costates(
    transcription: Transcription, nlp: NonlinearProgram, outcome: Outcome, trajectories: Sequence[Trajectory]
) -> tuple[Trajectory, ...]:
    """The trajectories with lambda, shape (n_x, K + N - 1): at the slots of the mesh, in objective per unit of state.

    transcription: of the problem on one mesh for each phase.
    nlp: its compiled program.
    outcome: its solution, with multipliers.
    trajectories: one for each phase, read from the outcome.

    Shooting has them from the same definition as collocation, by the adjoint of its simulation; finite differences have
    none.
    """
    outcome = replace(outcome, y=without_end_masses(transcription, nlp, outcome))
    found = _kind_of(transcription).costates(transcription, nlp, outcome)
    return tuple(replace(own, costate=costate) for own, costate in zip(trajectories, found, strict=True))


@building()
def numbers_of(transcription: Transcription, nlp: NonlinearProgram) -> Numbers:
    """What a program reads beside its unknowns: given times, and the parameters of the file that are data in it.

    transcription: of any methods.
    nlp: its program.
    """
    return _kind_of(transcription).numbers(transcription, nlp)


def refused(problem: Problem, meshes: Sequence[Mesh]) -> Iterator[Mistake]:
    """Why a problem cannot be transcribed on these meshes: each at mesh, or with several at phases.NAME.mesh."""
    unknowns = sum(
        len(mesh.fractions) * (len(phase.states) + len(phase.inputs))
        for phase, mesh in zip(problem.phases, meshes, strict=True)
    )
    if unknowns > MAX_UNKNOWNS:
        what = f"{unknowns} unknowns are more than the {MAX_UNKNOWNS} that trajopt takes"
        yield Mistake("mesh", what, "use fewer segments")
    kinds = {mesh.schemes[0].kind for mesh in meshes}
    if kinds >= {"shooting", "differences"}:
        what = "finite differences have no velocities among their unknowns, to be linked with those of a simulation"
        yield Mistake("mesh", what, "take another method for one of the phases")
    for phase, mesh in zip(problem.phases, meshes, strict=True):
        whose = "" if len(meshes) == 1 else f"phases.{phase.name}."
        yield from (replace(m, where=whose + m.where) for m in kind_of(mesh).refused(problem, phase, mesh))


MORE_SEGMENTS = (2, 4)
"""Times the segments of a mesh: what is tried where so few may have no solution."""


def divided(problem: Problem, meshes: Sequence[Mesh], times: int) -> list[Mesh]:
    """The meshes with this many segments for each; those of phases that have no other mesh stay as they are.

    problem: that they are of.
    meshes: one for each phase.
    times: as many segments.
    """
    pairs = zip(problem.phases, meshes, strict=True)
    return [mesh if phase.exact else mesh.divided(times) for phase, mesh in pairs]


def may_be_divided(problem: Problem, meshes: Sequence[Mesh], times: int) -> bool:
    """Whether there are such meshes, and none is refused.

    problem, meshes, times: as of `divided`.
    """
    has_other = not all(phase.exact for phase in problem.phases)
    return has_other and not any(refused(problem, divided(problem, meshes, times)))


def planned(problem: Problem | Sequence[Problem], schedule: Schedule) -> list[Planned]:
    """The solves of a schedule.

    Raises SpecError with all that cannot be transcribed, at its entry of the schedule, before anything is solved.
    """
    problems = [problem] * len(schedule) if isinstance(problem, Problem) else problem
    steps = [_plan(own, step) for own, step in zip(problems, schedule, strict=True)]
    mistakes = [
        replace(mistake, where=re.sub(r"^((?:phases\.[^.]+\.)?)mesh\b", rf"\g<1>mesh.{number}", mistake.where))
        for number, (own, meshes, _) in enumerate(steps)
        for mistake in refused(own, meshes)
    ]
    if mistakes:
        raise SpecError(mistakes)
    return steps


def _plan(problem: Problem, step: Step | Sequence[Step]) -> Planned:
    own = [step] * len(problem.phases) if isinstance(step, Step) else list(step)
    return problem, meshes_of(problem, own), min(one.tolerance for one in own)
