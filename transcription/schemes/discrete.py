"""Discrete time: every segment of the mesh is one step.

With f the change in a step, x[k + 1] - x[k] as the problem gives it, and h = 1 the duration of a step,

    x[k + 1] - x[k]  =  h f(t_k, x[k], u[k]),          sum of h w(t_k, x[k], u[k])        (paper, 9.3)

which is the problem itself, and approximates nothing. It is also the explicit rule of Euler, whose defects, costates
and multipliers serve here; but between the steps there is nothing: states and controls are held.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from .scheme import Scheme
from .segment import Interpolant


class DiscreteStep(Scheme):
    """One step of discrete time, as a scheme."""

    coarsens: ClassVar[bool] = False

    @property
    def state_interpolant(self) -> str:
        return "0"

    def interpolant(self, tau: np.ndarray) -> Interpolant:
        """The values at the start of the step, held; at its end those after it."""
        after = (np.asarray(tau) >= 1.0).astype(float)[:, None]
        one = np.ones_like(after)
        return Interpolant(np.hstack([one, 0 * one]), after, np.zeros((len(after), 2)), one, one)

    def costate_basis(self, tau: np.ndarray) -> np.ndarray:
        """The costate at the start of the step, held; at its end that after it."""
        after = (np.asarray(tau) >= 1.0).astype(float)[:, None]
        return np.hstack([1 - after, after])


def _step(name: str, family: str) -> DiscreteStep:
    return DiscreteStep(
        name=name,
        family=family,
        order=1,
        source="Kelly 2017, section 9.3",
        sigma=np.array([0.0, 1.0]),
        c=np.array([0.0]),
        L=np.array([[-1.0, 1.0]]),
        R=np.array([[1.0]]),
    )


DISCRETE, STATIC = _step("discrete", "discrete time"), _step("static", "no time")
"""What every step of discrete time is, and the one segment of a phase without time, in which nothing varies.

A file has them by next:, or by having no time, not by the name of a method.
"""

EXACT = {own.name: own for own in (DISCRETE, STATIC)}
