"""Second-order finite differences: only positions and controls are variables (introduction to direct collocation, 6).

With K equally spaced points, dt = (tF - t0) / (K - 1) and a(t, x, dx/dt, u) the accelerations,

    x_{k-1} - 2 x_k + x_{k+1} == dt^2 a_k,        0 < k < K - 1                       (41), (42)
    x_0 - 2 x_1 + x_2 == dt^2 a_0,    and likewise at the other end                    as in the introduction's listing
    dx/dt_k = (x_{k+1} - x_{k-1}) / (2 dt);    at the ends (-3 x_0 + 4 x_1 - x_2) / (2 dt) and its mirror image
    integral of w = dt sum_k w_k over all points                                      as in the introduction's listing
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...problems.problem import Curves
from ...problems.quantities import State
from ..constraint_kinds import BOUND, BOUND_FINAL, BOUND_INITIAL, DEFECT, ConstraintKind
from ..libraries.pyomo import RangeSet, pyomo
from ..program.templates import item
from .builder import PhaseBuilder
from .place import Place, Values


class DifferenceBuilder(PhaseBuilder):
    """Fills the block of one phase whose states are positions and their velocities, on equal segments."""

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        velocities = {state.velocity_of: state for state in self.phase.states if state.velocity_of}
        self.pairs = [(s, velocities[s.name]) for s in self.phase.states if s.name in velocities]

    @property
    def dt(self) -> Any:
        return self.duration * (1.0 / self.last)

    def stored(self) -> tuple[list[str], np.ndarray]:
        return [position.name for position, _ in self.pairs], np.arange(self.last + 1)

    def variables(self, guess: Curves) -> None:
        super().variables(guess)
        self.block.inner = RangeSet(1, self.last - 1)

    def places(self) -> list[Place]:
        v = [velocity for _, velocity in self.pairs]

        def place(
            name: str, over: Any, values: Callable[[Any], dict], points: list[int], asked: ConstraintKind
        ) -> Place:
            quadrature = np.full(len(points), 1.0 / self.last)
            return Place(name, over, values, lambda k: self.dt, np.array(points, int), quadrature, v, asked)

        return [
            place("", self.block.inner, self._inner_values, list(range(1, self.last)), BOUND),
            place("_initial", None, lambda k: self.end_values(False), [0], BOUND_INITIAL),
            place("_final", None, lambda k: self.end_values(True), [self.last], BOUND_FINAL),
        ]

    def _positions(self, k: Any) -> Values:
        return self.at(k, [position.name for position, _ in self.pairs])

    def _inner_values(self, k: Any) -> Values:
        x, values = self.block.x, self._positions(k)
        for position, velocity in self.pairs:
            values[velocity.name] = (item(x, position.name, k + 1) - item(x, position.name, k - 1)) / (2 * self.dt)
        return values

    def end_values(self, last: bool) -> Values:
        end, step = (self.last, -1) if last else (0, 1)
        values = self._positions(end)
        for position, velocity in self.pairs:
            a, b, c = (self.block.x[position.name, end + i * step] for i in range(3))
            values[velocity.name] = step * (-3 * a + 4 * b - c) / (2 * self.dt)
        return values

    def dynamics(self) -> None:
        for position, velocity in self.pairs:

            def inner(block: Any, k: Any, position: State = position, velocity: State = velocity) -> Any:
                return self._defect(position, velocity, k, self._inner_values(k))

            def first(block: Any, *, position: State = position, velocity: State = velocity) -> Any:
                return self._defect(position, velocity, 1, self.end_values(False))

            def final(block: Any, *, position: State = position, velocity: State = velocity) -> Any:
                return self._defect(position, velocity, self.last - 1, self.end_values(True))

            name, times = velocity.name, self.mesh.fractions[1:-1]
            self.add(f"defect_{name}", self.block.inner, inner, DEFECT, name, (times, times))
            self.add(f"defect_{name}_initial", None, first, DEFECT, name, (0.0, 0.0))
            self.add(f"defect_{name}_final", None, final, DEFECT, name, (1.0, 1.0))

    def _defect(self, position: State, velocity: State, k: Any, values: dict) -> Any:
        x = self.block.x
        before, here, after = (item(x, position.name, k + i) for i in (-1, 0, 1))
        second = before - 2 * here + after
        return second == self.dt**2 * velocity.rate(values, pyomo)  # (42)
