"""Constraints that contradict each other, from the multipliers at a point of least infeasibility.

There IPOPT's multipliers are those of its restoration phase, which minimises the sum of all violations: zero for
whatever could be dropped without making the point less infeasible. What was demanded of the ends and the times is named
first, then constraints, and bounds last: they act wherever a problem is hard.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from ...problems.quantities import State
from ..constraint_kinds import ConstraintKind
from ..engines.outcome import Outcome
from ..layout import Family, Layout, Transcription
from ..program.contract import NonlinearProgram
from ..solution.trajectory import Trajectory, trajectories
from ..solution.violation import Trouble, constraint_named, of_phase, times_at, when_between

ACTIVE = 1e-4  # of the largest multiplier: smaller ones are what the barrier leaves on constraints that do not act


def conflict(transcription: Transcription, nlp: NonlinearProgram, outcome: Outcome) -> Trouble:
    """Which constraints cannot all hold, if that can be told.

    transcription: what stands where.
    nlp: its compiled program.
    outcome: of a solve that ended at a point of least infeasibility.
    """
    phases = {trajectory.phase.name: trajectory for trajectory in trajectories(transcription, outcome.z)}
    largest = max(np.abs(part).max(initial=0.0) for part in (outcome.y, outcome.z_lower, outcome.z_upper))
    limit = ACTIVE * float(largest)
    if not limit:
        return Trouble()
    first = [part for layout in transcription.phases for part in _ends(layout, outcome, limit)]
    first += _parameters(transcription, outcome, limit)
    first += _constraints(transcription, nlp, outcome, phases, limit)
    first += [part for layout in transcription.phases for part in _bounds(layout, outcome, phases, limit)]
    return Trouble("these cannot all hold: {}", tuple(first)) if first else Trouble()


def _force(outcome: Outcome, places: np.ndarray) -> np.ndarray:
    """Multipliers of the lower and upper bounds of unknowns, shape (2, ...); 0 where there is no unknown."""
    return np.where(places >= 0, np.abs([outcome.z_lower[places], outcome.z_upper[places]]), 0.0)


def _ends(layout: Layout, outcome: Outcome, limit: float) -> Iterator[str]:
    """Values of states at the ends, and times."""
    phase, whose = layout.phase, of_phase(layout.phase.name)
    for state, places in zip(phase.states, layout.x, strict=True):
        forces = _force(outcome, places[[0, -1]]).max(axis=0)
        for end, own, force in zip(("initial", "final"), state.own_ends, forces, strict=True):
            if own and force > limit:
                yield f"the {end} value of {state.name}{whose}"
    for end, sides in zip(("initial", "final"), _force(outcome, layout.t).T, strict=True):
        for side, force in zip(("lower", "upper"), sides, strict=True):
            if force > limit:
                yield f"the {side} bound of the {end} time{whose}"


def _parameters(transcription: Transcription, outcome: Outcome, limit: float) -> Iterator[str]:
    forces = _force(outcome, transcription.parameters).T
    for parameter, sides in zip(transcription.problem.parameters, forces, strict=True):
        for side, force in zip(("lower", "upper"), sides, strict=True):
            if force > limit:
                yield f"the {side} bound of {parameter.name}"


def _constraints(
    transcription: Transcription,
    nlp: NonlinearProgram,
    outcome: Outcome,
    phases: Mapping[str, Trajectory],
    limit: float,
) -> Iterator[str]:
    """What holds once before what holds over time."""
    constraints: dict[tuple[str, ConstraintKind, str], list[Family]] = {}
    for family in transcription.families:
        if not family.kind.model:
            constraints.setdefault((family.phase, family.kind, family.name), []).append(family)
    for key, same in sorted(constraints.items(), key=lambda item: item[0][1].timed):
        acting = [f.span[np.abs(outcome.y[f.rows(nlp)]) / f.weights > limit] for f in same]
        s = np.concatenate(acting).ravel()
        if len(s):
            phase, kind, _ = key
            when = when_between(*times_at(phases[phase], np.array([s.min(), s.max()]))) if kind.timed else ""
            yield constraint_named(*key) + when


def _bounds(layout: Layout, outcome: Outcome, phases: Mapping[str, Trajectory], limit: float) -> Iterator[str]:
    """Bounds of states and inputs that act over time."""
    phase, mesh = layout.phase, layout.mesh
    for variable, places in zip((*phase.states, *phase.inputs), (*layout.x, *layout.u), strict=True):
        sides = _force(outcome, places)
        if isinstance(variable, State):
            sides[:, [0, -1]] *= ~np.array(variable.own_ends)
        for side, force in zip(("lower", "upper"), sides, strict=True):
            s = mesh.fractions[force / np.where(mesh.weights > 0, mesh.weights, np.inf) > limit]
            if len(s):
                when = when_between(*times_at(phases[phase.name], s[[0, -1]]))
                yield f"the {side} bound of {variable.name}{of_phase(phase.name)}{when}"
