"""Path constraints hold at both ends, whether or not the method collocates there."""

import json

import pytest
from command_line import trajopt
from named import crossed

from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.problems.probe import depends_on
from trajopt.transcription.schemes.table import METHODS
from trajopt.transcription.settings import Step
from trajopt.transcription.solve import solve

FLOOR = """
trajopt: 1
name: floor
time: {initial: 0, final: 1}
states: {x: {rate: u, START}}
controls: {u: {}}
constraints: {path: [{name: floor, expression: EXPRESSION, lower: 1}]}
objective: {minimize: {terminal: "x[END]", integral: 0.001*u**2}}
"""
COLLOCATION = sorted(METHODS.keys() - {"finite-difference", "explicit-euler", "implicit-euler"})


def floor(expression: str, end: str) -> str:
    other = "final: 2" if end == "initial" else "initial: 2"
    return FLOOR.replace("START", other).replace("EXPRESSION", expression).replace("END", end)


FLOORS = ["x + 0*u", "2*x - 1", "x + t*(1 - t) - t + t**2"]
CASES = [(method, end, floor) for end in ("initial", "final") for method, floor in crossed(COLLOCATION, FLOORS)]


@pytest.mark.parametrize(("method", "end", "expression"), CASES)
def test_a_path_constraint_holds_at_a_free_end(method, expression, end):
    """From x = 2 at the other end down to the floor, x = 1: J = 1 + 0.001 exactly, and u = -1 or 1 everywhere."""
    problem = build(load_text(floor(expression, end), "floor.yaml"))
    solution = solve(problem, [Step(method, 10, 1e-9)])
    assert solution.solved
    assert solution.objective == pytest.approx(1.001, abs=1e-6)
    (trajectory,) = solution.trajectories
    assert trajectory.dense.x.min() > 1 - 1e-6
    assert abs(solution.objective_error.bar) < 1e-5


def test_what_a_function_depends_on():
    assert not depends_on(lambda v, f: v["x"] + 0 * v["u"], {"u"})
    assert depends_on(lambda v, f: v["x"] + 1e-3 * v["u"], {"u"})
    assert depends_on(lambda v, f: f.sqrt(v["u"] - 9), {"u"})  # it has no value to tell by
    assert not depends_on(lambda v, f: v["x"], {"u"})


OBSTACLE = """
trajopt: 1
name: obstacle
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: 0, final: 2}, y: {rate: w, initial: 0, final: 0}}
controls: {u: {}, w: {}}
constraints: {path: [{expression: (x - XC)**2 + y**2, lower: 0.04}]}
objective: {minimize: {integral: u**2 + w**2}}
"""


@pytest.mark.parametrize(("center", "end"), [("0.1", "initial"), ("2.1", "final")])
def test_an_end_inside_an_obstacle_is_refused(center, end, folder):
    (folder / "obstacle.yaml").write_text(OBSTACLE.replace("XC", center))
    run = trajopt("check", "obstacle.yaml")
    assert run.exit_code == 2
    assert "obstacle.yaml:7: constraints.path.0.expression: this cannot hold at the " + end in run.stderr
    assert "it is 0.01 there, and at least 0.04 is asked" in run.stderr
    assert f"x[{end}], y[{end}]" in run.stderr


def test_time_and_abs_count_at_the_ends(folder):
    text = OBSTACLE.replace("(x - XC)**2 + y**2", "abs(x) + t").replace("name: ob", "nonsmooth: slack\nname: ob")
    (folder / "late.yaml").write_text(text)
    run = trajopt("check", "late.yaml")
    assert run.exit_code == 2 and "it is 0 there" in run.stderr


def test_an_end_outside_the_obstacle_passes(folder):
    (folder / "obstacle.yaml").write_text(OBSTACLE.replace("XC", "1") + "guess: {keyframes: {y: [0, 0.5, 0]}}\n")
    run = trajopt("solve", "obstacle.yaml", "--json")
    assert json.loads(run.stdout)["solved"]


def test_a_path_constraint_without_a_value_at_a_given_end_is_no_crash():
    """x/x at x = 0 is no number: nothing is said of it before the solve."""
    assert load_text(floor("x/x", "final").replace("initial: 2", "initial: 0"), "floor.yaml")
