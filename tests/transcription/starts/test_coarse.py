"""A large first mesh starts from the solution on a coarse one: the same answer sooner, and no failure of its own."""

import numpy as np
import pytest
from named import problem_named

from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load
from trajopt.transcription.engines.outcome import Status
from trajopt.transcription.engines.watch import Watch
from trajopt.transcription.one_mesh import COARSE, LARGE, Origin, solve_mesh
from trajopt.transcription.schemes.mesh import Mesh
from trajopt.transcription.schemes.table import find
from trajopt.transcription.settings import Settings, Step, settings_of
from trajopt.transcription.solve import solve

BIG = Step("trapezoid", 420, 1e-8)


@pytest.mark.parametrize("name", ["cartpole", "brachistochrone", "van_der_pol", "shot_put"])
def test_the_answer_is_that_of_a_start_from_the_guess(name):
    problem = problem_named(name)
    coarse, direct = solve(problem, [BIG]), solve(problem, [BIG], Settings(coarse_start=False))
    assert coarse.solved and direct.solved
    assert [record.mesh.segments for record in coarse.meshes] == [COARSE, 420]
    assert [record.mesh.segments for record in direct.meshes] == [420]
    assert coarse.objective == pytest.approx(direct.objective, rel=1e-7)
    assert coarse.meshes[-1].iterations < direct.meshes[-1].iterations


def test_it_finds_the_answer_where_the_guess_does_not():
    problem, mesh = problem_named("shot_put"), Step("radau", 250, 1e-8, 4).mesh()

    def on_the_mesh(settings):
        """Without the other starts that `solve` tries."""
        return solve_mesh(problem, [mesh], 1e-8, settings, Origin(None, None), Watch(None, None, 0))[0]

    assert not on_the_mesh(Settings(coarse_start=False)).solved
    assert on_the_mesh(Settings()).solved


def test_small_meshes_and_later_ones_and_those_with_a_guess_start_as_they_are():
    problem = problem_named("cartpole")
    small, large = Step("trapezoid", LARGE - 1, 1e-8), Step("trapezoid", LARGE, 1e-8)
    assert len(solve(problem, [small]).meshes) == 1
    assert len(solve(problem, [large]).meshes) == 2
    first = solve(problem, [small, large])
    assert len(first.meshes) == 2
    assert len(solve(problem, [large], guess=first.trajectories).meshes) == 1


def test_a_coarse_mesh_that_fails_leaves_the_guess_to_start_from():
    solution = solve(problem_named("bryson_denham"), [BIG], Settings({"max_iter": 1}))
    assert solution.status is Status.MAX_ITERATIONS
    assert [record.mesh.segments for record in solution.meshes] == [COARSE, 420]
    assert solution.trajectories[0].mesh.segments == 420


def test_a_stop_on_the_coarse_mesh_is_a_stop():
    solution = solve(problem_named("cartpole"), [BIG], stop=lambda: True)
    assert solution.status is Status.INTERRUPTED
    assert [record.mesh.segments for record in solution.meshes] == [COARSE]


def test_the_file_can_turn_it_off():
    spec = load(shipped()["cartpole"], ["mesh.-1.segments=300", "solver.coarse_start=false"])
    assert len(solve(build(spec), [Step("hermite-simpson", 300, 1e-8)], settings_of(spec)).meshes) == 1
    assert "coarse_start" not in spec.solver.options


def test_knots_of_the_coarse_mesh_are_knots_of_the_fine_one():
    widths = np.geomspace(1, 1000, 457)
    fine = Mesh.of(find("hermite-simpson"), widths)
    coarse = fine.coarsened(100)
    assert coarse.segments == 50
    assert all(np.abs(fine.edges - edge).min() < 1e-12 for edge in coarse.edges)
    assert Mesh.of(find("radau", 40), 3).coarsened(100).segments == 2
    assert Mesh.of(find("radau", 40), 1).coarsened(10).segments == 1
    assert Mesh((find("radau", 3), find("radau", 4)), np.ones(2)).coarsened(4) is None
