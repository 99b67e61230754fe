"""Order of convergence, costates and the error estimate on a smooth problem with a known answer."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from exact import (
    GROWTH_OBJECTIVE,
    growth,
    growth_control,
    growth_costate,
    growth_state,
    integration,
    integration_state,
)
from named import COLLOCATION, FAMILIES

from trajopt.transcription.engines.outcome import Status
from trajopt.transcription.schemes.runge_kutta import TABLES
from trajopt.transcription.schemes.table import METHODS as TABLE
from trajopt.transcription.schemes.table import find
from trajopt.transcription.settings import Settings, Step
from trajopt.transcription.solve import solve

LADDERS = {  # (method, degree) -> numbers of segments: errors from visible down to well above rounding
    **{(name, None): (10, 20, 40, 80) for name in COLLOCATION if name not in FAMILIES},
    ("gauss", 1): (10, 20, 40, 80),
    ("gauss", 2): (4, 8, 16, 32),
    ("gauss", 3): (3, 6, 9, 12),
    ("radau", 2): (8, 16, 32, 64),
    ("radau", 3): (4, 8, 12, 20),
    ("radau-left", 2): (8, 16, 32, 64),
    ("radau-left", 3): (4, 8, 12, 20),
    ("lobatto", 3): (4, 6, 8, 12),
    ("lobatto", 4): (2, 3, 4, 6),
    ("chebyshev", 3): (4, 8, 16, 32),
    ("chebyshev", 4): (4, 6, 8, 12),
}
FINE = {  # the same for mere integration, where smaller errors can be told from rounding
    **LADDERS,
    ("gauss", 2): (16, 32, 64),
    ("gauss", 3): (8, 16, 24),
    ("radau", 3): (8, 16, 32),
    ("radau-left", 3): (8, 16, 32),
    ("lobatto", 3): (8, 16, 24),
    ("lobatto", 4): (6, 8, 12),
    ("chebyshev", 3): (16, 32, 64),
    ("chebyshev", 4): (8, 16, 24),
}
METHODS = pytest.mark.parametrize(("method", "degree"), LADDERS)
# Without the symmetry of Gauss quadrature a Chebyshev scheme keeps its order for given controls only: its costates
# obey a scheme of lower order (Hager, Numerische Mathematik 87, 2000).
OPTIMAL = pytest.mark.parametrize(("method", "degree"), [key for key in LADDERS if key[0] != "chebyshev"])
PROBLEMS = {"growth": growth, "integration": integration}


@cache
def solved(problem: str, method: str, degree: int | None, segments: int):
    solution = solve(PROBLEMS[problem](), [Step(method, segments, 1e-13, degree)], Settings({"acceptable_iter": 0}))
    assert solution.status in (Status.SOLVED, Status.STALLED), solution.status  # stalled: at rounding, above 1e-13
    return solution


def ladder(problem: str, method: str, degree: int | None):
    segments = (FINE if problem == "integration" else LADDERS)[method, degree]
    return [solved(problem, method, degree, n) for n in segments]


def order(solutions, errors) -> float:
    """The slope of log error against log h."""
    return -np.polyfit(np.log([s.trajectories[0].mesh.segments for s in solutions]), np.log(errors), 1)[0]


def test_every_method_of_the_table_has_a_ladder():
    """But for shooting and finite differences, which have tests of their order of their own."""
    assert {method for method, _ in LADDERS} == set(COLLOCATION)
    assert FINE.keys() == LADDERS.keys()
    assert {*COLLOCATION, "finite-difference", *(table.name for table in TABLES)} == TABLE.keys()


@METHODS
def test_order_of_integration(method, degree):
    """State at the knots and integral, for given dynamics: the order in the table of methods."""
    state, integral, solutions = [], [], ladder("integration", method, degree)
    for solution in solutions:
        (trajectory,) = solution.trajectories
        exact = integration_state(trajectory.knots)
        state.append(np.abs(trajectory.x[0, trajectory.mesh.knots] - exact).max())
        integral.append(abs(solution.objective - exact[-1] + 1))
    expected = find(method, degree).order
    assert order(solutions, state) == pytest.approx(expected, abs=0.35)
    assert all(a <= 1.1 * b for a, b in zip(integral, state, strict=True))


@OPTIMAL
def test_order_of_the_optimal_objective(method, degree):
    solutions = ladder("growth", method, degree)
    errors = [abs(solution.objective - GROWTH_OBJECTIVE) for solution in solutions]
    assert order(solutions, errors) == pytest.approx(find(method, degree).order, abs=0.5)


@METHODS
def test_order_of_the_optimal_state_and_costate_at_the_knots(method, degree):
    state, costate, solutions = [], [], ladder("growth", method, degree)
    for solution in solutions:
        (trajectory,) = solution.trajectories
        mesh, knots = trajectory.mesh, trajectory.knots
        state.append(np.abs(trajectory.x[0, mesh.knots] - growth_state(knots)).max())
        costate.append(np.abs(trajectory.point_costate[0, mesh.knots] - growth_costate(knots)).max())
    expected = find(method, degree).order
    if method == "chebyshev":
        expected = 2 if degree % 2 else 4
    if method == "lobatto":  # segments share the control at their knot, and with it the error of both sides
        expected = 4
    assert order(solutions, state) > expected - 0.5
    assert order(solutions, costate) > expected - 0.5


@METHODS
def test_both_sides_of_a_knot_give_the_same_costate(method, degree):
    (trajectory,) = ladder("growth", method, degree)[1].trajectories
    start = trajectory.mesh.offset[1:]
    assert trajectory.costate[:, start - 1] == pytest.approx(trajectory.costate[:, start], abs=1e-9)


@METHODS
def test_interpolants_pass_through_the_points(method, degree):
    (trajectory,) = ladder("growth", method, degree)[2].trajectories
    sample = trajectory.at(trajectory.mesh.fractions)
    assert sample.x == pytest.approx(trajectory.x, abs=1e-11)
    for group in trajectory.mesh.groups:
        inside = trajectory.grid(group.segments, group.scheme.c)
        assert inside.u == pytest.approx(trajectory.u[:, group.collocated], abs=1e-11)
        f = trajectory.phase.dynamics(inside.t, inside.x, inside.u, {})
        assert inside.dx == pytest.approx(f, abs=1e-9)  # epsilon is zero at the collocation points


@METHODS
def test_state_and_control_converge_between_the_points(method, degree):
    state, control, solutions = [], [], ladder("growth", method, degree)
    for solution in solutions:
        (trajectory,) = solution.trajectories
        dense = trajectory.dense
        state.append(np.abs(dense.x[0] - growth_state(dense.t)).max())
        control.append(np.abs(dense.u[0] - growth_control(dense.t)).max())
    assert order(solutions, state) > min(find(method, degree).order, 2) - 0.6
    assert order(solutions, control) > 0.8


@METHODS
def test_the_error_estimate_bounds_the_true_error(method, degree):
    for solution in ladder("growth", method, degree):
        (trajectory,), (error,) = solution.trajectories, solution.errors
        # The dynamics dx/dt = u x carry a defect on to the end, at most multiplied by exp(max |u|).
        end_error = abs(integrate(trajectory) - trajectory.x[0, -1])
        assert end_error <= error.eta.sum() * np.exp(np.abs(trajectory.u).max()) + 1e-13


def integrate(trajectory) -> float:
    """x(1) of dx/dt = u x for the trajectory's own control: e exp(integral of u), integrated by Gauss on segments."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    u = trajectory.grid(np.arange(trajectory.mesh.segments), (nodes + 1) / 2).u[0]
    return float(np.exp(1 + (trajectory.h[:, None] * weights / 2 * u).sum()))


