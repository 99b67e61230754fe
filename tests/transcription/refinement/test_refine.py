"""Refinement: meets its tolerance where it can, says where it cannot, and puts the points where they are needed."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from exact import GROWTH_OBJECTIVE, growth, growth_state

from trajopt.problems.build import build_all
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load
from trajopt.problems.quantities import TOLERATED_EXCESS
from trajopt.transcription.again.next_mesh import LOOSE, LOOSENESS
from trajopt.transcription.refinement.refine import MERGE_MARGIN, refine
from trajopt.transcription.settings import Refine, Settings, Step, settings_of, steps
from trajopt.transcription.solve import solve


@cache
def run(name: str, *overrides: str):
    spec = load(shipped()[name], overrides)
    return solve(build_all(spec), steps(spec.mesh), settings_of(spec))


@pytest.mark.parametrize(
    ("method", "degree"), [("trapezoid", None), ("hermite-simpson", None), ("gauss", 4), ("radau", 3)]
)
def test_a_smooth_problem_meets_its_tolerance(method, degree):
    tolerance = 1e-5 if method == "trapezoid" else 1e-8
    solution = solve(growth(), [Step(method, 4, 1e-11, degree)], Settings(refine=Refine(tolerance)))
    assert solution.solved
    assert not solution.unmet
    assert solution.meshes[-1].relative_error <= tolerance
    (trajectory,) = solution.trajectories
    dense = trajectory.dense
    # eta tells how well the dynamics are met; how near the control is to the best one adds to that.
    assert np.abs(dense.x[0] - growth_state(dense.t)).max() < 200 * tolerance
    assert solution.objective == pytest.approx(GROWTH_OBJECTIVE, abs=200 * tolerance)


@pytest.mark.parametrize("method", ["hermite-simpson", "radau", "gauss"])
def test_the_swing_up_to_1e_8_on_far_fewer_points_than_an_equal_mesh(method):
    """At most half the collocation points of the coarsest uniform mesh of 2^n segments that is as accurate."""
    adaptive = run("cartpole", "mesh.-1.segments=10", f"mesh.*.method={method}", "refine.tolerance=1e-8")
    assert adaptive.solved
    assert not adaptive.unmet
    assert adaptive.objective == pytest.approx(58.8076675, rel=1e-8)
    uniform = run("cartpole", "mesh.-1.segments=512", "mesh.*.method=hermite-simpson")
    assert uniform.meshes[-1].relative_error > 1e-8
    assert len(adaptive.trajectories[0].times) <= (2 * 1024 + 1) / 2


def test_points_gather_where_the_swing_up_is_fast():
    solution = run("cartpole", "mesh.-1.segments=10", "refine.tolerance=1e-6")
    (trajectory,) = solution.trajectories
    middle = np.abs(trajectory.knots[:-1] - 0.9) < 0.25
    assert trajectory.h[middle].mean() < trajectory.h[~middle].mean() / 2


def test_switching_times_of_the_minimum_work_block():
    """u_max = 20: t* = (1 - sqrt(1 - 4/20))/2 and 1 - t*, found within 1e-4; J = (u_max t*)^2."""
    solution = run("block_move_min_work", "mesh.*.method=radau", "mesh.-1.segments=20", "mesh.-1.degree=3",
                   "refine.tolerance=1e-6", "refine.max_meshes=15")  # fmt: skip
    exact = (1 - np.sqrt(1 - 4 / 20)) / 2
    assert solution.objective == pytest.approx((20 * exact) ** 2, abs=1e-4)
    (trajectory,) = solution.trajectories
    names = [control.name for control in trajectory.phase.controls]
    dense = trajectory.dense
    u = dense.u[names.index("u")]
    falls = dense.t[1:][(u[:-1] > 10) & (u[1:] <= 10)]
    assert np.abs(falls - exact).min() < 1e-4
    stops = dense.t[1:][(u[:-1] > -10) & (u[1:] <= -10)]
    assert np.abs(stops - (1 - exact)).min() < 1e-4


def test_minimum_time_swing_up():
    solution = run("cartpole_min_time")
    assert solution.solved
    assert solution.objective == pytest.approx(1.10667, abs=1e-4)


def test_hyper_sensitive_problem_from_the_default_guess():
    solution = run("hyper_sensitive")
    assert solution.solved
    assert not solution.unmet
    assert solution.objective == pytest.approx(1.3308, abs=5e-5)
    (trajectory,) = solution.trajectories
    assert trajectory.h.min() < 1
    assert trajectory.h.max() > 2000


def test_what_cannot_be_met_is_told():
    solution = run(
        "cartpole", "mesh.-1.segments=5", "mesh.*.method=trapezoid", "refine.tolerance=1e-9", "refine.max_meshes=2"
    )
    assert len(solution.meshes) == 3
    assert solution.unmet
    assert solution.unmet[0].startswith("segment ")
    assert "error" in solution.unmet[0]


def test_no_mesh_is_solved_twice_and_a_good_one_stays():
    solution = solve(growth(), [Step("radau", 10, 1e-11, 8)], Settings(refine=Refine(1e-6)))
    assert len(solution.meshes) == 1
    (trajectory,), (error,) = solution.trajectories, solution.errors
    assert refine(trajectory, error, 1e-6).mesh is trajectory.mesh


def test_meshes_on_the_way_are_solved_loosely_and_the_last_one_is_not():
    solution = solve(growth(), [Step("hermite-simpson", 2, 1e-10)], Settings(refine=Refine(1e-9)))
    first, *between, last = solution.meshes
    assert first.tolerance == last.tolerance == 1e-10
    for before, record in pairwise([first, *between]):
        assert record.tolerance == min(LOOSE, LOOSENESS * before.relative_error)
    assert solution.outcome.iterations["dual_infeasibility"][-1] < 1e-10


def test_a_mesh_that_turns_out_to_be_the_last_is_solved_again():
    """30 segments should just miss 3e-5, and meet it."""
    schedule = "mesh=[{method: finite-difference, segments: 15, tolerance: 1e-9}]"
    solution = run("pendulum", schedule, "refine.tolerance=3e-5")
    assert not solution.unmet
    *_, before, last = solution.meshes
    assert before.mesh.segments == last.mesh.segments
    assert before.tolerance > last.tolerance == 1e-9


def test_the_quadrature_of_integrals_counts(tmp_path):
    """States that any mesh meets exactly, and an integral that a coarse one does not: J = 12, not 13.9."""
    (tmp_path / "area.yaml").write_text("""
