"""Controls that are angles: a value and that a turn later mean the same, and a solution may take either at any point.

Between two points that took different turns the control sweeps over all directions, which no equation sees. So a
control with a period, as far as everything that holds over time can tell, is made continuous: over the points at which
it has an effect its values are taken as near to those of the point before as whole turns allow, and where it has none,
as the direction of a thrust that is off, it goes straight from one to the next.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ...problems.problem import Curves, Guess
from ...problems.quantities import Variable
from ..solution.trajectory import Trajectory

TURNS = (2 * np.pi, 360.0)
SAME = 1e-9  # relative: what is equal a turn later
EFFECT = 1e-3  # of the largest change by the angle along the trajectory: with less it has no effect
DIRECTIONS = 8  # of a turn, in which the effect is looked for


def short_turns(trajectories: Sequence[Trajectory]) -> tuple[list[Curves], list[str]]:
    """Trajectories to start from whose angles go the short way, and the names of those that did not.

    trajectories: one for each phase.
    """
    curves: list[Curves] = []
    names: list[str] = []
    for own in trajectories:
        found = dict(_unwound(own))
        names += found
        curves.append(_turned(own, found) if found else own)
    return curves, names


def _unwound(trajectory: Trajectory) -> Iterator[tuple[str, np.ndarray]]:
    """Name of each angle that jumps by half a turn and more -> its values at the collocation points, without jumps."""
    phase, k = trajectory.phase, trajectory.mesh.collocated
    if phase.exact:
        return
    for control, u in zip(phase.controls, trajectory.u[:, k], strict=False):
        turn = next((own for own in TURNS if np.ptp(u) > own / 2 and _periodic(trajectory, control, own)), 0.0)
        if not turn or not np.isfinite(u).all():
            continue
        acts = np.flatnonzero(_effect(trajectory, control, turn))
        if len(acts) < 2 or not (np.abs(np.diff(u[acts])) > turn / 2).any():
            continue
        v = _near(control, np.unwrap(u[acts], period=turn), turn)
        if control.bounds.lower <= v.min() and v.max() <= control.bounds.upper:
            yield control.name, np.interp(k, k[acts], v)


def _near(control: Variable, v: np.ndarray, turn: float) -> np.ndarray:
    """The same angles, by whole turns nearest to the middle of the bounds of the control, or to zero."""
    middle = (control.bounds.lower + control.bounds.upper) / 2
    middle = middle if np.isfinite(middle) else 0.0
    return v - turn * np.round((v.mean() - middle) / turn)


def _at(trajectory: Trajectory, control: Variable, shift: float) -> list[np.ndarray]:
    """What may depend on a control, (M,) each at the collocation points, with the control larger by `shift`."""
    phase, k = trajectory.phase, trajectory.mesh.collocated
    u = trajectory.u[:, k].copy()
    u[[own.name for own in phase.inputs].index(control.name)] += shift
    values = phase.arguments(trajectory.times[k], trajectory.x[:, k], u, trajectory.parameters)
    return [np.broadcast_to(function(values, np), len(k)) for function in phase.over_time]


def _periodic(trajectory: Trajectory, control: Variable, turn: float) -> bool:
    """Whether nothing tells a value of a control from that a turn later, and something does from half a turn later."""
    here, half, later = (np.array(_at(trajectory, control, shift)) for shift in (0.0, turn / 2, turn))
    size = SAME * (1 + np.maximum(np.abs(here), np.abs(half)).max(axis=1, initial=0.0, keepdims=True))
    return bool((np.abs(here - later) <= size).all() and (np.abs(here - half) > size).any())


def _effect(trajectory: Trajectory, control: Variable, turn: float) -> np.ndarray:
    """Whether an angle has an effect at each collocation point, shape (M,)."""
    shifts = turn * np.arange(DIRECTIONS) / DIRECTIONS
    spans = np.ptp(np.array([_at(trajectory, control, shift) for shift in shifts]), axis=0)
    most = spans.max(axis=1, keepdims=True)
    return (spans > EFFECT * np.where(most > 0, most, np.inf)).any(axis=0)


def _turned(trajectory: Trajectory, angles: Mapping[str, np.ndarray]) -> Guess:
    """A trajectory with other values of some controls, at the collocation points."""
    s, k = trajectory.mesh.fractions, trajectory.mesh.collocated
    return trajectory.with_controls({name: np.interp(s, s[k], u) for name, u in angles.items()})
