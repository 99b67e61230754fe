"""A quantity of a solved phase as a function of time."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from ...problems.lean.records import dataclass
from ...transcription.solution.trajectory import Sample, Trajectory

ROUNDING = 1e-12
"""Of the duration and of the size of times: a time this far outside a phase is meant to be its end."""

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, repr=False, eq=False)
class TimeFunction:
    """One quantity over the time of its phase; call it with a time, or with an array of times.

    name: as in the problem file.
    kind: "state", "control", "algebraic", "output" or "costate".
    unit: as in the problem file; "" where it gives none.
    values: (K,) at the points of the mesh, whose times are `time` of the phase.
    """

    name: str
    kind: str
    unit: str
    values: Array
    _trajectory: Trajectory
    _rows: Callable[[Sample], Array]

    def __call__(self, t: npt.ArrayLike) -> float | Array:
        """The value at time t, by the interpolant of the method that solved it.

        t: a time in the unit of the phase, or times of any shape (...). At the end of a segment where a control jumps
            it is that of the segment that begins there.

        Gives a float for one time, else an array of the shape of t. Raises ValueError for a time outside the phase.
        """
        times = np.asarray(t, dtype=float)
        sample = self._trajectory.at(self._fractions(times.ravel()))
        with np.errstate(all="ignore"):  # the last iterate of a failed solve need not be finite
            values = np.broadcast_to(self._rows(sample), sample.t.shape).reshape(times.shape)
        return float(values) if values.ndim == 0 else np.array(values)

    def _fractions(self, times: Array) -> Array:
        """Times (M,) as fractions of the duration (M,), in [0, 1]."""
        first, last = self._trajectory.initial_time, self._trajectory.final_time
        rounding = ROUNDING * max(abs(first), abs(last), last - first)
        inside = (times >= first - rounding) & (times <= last + rounding)
        if not inside.all():
            unit, name = self._trajectory.phase.time_unit, self._trajectory.phase.name
            outside = times[np.argmin(inside)]
            raise ValueError(
                f"t = {outside:.10g} is outside phase {name}, which goes from {first:.10g} to {last:.10g} {unit}"
            )
        if last == first:
            return np.zeros_like(times)
        return np.clip((times - first) / (last - first), 0.0, 1.0)

    def __repr__(self) -> str:
        first, last, unit = self._trajectory.initial_time, self._trajectory.final_time, self._trajectory.phase.time_unit
        own = f" in {self.unit}" if self.unit else ""
        return f"<{self.kind} {self.name}(t){own}, t = {first:.6g} to {last:.6g} {unit}>"
