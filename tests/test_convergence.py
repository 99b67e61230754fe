"""Order of convergence, costates and the error estimate on a smooth problem with a known answer."""

from functools import cache

import numpy as np
import pytest
from exact import GROWTH_OBJECTIVE, growth, growth_control, growth_costate, growth_state

from trajopt.transcription.outcome import Status
from trajopt.transcription.schemes import COLLOCATION
from trajopt.transcription.solve import Settings, Step, solve

METHODS = pytest.mark.parametrize("method", COLLOCATION)
SEGMENTS = (5, 10, 20, 40)


@cache
def solved(method: str, segments: int):
    solution = solve(growth(), [Step(method, segments, 1e-13)], Settings({"acceptable_iter": 0}))
    assert solution.status is Status.SOLVED
    return solution


def order(errors) -> float:
    """The slope of log error against log h."""
    return -np.polyfit(np.log(SEGMENTS), np.log(errors), 1)[0]


@METHODS
def test_order_of_the_objective(method):
    errors = [abs(solved(method, n).objective - GROWTH_OBJECTIVE) for n in SEGMENTS]
    assert order(errors) == pytest.approx(COLLOCATION[method].order, abs=0.15)


@METHODS
def test_order_of_the_state_and_costate_at_the_knots(method):
    state, costate = [], []
    for n in SEGMENTS:
        (trajectory,) = solved(method, n).trajectories
        knots = trajectory.knots
        state.append(np.abs(trajectory.x[0, :: trajectory.mesh.degree] - growth_state(knots)).max())
        at_knots = trajectory.point_costate[0, :: trajectory.mesh.degree]
        costate.append(np.abs(at_knots - growth_costate(knots)).max())
    assert order(state) == pytest.approx(COLLOCATION[method].order, abs=0.2)
    assert order(costate) == pytest.approx(COLLOCATION[method].order, abs=0.2)


@METHODS
def test_both_sides_of_a_knot_give_the_same_costate(method):
    (trajectory,) = solved(method, 10).trajectories
    assert trajectory.costate[:, :-1, -1] == pytest.approx(trajectory.costate[:, 1:, 0], abs=1e-10)


@METHODS
def test_interpolants_pass_through_the_points_and_converge_between_them(method):
    (trajectory,) = solved(method, 20).trajectories
    sample = trajectory.at(trajectory.mesh.fractions)
    assert sample.x == pytest.approx(trajectory.x, abs=1e-11)
    assert sample.u == pytest.approx(trajectory.u, abs=1e-11)
    errors = []
    for n in SEGMENTS:
        (trajectory,) = solved(method, n).trajectories
        dense = trajectory.dense
        errors.append(np.abs(dense.x[0] - growth_state(dense.t)).max())
        assert np.abs(dense.u[0] - growth_control(dense.t)).max() < 3 / n**COLLOCATION[method].order ** 0.5
    # At the midpoint of a Hermite-Simpson segment the control, and with it the state inside, is less accurate.
    assert order(errors) > min(COLLOCATION[method].order, 3) - 0.1


@METHODS
def test_the_error_estimate_bounds_the_true_error(method):
    for n in SEGMENTS:
        solution = solved(method, n)
        (trajectory,), (error,) = solution.trajectories, solution.errors
        # The dynamics dx/dt = u x carry a defect on to the end, at most multiplied by exp(max |u|).
        end_error = abs(integrate(trajectory) - trajectory.x[0, -1])
        assert end_error <= error.eta.sum() * np.exp(np.abs(trajectory.u).max())
        assert error.eta.sum() <= 100 * end_error + 1e-12 or method != "trapezoid"


def integrate(trajectory) -> float:
    """x(1) of dx/dt = u x for the trajectory's own control: e exp(integral of u), integrated by Gauss on segments."""
    nodes, weights = np.polynomial.legendre.leggauss(8)
    segments = np.arange(trajectory.mesh.segments)[:, None]
    u = trajectory.evaluate(segments, (nodes[None, :] + 1) / 2).u[0]
    return float(np.exp(1 + (trajectory.h[:, None] * weights / 2 * u).sum()))


@METHODS
def test_epsilon_is_zero_at_the_collocation_points(method):
    (trajectory,) = solved(method, 10).trajectories
    sample = trajectory.at(trajectory.mesh.fractions)
    f = trajectory.phase.dynamics(sample.t, sample.x, sample.u, {})
    assert sample.dx == pytest.approx(f, abs=1e-10)


def test_maximising_the_negative_is_the_same_problem():
    solution = solve(growth(sense=-1), [Step("hermite-simpson", 10, 1e-10)])
    assert solution.objective == pytest.approx(-GROWTH_OBJECTIVE, abs=1e-4)
    (same,), (trajectory,) = solved("hermite-simpson", 10).trajectories, solution.trajectories
    assert trajectory.costate == pytest.approx(-same.costate, abs=1e-6)
