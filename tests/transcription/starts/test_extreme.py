"""Unknowns that are small beside the distance by which IPOPT moves a start, and states of 1e6 and more."""

import numpy as np
import pytest

import trajopt
from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.results.verify import verify
from trajopt.transcription.settings import schedule_of, settings_of
from trajopt.transcription.solve import solve
from trajopt.transcription.starts.extreme import _is_quadrature

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


TRAIN = """
trajopt: 1
parameters: {M: 200, A: 2.0, B: 0.03, scale: 1}
states:
  s: {rate: v, initial: 0, final: 2000}
  v: {rate: "(scale*F - A - B*v**2)/M", initial: 0, final: 0, lower: 0, upper: 30}
controls: {F: {lower: -200/scale, upper: 200/scale}}
integrals: {effort: F**2}
time: {initial: 0, final: {lower: 80, upper: 200, guess: 120}}
phases: {go: {time: {final: 40}}, cruise: {time: {final: 70}, states: {v: {lower: 15}}}, brake: {}}
objective: {minimize: {terminal: "scale**2*integral.effort/(s[final]*100) + t[final]/10"}}
mesh: [{method: radau, segments: 4}]
"""


@pytest.mark.parametrize(
    "override", ["parameters.scale=1", "parameters.scale=0.1", "parameters.A=3", "time.final.guess=90"]
)
def test_an_integral_of_any_size_is_no_trouble(override):
    """Its value follows from the rest; with F = 0 at the start it is known to be large by the bounds of F alone."""
    ratio = run(TRAIN, override)
    plain = TRAIN.replace("scale**2*integral.effort/(s[final]*100) + ", "")
    plain = plain.replace("{terminal", '{integral: "scale**2*F**2/200000", terminal')
    assert ratio.objective == pytest.approx(run(plain, override).objective, rel=1e-7)
    of_size_one = run(TRAIN, override, "scaling={effort: 1}")
    assert ratio.meshes[0].iterations < of_size_one.meshes[0].iterations  # 24 to 32 for 37 to 765


def run(text: str, *overrides: str):
    spec = load_text(text, "train.yaml", overrides)
    solution = solve(build(spec), schedule_of(spec), settings_of(spec))
    assert solution.solved
    return solution


@pytest.mark.parametrize(
    ("integral", "found"), [("F**2", ["s", "effort"]), ("F**2 + s", ["effort"]), ("F**2 + v*effort", ["s"])]
)
@pytest.mark.parametrize("residual", ["residuals=[z - F]", "residuals=[z - F, {expression: w - F}]"])
def test_residuals_do_not_hide_a_quadrature(integral, found, residual):
    own = [f"integrals.effort={integral}", "algebraic={z: {}}" if "w" not in residual else "algebraic={z: {}, w: {}}"]
    phase = build(load_text(TRAIN, "train.yaml", [*own, residual])).phases[0]
    assert [own.name for own in phase.states if _is_quadrature(phase, own)] == found
    seen = build(load_text(TRAIN, "train.yaml", [*own, residual.replace("z - F", "z - F - effort")])).phases[0]
    assert "effort" not in [own.name for own in seen.states if _is_quadrature(seen, own)]


@pytest.mark.parametrize(
    ("integral", "found"), [("F**2", ["s", "effort"]), ("F**2 + s", ["effort"]), ("F**2 + v*effort", ["s"])]
)
def test_only_what_nothing_over_time_depends_on_is_a_quadrature(integral, found):
    phase = build(load_text(TRAIN, "train.yaml", [f"integrals.effort={integral}"])).phases[0]
    assert [own.name for own in phase.states if _is_quadrature(phase, own)] == found
