"""Where on a segment a control switches: jumps, or has a kink because a constraint becomes active or inactive.

A collocation method smears a switch over the segment that holds it, but the controls of the neighbours are those of
the arcs on both sides. Continued into the segment, from both sides, they tell what is there:

    a jump    the ends differ, much more steeply than the neighbours change. As the states at both ends of the segment
              are right to first order, so is the mean of the control, which gives the time:
                  mean u = tau u_left + (1 - tau) u_right
    a kink    both continuations, parabolas, meet inside the segment, and one up to there and the other from there on
              fit the segment's own control far better than its height
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.quantities import Variable
from ..solution.trajectory import Trajectory

SAMPLES = 41  # on each segment; a multiple of 4, plus 1
NEAR = slice(SAMPLES // 2, None, SAMPLES // 4)  # the samples of the segment before that are continued: 1/2, 3/4, 1
FAR = slice(0, SAMPLES // 2 + 1, SAMPLES // 4)  # and of the segment after: 0, 1/4, 1/2
JUMP = 0.25  # of a control's range within one segment
FLAT = 0.01  # of the distance of a control's bounds: one that varies less shows what the barrier leaves, no range
STEEP = 4.0  # times the slope of the neighbours' controls, or of the median of the segment's own
KINK_MISFIT = 0.25  # of the height of the kink above its chord


@dataclass(frozen=True)
class Switch:
    """name: of the control. tau: where on the segment, in (0, 1). height: of a jump or kink, over the range of u."""

    name: str
    tau: float
    height: float


@dataclass(frozen=True)
class Switches:
    """Looks for switches on the segments of a trajectory."""

    trajectory: Trajectory

    @cached_property
    def u(self) -> np.ndarray:
        """The controls on a grid of every segment, shape (n_u, N, SAMPLES)."""
        return self.trajectory.inputs(np.linspace(0, 1, SAMPLES))[: len(self.trajectory.phase.controls)]

    @cached_property
    def t(self) -> np.ndarray:
        """The times of that grid, shape (N, SAMPLES)."""
        return self.trajectory.knots[:-1, None] + self.trajectory.h[:, None] * np.linspace(0, 1, SAMPLES)

    @cached_property
    def jumps(self) -> dict[int, Switch]:
        """Jumps by the number of their segment."""
        found: dict[int, Switch] = {}
        for control, u in zip(self.trajectory.phase.controls, self.u, strict=True):
            left, right = np.append(u[0, 0], u[:-1, -1]), np.append(u[1:, 0], u[-1, -1])
            height, span = np.abs(right - left), max(float(np.ptp(u)), FLAT * _size(control, u))
            for s in np.flatnonzero((height > JUMP * span) & self._is_steep(u, height)):
                mean = np.trapezoid(u[s]) / (SAMPLES - 1)
                tau = np.clip((mean - right[s]) / (left[s] - right[s]), 0.0, 1.0)
                found.setdefault(int(s), Switch(control.name, float(tau), float(height[s] / span)))
        return found

    def jump(self, s: int) -> Switch | None:
        """A jump on segment s."""
        return self.jumps.get(s)

    @np.errstate(all="ignore")
    def worth(self, s: int) -> float:
        """What it is worth, in the objective, that a control is where it is on segment s, within its jump there.

        The largest |H(u before) - H(u after)| on the segment, times its duration: nothing, where the problem does not
        determine the control. Infinite without costates.
        """
        tr, u = self.trajectory, self.u
        sample = tr.grid(np.array([s]), np.array([0.0, 0.5, 1.0]))
        if sample.costate is None:
            return float("inf")
        t, x, costate = (a.reshape(*a.shape[:-2], -1) for a in (sample.t, sample.x, sample.costate))
        values = []
        for side in (u[:, max(s - 1, 0), -1], u[:, min(s + 1, len(tr.h) - 1), 0]):
            own = sample.u.reshape(len(sample.u), -1).copy()
            own[: len(u)] = side[:, None]
            H = (costate * tr.phase.dynamics(t, x, own, tr.parameters)).sum(axis=0)
            if tr.phase.lagrange:
                H = H + tr.phase.lagrange(tr.phase.arguments(t, x, own, tr.parameters), np)
            values.append(H)
        return float(np.abs(values[0] - values[1]).max() * tr.h[s])

    def _is_steep(self, u: np.ndarray, height: np.ndarray) -> np.ndarray:
        """Whether a change by this height (N,) over each segment is steeper than what is around it, shape (N,)."""
        steps = np.abs(np.diff(u))
        steep = steps.max(axis=1) > STEEP * np.median(steps, axis=1)
        h = self.trajectory.h
        before, after = np.zeros((2, len(h)))
        before[1:], after[:-1] = np.ptp(u[:-1, NEAR], axis=1) / h[:-1], np.ptp(u[1:, FAR], axis=1) / h[1:]
        return steep | (height / h > STEEP * 2 * np.maximum(before, after)) & (len(h) > 1)

    def kink(self, s: int) -> Switch | None:
        """A kink on segment s, which needs a segment on each side."""
        if not 0 < s < self.trajectory.mesh.segments - 1:
            return None
        start, h = self.trajectory.knots[s], self.trajectory.h[s]
        found: list[Switch] = []
        for control, u in zip(self.trajectory.phase.controls, self.u, strict=True):
            sides = ((s - 1, NEAR), (s + 1, FAR))
            left, right = (np.polyfit((self.t[n, part] - start) / h, u[n, part], 2) for n, part in sides)
            own, tau = u[s], np.linspace(0, 1, SAMPLES)
            for root in np.roots(left - right):
                if abs(root.imag) > 0 or not 0 < root.real < 1:
                    continue
                crossing = float(root.real)
                fit = np.where(tau < crossing, np.polyval(left, tau), np.polyval(right, tau))
                turn = abs(np.polyval(np.polyder(left - right), crossing))
                height = turn * crossing * (1 - crossing)
                misfit = np.sqrt(np.mean((own - fit) ** 2))
                if misfit < KINK_MISFIT * height:
                    found.append(Switch(control.name, crossing, float(height / (np.ptp(u) or 1.0))))
        return max(found, key=lambda switch: switch.height, default=None)


def _size(control: Variable, u: np.ndarray) -> float:
    """How large a control can be: the distance of its bounds, or else 1 + its largest value."""
    distance = control.bounds.upper - control.bounds.lower
    return distance if np.isfinite(distance) else 1.0 + float(np.abs(u).max())
