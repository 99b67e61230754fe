"""Unknowns that are small beside the distance by which IPOPT moves a start inside its bounds."""

import numpy as np
import pytest

import trajopt

OFFSET = """
trajopt: 1
name: decay to an offset
time: {initial: 0, final: FINAL}
states: {x: {rate: -k*x + j, initial: 1}}
optimize: {k: {lower: 0GUESS_K}, j: {lower: 0GUESS_J}}
measurements: {m: {data: {time: [0, T1, T2, FINAL], x: [1.02, 0.66, 0.45, 0.40]}}}
"""


def offset(unit: float, k: str = "", j: str = "") -> str:
    text = OFFSET.replace("FINAL", repr(3 * unit)).replace("T1", repr(unit)).replace("T2", repr(2 * unit))
    return text.replace("GUESS_K", k).replace("GUESS_J", j)


@pytest.mark.parametrize("unit", [1.0, 1e3, 1e6])
@pytest.mark.parametrize("guessed", [True, False])
def test_rate_constants_in_any_unit(unit, guessed):
    """In every unit but the first there is another optimum, a constant, to which a start of 0.01 leads."""
    guesses = (f", guess: {1 / unit!r}", f", guess: {0.1 / unit!r}") if guessed else ()
    solution = trajopt.solve(trajopt.load(offset(unit, *guesses)))
    assert solution.solved and solution.objective == pytest.approx(1.25827e-3, rel=1e-4)
    found = np.array([solution.estimates[name].value for name in ("k", "j")])
    assert found * unit == pytest.approx([0.716339, 0.220406], rel=1e-4)


MOVE = """
trajopt: 1
name: move
time: {initial: 0, final: 1}
states:
  x: {rate: v, initial: 0, final: SIZE, lower: 0}
  v: {rate: u, initial: 0, final: 0, upper: V}
controls: {u: {}}
objective: {minimize: {integral: (u/SIZE)**2}}
"""


@pytest.mark.parametrize("size", [1.0, 1e-6])
def test_states_in_any_unit(size):
    """v rises to its bound by 1.2 (1 - (1 - t/ramp)^2), of area 1.2 (1 - 2 ramp/3), stays there, and falls likewise."""
    solution = trajopt.solve(trajopt.load(MOVE.replace("SIZE", repr(size)).replace("V}", f"{1.2 * size!r}}}")))
    ramp = 3 * (1 - 1 / 1.2) / 2
    exact = 2 * (2 * 1.2 / ramp**2) ** 2 * ramp**3 / 3
    assert solution.solved and abs(solution.objective - exact) <= solution.error.objective <= 0.05


def test_what_the_file_says_of_scaling_comes_first():
    text = offset(1e6, ", guess: 1e-6", ", guess: 1e-7") + "solver: {nlp_scaling_method: gradient-based}\n"
    assert trajopt.solve(trajopt.load(text)).objective == pytest.approx(0.0384667, rel=1e-4)
