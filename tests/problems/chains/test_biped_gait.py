"""The five-link biped: its optimal gait against independent values."""

from decimal import Decimal
from functools import cache

import numpy as np
import pytest
from named import ALL

from .walker import HS, KNEES, SUPPLEMENT, biped, run


@cache
def solved(walker: str, method: str, segments: int):
    problem = biped(KNEES if "knees" in walker else (), **SUPPLEMENT if "supplement" in walker else {})
    return run(problem, (method, segments, 1e-8))


REFERENCES = [  # walker, method, segments, objective as printed: half a unit of the last digit is the tolerance
    ("table 4", HS, 5, "390.73094"),
    ("table 4", HS, 15, "390.78984"),
    ("table 4", HS, 25, "390.79044"),
    ("table 4", HS, 60, "390.79053"),
    ("table 4", "trapezoid", 24, "393.49732"),
    ("table 4", "trapezoid", 100, "390.96116"),
    ("table 4, knees", HS, 25, "390.79044"),
    ("supplement", HS, 25, "469.50107"),
    ("supplement, knees", HS, 5, "469.46885"),
    ("supplement, knees", HS, 15, "469.64333"),
    ("supplement, knees", HS, 25, "469.64678"),
    ("supplement, knees", HS, 60, "469.6500"),
    ("supplement, knees", "trapezoid", 24, "473.86487"),
    ("supplement, knees", "trapezoid", 100, "469.91994"),
]


FEW = [row for row in REFERENCES if row[2] in (5, 25)]
"""The others are run where TRAJOPT_SLOW is set, and by `trajopt reproduce` in reproduction/paper.py."""


@pytest.mark.parametrize(("walker", "method", "segments", "printed"), REFERENCES if ALL else FEW)
def test_reference_value(walker, method, segments, printed):
    """Computed independently of trajopt with CasADi and IPOPT, tol 1e-8."""
    solution = solved(walker, method, segments)
    half_a_unit = 0.5 * 10.0 ** Decimal(printed).as_tuple().exponent
    assert solution.objective == pytest.approx(float(printed), rel=0, abs=half_a_unit * 1.001)


PRINTED = {  # x(0), dq(T), u(0), u(T), greatest height of the swing foot, greatest eta of q1 to q5; 25 segments
    "table 4": {
        "x0": [0.07129, 0.50165, -0.22793, -0.35099, -0.36192, -1.20789, -1.07960, 0.23077, -0.58534, -1.91620],
        "dq_final": [-2.05706, -1.52743, 1.07607, -1.96205, 3.57032],
        "u0": [0, -22.955, 41.965, 8.670, 12.613],
        "u_final": [0, 13.452, 8.722, -22.109, 9.460],
        "height": 0.0704,
        "eta": [3.8e-6, 3.9e-6, 1.2e-6, 1.7e-6, 1.8e-6],
    },
    "supplement, knees": {
        "x0": [0.08645, 0.49319, -0.12735, -0.34672, -0.35800, -1.50587, -0.60570, 0.01500, -0.54394, -2.01556],
        "dq_final": [-2.17582, -1.62054, 1.02672, -1.37964, 2.99184],
        "u0": [0, -25.118, 53.669, 1.696, 16.103],
        "u_final": [0, 14.362, 8.233, -22.671, 7.585],
        "height": 0.0712,
        "eta": [9.4e-6, 1.02e-5, 1.8e-6, 2.3e-6, 1.7e-6],
    },
}


@pytest.mark.parametrize("gait", PRINTED)
def test_gait(gait):
    (trajectory,), printed = solved(gait, HS, 25).trajectories, PRINTED[gait]
    x, u = trajectory.x, trajectory.u
    assert x[:, 0] == pytest.approx(printed["x0"], abs=5.1e-6)
    assert x[:5, -1] == pytest.approx(x[4::-1, 0], abs=1e-9)
    assert x[5:, -1] == pytest.approx(printed["dq_final"], abs=5.1e-6)
    assert u[:5, 0] == pytest.approx(printed["u0"], abs=5.1e-4)
    assert u[:5, -1] == pytest.approx(printed["u_final"], abs=5.1e-4)


@pytest.mark.parametrize("gait", PRINTED)
def test_foot_stays_above_the_ground(gait):
    """(7.5) holds without being asked for."""
    (trajectory,) = solved(gait, HS, 25).trajectories
    dense = trajectory.dense
    foot_y = trajectory.phase.outputs["foot_y"].function
    y = foot_y(trajectory.phase.arguments(dense.t, dense.x, dense.u, {}), np)
    assert y.max() == pytest.approx(PRINTED[gait]["height"], abs=5.1e-5)
    assert y[1:-1].min() > 0
    assert (y[0], y[-1]) == pytest.approx((0, 0), abs=1e-8)


@pytest.mark.parametrize("gait", PRINTED)
def test_error_estimate(gait):
    """The right side of Figure 15, computed independently; all digits given."""
    (error,) = solved(gait, HS, 25).errors
    printed = np.array(PRINTED[gait]["eta"])
    assert np.all(np.abs(error.eta.max(axis=1)[:5] - printed) <= 0.51e-7)


def test_both_meshes_of_the_paper():
    """5 segments to 1e-3, then 25 to 1e-6; the paper's solver needs 29 and 56 iterations, 0.96 s and 21.3 s."""
    solution = run(biped(), (HS, 5, 1e-3), (HS, 25, 1e-6))
    assert solution.objective == pytest.approx(390.79044, abs=5e-6)
    assert [mesh.iterations < 30 for mesh in solution.meshes] == [True, True]
    for mesh in solution.meshes:
        parts = ", ".join(f"{name} {seconds:.3f}" for name, seconds in mesh.seconds.items())
        total = sum(mesh.seconds.values())
        print(f"{mesh.mesh.segments} segments: {mesh.iterations} iterations, {total:.3f} s: {parts}")


def test_compressed_form_finds_the_same_gait():
    """The midpoint states are eliminated; the accelerations at the midpoints stay unknown."""
    assert run(biped(), (f"{HS}-compressed", 5, 1e-8)).objective == pytest.approx(390.73094, abs=5e-6)


def test_foot_clearance_over_a_bump():
    """(7.7): the swing foot stays above h (1 - (x / step length)^2)."""
    clearance = {"name": "clearance", "expression": "foot_y - 0.08*(1 - (foot_x/step_length)**2)", "lower": 0}
    solution = run(biped([clearance]), (HS, 15, 1e-8))
    (trajectory,) = solution.trajectories
    values = trajectory.phase.arguments(trajectory.times, trajectory.x, trajectory.u, {})
    margin = trajectory.phase.path[0].function(values, np)
    assert margin.min() > -1e-7
    assert np.sum(margin < 1e-6) > 2
    assert solution.objective > 391