trajopt: 1
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: 0, final: 0}}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
constraints: {integral: [{expression: x, equals: 1}]}
mesh: [{method: trapezoid, segments: 5}]
refine: {tolerance: 1.0e-7}
""")
    spec = load(tmp_path / "area.yaml")
    solution = solve(build_all(spec), steps(spec.mesh), settings_of(spec))
    assert solution.meshes[0].relative_error > 1e-3
    assert not solution.unmet
    assert solution.objective == pytest.approx(12, abs=1e-3)


def test_needless_points_are_taken_away():
    solution = solve(growth(), [Step("radau", [1, 1, 40], 1e-11, [16, 16, 3])])
    (trajectory,), (error,) = solution.trajectories, solution.errors
    errors = error.relative
    tolerance = float(errors[2]) / 2
    assert errors[:2].max() < MERGE_MARGIN * tolerance
    reduced = refine(trajectory, error, tolerance).mesh
    assert max(scheme.degree for scheme in reduced.schemes[:2]) < 16
    kept = refine(trajectory, error, tolerance, merge=False).mesh
    assert [scheme.degree for scheme in kept.schemes[:2]] == [16, 16]


def test_what_passes_through_an_obstacle_between_the_points_is_refined(tmp_path):
    """Straight lines around a disc: the dynamics are met exactly on any mesh, the disc is not."""
    (tmp_path / "disc.yaml").write_text("""
trajopt: 1
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: -1, final: 1}, y: {rate: v, initial: 0, final: 0}}
controls: {u: {}, v: {}}
objective: {minimize: {integral: u**2 + v**2}}
constraints: {path: [{name: disc, expression: sqrt(x**2 + y**2), lower: 0.5}]}
guess: {keyframes: {y: [0, 1, 0]}}
mesh: [{method: implicit-euler, segments: 6}]
refine: {tolerance: 0.1}
""")
    spec = load(tmp_path / "disc.yaml")
    solution = solve(build_all(spec), steps(spec.mesh), settings_of(spec))
    assert solution.solved and not solution.unmet
    (error,), (trajectory,) = solution.errors, solution.trajectories
    excess = error.excess["path constraint 'disc'"]
    assert (excess * trajectory.mesh.widths <= TOLERATED_EXCESS).all()
    coarse = solve(build_all(spec), steps(spec.mesh), Settings())
    ((profile,), (first,)) = coarse.errors, coarse.trajectories
    assert (profile.excess["path constraint 'disc'"] * first.mesh.widths).max() > 10 * TOLERATED_EXCESS
    assert refine(first, profile, 0.1).unmet[0].count("path constraint 'disc' exceeded by")
    dense = trajectory.dense
    inside = 0.5 - np.hypot(*dense.x)
    assert inside.max() / 1.5 == pytest.approx(excess.max(), rel=1e-12)


def test_finite_differences_stay_on_equal_segments():
    solution = run("pendulum", "mesh.-1.segments=50", "refine.tolerance=1e-6", "refine.max_meshes=4")
    meshes = [record.mesh for record in solution.meshes]
    assert solution.solved and len(meshes) > 1
    assert all(fine.segments == 2 * coarse.segments for coarse, fine in pairwise(meshes))
    assert np.ptp(meshes[-1].widths) < 1e-12
