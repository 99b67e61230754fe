"""A solution made exact by its structure: its arcs become phases with free switch times, and are solved again.

Where a control is on a bound it is fixed there, and a constraint that is active holds with equality; what is left is
smooth on every arc, so that few segments of high degree have it to the engine's tolerance. The solution of the phases
is kept if it is one of the same problem, claims a smaller error, wants no fixed control off its bound, and fails no
check of `verify` that the first one passes.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from math import inf
from pathlib import Path
from time import perf_counter

import numpy as np

from ...problems.errors import SpecError
from ...problems.lean.records import dataclass
from ...problems.phases.split import Part, split, why_not
from ...problems.problem import Guess, Problem
from ...problems.schema.spec import Spec
from ...transcription.continuation import solve_spec
from ...transcription.loading import build_checked, load_yaml
from ...transcription.refinement.goal import Goal
from ...transcription.solution.solution import Solution
from ..file.guess import adapted
from ..file.write import image_of, write_image
from ..verify import verify
from .parts import merged, parts_of
from .signs import worth_of_leaving

MOST_PARTS = 16
TOLERANCE, REFINED = 1e-10, 1e-9
"""Of the engine, and of the refined meshes."""

S = np.linspace(0, 1, 101)
"""Normalised times of a phase: of the part of the first solution from which it starts, and of bounds that it keeps."""

ALLOWED = 1e-6  # excess over 1 + |bound|, of a state whose bound is not in the problem of its phase
COLLAPSED = 1e-6  # of the duration: a phase that is shorter is none
ROUNDS = 3  # of leaving such phases out
ROUNDING = 1e-9  # of 1 + |objective|: what is worth less, is nothing

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
    spent = sum(sum(record.seconds.values()) for record in solution.meshes)
    end = began + max((spec.solver.seconds or inf) - spent - solution.elsewhere, 0.0)
    found = why_not(spec) or _polished(first, progress, lambda: perf_counter() > end or (stop is not None and stop()))
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
        elsewhere=new.elsewhere + solution.elsewhere + spent,
    )
    return Polished(new, found.spec)


def _polished(first: Polished, progress: Progress, stop: Stop) -> Polished | str:
    """The solution in phases, or why there is none that is better."""
    if not first.solution.objective_error.applies:
        return f"its objective has no error bar to compare with ({first.solution.objective_error.why_not})"
    return _in_phases(first, parts_of(first.solution.arcs[0], first.solution.trajectories[0]), progress, stop)


def _in_phases(first: Polished, parts: Sequence[Part], progress: Progress, stop: Stop) -> Polished | str:
    """The solution in phases, without those that shrink to nothing, or why there is none that is better."""
    whole = first.solution.trajectories[0]
    for _ in range(ROUNDS):
        if not 2 <= len(parts) <= MOST_PARTS:
            return "it has no switch" if len(parts) < 2 else f"it has {len(parts)} arcs, which are too many"
        new = _solved(first, parts, progress, stop)
        if isinstance(new, str):
            return new
        duration = whole.final_time - whole.initial_time
        lasts = [own.final_time - own.initial_time > COLLAPSED * duration for own in new.solution.trajectories]
        if all(lasts):
            return _why_worse(first, new, parts) or Polished(_with_arcs(new.solution, first.solution, parts), new.spec)
        parts = merged([part for part, kept in zip(parts, lasts, strict=True) if kept])
    return "its arcs shrink to nothing"


def _with_arcs(new: Solution, old: Solution, parts: Sequence[Part]) -> Solution:
    """The solution in phases with the arcs of the first one, whose controls are not bounded but fixed in it."""
    starts, found = [old.trajectories[0].initial_time, *(part.end for part in parts)], []
    for own, (a, b) in zip(new.trajectories, pairwise(starts), strict=True):
        arcs = [(course, course.at((a + b) / 2)) for course in old.arcs[0]]
        start, end = own.initial_time, own.final_time
        found.append(tuple(replace(course, arcs=(replace(arc, start=start, end=end),)) for course, arc in arcs))
    return replace(new, arcs=tuple(found))


def _solved(first: Polished, parts: Sequence[Part], progress: Progress, stop: Stop) -> Polished | str:
    """The solution in phases, or why there is none."""
    try:
        spec = load_yaml(split(first.spec, parts, TOLERANCE, REFINED), file=first.spec.file)
        (problems,) = build_checked([spec])
    except SpecError as error:
        return f"in {len(parts)} phases, {error.mistakes[0].what}"
    solution = solve_spec(spec, problems, guess=_guess(first, problems[0], parts), progress=progress, stop=stop)
    if not solution.solved:
        return f"in {len(parts)} phases it is not solved ({solution.status.message})"
    return Polished(solution, spec)


def _guess(first: Polished, problem: Problem, parts: Sequence[Part]) -> list[Guess]:
    """The parts of the first solution."""
    whole = first.solution.trajectories[0]
    start, duration = whole.initial_time, whole.final_time - whole.initial_time
    found = []
    for phase, (a, b) in zip(problem.phases, pairwise([start, *(part.end for part in parts)]), strict=True):
        curves = whole.samples(np.clip((a + (b - a) * S - start) / duration, 0.0, 1.0))
        found.append(adapted(Guess(a, b, S, curves, whole.parameters), phase))
    return found


def _why_worse(first: Polished, new: Polished, parts: Sequence[Part]) -> str:
    """What speaks against the solution in phases; "" if it is better."""
    old, own, sense = first.solution, new.solution, first.solution.problem.sense
    bars = [s.objective_error.bar for s in (old, own)]
    told = f"in {len(own.trajectories)} phases the objective is {own.objective:.10g}"
    if sense * (own.objective - old.objective) > bars[0] + bars[1]:
        return f"{told}, which is worse"
    phase = old.problem.phases[0]
    bounds = {variable.name: variable.bounds for variable in (*phase.states, *phase.controls)}
    for trajectory, part in zip(own.trajectories, parts, strict=True):
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
        write_image(path, image_of(solution, spec.text, spec.model_dump_json(), "", spec.overrides))
        return {check.name.rpartition(": ")[2] for check in verify(path, anew=False) if not check.passed}
