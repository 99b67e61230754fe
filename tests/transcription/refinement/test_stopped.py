"""What ends refinement before its goal: a failed mesh, an interruption, the time limit; and what is kept then."""

import time
from pathlib import Path

import pytest
from command_line import trajopt
from exact import growth

from trajopt.cli.errors import TOLERANCE_MISSED
from trajopt.results.file.reload import reload
from trajopt.transcription.engines.outcome import Status
from trajopt.transcription.settings import Refine, Settings, Step
from trajopt.transcription.solve import solve


def test_a_refined_mesh_that_fails_leaves_the_solution_before_it(folder):
    arguments = ("block_move_min_work", "--set", "mesh=[{method: radau, segments: 20}]", "--refine", "1e-7")
    run = trajopt("solve", *arguments, "--set", "solver.max_iter=30", "-o", "kept.h5")
    assert run.exit_code == TOLERANCE_MISSED
    assert "solved, tolerance missed" in run.stdout
    assert "miss the tolerance; the worst: segment" in run.stdout
    (line,) = (line for line in run.stdout.splitlines() if line.startswith("stopped"))
    assert line.startswith("stopped     the next mesh, of ")
    assert line.endswith("failed: ran out of iterations")
    kept = reload(Path("kept.h5"))
    assert kept.solved
    assert kept.objective == pytest.approx(1.11456, abs=1e-3)


def test_an_interrupted_refinement_keeps_the_mesh_that_was_solved():
    seen = []
    settings = Settings(refine=Refine(1e-9))
    solution = solve(
        growth(), [Step("hermite-simpson", 5, 1e-10)], settings,
        progress=lambda mesh, record: seen.append(mesh), stop=lambda: 1 in seen,
    )  # fmt: skip
    assert solution.solved and len(solution.meshes) == 1
    assert solution.unmet and solution.stopped.endswith("segments, was interrupted")
    assert solution.inaccurate


def test_an_interrupted_schedule_keeps_the_mesh_that_was_solved():
    seen = []
    steps = [Step("trapezoid", 5, 1e-10), Step("hermite-simpson", 50, 1e-10)]
    solution = solve(growth(), steps, progress=lambda mesh, record: seen.append(mesh), stop=lambda: 1 in seen)
    assert solution.solved and len(solution.meshes) == 1 and not solution.unmet
    assert solution.stopped == "the next mesh, of 50 segments, was interrupted"


def test_an_interrupted_first_mesh_has_no_solution():
    assert solve(growth(), [Step("trapezoid", 5, 1e-10)], stop=lambda: True).status is Status.INTERRUPTED


@pytest.mark.parametrize("engine", ["ipopt", "newton"])
def test_a_time_limit_is_told_from_an_interruption(engine):
    settings = Settings(engine=engine, seconds=1e-9)
    assert solve(growth(), [Step("trapezoid", 5, 1e-10)], settings).status is Status.TIME_LIMIT


def test_a_time_limit_keeps_the_mesh_that_was_solved():
    def late(mesh, record):
        if mesh == 1:
            time.sleep(0.5)

    settings = Settings(refine=Refine(1e-9), seconds=0.5)
    solution = solve(growth(), [Step("hermite-simpson", 5, 1e-10)], settings, progress=late)
    assert solution.solved and len(solution.meshes) == 1
    assert "time limit" in solution.stopped and solution.inaccurate


@pytest.mark.parametrize("limit", ["0", "-3", ".nan", "soon"])
def test_a_time_limit_is_a_positive_number(limit):
    run = trajopt("solve", "cartpole", "--time-limit", limit)
    assert run.exit_code == 2 and "--time-limit" in run.stderr


PENDULUM = """
trajopt: 1
name: pendulum
time: {initial: 0, final: 1}
states:
  x: {initial: 0, rate: vx}
  y: {initial: -1, rate: vy}
  vx: {initial: 0}
  vy: {initial: 0}
algebraic: {lam: {}}
controls: {u: {lower: -5, upper: 5}}
residuals: ["vx[rate] - u - 2*lam*x", "vy[rate] + 9.81 - 2*lam*y", "x**2 + y**2 - 1"]
objective: {minimize: {integral: "u**2 - x"}}
"""


def test_residuals_that_leave_the_rates_open_end_refinement(folder):
    """A pendulum in Cartesian coordinates is a differential-algebraic problem of index 3."""
    (folder / "dae.yaml").write_text(PENDULUM)
    run = trajopt("solve", "dae.yaml")
    assert run.exit_code == TOLERANCE_MISSED
    assert "the residuals do not determine the rates (index above 1)" in run.stdout
    assert reload(Path("dae.h5")).objective == pytest.approx(-0.0038768, abs=1e-6)
