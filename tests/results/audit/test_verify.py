"""The independent audit of a result: passes what is right, and sees what is wrong."""

import re
import warnings

import h5py
import numpy as np
import pytest
from command_line import strict_json, trajopt
from exact import growth, growth_state
from named import crossed
from stored import save_not_finite

from trajopt.problems.build import build_all
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load
from trajopt.problems.quantities import Range
from trajopt.results.audit.optimality import _natural_residual
from trajopt.results.audit.pontryagin import NAME as PONTRYAGIN
from trajopt.results.audit.starts import NAME as STARTS
from trajopt.results.audit.trajectory import simulate
from trajopt.results.file.reload import reload
from trajopt.results.file.write import write
from trajopt.results.verify import verify
from trajopt.transcription.settings import Step, settings_of, steps
from trajopt.transcription.solve import solve


def stored(folder, name, *overrides):
    """The result file of a shipped problem."""
    spec = load(shipped()[name], overrides)
    solution = solve(build_all(spec), steps(spec.mesh), settings_of(spec))
    write(folder / "result.h5", solution, spec.text, spec.model_dump_json(), "test")
    return folder / "result.h5", solution


def by_name(checks):
    return {check.name: check for check in checks}


@pytest.mark.parametrize("name", ["block_move_min_force", "brachistochrone", "bryson_denham", "shot_put"])
def test_exact_solutions_pass_a_tight_tolerance(tmp_path, name):
    path, _ = stored(tmp_path, name)
    failed = [check for check in verify(path, 1e-3) if not check.passed]
    assert not failed


def test_the_swing_up_passes_at_the_default_and_not_below_its_error(tmp_path):
    path, _ = stored(tmp_path, "cartpole")
    assert all(check.passed for check in verify(path, anew=False))
    failed = {check.name for check in verify(path, 1e-4, anew=False) if not check.passed}
    assert "simulated v2, relative to its range" in failed
    assert "Hamiltonian along the trajectory, relative" in failed


def test_optimality_residuals_shrink_with_the_mesh(tmp_path):
    residuals = []
    for segments in (25, 100):
        path, _ = stored(tmp_path, "cartpole", f"mesh.0.segments={segments}")
        checks = by_name(verify(path, anew=False))
        residuals.append([checks[name].value for name in checks if "Hamiltonian" in name or "stationarity" in name])
    coarse, fine = np.array(residuals)
    assert (fine < coarse / 4).all()


def test_reloading_gives_the_same_trajectories(tmp_path):
    path, solution = stored(tmp_path, "cartpole", "mesh.*.method=hermite-simpson-compressed", "parameters.u_max=15")
    again = reload(path)
    for new, old in zip(again.trajectories, solution.trajectories, strict=True):
        assert new.x == pytest.approx(old.x, abs=1e-15)
        assert new.u == pytest.approx(old.u, abs=1e-15)
        assert new.costate == pytest.approx(old.costate, abs=1e-9)
    assert again.problem.phases[0].controls[0].bounds.upper == 15


@pytest.mark.parametrize(("name", "sense"), [("block_move_min_force", 1), ("shot_put", -1)])
def test_a_reloaded_outcome_has_the_minimised_objective(tmp_path, name, sense):
    path, solution = stored(tmp_path, name)
    again = reload(path)
    assert again.objective == solution.objective == sense * again.outcome.objective
    assert again.outcome.objective == pytest.approx(solution.outcome.objective, rel=1e-12)


def test_a_control_that_does_something_else_fails(tmp_path):
    path, _ = stored(tmp_path, "block_move_min_force")
    with h5py.File(path, "r+") as file:
        z = file["solver/z"]
        z[2::3] = z[2::3] * 1.2  # x, v, u at each point
    checks = by_name(verify(path))
    assert not checks["simulated x, relative to its range"].passed
    assert not checks["stationarity dH/du, relative"].passed


def test_an_unfinished_solve_fails(tmp_path):
    path, _ = stored(tmp_path, "block_move_min_force", "solver.max_iter=1")
    assert not by_name(verify(path))["solver status"].passed


def test_a_feasible_control_that_is_not_optimal_fails(tmp_path):
    """u + c (6 t^2 - 6 t + 1) moves the block to the same place: the scheme is exact for v, and Hermite's formula
    gives x in the middle of the segments."""
    path, solution = stored(tmp_path, "block_move_min_force")
    t, c = solution.trajectories[0].times, 2.0
    x, v = c * (t**4 / 2 - t**3 + t**2 / 2), c * (2 * t**3 - 3 * t**2 + t)
    x[1::2] = (x[:-2:2] + x[2::2]) / 2 + np.diff(t[::2]) / 8 * (v[:-2:2] - v[2::2])
    with h5py.File(path, "r+") as file:
        z = file["solver/z"]
        z[:] += np.column_stack([x, v, c * (6 * t**2 - 6 * t + 1)]).ravel()
    result = reload(path)
    assert np.abs(result.nlp.constraints(result.outcome.z) - result.nlp.cl).max() < 1e-12
    assert result.nlp.objective(result.outcome.z) > solution.objective + 0.1
    checks = by_name(verify(path, 1e-6, anew=False))
    assert checks["simulated x, relative to its range"].passed
    assert checks["simulated v, relative to its range"].passed
    assert not by_name(verify(path, anew=False))["stationarity dH/du, relative"].passed


