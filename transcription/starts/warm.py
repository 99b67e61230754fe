"""Multipliers of a solved mesh -> multipliers to start the next mesh from.

Multipliers are no functions of time, but densities of them are: with the quadrature weight w_k of a point and the
phase's duration T,

    y_k / (w_k T)   of a path constraint or a bound     approximates the multiplier function of the continuous problem,
    mu_s R          of the defects of segment s         equals -b lambda, lambda being the costate (see `costate`).

So costates and densities are interpolated to the new points and turned back. Boundary and integral constraints, links,
free times and parameters have one multiplier each, which is kept.
"""

from __future__ import annotations

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.text import short_repr
from ..constraint_kinds import Multiplier
from ..engines.outcome import Outcome, Start
from ..layout import BETWEEN, Family, Layout, Transcription
from ..program.contract import NonlinearProgram
from ..refinement.chatter import UNDAMPED, Damping
from ..solution.trajectory import Trajectory


@short_repr
@dataclass(frozen=True)
class Solved:
    """What a solve leaves for the next one.

    nlp, outcome: the program of the problem itself, and its objective. damping: of controls that chattered,
    worth: what that adds to it.
    """

    transcription: Transcription
    nlp: NonlinearProgram
    outcome: Outcome
    trajectories: tuple[Trajectory, ...]
    damping: Damping = UNDAMPED
    worth: float = 0.0

    def has_densities(self, transcription: Transcription) -> bool:
        """Whether both this mesh and the next give multipliers a meaning over time."""
        layouts = (*self.transcription.phases, *transcription.phases)
        return all(scheme.densities for layout in layouts for scheme in layout.mesh.schemes)


def warm_start(old: Solved, transcription: Transcription, nlp: NonlinearProgram) -> Start:
    """Multipliers for a new transcription of the same problem, shapes (m,), (n,), (n,).

    old: the solve before; its method has densities, see `Solved.has_densities`.
    transcription: of the problem on the new mesh, by a method that has densities too.
    nlp: its compiled program, which knows the rows of a family.
    """
    y = np.zeros(nlp.m)
    for family in transcription.families:
        if family.phase == BETWEEN:
            y[family.rows(nlp)] = _density(family, old)
    for layout, trajectory in zip(transcription.phases, old.trajectories, strict=True):
        sample = trajectory.at(layout.mesh.fractions)
        assert sample.costate is not None  # multipliers with densities have costates
        costate = sample.costate * transcription.problem.sense
        mu = [group.scheme.defect_multipliers(costate[:, group.nodes]) for group in layout.mesh.groups]
        for family in transcription.families:
            if family.phase != layout.phase.name:
                continue
            rows = family.rows(nlp)
            of_defects = family.kind.multiplier is Multiplier.COSTATE
            y[rows] = _of_state(family, layout, mu) if of_defects else _density(family, old)
    lower, upper = np.zeros((2, nlp.n))
    for new, values in ((lower, old.outcome.z_lower), (upper, old.outcome.z_upper)):
        new[transcription.parameters] = values[old.transcription.parameters]
        for layout, before in zip(transcription.phases, old.transcription.phases, strict=True):
            _bounds(layout, before, new, values)
    return Start(y, lower, upper)


def _density(family: Family, old: Solved) -> np.ndarray:
    """The multipliers of a constraint that is no defect."""
    wanted = (family.phase, family.kind, family.name)
    same = [f for f in old.transcription.families if (f.phase, f.kind, f.name) == wanted]
    if not same:  # the bounds of a state that the scheme before did not eliminate
        return np.zeros(len(family.span))
    before = np.concatenate([old.outcome.y[f.rows(old.nlp)] / f.weights for f in same])
    times = np.concatenate([f.span[:, 0] for f in same])
    order = np.argsort(times)
    return family.weights * np.interp(family.span[:, 0], times[order], before[order])


def _of_state(family: Family, layout: Layout, mu: list[np.ndarray]) -> np.ndarray:
    """The multipliers of one family of defects, from those of all the rows of each group, (n_x, G, rows)."""
    state = [s.name for s in layout.phase.states].index(family.name)
    rows = layout.mesh.groups[family.group].scheme.rows
    wanted = [family.row] if isinstance(family.row, int) else family.row
    return mu[family.group][state][:, [rows.index(r) for r in wanted]].ravel()


def _bounds(layout: Layout, before: Layout, new: np.ndarray, values: np.ndarray) -> None:
    """Multipliers of the bounds on the times, states and controls of one phase, into `new`."""
    for place, old in zip(layout.t, before.t, strict=True):
        if place >= 0:
            new[place] = values[old]
    for places, olds in ((layout.x, before.x), (layout.u, before.u)):
        for place, old in zip(places, olds, strict=True):
            known = np.flatnonzero((old >= 0) & (before.mesh.weights > 0))  # elsewhere there is no density
            wanted = np.flatnonzero(place >= 0)
            density = values[old[known]] / before.mesh.weights[known]
            at = np.interp(layout.mesh.fractions[wanted], before.mesh.fractions[known], density)
            new[place[wanted]] = at * layout.mesh.weights[wanted]
            for end in (0, -1):  # the bounds of an initial or final value act once, not over time
                if place[end] >= 0 and old[end] >= 0:
                    new[place[end]] = values[old[end]]
