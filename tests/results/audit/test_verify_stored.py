"""`verify` reads what people read: arrays that were changed, controls that are not those of the solver's point."""

import re
from pathlib import Path
from shutil import copy

import h5py
import numpy as np
import pytest
from command_line import solved_once, trajopt
from exact import RIVER

from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.results.file.write import write
from trajopt.results.verify import verify
from trajopt.transcription.settings import steps
from trajopt.transcription.solve import solve


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    return solved_once(tmp_path_factory.mktemp("solved") / "wire.h5", "brachistochrone")


@pytest.fixture
def result(solved, folder):
    """A copy, which a test may damage."""
    return Path(copy(solved, folder))


def failed(path, anew: bool = False) -> set[str]:
    """anew: whether other starts are looked at, too."""
    return {check.name for check in verify(path, anew=anew) if not check.passed}


def test_a_good_result_passes(result):
    assert not failed(result, anew=True)


@pytest.mark.parametrize("where", ["points/control/theta", "dense/control/theta", "points/state/v", "dense/state/x"])
def test_an_array_that_was_changed_fails(where, result):
    with h5py.File(result, "r+") as file:
        file[f"phase/main/{where}"][...] *= 1.01
    assert failed(result) == {"stored arrays of main, from the solver's point, relative"}


def test_times_that_were_changed_fail(result):
    with h5py.File(result, "r+") as file:
        file["phase/main/dense/time"][5] += 1e-6
    assert "stored arrays of main, from the solver's point, relative" in failed(result)


def test_a_point_that_was_changed_fails(result):
    """The controls in z, too: then the defects do not vanish."""
    with h5py.File(result, "r+") as file:
        file["solver/z"][...] *= 1.01
    assert {
        "constraints at the points, relative",
        "stored arrays of main, from the solver's point, relative",
    } <= failed(result)


@pytest.mark.parametrize("share", [0.0, 1e-300])
def test_a_point_without_duration_fails(share, result):
    """The final time and all else are zero, or next to it: a ZeroDivisionError once."""
    with h5py.File(result, "r+") as file:
        file["solver/z"][...] *= share
    assert {
        "constraints at the points, relative",
        "stored arrays of main, from the solver's point, relative",
    } <= failed(result)


@pytest.mark.parametrize(("which", "value"), [(slice(None), np.nan), (3, np.nan), (0, np.inf)])
def test_a_point_that_is_not_finite_fails(which, value, result):
    """All of it, as of a solve that came to nothing, or one number: NotFinite went through once."""
    with h5py.File(result, "r+") as file:
        z = file["solver/z"][...]
        z[which] = value
        file["solver/z"][...] = z
    assert failed(result) == {"the solver's point and its objective are finite"}


def test_an_objective_that_is_not_finite_fails(folder):
    """log of a negative number, at a point that is finite."""
    text = """
trajopt: 1
name: no value
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: 0, final: 1}}
controls: {u: {}}
objective: {minimize: {integral: log(x + 0.5) + u**2}}
mesh: [{method: trapezoid, segments: 4}]
"""
    (folder / "a.yaml").write_text(text)
    path = solved_once(folder / "a.h5", folder / "a.yaml")
    with h5py.File(path, "r+") as file:
        file["solver/z"][...] = -1.0
    assert "the solver's point and its objective are finite" in failed(path)


def test_an_objective_that_was_changed_fails(result):
    with h5py.File(result, "r+") as file:
        file.attrs["objective"] *= 1.001
    run = trajopt("verify", result)
    assert run.exit_code == 1
    assert re.search("(?m)^FAIL .*stored objective, from that of the solver's point, relative", run.stdout), run.stdout


def test_a_fine_mesh_passes(folder):
    assert not failed(solved_once(folder / "fine.h5", "cartpole", "--segments", "200"))


UNSTABLE = """
trajopt: 1
name: unstable
time: {initial: 0, final: 40}
states: {x: {rate: x + u, initial: 1, final: 1}, c: {rate: 0*u, initial: 3}}
controls: {u: {}}
objective: {minimize: {integral: x**2 + u**2}}
"""


def test_unstable_dynamics_and_a_constant_state_are_no_failure(folder):
    """An error of 1e-12 at t = 0 is one of 1e5 at t = 40: it says nothing about the control."""
    (folder / "unstable.yaml").write_text(UNSTABLE)
    checks = {check.name: check for check in verify(solved_once(folder / "unstable.h5", "unstable.yaml"))}
    assert all(check.passed for check in checks.values())
    assert "the dynamics are unstable" in checks["simulated x, relative to its range"].where


def river(folder, guess: str):
    spec = load_text(RIVER + guess, "river.yaml")
    problem = build(spec)
    solution = solve(problem, steps(spec.mesh), guess=[phase.guess for phase in problem.phases])
    write(folder / "river.h5", solution, spec.text, spec.model_dump_json(), "test")
    return solution


def test_an_extremal_that_is_no_optimum_fails_on_the_tangent_of_the_constraint(folder):
    """With u1 = -1 in place of 1 everywhere the first-order conditions hold as well: it minimises x(2)."""
    good = river(folder, "guess: {constants: {u1: 1, u2: 0}}")
    assert good.solved and good.objective > 0
    assert not failed(folder / "river.h5")
    (folder / "river.h5").unlink()
    bad = river(folder, "guess: {constants: {u1: -1, u2: 0}}")
    if bad.objective < good.objective - 1e-3:
        assert "d2H/du2 without negative eigenvalues, relative" in failed(folder / "river.h5")


def test_the_control_held_between_samples(result):
    rough = trajopt("verify", result, "--sample-hold", "0.1", "--tol", "1e-2")
    assert rough.exit_code == 1 and "v under the control held for 0.1 s" in rough.stdout
    assert all(check.passed for check in verify(result, 1e-2, hold=0.002, anew=False))


def test_half_the_interval_is_half_the_deviation(result):
    """A zero-order hold is of first order."""
    name = "x under the control held for {:g} s"
    wide, narrow = (
        next(c.value for c in verify(result, hold=hold, anew=False) if c.name == name.format(hold))
        for hold in (0.02, 0.01)
    )
    assert wide / narrow == pytest.approx(2, rel=0.1)


@pytest.mark.parametrize("interval", ["0", "-1", "nan", "inf"])
def test_an_interval_is_positive(interval, result):
    run = trajopt("verify", result, "--sample-hold", interval)
    assert run.exit_code == 2 and run.stderr.startswith("error: --sample-hold: ")


def test_a_point_without_a_value_is_not_compared():
    from trajopt.results.audit.stored import _difference

    assert _difference(np.array([1.0, np.nan]), np.array([1.0, 5.0])) == 0
    assert _difference(np.zeros(2), np.zeros(3)) == np.inf