def test_a_result_without_finite_values_fails_every_check_without_a_warning(tmp_path):
    path = save_not_finite(tmp_path / "a.h5")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        checks = verify(path)
    assert len(checks) == 10
    assert not [check for check in checks if check.passed]
    told = strict_json(trajopt("verify", path, "--json").stdout)
    assert [check["value"] for check in told["checks"]] == [1.0, *[None] * 9]
    table = trajopt("verify", path)
    assert table.exit_code == 1 and "nan" not in table.stdout


def test_a_path_constraint_crossed_between_the_points_is_seen(tmp_path):
    path, _ = stored(tmp_path, "bryson_denham", "mesh.0.segments=4", "mesh.*.method=trapezoid")
    checks = by_name(verify(path, 1e-3))
    crossed = checks["path constraint 'displacement limit' between the points"]
    assert not crossed.passed
    assert crossed.where.startswith("t = ")


def test_a_wrong_reference_fails(tmp_path):
    path, _ = stored(tmp_path, "block_move_min_force", "reference.objective=12.1")
    assert not by_name(verify(path, anew=False))["objective, difference from the reference"].passed


def test_simulation_against_an_exact_solution():
    solution = solve(growth(), [Step("hermite-simpson", 40, 1e-12)])
    (trajectory,) = solution.trajectories
    assert simulate(trajectory)[0] == pytest.approx(growth_state(trajectory.knots), abs=1e-6)


def test_implicit_dynamics_are_simulated_by_solving_the_residuals(tmp_path):
    text = """
trajopt: 1
name: implicit
time: {initial: 0, final: 1}
states:
  x: {rate: v, initial: 0, final: 1}
  v: {initial: 0, final: 0}
controls: {u: {}}
residuals: ["2*v[rate] + v[rate]**3 - u"]
objective: {minimize: {integral: u**2}}
mesh: [{method: hermite-simpson, segments: 20}]
"""
    (tmp_path / "implicit.yaml").write_text(text)
    spec = load(tmp_path / "implicit.yaml")
    solution = solve(build_all(spec), steps(spec.mesh))
    write(tmp_path / "result.h5", solution, spec.text, spec.model_dump_json(), "test")
    assert solution.solved
    assert solution.max_eta > 0
    assert not [check for check in verify(tmp_path / "result.h5", 1e-2, anew=False) if not check.passed]


EXACT = {
    "integral constraint": ("""
states: {x: {rate: u, initial: 0}}
controls: {u: {}}
objective: {maximize: {integral: x}}
constraints: {integral: [{expression: u**2, equals: 1}]}
""", 1 / np.sqrt(3)),
    "path constraint that depends on time": ("""
states: {x: {rate: u1, initial: 0}}
controls: {u1: {}, u2: {}}
objective: {minimize: {integral: u1**2 + u2**2}}
constraints: {path: [{expression: u1 + 2*u2 - t, equals: 0}]}
""", 1 / 15),
}  # fmt: skip


@pytest.mark.parametrize(("method", "name"), crossed(["hermite-simpson", "gauss", "radau-left"], [*EXACT]))
def test_exact_optima_with_constraints_pass(tmp_path, name, method):
    body, objective = EXACT[name]
    head = f"trajopt: 1\nname: {name}\ntime: {{initial: 0, final: 1}}\nmesh: [{{method: {method}, segments: 10}}]\n"
    (tmp_path / "exact.yaml").write_text(head + body)
    spec = load(tmp_path / "exact.yaml")
    solution = solve(build_all(spec), steps(spec.mesh))
    write(tmp_path / "result.h5", solution, spec.text, spec.model_dump_json(), "test")
    assert solution.objective == pytest.approx(objective, abs=1e-8)
    assert not [check for check in verify(tmp_path / "result.h5", 1e-4) if not check.passed]


def test_a_reference_of_another_mesh_is_not_compared(tmp_path):
    path, _ = stored(tmp_path, "cartpole", "mesh.0.segments=40", "refine=")
    assert not by_name(verify(path, anew=False))["objective, difference from the reference"].passed
    spec = load(shipped()["cartpole"], ["mesh.0.segments=40", "refine="])
    solution = solve(build_all(spec), steps(spec.mesh))
    write(path, solution, spec.text, spec.model_dump_json(), "test", spec.overrides)
    assert "objective, difference from the reference" not in by_name(verify(path, anew=False))


