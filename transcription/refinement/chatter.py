"""Chatter: a control that turns at nearly every point of the mesh, or in every segment, where the problem hardly
determines it.

On a singular arc H does not depend on the control, and what of J does, through the states, falls with the square of the
frequency. The fastest oscillation that a mesh can hold is then worth nothing, or a little less than nothing, as the
scheme does not see what happens between its points: the nonlinear program has no smooth solution, and a finer mesh
holds faster oscillations. So such a control is damped. With the second difference of three neighbouring points,

    d_k = 2 (h+ u_k-1 - (h- + h+) u_k + h- u_k+1) / (h- + h+),        h-, h+ their distances, over the duration,

which is 0 for a straight line, the objective gets

    strength (1 + |J|) sum over k of (h- + h+)/2 (d_k / range of u)^2.

A smooth control has d of second order in h, the term is of fourth. An oscillation has d = 2 range. A jump costs some h,
wherever it is, so that the term is summed over the whole phase: where it ends, oscillations begin. The objective of
a solution is always that of the problem itself; what the term is worth is a part of its error bar.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.quantities import Variable
from ...problems.text import short_repr
from ..layout import Transcription
from ..program.contract import NonlinearProgram, WithTerm
from ..solution.trajectory import Trajectory
from ..solution.violation import of_phase
from .damped import Squares

TURN = 0.05  # of a control's range: what it has to go back and forth to turn
WIDE = 0.5  # of a control's range: turns at one point by so much count wherever they are
TURNS = 8  # of a control that chatters, at least: the bang-bang controls that a mesh resolves turn more rarely
PERIODS = 16  # one in each segment: bang-bang controls with few points on each arc have some, too
NEAR = 2  # points from one turn to the next, at most
STRENGTH = 1e-2
WEAKER = 0.1
FLAT = 1e-6  # of the size of a control: one that varies less does not chatter


@dataclass(frozen=True)
class Rough:
    """A control that chatters.

    phase, control: their names. start, end: normalised times, of the points before the first and after the last turn.
    span: the range of the control, the distance of its bounds or else that of its values.
    """

    phase: str
    control: str
    start: float
    end: float
    span: float

    def told(self, trajectories: Sequence[Trajectory]) -> str:
        """Where it chatters, in words.

        trajectories: of the solution, one for each phase.
        """
        times = next(own.times for own in trajectories if own.phase.name == self.phase)
        start, end = (times[0] + s * np.ptp(times) for s in (self.start, self.end))
        return f"{self.control}{of_phase(self.phase)} is hardly determined within t = {start:.4g} to {end:.4g}"


@short_repr
@dataclass(frozen=True)
class Damping:
    """The controls that are damped, none if there are none, and how; size: 1 + |J|."""

    controls: tuple[Rough, ...] = ()
    strength: float = STRENGTH
    size: float = 1.0

    def of(self, nlp: NonlinearProgram, transcription: Transcription) -> WithTerm | None:
        """A program with damped controls; None if nothing is to be damped.

        nlp: the program of the problem itself.
        transcription: says where its unknowns stand.
        """
        if not self.controls:
            return None
        columns, factors = zip(*(self._rows(transcription, control) for control in self.controls), strict=True)
        return WithTerm(nlp, Squares(np.concatenate(columns), np.concatenate(factors)))

    def _rows(self, transcription: Transcription, rough: Rough) -> tuple[np.ndarray, np.ndarray]:
        """Columns and factors of one control, (M, 3) each."""
        layout = next(layout for layout in transcription.phases if layout.phase.name == rough.phase)
        number = [control.name for control in layout.phase.controls].index(rough.control)
        known = layout.u[number] >= 0
        places, tau = layout.u[number, known], layout.mesh.fractions[known]
        three = np.arange(len(places) - 2)[:, None] + np.arange(3)
        before, after = np.diff(tau[three]).T
        both = before + after
        d = 2 * np.stack([after, -both, before], axis=1) / both[:, None]
        weight = self.strength * self.size * both  # twice that of the docstring: of the half in 1/2 |D z|^2
        return places[three], np.sqrt(weight)[:, None] * d / rough.span

    def worth(self, nlp: NonlinearProgram, transcription: Transcription, z: np.ndarray) -> float:
        """What the damping term is at z.

        nlp, transcription: as of `of`.
        z: (n,) the unknowns.
        """
        damped = self.of(nlp, transcription)
        return damped.term.objective(z) if damped else 0.0

    def told(self, trajectories: Sequence[Trajectory], worth: float) -> list[str]:
        """What was done, a sentence for each control.

        trajectories: of the solution, one for each phase.
        worth: of the term there.
        """
        damped = f"and chattered; its oscillations are damped (worth {worth:.1e} of the objective)"
        return [f"{rough.told(trajectories)}, {damped}" for rough in self.controls]

    def weaker(self) -> Damping:
        return replace(self, strength=self.strength * WEAKER)

    def stronger(self) -> Damping:
        return replace(self, strength=self.strength / WEAKER)

    def joined(self, more: Iterable[Rough], objective: float) -> Damping:
        """With more controls; those that are here already chatter within both times.

        more: any of them may be here already.
        objective: J, for the size of the term.
        """
        controls: dict[tuple[str, str], Rough] = {}
        for rough in (*self.controls, *more):
            one = controls.setdefault((rough.phase, rough.control), rough)
            wider = replace(one, start=min(one.start, rough.start), end=max(one.end, rough.end))
            controls[rough.phase, rough.control] = wider
        return replace(self, controls=tuple(controls.values()), size=1 + abs(objective))


UNDAMPED = Damping()


def chatter(trajectories: Sequence[Trajectory], transcription: Transcription) -> list[Rough]:
    """The controls of a solution that turn at nearly every point somewhere, each as often as there are such places.

    trajectories: one for each phase.
    transcription: of the same mesh.
    """
    found = []
    for layout, trajectory in zip(transcription.phases, trajectories, strict=True):
        for number, control in enumerate(layout.phase.controls):
            known = layout.u[number] >= 0
            u, tau = trajectory.u[number, known], layout.mesh.fractions[known]
            arcs = _turning(u, tau, layout.mesh.degrees_at_points[known]) if len(u) > TURNS else []
            found += [Rough(layout.phase.name, control.name, *ends, _range(control, u)) for ends in arcs]
    return found


def left_alone(trajectories: Sequence[Trajectory], transcription: Transcription) -> list[str]:
    """What is told of controls that chatter on a mesh that is not refined, a sentence for each such place.

    trajectories: one for each phase.
    transcription: of the same mesh.
    """
    discrete = {own.phase.name for own in trajectories if own.phase.exact}  # each step is what it is there
    rough = (own for own in chatter(trajectories, transcription) if own.phase not in discrete)
    return [f"{own.told(trajectories)}, and chatters; refine: {{}} in the file damps its oscillations" for own in rough]


def _turning(u: np.ndarray, tau: np.ndarray, degrees: np.ndarray) -> list[tuple[float, float]]:
    """The times before the first and after the last turn of each run of turns.

    u, tau: (K,) at least two. degrees: (K,) points of the segment of each.
    """
    least = max(TURN * float(np.ptp(u)), FLAT * (1 + float(np.abs(u).max())))
    everywhere, near = np.full(len(u), len(u)), np.full(len(u), NEAR)
    runs = _runs(_sharp_turns(u, max(WIDE * float(np.ptp(u)), least)), everywhere, TURNS)
    runs = runs or _runs(_sharp_turns(u, least), near, TURNS) + _runs(_turns(u, least)[::2], degrees, PERIODS)
    return [(float(tau[run[0] - 1]), float(tau[run[-1] + 1])) for run in runs]


def _runs(turns: np.ndarray, near: np.ndarray, least: int) -> list[np.ndarray]:
    """The runs of at least so many turns (M,), with at most near (K,) points from each to the next."""
    runs = np.split(turns, np.flatnonzero(np.diff(turns) > near[turns[:-1]]) + 1)
    return [run for run in runs if len(run) >= least]


def _sharp_turns(u: np.ndarray, least: float) -> np.ndarray:
    """The numbers of the points of u (K,) that are above both neighbours, or below, by more than `least`."""
    steps = np.diff(u)
    large = np.abs(steps) > least
    return np.flatnonzero((steps[1:] * steps[:-1] < 0) & large[1:] & large[:-1]) + 1


def _turns(u: np.ndarray, least: float) -> np.ndarray:
    """The numbers of the points at which u (K,) turns: a highest and a lowest one in turn, more than `least` apart."""
    highest = lowest = direction = 0
    turns: list[int] = []
    values = u.tolist()
    for k, value in enumerate(values):
        highest = k if value > values[highest] else highest
        lowest = k if value < values[lowest] else lowest
        if direction >= 0 and values[highest] - value > least:
            turns += [highest] * direction
            direction, lowest = -1, k
        elif direction <= 0 and value - values[lowest] > least:
            turns += [lowest] * -direction
            direction, highest = 1, k
    return np.array(turns, int)


def _range(control: Variable, u: np.ndarray) -> float:
    """The distance of a control's bounds, or else of its values."""
    distance = control.bounds.upper - control.bounds.lower
    return float(distance if np.isfinite(distance) and distance > 0 else np.ptp(u))
