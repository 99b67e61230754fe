"""The arcs of all quantities together: a solution cut wherever one of them comes to a bound or leaves it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ...problems.phases.split import PhasePart
from ...transcription.arcs import CONTROL, HELD, INSIDE, STATE, UPPER, Arc, Course
from ...transcription.solution.trajectory import Trajectory

NEAR = 2e-3
"""Of the duration: switches nearer to each other than this are one."""


def parts_of(courses: Sequence[Course], trajectory: Trajectory) -> list[PhasePart]:
    """The parts of a phase, one after the other.

    courses: of the phase.
    trajectory: of the phase.
    """
    start, end = trajectory.initial_time, trajectory.final_time
    groups: list[list[float]] = []
    for t in sorted(arc.end for course in courses for arc in course.arcs[:-1]):
        if groups and t - groups[-1][-1] <= NEAR * (end - start):
            groups[-1].append(t)
        else:
            groups.append([t])
    ends = [*(float(np.mean(group)) for group in groups), end]
    return merged(_freed_beside([_part(courses, trajectory, (a + b) / 2, b) for a, b in pairwise([start, *ends])]))


def _part(courses: Sequence[Course], trajectory: Trajectory, t: float, end: float) -> PhasePart:
    """The part that has a time t, and ends at another.

    A constraint that is active is held by a control that is free; a state beside controls that are all on their bounds
    is where it is because of them.
    """
    at = {course.name: course.at(t) for course in courses if course.kind == CONTROL}
    fixed = {name: arc.on for name, arc in at.items() if arc.on != INSIDE}
    free = len(trajectory.phase.controls) - len(fixed)
    active = {
        course.name: (course, arc)
        for course in courses
        if course.kind != CONTROL and (arc := course.at(t)).on != INSIDE
    }
    named = [arc.by.removeprefix(HELD) for arc in at.values() if arc.by.startswith(HELD)]
    unnamed = free - sum(arc.on == INSIDE for arc in at.values())  # controls that have no arcs of their own
    named += [name for name in active if name not in named][:unnamed]
    held = {name: arc.on for name, (_, arc) in active.items() if name in named}
    freed = {name: (arc.on, _beyond(course, arc)) for name, (course, arc) in active.items() if not free}
    return PhasePart(end, fixed, held, {name: own for name, own in freed.items() if active[name][0].kind == STATE})


def _freed_beside(parts: Sequence[PhasePart]) -> list[PhasePart]:
    """Parts in which the states that a neighbour frees are free, too: where they meet, they are still on the bound."""
    found = []
    for part, others in zip(parts, zip([None, *parts[:-1]], [*parts[1:], None], strict=True), strict=True):
        beside = {name: own for other in others if other for name, own in other.freed.items() if name not in part.held}
        found.append(replace(part, freed={**beside, **part.freed}))
    return found


def _beyond(course: Course, arc: Arc) -> float:
    """A number beyond the bound of an arc."""
    bound = course.bound(arc)
    return bound + (1 + abs(bound)) * (1 if arc.on == UPPER else -1)


def merged(parts: Sequence[PhasePart]) -> list[PhasePart]:
    """Parts without switches between two that are alike, where nothing is left to jump."""
    kept: list[PhasePart] = []
    for part in parts:
        if kept and part.fixed and replace(kept[-1], end=part.end) == part:
            kept[-1] = part
        else:
            kept.append(part)
    return kept