@pytest.mark.parametrize("method", FAMILIES)
def test_spectral_convergence_of_global_collocation(method):
    """One segment: the error falls geometrically with the degree, down to rounding."""
    errors = []
    for degree in (8, 12, 16, 20, 24, 28):
        (trajectory,) = solve(integration(), [Step(method, 1, 1e-13, degree)]).trajectories
        errors.append(abs(trajectory.x[0, -1] - integration_state(2.0)))
    assert errors[-1] < 1e-12
    falling = [b < a / 20 for a, b in pairwise(errors) if a > 1e-12]
    assert all(falling)


@pytest.mark.parametrize("method", [name for name in FAMILIES if name != "chebyshev"])  # see OPTIMAL
@pytest.mark.parametrize("degree", [5, 30, 60])
def test_global_collocation_of_the_optimal_problem(method, degree):
    (trajectory,), objective = (s := solve(growth(), [Step(method, 1, 1e-12, degree)])).trajectories, s.objective
    tolerance = 1e-5 if degree == 5 else 1e-11
    assert objective == pytest.approx(GROWTH_OBJECTIVE, abs=tolerance)
    dense = trajectory.dense
    assert dense.x[0] == pytest.approx(growth_state(dense.t), abs=50 * tolerance)


def test_degrees_may_differ_from_segment_to_segment():
    step = Step("radau", [1, 2, 1], 1e-12, [3, 8, 5])
    solution = solve(growth(), [step])
    (trajectory,) = solution.trajectories
    assert [group.scheme.c.size for group in trajectory.mesh.groups] == [3, 8, 5]
    assert solution.objective == pytest.approx(GROWTH_OBJECTIVE, abs=1e-7)
    dense = trajectory.dense
    assert dense.x[0] == pytest.approx(growth_state(dense.t), abs=1e-4)
    assert dense.costate[0] == pytest.approx(growth_costate(dense.t), abs=1e-3)


def test_maximising_the_negative_is_the_same_problem():
    solution = solve(growth(sense=-1), [Step("hermite-simpson", 10, 1e-10)])
    assert solution.objective == pytest.approx(-GROWTH_OBJECTIVE, abs=1e-4)
    (same,) = solve(growth(), [Step("hermite-simpson", 10, 1e-10)]).trajectories
    assert solution.trajectories[0].costate == pytest.approx(-same.costate, abs=1e-6)
