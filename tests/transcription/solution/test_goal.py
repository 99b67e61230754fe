"""Refinement for the objective: the bar asked for is reached and the true error is below it, or it is said why not."""

import json

import pytest
from command_line import trajopt
from exact import GROWTH_OBJECTIVE, growth
from named import crossed

from trajopt.transcription.settings import Refine, Settings, Step
from trajopt.transcription.solve import solve

T_CYCLOID = 1.801603122456
OPTIMA = {
    "bryson_denham": 4.0,
    "brachistochrone": T_CYCLOID,
    "hyper_sensitive": 1.3308069049,
    "block_move_min_force": 12.0,
}

ACCELERATED = """
trajopt: 1
name: move
time: {initial: 0, final: 1}
states: {x: {accel: u, velocity: {name: v, initial: 0, final: 0}, initial: 0, final: 1}}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
mesh: [{method: finite-difference, segments: 20}]
refine: {objective: 0.1, max_meshes: 3}
"""


@pytest.mark.parametrize(("name", "accuracy"), crossed([*OPTIMA], [1e-5, 1e-7]))
def test_the_bar_asked_for_is_reached_and_holds(name, accuracy, folder):
    optimum = OPTIMA[name]
    run = trajopt("solve", name, "--accuracy", accuracy, "--json")
    summary = json.loads(run.stdout)
    assert run.exit_code == 0 and not summary["inaccurate"]
    assert summary["objective_error"] <= accuracy * (1 + abs(optimum))
    assert abs(summary["objective"] - optimum) <= summary["objective_error"] + 1e-10


@pytest.mark.parametrize("method", ["trapezoid", "hermite-simpson", "radau", "runge-kutta-4"])
def test_every_family_of_methods(method):
    solution = solve(growth(), [Step(method, 5, 1e-8)], Settings(refine=Refine(objective=1e-7)))
    assert solution.solved and not solution.inaccurate
    assert solution.objective_error.bar <= 1e-7 * (1 + GROWTH_OBJECTIVE)
    assert abs(solution.objective - GROWTH_OBJECTIVE) <= solution.objective_error.bar


def test_what_cannot_be_had_is_told():
    """The barrier leaves more than that, whatever the mesh."""
    solution = solve(growth(), [Step("radau", 5, 1e-8)], Settings(refine=Refine(objective=1e-14, max_meshes=4)))
    assert solution.solved and solution.inaccurate


def test_without_a_bar_the_error_of_the_segments_serves(folder):
    (folder / "move.yaml").write_text(ACCELERATED)
    summary = json.loads(trajopt("solve", "move.yaml", "--json").stdout)
    assert summary["solved"] and summary["objective"] == pytest.approx(12, rel=0.15)  # of first order
    assert "there is no error bar: finite differences have no costates" in summary["inaccurate"]


def test_in_the_file(folder):
    text = """
trajopt: 1
name: move
time: {initial: 0, final: 1}
states: {x: {rate: v, initial: 0, final: 1}, v: {rate: u, initial: 0, final: 0}}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
mesh: [{method: trapezoid, segments: 5}]
refine: {objective: 1.0e-3}
"""
    (folder / "move.yaml").write_text(text)
    summary = json.loads(trajopt("solve", "move.yaml", "--json").stdout)
    assert summary["objective"] == pytest.approx(12, abs=13e-3)
    assert summary["objective_error"] <= 13e-3


@pytest.mark.parametrize("value", ["0", "2", ".nan", "small"])
def test_an_accuracy_is_a_small_number(value, folder):
    run = trajopt("solve", "cartpole", "--accuracy", value)
    assert run.exit_code == 2 and "--accuracy" in run.stderr
