"""Unknowns that are small beside the distance by which IPOPT moves a start, and states of 1e6 and more."""

import numpy as np
import pytest

import trajopt
from trajopt.results.verify import verify

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


RESERVOIR = """
trajopt: 1
name: a reservoir in litres
time: {initial: 0, final: 365}
states: {w: {rate: "2e7*(1 + 0.8*sin(2*pi*t/365)) - q - 1e-3*w", initial: 4e9, lower: 2e9, upper: 6e9}}
controls: {q: {lower: 0, upper: 5e7}}
objective: {minimize: {integral: "(q/2e7 - 1)**2 + 1e-3*(w/4e9 - 1)**2"}}
"""
CELLS = """
trajopt: 1
name: cells under a drug
time: {initial: 0, final: 30}
states:
  n: {rate: "0.2*n*(1 - n/1e9) - 0.4*c*n", initial: 5e8}
  m: {rate: "0.1*n - 0.3*m", initial: 2e8}
controls: {c: {lower: 0, upper: 1}}
objective: {minimize: {integral: "1e-9*(n + m) + 0.3*c**2"}}
"""
"""Both ended unsolved: no digit of double precision is left for a defect of 1e-8."""


@pytest.mark.parametrize(("text", "J"), [(RESERVOIR, 0.0144938979), (CELLS, 8.29300508)])
def test_large_numbers_are_solved_as_small_ones(text, J, tmp_path):
    solution = trajopt.solve(trajopt.load(text))
    assert solution.solved and solution.objective == pytest.approx(J, rel=1e-7)
    solution.save(tmp_path / "large.h5")
    assert all(check.passed for check in verify(tmp_path / "large.h5"))


def test_what_only_rounding_keeps_from_the_tolerance_is_solved():
    """The same cells without any scaling."""
    solution = trajopt.solve(trajopt.load(CELLS, ["scaling={n: 1, m: 1, c: 1}"]))
    assert solution.solved and solution.objective == pytest.approx(8.29300508, rel=1e-7)


ORBIT = """
trajopt: 1
name: a circular orbit raised by low thrust
parameters: {mu: 3.986004418e14*L**3/S**2, L: LENGTH, S: SECOND, T: 0.02*L/S**2, c: 3e4*L/S,
  near: 6.778e6*L, far: 8e6*L}
time: {initial: 0, final: {lower: 1e3*S, upper: 2e5*S, guess: 3e4*S}}
states:
  r: {rate: w, initial: near, final: far}
  w: {rate: v**2/r - mu/r**2 + T*sin(a)/m, initial: 0, final: 0}
  v: {rate: -w*v/r + T*cos(a)/m, initial: sqrt(mu/near), final: sqrt(mu/far)}
  m: {rate: -T/c, initial: 1, lower: 0.01}
controls: {a: {lower: -pi, upper: pi}}
objective: {minimize: {terminal: "t[final]"}}
"""


@pytest.mark.parametrize(("length", "second"), [(1, 1), (1e-3, 1), (1 / 6.778e6, 1 / 883.0)])
def test_an_orbit_is_found_in_any_unit(length, second):
    """In metres and seconds it ran out of 3000 iterations, as neither a free time nor what starts at 0 was scaled."""
    found = trajopt.solve(trajopt.load(ORBIT.replace("LENGTH", repr(length)).replace("SECOND", repr(second))))
    assert found.solved and sum(mesh.iterations for mesh in found.meshes) < 60
    assert found.objective / second == pytest.approx(30324.2542, rel=1e-7)
