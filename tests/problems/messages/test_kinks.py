"""A norm that vanishes has a kink there; a failed solve names it, and what it advises is solved."""

import pytest

import trajopt

FUEL = """\
trajopt: 1
time: {initial: 0, final: 10}
states:
  x: {rate: vx, initial: 0, final: 3}
  y: {rate: vy, initial: 0, final: 4}
  vx: {rate: ax, initial: 0, final: 0}
  vy: {rate: ay, initial: 0, final: 0}
controls: {ax: {}, ay: {}}
expressions: {size: {value: "hypot(ax, 1*ay)"}}
constraints: {path: [{expression: ax**2 + ay**2, upper: 0.25}]}
objective: {minimize: {integral: "NORM"}}
"""
"""The thrust is off from 1.127 to 8.873; J = 10/2 - sqrt(15) = 1.127 with an exact norm."""


@pytest.mark.parametrize(
    ("norm", "told"),
    [
        ("sqrt(ax**2 + ay**2)", "write sqrt(ax**2 + ay**2 + 1e-6)"),
        ("norm(ax, ay)", "write sqrt(ax**2 + ay**2 + 1e-6)"),
        ("size", "write sqrt(ax**2 + (1*ay)**2 + 1e-6)"),
    ],
)
def test_the_norm_is_named(norm, told):
    solution = trajopt.solve(trajopt.load(FUEL.replace("NORM", norm), ["solver.max_iter=200"]))
    assert not solution.solved
    assert "is all but zero between t = " in solution.causes[0] and told in solution.causes[0]


def test_the_advice_is_solved():
    solution = trajopt.solve(trajopt.load(FUEL.replace("NORM", "sqrt(ax**2 + ay**2 + 1e-6)")))
    assert solution.solved and solution.objective == pytest.approx(5 - 15**0.5, abs=1e-2)


def test_a_root_of_what_is_no_square_is_no_norm():
    text = FUEL.replace("NORM", "ax**2 + ay**2 + sqrt(t)").replace("upper: 0.25", "upper: 1e-3")
    solution = trajopt.solve(trajopt.load(text, ["solver.max_iter=20"]))
    assert not solution.solved and "kink" not in " ".join(solution.causes)
