"""States at earlier times in a simulation: by the method of steps, from what it has simulated itself."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable

import numpy as np

from ...problems.quantities import Delayed
from ...transcription.solution.trajectory import Trajectory

LATE = 1e-12
"""Of the duration: a step that is longer than a delay by less than this asks for what is known."""


class Past:
    """The states at earlier times, for a simulation of a trajectory's control.

    trajectory: of one phase. remembers: whether they are those that were simulated before; else the trajectory's.
    """

    def __init__(self, trajectory: Trajectory, remembers: bool) -> None:
        self.trajectory, self.delayed = trajectory, trajectory.phase.delayed
        self.remembers = remembers and bool(self.delayed)
        self.starts: list[float] = []
        self.pieces: list[Callable[[float], np.ndarray]] = []
        self.rows = [[s.name for s in trajectory.phase.states].index(own.state) for own in self.delayed]

    def steps(self, start: float, end: float) -> np.ndarray:
        """The times to stop at between two: no step is longer than the shortest delay, so that all it asks is known."""
        if not self.remembers:
            return np.array([start, end])
        lag = min(own.lag for own in self.delayed)
        return np.linspace(start, end, max(int(np.ceil((end - start) / lag - LATE)), 1) + 1)

    def remember(self, start: float, piece: Callable[[float], np.ndarray] | None) -> None:
        """Keep the states from a time on, as a function of time."""
        if piece is not None:
            self.starts.append(start)
            self.pieces.append(piece)

    def filled(self, t: float, u: np.ndarray) -> np.ndarray:
        """Inputs at a time, shape (n_u,), with the states at earlier times as they are."""
        if not self.delayed:
            return u
        u = u.copy()
        u[self.trajectory.phase.rows_of_delayed] = [
            self._value(*own, t) for own in zip(self.delayed, self.rows, strict=True)
        ]
        return u

    def _value(self, own: Delayed, row: int, t: float) -> float:
        if not self.remembers:
            return float(self.trajectory.earlier(own, np.array([t]))[0])
        earlier = t - own.lag
        if earlier < self.trajectory.t[0]:
            return float(self.trajectory.past(own, np.array([earlier]))[0])
        if not self.pieces:  # the first step ends where the history does
            return float(self.trajectory.x[row, 0])
        return float(self.pieces[max(bisect_right(self.starts, earlier) - 1, 0)](earlier)[row])
