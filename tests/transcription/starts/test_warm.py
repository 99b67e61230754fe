"""Multipliers carried to the next mesh: closer to its own than none, and fewer iterations."""

import numpy as np
import pytest
from named import crossed, problem_named

from trajopt.transcription.program.compiler import compile_model
from trajopt.transcription.settings import Settings, Step
from trajopt.transcription.solve import solve
from trajopt.transcription.starts.warm import Solved, warm_start
from trajopt.transcription.transcribe import transcribe

PROBLEMS = ("cartpole", "van_der_pol", "bryson_denham", "block_move_min_force", "brachistochrone", "shot_put")
METHODS = ("hermite-simpson", "trapezoid", "hermite-simpson-compressed")


@pytest.mark.parametrize(("name", "method"), crossed(PROBLEMS, METHODS))
def test_warm_start_takes_fewer_iterations_than_cold(name, method):
    problem, coarse, fine = problem_named(name), Step(method, 20, 1e-8), Step(method, 40, 1e-8)
    warm = solve(problem, [coarse, fine])
    cold = solve(problem, [fine], guess=solve(problem, [coarse]).trajectories)  # the same curves, no multipliers
    assert warm.solved and cold.solved
    assert warm.objective == pytest.approx(cold.objective, rel=1e-7)
    assert warm.meshes[1].iterations < cold.meshes[0].iterations


def returned(name: str, segments: int):
    """Multipliers of a solution, carried to the mesh they come from, and their largest relative error."""
    problem, step = problem_named(name), Step("hermite-simpson", segments, 1e-8)
    solution = solve(problem, [step])
    transcription = transcribe(problem, [step.mesh()], solution.trajectories)
    nlp = compile_model(transcription.model, transcription.variables)
    start = warm_start(Solved(transcription, nlp, solution.outcome, solution.trajectories), transcription, nlp)
    np.testing.assert_allclose(start.z_lower, solution.outcome.z_lower, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(start.z_upper, solution.outcome.z_upper, rtol=1e-9, atol=1e-9)
    return np.abs(start.y - solution.outcome.y).max() / np.abs(solution.outcome.y).max()


@pytest.mark.parametrize("name", ["block_move_min_force", "shot_put"])
def test_multipliers_come_back_exactly_where_costates_are_polynomials(name):
    assert returned(name, 20) < 1e-7


def test_elsewhere_they_come_back_better_on_finer_meshes():
    errors = [returned("cartpole", segments) for segments in (20, 40, 80)]
    assert errors[0] > 3 * errors[1] > 9 * errors[2], errors


def test_another_method_can_follow():
    steps = [("trapezoid", 20), ("hermite-simpson-compressed", 30), ("hermite-simpson", 60)]
    solution = solve(problem_named("cartpole"), [Step(method, segments, 1e-8) for method, segments in steps])
    assert solution.solved
    assert [record.mesh.segments for record in solution.meshes] == [20, 30, 60]
    assert solution.meshes[2].iterations <= 5


def test_a_failed_mesh_ends_the_schedule():
    schedule = [Step("hermite-simpson", 10, 1e-8), Step("hermite-simpson", 20, 1e-8)]
    solution = solve(problem_named("cartpole"), schedule, Settings({"max_iter": 2}))
    assert len(solution.meshes) == 1 and not solution.solved
