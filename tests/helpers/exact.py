"""Problems whose solution is known in closed form, built without a problem file."""

import numpy as np

from trajopt.problems.problem import Guess, Phase, Problem
from trajopt.problems.quantities import Range, State, Variable

RIVER = """\
trajopt: 1
name: crossing
time: {initial: 0, final: 2}
states:
  x: {rate: v*u1, initial: 0}
  y: {rate: v*u2, initial: 0, final: 0.1}
  v: {rate: 0.5 - u2, initial: 0}
controls: {u1: {}, u2: {}}
constraints: {path: [{name: unit, expression: u1**2 + u2**2, equals: 1}]}
objective: {maximize: {terminal: "x[final]"}}
mesh: [{method: radau, segments: 20}]
"""
"""Crossing a river as far down as can be: x(2) = 1.712315; the zero guess leads to the lesser optimum 0.2523."""


def fixed(value: float) -> Range:
    return Range(value, value)


def growth(sense: int = 1) -> Problem:
    """Minimise the integral of (ln x)^2 + u^2 over [0, 1] with dx/dt = u x, x(0) = e, x(1) free.

    With y = ln x it is the linear-quadratic problem dy/dt = u, y(0) = 1: y = cosh(1 - t) / cosh(1), J = tanh(1), and
    the costate of x is 2 sinh(1 - t) / cosh(1) / x. Nonlinear, smooth, no polynomial.
    """
    guess = Guess(0.0, 1.0, np.array([0.0, 1.0]), {"x": np.full(2, np.e), "u": np.zeros(2)})
    state = State("x", rate=lambda v, m: v["u"] * v["x"], initial=fixed(np.e))
    phase = Phase(
        "main", fixed(0), fixed(1), (state,), (Variable("u"),), guess,
        lagrange=lambda v, m: sense * (m.log(v["x"]) ** 2 + v["u"] ** 2),
    )  # fmt: skip
    return Problem("growth", sense, (phase,))


def growth_state(t):
    return np.exp(np.cosh(1 - t) / np.cosh(1))


def growth_control(t):
    return -np.sinh(1 - t) / np.cosh(1)


def growth_costate(t):
    return 2 * np.sinh(1 - t) / np.cosh(1) / growth_state(t)


GROWTH_OBJECTIVE = np.tanh(1)


def integration() -> Problem:
    """No control, nothing to optimise: dx/dt = x cos(3 t), x(0) = 1 on [0, 2], J = integral of x cos(3 t).

    x = exp(sin(3 t) / 3), so J = x(2) - 1.
    """
    guess = Guess(0.0, 2.0, np.array([0.0, 1.0]), {"x": np.ones(2)})

    def rate(v, m):
        return v["x"] * m.cos(3 * v["t"])

    phase = Phase("main", fixed(0), fixed(2), (State("x", rate=rate, initial=fixed(1)),), (), guess, lagrange=rate)
    return Problem("integration", 1, (phase,))


def integration_state(t):
    return np.exp(np.sin(3 * t) / 3)
