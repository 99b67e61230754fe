"""Objectives computed independently of trajopt (CasADi and IPOPT, tol 1e-8), or known exactly: all digits given."""

from decimal import Decimal

import numpy as np
import pytest
from named import share

from trajopt.problems.build import build_all
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load
from trajopt.transcription.settings import schedule_of, settings_of
from trajopt.transcription.solve import solve

HS = "hermite-simpson"

REFERENCES = [  # problem, method, segments, objective as printed: half a unit of the last digit is the tolerance
    ("cartpole", HS, 25, "58.805425"),
    ("cartpole", HS, 100, "58.807666"),
    ("cartpole", "trapezoid", 9, "59.6379"),
    ("cartpole", "trapezoid", 19, "60.5969"),
    ("cartpole", "trapezoid", 29, "59.7442"),
    ("cartpole", "trapezoid", 200, "58.8304"),
    ("cartpole", HS, 400, "58.8076675"),  # the converged value
    ("block_move_min_force", "trapezoid", 9, "12.568966"),
    ("block_move_min_force", "trapezoid", 29, "12.055858"),
    ("block_move_min_force", "trapezoid", 59, "12.013629"),
    ("block_move_min_force", HS, 1, "12.0000000"),  # exact for any mesh: u = 6 - 12 t
    ("block_move_min_force", HS, 7, "12.0000000"),
    ("block_move_min_force", HS, 100, "12.0000000"),
]


def run(name: str, *overrides: str):
    spec = load(shipped()[name], overrides)
    solution = solve(build_all(spec), schedule_of(spec), settings_of(spec))
    assert solution.solved, solution.status
    return spec, solution


@pytest.mark.parametrize(("name", "method", "segments", "printed"), REFERENCES)
def test_reference_value(name, method, segments, printed):
    _, solution = run(name, f"mesh.*.method={method}", f"mesh.-1.segments={segments}")
    half_a_unit = 0.5 * 10.0 ** Decimal(printed).as_tuple().exponent
    assert solution.objective == pytest.approx(float(printed), rel=0, abs=half_a_unit * 1.001)


FEWER = {"biped": 10, "block_move_min_work_smooth": 15, "cartpole_min_time": 10}
"""Segments, where those of the file take long."""

OF_ONE_METHOD = ("\ncomplementarity:", "history:")  # pairs and delays


def has_a_mesh_of_any_method(text):
    return "\nmesh:" in text and not any(key in text for key in OF_ONE_METHOD)


@pytest.mark.parametrize(
    "name", share([name for name, path in shipped().items() if has_a_mesh_of_any_method(path.read_text())], 2)
)
def test_separated_and_compressed_form_are_one_method(name):
    """On one mesh: refinement would give the two forms meshes that differ by rounding, and grow from there."""
    fewer = ["refine=", *([f"mesh.-1.segments={FEWER[name]}"] if name in FEWER else [])]
    _, separated = run(name, *fewer, f"mesh.*.method={HS}")
    _, compressed = run(name, *fewer, f"mesh.*.method={HS}-compressed")
    assert compressed.objective == pytest.approx(separated.objective, abs=2e-7 * (1 + abs(separated.objective)))
    for a, b in zip(separated.trajectories, compressed.trajectories, strict=True):
        assert b.x == pytest.approx(a.x, abs=2e-5)


def test_cartpole_error_estimate():
    """max |epsilon| and max eta, computed independently with 201 points a segment; segments count from 0."""
    _, solution = run("cartpole")
    (error,) = solution.errors
    assert error.eta.max(axis=1) == pytest.approx([5.08e-4, 1.35e-3, 3.96e-3, 1.27e-2], rel=5e-3)
    assert error.eta.argmax(axis=1).tolist() == [10, 10, 12, 10]
    assert np.abs(error.epsilon).max(axis=1) == pytest.approx([9.77e-3, 2.60e-2, 0.1135, 0.3688], rel=1e-2)


def test_cartpole_trajectory():
    _, solution = run("cartpole")
    (trajectory,) = solution.trajectories
    u, x = trajectory.u[0], trajectory.x
    assert (u[0], u[-1], np.abs(u).max()) == pytest.approx((2.21157, -1.79084, 13.8034), abs=5e-5)
    assert (x[0].max(), x[1].min()) == pytest.approx((1.1774, -0.9209), abs=5e-5)


@pytest.mark.parametrize("method", [HS, f"{HS}-compressed"])
def test_costates_of_the_minimum_force_block(method):
    """Appendix B: lambda_x = c_0, lambda_v = c_1 - c_0 t with u = (c_0 t - c_1) / 2 = 6 - 12 t."""
    _, solution = run("block_move_min_force", f"mesh.*.method={method}")
    (trajectory,) = solution.trajectories
    t, (lambda_x, lambda_v) = trajectory.times, trajectory.point_costate
    assert lambda_x == pytest.approx(np.full_like(t, -24), abs=1e-6)
    assert lambda_v == pytest.approx(24 * t - 12, abs=1e-6)
    dense = trajectory.dense
    assert dense.costate[1] == pytest.approx(24 * dense.t - 12, abs=1e-6)


def test_costates_of_the_minimum_force_block_by_trapezoid_are_near():
    _, solution = run("block_move_min_force", "mesh.*.method=trapezoid", "mesh.-1.segments=100")
    (trajectory,) = solution.trajectories
    assert trajectory.point_costate[1] == pytest.approx(24 * trajectory.times - 12, abs=2e-2)
