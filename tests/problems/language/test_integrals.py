"""Integrals by their names: ratios, powers, constraints, in one phase and over several."""

from math import sqrt, tanh

import numpy as np
import pytest

import trajopt
from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.results.verify import verify

LAPS = """\
trajopt: 1
time: {initial: 0, final: {lower: 1, upper: 10}}
states: {x: {rate: v, initial: 0, final: 2}}
controls: {v: {lower: 0.1}}
integrals: {work: {value: 1 + v**2, unit: J}, spent: v**2}
objective: {minimize: {terminal: "integral.work**2/x[final]"}}
phases:
  a: {time: {final: {lower: 0.1, upper: 5}}, states: {x: {final: 1}}}
  b: {without: [spent], constraints: {boundary: [{expression: 2*integral.work, lower: 1}]}}
links: [{expression: "a.work[final] + 2*integral.spent", upper: 9}]
"""
"""At speed 1 a metre costs least, 2 J: (2 + 2)^2/2. The constraints leave room."""


@pytest.mark.parametrize("method", ["radau", "hermite-simpson", "lobatto", "dormand-prince"])
def test_a_ratio(method):
    overrides = {"mesh": [{"method": method, "segments": 20}]}
    solution = trajopt.solve(trajopt.load("cost_of_transport", overrides))
    exact = 2 * sqrt(15 * 0.5 / (5 - 2 / sqrt(0.5) * tanh(sqrt(0.5) * 2.5))) / (2 * 9.81)
    error = abs(solution.objective - exact)
    assert error <= min(1e-6, 1.01 * solution.error.objective + 1e-9)


def test_the_costate_is_the_derivative_by_the_integral(tmp_path):
    solution = trajopt.solve(trajopt.load("cost_of_transport"))
    distance = solution["x"](5.0)
    assert solution.costate["work"](np.array([0.0, 2.5, 5.0])) == pytest.approx(1 / (2 * 9.81 * distance), rel=1e-7)
    assert solution["work"](5.0) == pytest.approx(30.0, rel=1e-6)  # at the best distance half of it is P T
    solution.save(tmp_path / "ratio.h5")
    assert all(check.passed for check in verify(tmp_path / "ratio.h5"))


def test_phases_have_a_share_each():
    solution = trajopt.solve(trajopt.load(LAPS))
    assert solution.objective == pytest.approx(8, rel=1e-6)
    a, b = solution.phases.values()
    assert a["work"](a.time[-1]) == pytest.approx(2, rel=1e-4) and b["work"](b.time[0]) == 0 and "spent" not in b


def test_what_the_names_stand_for():
    problem = build(load_text(LAPS, "laps.yaml"))
    ends = {"a.work[final]": 3.0, "b.work[final]": 4.0, "b.x[final]": 2.0, "a.spent[final]": 5.0}
    assert problem.mayer(ends, np) == pytest.approx((3 + 4) ** 2 / 2)
    assert problem.links[-1].function(ends, np) == pytest.approx(3 + 2 * 5)
    own = next(c for c in problem.phases[1].boundary if "work" in c.name)
    assert own.function({"work[final]": 4.0}, np) == pytest.approx(8)
    assert not any("work from" in link.name for link in problem.links)


def test_the_guess_is_the_integral_of_the_guess():
    """A divisor is not zero at the start."""
    text = "trajopt: 1\ntime: {initial: 0, final: 2}\nstates: {x: {rate: u, initial: 0, final: 1}}\ncontrols: {u: {}}\n"
    text += "integrals: {total: x**2 + 1}\nobjective: {minimize: {integral: u**2, terminal: 1/integral.total}}\n"
    guess = build(load_text(text, "x.yaml")).phases[0].guess
    assert guess.values["total"][[0, -1]] == pytest.approx([0, 2 / 3 + 2], rel=1e-3)
    solution = trajopt.solve(trajopt.load(text))
    assert solution.solved


def test_an_integral_beside_a_model():
    spec = trajopt.load("biped", {"integrals": {"effort": "u1**2 + u2**2"}, "mesh.*.segments": 5})
    solution = trajopt.solve(spec)
    assert solution.solved and solution["effort"](solution.time[-1]) > 0
