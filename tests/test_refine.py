"""Refinement: meets its tolerance where it can, says where it cannot, and puts the points where they are needed."""

import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from command_line import trajopt
from exact import GROWTH_OBJECTIVE, growth, growth_state

from trajopt.cli.errors import TOLERANCE_MISSED
from trajopt.problems.build import build_all
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load
from trajopt.problems.quantities import TOLERATED_EXCESS
from trajopt.results.file.reload import reload
from trajopt.transcription.again.next_mesh import LOOSE, LOOSENESS
from trajopt.transcription.engines.outcome import Status
from trajopt.transcription.refinement.refine import MARGIN, MERGE_MARGIN, refine
from trajopt.transcription.schemes.mesh import Mesh
from trajopt.transcription.schemes.table import find
from trajopt.transcription.settings import Refine, Settings, Step, settings_of, steps
from trajopt.transcription.solve import solve

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
                   "refine.tolerance=1e-7", "refine.max_meshes=15")  # fmt: skip
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


def test_residuals_that_leave_the_rates_open_end_refinement(folder):
    """A pendulum in Cartesian coordinates is a differential-algebraic problem of index 3."""
    (folder / "dae.yaml").write_text(PENDULUM)
    run = trajopt("solve", "dae.yaml")
    assert run.exit_code == TOLERANCE_MISSED
    assert "the residuals do not determine the rates (index above 1)" in run.stdout
    assert reload(Path("dae.h5")).objective == pytest.approx(-0.0038768, abs=1e-6)


def test_no_mesh_is_solved_twice_and_a_good_one_stays():
    solution = solve(growth(), [Step("radau", 10, 1e-11, 8)], Settings(refine=Refine(1e-6)))
    assert len(solution.meshes) == 1
    (trajectory,), (error,) = solution.trajectories, solution.errors
    assert refine(trajectory, error, 1e-6).mesh is trajectory.mesh


def test_segments_are_split_in_proportion_to_their_error():
    solution = solve(growth(), [Step("trapezoid", [3, 1, 1], 1e-11)])
    (trajectory,), (error,) = solution.trajectories, solution.errors
    errors, error = error.relative, replace(error, worth=np.zeros(3))
    refinement = refine(trajectory, error, tolerance=float(errors[1:].max()) / MARGIN * 1.01)
    assert refinement.mesh.segments > 3
    assert refinement.mesh.widths[-2:] == pytest.approx(trajectory.mesh.widths[1:])  # the good ones are left alone
    assert refinement.mesh.widths[:-2].sum() == pytest.approx(trajectory.mesh.widths[0])


def test_neighbours_are_divided_together_where_the_method_has_one_degree():
    """Ten equal segments that each need a little more than one part become a few more segments, not twenty."""
    solution = solve(growth(), [Step("hermite-simpson", 10, 1e-11)])
    (trajectory,), (error,) = solution.trajectories, solution.errors
    tolerance = float(error.relative.min())
    refinement = refine(trajectory, error, tolerance)
    assert 10 < refinement.mesh.segments < 20
    again = solve(growth(), [Step("hermite-simpson", refinement.mesh.widths.tolist(), 1e-11)])
    errors = again.errors[0].relative
    assert errors.max() < tolerance
    assert errors.max() < 2 * errors.min()  # the density of segments follows the error


def test_what_a_switch_needs_is_not_moved_by_its_neighbours():
    """Where the degree is free, a segment that is split keeps its ends as knots."""
    solution = solve(build_all(load(shipped()["hyper_sensitive"]))[0], [Step("radau", 30, 1e-9, 4)])
    (trajectory,), (error,) = solution.trajectories, solution.errors
    refined = refine(trajectory, error, 1e-6, merge=False).mesh
    assert refined.segments > 30
    assert np.isin(trajectory.mesh.edges.round(12), refined.edges.round(12)).all()


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


def test_neighbours_are_merged_only_far_below_the_tolerance():
    solution = solve(growth(), [Step("hermite-simpson", [20, *[1] * 10], 1e-11)])
    (trajectory,), (error,) = solution.trajectories, solution.errors
    errors = error.relative
    tolerance = float(errors[0]) / 2
    assert errors[1:].max() < MERGE_MARGIN * tolerance
    merged = refine(trajectory, error, tolerance)
    kept = refine(trajectory, error, tolerance, merge=False)
    assert merged.mesh.segments == kept.mesh.segments - 5
    assert merged.mesh.widths.sum() == pytest.approx(1)


def test_smooth_segments_get_points_and_rough_ones_are_split():
    smooth = solve(growth(), [Step("radau", 2, 1e-11, 4)])
    (trajectory,), (error,) = smooth.trajectories, smooth.errors
    raised = refine(trajectory, error, 1e-9).mesh
    assert raised.segments == 2
    assert min(scheme.degree for scheme in raised.schemes) > 4
    rough = run("hyper_sensitive", "refine.max_meshes=1")
    assert rough.meshes[1].mesh.widths.min() < rough.meshes[0].mesh.widths.min()


def test_meshes_are_pure_data():
    mesh = Mesh.of(find("radau", 3), 4)
    assert mesh.segments == 4
    with pytest.raises(AttributeError):
        mesh.widths = None


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
