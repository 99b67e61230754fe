"""Explicit Runge-Kutta tables: order conditions, interpolants, order of integration and of the optimal solution."""

import numpy as np
import pytest
from exact import GROWTH_OBJECTIVE, growth, growth_costate, growth_state, integration, integration_state
from shooting import SCHEME

from trajopt.transcription.schemes.runge_kutta import CLASSICAL, CONTROLS, TABLES, ButcherTable, order_conditions
from trajopt.transcription.schemes.shooting import Shooting
from trajopt.transcription.schemes.table import find
from trajopt.transcription.settings import Settings, Step
from trajopt.transcription.solve import solve

TABLE = pytest.mark.parametrize("table", TABLES, ids=lambda table: table.name)


# -- the tables and the interpolants ----------------------------------------------------------------


@TABLE
def test_order_conditions(table):
    rows, sides = order_conditions(table.A, table.order)
    assert np.abs(rows @ table.b - sides).max() < 1e-15
    rows, sides = order_conditions(table.A, max(table.order - 1, 2), theta=0.5)
    assert np.abs(rows @ table.middle - sides).max() < 1e-15


@TABLE
def test_the_order_is_no_higher(table):
    quadrature = [abs(table.b @ table.c**k - 1 / (k + 1)) for k in range(8)]
    trees, sides = order_conditions(table.A, min(table.order + 1, 5))
    assert max(quadrature[table.order], np.abs(trees @ table.b - sides).max()) > 1e-4


def test_row_sums_and_weights_as_published():
    heun, classical, dormand_prince = TABLES
    assert heun.c.tolist() == [0, 1]
    assert classical.c.tolist() == [0, 1 / 2, 1 / 2, 1]
    assert dormand_prince.c == pytest.approx([0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1], abs=1e-14)
    assert classical.middle == pytest.approx([5 / 24, 1 / 6, 1 / 6, -1 / 24], abs=1e-15)


def test_an_implicit_table_is_refused():
    with pytest.raises(ValueError, match="strictly lower"):
        ButcherTable("midpoint", 2, np.array([[0.5]]), np.ones(1), "")


@pytest.mark.parametrize("control", CONTROLS)
@pytest.mark.parametrize("substeps", [1, 2, 5])
def test_interpolants_are_exact_for_polynomials(control, substeps):
    scheme, tau, h = Shooting(CLASSICAL, substeps, control), np.linspace(0, 1, 23), 3.0
    at = scheme.interpolant(tau)
    for k in range(int(scheme.state_interpolant) + 1):
        slope = k * (h * scheme.c) ** max(k - 1, 0)
        x = (h * scheme.sigma) ** k
        assert at.X @ x + h * at.F @ slope == pytest.approx((h * tau) ** k, abs=1e-12 * h**k)
        assert at.dX @ x / h + at.dF @ slope == pytest.approx(k * (h * tau) ** max(k - 1, 0), abs=1e-11 * h**k)
    u = scheme.c ** int(scheme.control_interpolant)
    assert at.U @ u == pytest.approx(tau ** int(scheme.control_interpolant), abs=1e-13)
    for k in range(min(substeps, 3) + 1):
        assert scheme.costate_basis(tau) @ scheme.sigma**k == pytest.approx(tau**k, abs=1e-13)


# -- order of convergence ---------------------------------------------------------------------------


def slope(sizes, errors) -> float:
    return -np.polyfit(np.log(sizes), np.log(errors), 1)[0]


@SCHEME
@pytest.mark.parametrize("substeps", [1, 4])
def test_order_of_integration(method, control, substeps):
    """State at the knots and integral, for given dynamics: the order in the table of methods."""
    sizes, state, integral = (32, 64, 128), [], []
    for size in sizes:
        solution = solve(integration(), [Step(method, size // substeps, 1e-13, substeps=substeps, control=control)])
        (trajectory,) = solution.trajectories
        exact = integration_state(trajectory.times)
        state.append(np.abs(trajectory.x[0] - exact)[trajectory.mesh.knots].max())
        integral.append(abs(solution.objective - exact[-1] + 1))
    order = find(method).order
    assert slope(sizes, state) == pytest.approx(order, abs=0.3)
    assert integral[-1] <= 1.1 * state[-1]


OPTIMAL = {"constant": (2, 2), "linear": (4, 4), "quadratic": (5, 4)}
"""What the control's polynomial leaves of the table's order: objective; state and costate at the knots."""


@SCHEME
def test_order_of_the_optimal_solution(method, control):
    sizes, objective, state, costate, between = (16, 32, 64), [], [], [], []
    for size in sizes:
        solution = solve(
            growth(), [Step(method, size // 4, 1e-13, substeps=4, control=control)], Settings({"acceptable_iter": 0})
        )
        (trajectory,), times = solution.trajectories, solution.trajectories[0].knots
        knots = trajectory.mesh.knots
        objective.append(abs(solution.objective - GROWTH_OBJECTIVE))
        state.append(np.abs(trajectory.x[0, knots] - growth_state(times)).max())
        costate.append(np.abs(trajectory.point_costate[0, knots] - growth_costate(times)).max())
        dense = trajectory.dense
        between.append(
            max(
                np.abs(dense.x[0] - growth_state(dense.t)).max(),
                np.abs(dense.costate[0] - growth_costate(dense.t)).max(),
            )
        )
    expected, at_knots = (min(find(method).order, order) for order in OPTIMAL[control])
    assert slope(sizes, objective) == pytest.approx(expected, abs=0.3)
    assert slope(sizes[1:], state[1:]) > at_knots - 0.5
    assert slope(sizes[1:], costate[1:]) > at_knots - 0.3
    assert slope(sizes, between) > min(at_knots, 3) - 0.3


@SCHEME
def test_the_error_estimate_bounds_the_true_error(method, control):
    solution = solve(growth(), [Step(method, 3, 1e-12, substeps=3, control=control)])
    (trajectory,), (error,) = solution.trajectories, solution.errors
    nodes, weights = np.polynomial.legendre.leggauss(4)
    tau = (
        (np.arange(12)[:, None] + (nodes + 1) / 2) / 12
    ).ravel()  # four pieces of each substep: none has a jump in it
    u = trajectory.grid(np.arange(3), tau).u[0]
    end = np.exp(1 + (trajectory.h[:, None] * np.tile(weights / 24, 12) * u).sum())
    assert abs(end - trajectory.x[0, -1]) <= error.eta.sum() * np.exp(np.abs(trajectory.u).max()) + 1e-13
    assert error.max_eta < 0.02