STATIONARY = """
trajopt: 1
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: 0}}
controls: {u: {lower: -1, upper: 1}, v: {}}
objective: {minimize: {integral: SIGN*u**2 + v**2 + u*v}}
"""


@pytest.mark.parametrize(("sign", "passed"), [("", True), ("-", False)])
def test_a_maximum_is_no_minimum(tmp_path, sign, passed):
    """u = v = 0 is stationary for both signs; d2H/du2 is [[2, 1], [1, 2]], or [[-2, 1], [1, 2]]."""
    (tmp_path / "a.yaml").write_text(STATIONARY.replace("SIGN*", sign))
    spec = load(tmp_path / "a.yaml")
    solution = solve(build_all(spec), [Step("gauss", 4, 1e-8, 2)])
    write(tmp_path / "a.h5", solution, spec.text, spec.model_dump_json(), "test")
    checks = by_name(verify(tmp_path / "a.h5"))
    check = checks.pop("d2H/du2 without negative eigenvalues, relative")
    assert check.passed is passed
    assert check.value == pytest.approx(0 if passed else np.sqrt(5) / 2, rel=1e-6)
    for name in ("error bar of the objective, relative", PONTRYAGIN):
        found = checks.pop(name, None)
        assert found is None or found.passed is passed
    checks.pop(STARTS, None)
    assert all(other.passed for other in checks.values())


def test_a_control_next_to_its_bound_is_judged_by_the_smaller_of_gradient_and_room():
    gradient = np.array([0.5, 0.5, -0.5, 1e-3, 0.5])
    u = np.array([-1 + 2e-4, 1.0, 1 - 2e-4, 0.0, 0.0])
    assert _natural_residual(gradient, u, Range(-1, 1)) == pytest.approx([1e-4, 0.5, 1e-4, 1e-3, 0.5])
    assert _natural_residual(gradient, u, Range()) == pytest.approx(np.abs(gradient))
    assert _natural_residual(gradient, np.zeros(5), Range(0, 0)) == pytest.approx(0)


# A rate has no value beyond some time: the square root or the logarithm of what turns negative, a pole at one end.
@pytest.mark.parametrize("rate", ["u + sqrt(0.7 - t)", "u + log(0.4 - t)", "u + 0/(t - 0.5)"])
def test_dynamics_without_a_value_end_in_a_failed_check(tmp_path, rate):
    """Where the simulation meets NaN, SciPy would make its steps ever smaller."""
    path = tmp_path / "good.h5"
    text = GROWTH.replace("RATE", "u")
    (tmp_path / "a.yaml").write_text(text)
    assert trajopt("solve", tmp_path / "a.yaml", "-o", path, "-q").exit_code == 0
    with h5py.File(path, "r+") as file:
        full = file["spec/full"].asstr()[()]
        assert '"rate":"u"' in full
        del file["spec/full"]
        file["spec/full"] = full.replace('"rate":"u"', f'"rate":"{rate}"')
    checks = by_name(verify(path))
    check = checks["simulated x, relative to its range"]
    assert not check.passed and "no finite value" in check.where


GROWTH = """
trajopt: 1
time: {initial: 0, final: 1}
states: {x: {rate: RATE, initial: 0, final: 1}}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
mesh: [{method: trapezoid, segments: 8}]
"""


def test_options_of_the_command_line_only(folder):
    """A result holds what was solved, and is not read as a file of a user's."""
    settings = ("--set", "solver.output_file=told.txt", "--set", "solver.hsllib=nothing.so")
    assert trajopt("solve", "shot_put", *settings, "-o", "a.h5", "-q").exit_code == 0
    assert all(check.passed for check in verify(folder / "a.h5", anew=False))
    assert trajopt("plot", "a.h5", "--only", "vx").exit_code == 0


def test_a_name_that_no_file_may_have(folder):
    """Older versions took control characters."""
    assert trajopt("solve", "shot_put", "-o", "a.h5", "-q").exit_code == 0
    with h5py.File("a.h5", "r+") as file:
        full = file["spec/full"].asstr()[()].replace("shot put", "shot\x7fput")
        del file["spec/full"]
        file["spec/full"] = full
    assert trajopt("verify", "a.h5").exit_code == 0


@pytest.mark.parametrize("content", ["{", "[]", '{"trajopt": 1}'])
def test_a_stored_problem_that_is_none(folder, content):
    assert trajopt("solve", "shot_put", "-o", "a.h5", "-q").exit_code == 0
    with h5py.File("a.h5", "r+") as file:
        del file["spec/full"]
        file["spec/full"] = content
    run = trajopt("verify", "a.h5")
    told = "the problem that it holds cannot be read|/spec/full: it holds no problem that can be read"
    assert run.exit_code == 3 and re.match(f"error: a\\.h5: ({told})", run.stderr)
