"""A solution made exact by its structure: its arcs become phases with free switch times, and are solved again.

Where a control is on a bound it is fixed there, and a constraint that is active holds with equality; what is left is
smooth on every arc, so that few segments of high degree have it to the engine's tolerance. The solution of the phases
is kept if it is one of the same problem, claims a smaller error, wants no fixed control off its bound, and fails no
check of `verify` that the first one passes.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from math import inf
from pathlib import Path
from time import perf_counter

import numpy as np

from ...problems.errors import SpecError
from ...problems.files import write_whole
from ...problems.lean.records import dataclass
from ...problems.nonsmooth.written import with_slack
from ...problems.phases.split import PhasePart, has_slack, why_not
from ...problems.phases.split_each import split
from ...problems.problem import Guess, Problem
from ...problems.schema.spec import Spec
from ...transcription.continuation import solve_spec
from ...transcription.loading import build_checked, load_yaml
from ...transcription.refinement.goal import Goal
from ...transcription.solution.solution import Solution
from ..file.guess import adapted
from ..file.write import image_of
from ..verify import verify
from .parts import merged, parts_of
from .signs import worth_of_leaving

MOST_PARTS = 16
TOLERANCE, REFINED = 1e-10, 1e-9
"""Of the engine, and of the refined meshes."""

MOST_ITERATIONS = 500
"""On each mesh in phases, which starts from a solution: one that takes more has lost it. Of the shipped problems none
that becomes better takes more than 300."""

S = np.linspace(0, 1, 101)
"""Normalised times of a phase: of the part of the first solution from which it starts, and of bounds that it keeps."""

ALLOWED = 1e-6  # excess over 1 + |bound|, of a state whose bound is not in the problem of its phase
COLLAPSED = 1e-6  # of the duration: a phase that is shorter is none
ROUNDS = 3  # of leaving such phases out
ROUNDING = 1e-9  # of 1 + |objective|: what is worth less, is nothing

Parts = Sequence[Sequence[PhasePart]]
"""Those of each phase, in order."""

Progress = Callable[[int, dict], None] | None
Stop = Callable[[], bool] | None


@dataclass(frozen=True)
class Polished:
    """The solution to keep, and its file: the first one, or that of the phases. The last of its notes says which."""

    solution: Solution
    spec: Spec


def polish(spec: Spec, solution: Solution, progress: Progress = None, stop: Stop = None) -> Polished:
    """Solve again by the structure that a solution shows.

    spec: the problem that was solved.
    solution: of it.
    progress, stop: as of `solve`.

    What cannot be polished, or is no better, comes back as it is, with a note that says why; what is not solved,
    without.
    """
    began, first = perf_counter(), Polished(solution, spec)
    if not solution.solved:
        return first
    spent = solution.seconds_of_meshes
    end = began + max((spec.solver.seconds or inf) - spent - solution.elsewhere, 0.0)
    found = why_not(spec) or _polished(
        _written(first), progress, lambda: perf_counter() > end or (stop is not None and stop())
    )
    if isinstance(found, str):
        notes = (*solution.notes, f"not polished: {found}")
        return Polished(replace(solution, notes=notes, elsewhere=solution.elsewhere + perf_counter() - began), spec)
    new, bar, segments = found.solution, solution.objective_error.bar, solution.meshes[-1].segments
    before = f"{solution.objective:.10g} +- {bar:.1g} on {segments} segments"
    asked = max(spec.refine.tolerance if spec.refine else 0.0, solution.meshes[-1].relative_error)
    missed = new.meshes[-1].relative_error > asked
    goal = spec.refine.objective if spec.refine else None
    stopped = new.stopped if missed else Goal(goal, new).missed if goal else ""
    new = replace(
        new,
        notes=(*new.notes, f"polished in {len(new.trajectories)} phases; before, {before}"),
        unmet=new.unmet if missed else (),
        stopped=stopped,
        discarded=(*solution.meshes, *solution.discarded, *new.discarded),
        elsewhere=solution.elsewhere + spent + perf_counter() - began - new.seconds_of_meshes,
    )
    return Polished(new, found.spec)


def _written(first: Polished) -> Polished:
    """The same with the slack variables of abs, min and max as controls of the file."""
    if not has_slack(first.spec):
        return first
    return Polished(first.solution, load_yaml(with_slack(first.spec), file=first.spec.file))


def _polished(first: Polished, progress: Progress, stop: Stop) -> Polished | str:
    """The solution in phases, or why there is none that is better."""
    if not first.solution.objective_error.applies:
        return f"its objective has no error bar to compare with ({first.solution.objective_error.why_not})"
    phases = zip(first.solution.arcs, first.solution.trajectories, strict=True)
    return _in_phases(first, [parts_of(courses, whole) for courses, whole in phases], progress, stop)


def _in_phases(first: Polished, parts: Parts, progress: Progress, stop: Stop) -> Polished | str:
    """The solution in phases, without those that shrink to nothing, or why there is none that is better."""
    for _ in range(ROUNDS):
        count = sum(map(len, parts))
        if count == len(parts):
            return "it has no switch" if count == 1 else "none of its phases has a switch"
        if count > MOST_PARTS * len(parts):
            return f"it has {count} arcs, which are too many"
        new = _solved(first, parts, progress, stop)
        if isinstance(new, str):
            return new
        lasting = _lasting(first, new, parts)
        if lasting == [list(own) for own in parts]:
            return _why_worse(first, new, parts) or Polished(_with_arcs(new.solution, first.solution, parts), new.spec)
        parts = [merged(own) for own in lasting]
    return "its arcs shrink to nothing"


def _lasting(first: Polished, new: Polished, parts: Parts) -> list[list[PhasePart]]:
    """The parts of each phase that have not shrunk to nothing; of several the last one, if all have."""
    found, trajectories = [], iter(new.solution.trajectories)
    for whole, own in zip(first.solution.trajectories, parts, strict=True):
        least = COLLAPSED * (whole.final_time - whole.initial_time)
        solved = [(part, next(trajectories)) for part in own]
        kept = [part for part, trajectory in solved if trajectory.final_time - trajectory.initial_time > least]
        found.append(kept if kept and len(own) > 1 else list(own[-1:]))
    return found


def _pieces(solution: Solution, parts: Parts) -> Iterator[tuple[int, PhasePart, float, float]]:
    """The number of the phase, the part, and from when to when it is in a solution, of all parts in order."""
    for number, (whole, own) in enumerate(zip(solution.trajectories, parts, strict=True)):
        starts = [whole.initial_time, *(part.end for part in own)]
        yield from ((number, part, a, b) for part, (a, b) in zip(own, pairwise(starts), strict=True))


def _with_arcs(new: Solution, old: Solution, parts: Parts) -> Solution:
    """The solution in phases with the arcs of the first one, whose controls are not bounded but fixed in it."""
    found = []
    for own, (number, _, a, b) in zip(new.trajectories, _pieces(old, parts), strict=True):
        arcs = [(course, course.at((a + b) / 2)) for course in old.arcs[number]]
        start, end = own.initial_time, own.final_time
        found.append(tuple(replace(course, arcs=(replace(arc, start=start, end=end),)) for course, arc in arcs))
    return replace(new, arcs=tuple(found))


def _solved(first: Polished, parts: Parts, progress: Progress, stop: Stop) -> Polished | str:
    """The solution in phases, or why there is none."""
    count = sum(map(len, parts))
    try:
        spec = _in_parts(first, first.spec, parts)
        (problems,) = build_checked([spec])
    except SpecError as error:
        return f"in {count} phases, {error.mistakes[0].what}"
    solution = solve_spec(spec, problems, guess=_guess(first, problems[0], parts), progress=progress, stop=stop)
    if not solution.solved:
        return f"in {count} phases it is not solved ({solution.status.message})"
    if _of_mesh(first, solution.objective):
        spec = _in_parts(first, first.spec.model_copy(update={"reference": None}), parts)
    return Polished(solution, spec)


def _in_parts(first: Polished, spec: Spec, parts: Parts) -> Spec:
    """The file in phases. Raises SpecError."""
    named = {phase.name: own for phase, own in zip(first.solution.problem.phases, parts, strict=True)}
    return load_yaml(split(spec, named, TOLERANCE, REFINED, MOST_ITERATIONS), file=spec.file)


def _of_mesh(first: Polished, objective: float) -> bool:
    """Whether the file's reference is of its mesh, and not of the problem: given more exactly than the solution on that
    is known, and missed by one that is better known."""
    given = first.spec.reference
    if given is None or given.tolerance >= first.solution.objective_error.bar:
        return False
    return abs(objective - given.objective) > given.tolerance


def _guess(first: Polished, problem: Problem, parts: Parts) -> list[Guess]:
    """The parts of the first solution."""
    found = []
    for phase, (number, _, a, b) in zip(problem.phases, _pieces(first.solution, parts), strict=True):
        whole = first.solution.trajectories[number]
        start, duration = whole.initial_time, (whole.final_time - whole.initial_time) or 1.0
        curves = whole.samples(np.clip((a + (b - a) * S - start) / duration, 0.0, 1.0))
        found.append(adapted(Guess(a, b, S, curves, whole.parameters), phase))
    return found


def _why_worse(first: Polished, new: Polished, parts: Parts) -> str:
    """What speaks against the solution in phases; "" if it is better."""
    old, own, sense = first.solution, new.solution, first.solution.problem.sense
    bars = [s.objective_error.bar for s in (old, own)]
    told = f"in {len(own.trajectories)} phases the objective is {own.objective:.10g}"
    if sense * (own.objective - old.objective) > bars[0] + bars[1]:
        return f"{told}, which is worse"
    for trajectory, (number, part, _, _) in zip(own.trajectories, _pieces(old, parts), strict=True):
        phase = old.problem.phases[number]
        bounds = {variable.name: variable.bounds for variable in (*phase.states, *phase.controls)}
        beyond = [name for name in part.freed if bounds[name].excess(trajectory.samples(S)[name]).max() > ALLOWED]
        if beyond:
            return f"{told}, but {beyond[0]} leaves its bounds"
        worth = worth_of_leaving(trajectory, part.fixed, bounds, old.problem.sense)
        if worth > max(bars[1], ROUNDING * (1 + abs(own.objective))):
            where = f"t = {trajectory.initial_time:.5g} to {trajectory.final_time:.5g}"
            return f"{told}, but from {where} {' or '.join(part.fixed)} should not be on its bound (worth {worth:.1g})"
    if not own.objective_error.applies or bars[1] >= bars[0]:
        return f"{told}, whose error bar is no smaller"
    failed = _failed(new)
    if failed and (worse := failed - _failed(first)):
        return f"{told}, but verify fails in '{min(worse)}'"
    return ""


def _failed(found: Polished) -> set[str]:
    """The kinds of checks of `verify` that fail; it is not solved anew."""
    solution, spec = found.solution, found.spec
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "result.h5"
        write_whole(path, image_of(solution, spec.text, spec.model_dump_json(), "", spec.overrides))
        return {check.name.rpartition(": ")[2] for check in verify(path, anew=False) if not check.passed}
