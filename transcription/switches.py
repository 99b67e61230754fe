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

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .trajectory import Trajectory

SAMPLES = 41  # on each segment; a multiple of 4, plus 1
NEAR = slice(SAMPLES // 2, None, SAMPLES // 4)  # the samples of the segment before that are continued: 1/2, 3/4, 1
FAR = slice(0, SAMPLES // 2 + 1, SAMPLES // 4)  # and of the segment after: 0, 1/4, 1/2
JUMP = 0.25  # of a control's range within one segment
STEEP = 4.0  # times the slope of the neighbours' controls, or of the median of the segment's own
KINK_MISFIT = 0.25  # of the height of the kink above its chord


@dataclass(frozen=True)
class Switch:
    """name: of the control. tau: where on the segment, in (0, 1)."""

    name: str
    tau: float


@dataclass(frozen=True)
class Switches:
    """Looks for switches on the segments of a trajectory."""

    trajectory: Trajectory

    @cached_property
    def u(self) -> np.ndarray:
        """The controls on a grid of every segment, shape (n_u, N, SAMPLES)."""
        mesh = self.trajectory.mesh
        sample = self.trajectory.grid(np.arange(mesh.segments), np.linspace(0, 1, SAMPLES))
        return sample.u[: len(self.trajectory.phase.controls)]

    @cached_property
    def t(self) -> np.ndarray:
        """The times of that grid, shape (N, SAMPLES)."""
        return self.trajectory.knots[:-1, None] + self.trajectory.h[:, None] * np.linspace(0, 1, SAMPLES)

    def jump(self, s: int) -> Switch | None:
        """A jump on segment s."""
        for control, u in zip(self.trajectory.phase.controls, self.u, strict=True):
            last = len(u) - 1
            left, right = u[max(s - 1, 0), -1 if s else 0], u[min(s + 1, last), 0 if s < last else -1]
            if abs(right - left) > JUMP * np.ptp(u) > 0 and self._is_steep(u, s, abs(right - left)):
                mean = np.trapezoid(u[s]) / (SAMPLES - 1)
                return Switch(control.name, float(np.clip((mean - right) / (left - right), 0.0, 1.0)))
        return None

    def _is_steep(self, u: np.ndarray, s: int, height: float) -> bool:
        steps = np.abs(np.diff(u[s]))
        if steps.max() > STEEP * np.median(steps):
            return True
        if not 0 < s < len(u) - 1:
            return False
        h = self.trajectory.h
        sides = np.ptp(u[s - 1, NEAR]) / h[s - 1], np.ptp(u[s + 1, FAR]) / h[s + 1]
        return height / h[s] > STEEP * 2 * max(sides)

    def kink(self, s: int) -> Switch | None:
        """A kink on segment s, which needs a segment on each side."""
        if not 0 < s < self.trajectory.mesh.segments - 1:
            return None
        start, h = self.trajectory.knots[s], self.trajectory.h[s]
        found: list[tuple[float, Switch]] = []
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
                    found.append((height / (np.ptp(u) or 1.0), Switch(control.name, crossing)))
        return max(found, key=lambda pair: pair[0])[1] if found else None
