"""The error bar of the objective: its terms, its order, and whether it holds."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.known_optima import KNOWN
from exact import GROWTH_OBJECTIVE, fixed, growth
from named import crossed, problem_named, share

from trajopt.problems.problem import Guess, Phase, Problem
from trajopt.problems.quantities import Constraint, Range, State, Variable
from trajopt.problems.text import with_bar
from trajopt.transcription.dual.multipliers import Multipliers
from trajopt.transcription.engines.outcome import Status
from trajopt.transcription.engines.watch import Watch
from trajopt.transcription.one_mesh import Origin, solve_mesh
from trajopt.transcription.settings import Settings, Step
from trajopt.transcription.solution.hamiltonian import Constrained, minimise
from trajopt.transcription.solution.objective_error import ROUNDING, objective_error
from trajopt.transcription.solve import solve


def solved(problem: Problem, method: str, segments: int, tolerance: float = 1e-10, **how):
    """The solution on one mesh, and what its error is estimated from."""
    meshes = [Step(method, segments, tolerance, **how).mesh() for _ in problem.phases]
    settings = Settings({"max_iter": 400}, coarse_start=False)
    solution, left = solve_mesh(problem, meshes, tolerance, settings, Origin(None, None), Watch(None, None, 0))
    return solution, (left.transcription, left.nlp, left.outcome, left.trajectories)


def estimated(problem: Problem, method: str, segments: int, **how):
    solution, left = solved(problem, method, segments, **how)
    assert solution.status is Status.SOLVED
    return solution, objective_error(*left)


def known(name: str):
    return next(own for own in KNOWN if own.name == name)


# -- the bar -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", ["hermite-simpson", "radau", "runge-kutta-4"])
def test_where_every_interpolant_is_exact_the_bar_is_rounding(method):
    """Block move: x is a cubic and u linear. Its bounds are far from the trajectory but for x at both ends."""
    solution, estimate = estimated(problem_named("block_move_min_force"), method, 8, tolerance=1e-12)
    assert estimate.bar < 10 * ROUNDING * (1 + solution.objective)
    assert abs(solution.objective - 12) <= estimate.bar


@pytest.mark.parametrize(
    ("method", "counts", "order"), [("trapezoid", (10, 20, 40), 2), ("hermite-simpson", (4, 8, 16), 4)]
)
def test_the_corrected_objective_is_of_a_higher_order(method, counts, order):
    pairs = [estimated(growth(), method, n, tolerance=1e-12) for n in counts]
    raw = [abs(solution.objective - GROWTH_OBJECTIVE) for solution, _ in pairs]
    corrected = [abs(solution.objective + e.correction - GROWTH_OBJECTIVE) for solution, e in pairs]

    def slope(errors) -> float:
        return -np.polyfit(np.log(counts), np.log(errors), 1)[0]

    assert slope(raw) == pytest.approx(order, abs=0.3)
    assert slope(corrected) > order + 1.5
    assert all(e.bar < 5 * error for (_, e), error in zip(pairs, raw, strict=True))


COVERED = [
    ("brachistochrone", "trapezoid"),
    ("brachistochrone", "dormand-prince"),
    ("bryson_denham", "gauss"),
    ("speed limit", "hermite-simpson"),
    ("minimum time", "radau"),
    ("minimum fuel", "hermite-simpson"),
    ("growth, algebraic", "midpoint"),
    ("drift, parameter", "runge-kutta-4"),
    ("decay, free time", "hermite-simpson-compressed"),
    ("hanging chain", "trapezoid"),
    ("mixed constraint", "lobatto"),
    ("range", "hermite-simpson"),
    ("interior point, two phases", "implicit-euler"),
    ("van_der_pol", "radau-left"),
    ("goddard", "hermite-simpson"),
]


@pytest.mark.parametrize(("covered", "segments"), crossed(COVERED, [10, 20]))
def test_the_bar_holds(covered, segments):
    """Kinks, jumps, bounds, free times, parameters, algebraic variables, constrained integrals, phases, maximising."""
    name, method = covered
    own = known(name)
    solution, estimate = estimated(own.problem(), method, segments, tolerance=1e-8)
    error = abs(solution.objective - own.optimum)
    assert error <= estimate.bar < 300 * max(error, ROUNDING * (1 + abs(own.optimum)))
    assert sum(share.sum() for share in estimate.shares) <= estimate.bar
    assert all(len(s) == segments for s in (*estimate.segments, *estimate.shares))


@pytest.mark.parametrize("method", share(["trapezoid", "hermite-simpson", "radau", "runge-kutta-4"], 2))
def test_a_bound_of_a_state_is_as_good_as_a_path_constraint_that_says_the_same(method):
    """Where it acts over an arc, its multipliers at the knots belong to the segments on both sides."""
    own = known("speed limit")
    problem = own.problem()
    (phase,) = problem.phases
    x, v = phase.states
    limit = Constraint("limit", lambda values, m: values["v"], v.bounds)
    other = replace(phase, states=(x, replace(v, bounds=Range())), path=(limit,))
    widths = [3, 2, 2, 3, 9, 3, 2, 2, 3]  # a wide segment within the arc
    bound, path = (estimated(p, method, widths)[1] for p in (problem, replace(problem, phases=(other,))))
    assert bound.bar < 2 * path.bar


def test_maximising_is_minimising_the_negative():
    _, least = estimated(growth(), "trapezoid", 10)
    _, most = estimated(growth(-1), "trapezoid", 10)
    assert most.correction == pytest.approx(-least.correction, rel=1e-6)
    assert most.bar == pytest.approx(least.bar, rel=1e-6)


def test_the_segments_of_the_error_contribute():
    """A coarse segment among fine ones has the most of the bar."""
    widths = [1, 1, 1, 8, 1, 1, 1]
    _, estimate = estimated(growth(), "hermite-simpson", widths)
    assert np.argmax(estimate.shares[0]) == 3


# -- the barrier ---------------------------------------------------------------------------------------------------


def test_the_gap_is_the_barrier_parameter_times_the_number_of_inequalities():
    solution, (transcription, nlp, outcome, _) = solved(problem_named("van_der_pol"), "trapezoid", 15, 1e-8)
    (layout,) = transcription.phases
    count = 2 * (layout.u >= 0).sum()  # u has both bounds; the states have none
    mu = outcome.iterations["mu"][-1]
    assert Multipliers(transcription, nlp, outcome).gap == pytest.approx(mu * count, rel=0.05)
    assert solution.status is Status.SOLVED


def test_what_the_barrier_leaves_is_in_correction_and_bar():
    """Minimise x(1) + the integral of u^2 / 10, dx/dt = u, u or x(1) at least -1: J = -0.9 but for the barrier."""

    def problem(bound: float, final: float) -> Problem:
        guess = Guess(0.0, 1.0, np.array([0.0, 1.0]), {"x": np.zeros(2), "u": np.zeros(2)})
        x = State("x", rate=lambda v, m: v["u"], initial=fixed(0), final=Range(final, np.inf))
        u = Variable("u", bounds=Range(bound, 5.0))
        phase = Phase("main", fixed(0), fixed(1), (x,), (u,), guess, lagrange=lambda v, m: v["u"] ** 2 / 10,
                      mayer=lambda v, m: v["x[final]"])  # fmt: skip
        return Problem("barrier", 1, (phase,))

    for own in (problem(-1.0, -np.inf), problem(-9.0, -1.0)):
        solution, estimate = estimated(own, "trapezoid", 10, tolerance=1e-5)
        error = solution.objective + 0.9
        assert error > 1e-8
        assert abs(error + estimate.correction) < 1e-2 * error
        assert error <= estimate.bar < 5 * error


def test_each_mesh_of_the_history_has_its_bar():
    solution = solve(growth(), [Step("trapezoid", 4, 1e-8), Step("trapezoid", 8, 1e-8)], Settings())
    for mesh in solution.meshes:
        assert abs(mesh.objective - GROWTH_OBJECTIVE) <= mesh.objective_error
        assert abs(mesh.objective_corrected - GROWTH_OBJECTIVE) < 0.1 * abs(mesh.objective - GROWTH_OBJECTIVE)
    last, error = solution.meshes[-1], solution.objective_error
    assert (last.objective_error, last.objective_corrected) == (error.bar, last.objective + error.correction)


@pytest.mark.parametrize(
    ("value", "bar", "shown"),
    [
        (58.807667463, 2.4e-8, ("58.80766746", "3e-8")),
        (58.80542547, 0.33, ("58.81", "0.4")),  # no less than four digits
        (58.80542547, 0.397, ("58.81", "0.5")),  # rounding the value took it out of reach of 0.4
        (37.598136921234, 4e-13, ("37.59813692", "2e-9")),  # no more than ten
        (12.0, 3e-8, ("12.00000000", "3e-8")),
        (9.99999, 0.6, ("10.000", "0.7")),
        (-1.5e-7, 2e-11, ("-1.5000e-07", "2e-11")),
        (5.3, 1e3, ("5.300", "1000")),
        (0.0, 1e-11, ("0.000000000", "1e-11")),
    ],
)
def test_a_value_is_written_with_the_digits_that_its_bar_supports(value, bar, shown):
    assert with_bar(value, bar) == shown
    assert abs(float(shown[0]) - value) + bar <= float(shown[1]) * (1 + 1e-6)


# -- where it does not apply ---------------------------------------------------------------------------------------


def test_finite_differences_have_no_bar():
    _, left = solved(problem_named("pendulum"), "finite-difference", 50)
    estimate = objective_error(*left)
    assert not estimate.applies and "finite differences" in estimate.why_not
    assert np.isnan(estimate.bar) and estimate.segments == ()


def test_a_failed_solve_has_no_bar():
    _, (transcription, nlp, outcome, trajectories) = solved(growth(), "trapezoid", 10)
    failed = replace(outcome, status=Status.MAX_ITERATIONS)
    assert "not optimal" in objective_error(transcription, nlp, failed, trajectories).why_not


def test_values_that_are_not_finite_have_no_bar():
    _, (transcription, nlp, outcome, (own,)) = solved(growth(), "trapezoid", 10)
    broken = replace(own, x=np.where(np.arange(11) == 4, np.nan, own.x))
    assert "no finite value" in objective_error(transcription, nlp, outcome, [broken]).why_not
    broken = replace(own, costate=own.costate * np.nan)
    assert "costates" in objective_error(transcription, nlp, outcome, [broken]).why_not


def test_a_hamiltonian_without_a_minimum_says_so():
    """The integral of -u^2 from x = 0.5 to 1: any control that is not constant is better than this one."""
    guess = Guess(0.0, 1.0, np.array([0.0, 1.0]), {"x": np.array([0.5, 1.0]), "u": np.full(2, 0.5)})
    x = State("x", rate=lambda v, m: v["u"], initial=fixed(0.5), final=fixed(1.0))
    cost = lambda v, m: -(v["u"] ** 2)  # noqa: E731
    phase = Phase("main", fixed(0), fixed(1), (x,), (Variable("u"),), guess, lagrange=cost)
    _, (transcription, nlp, outcome, trajectories) = solved(Problem("concave", 1, (phase,)), "trapezoid", 1)
    estimate = objective_error(transcription, nlp, replace(outcome, status=Status.SOLVED), trajectories)
    assert "no minimum over the controls" in estimate.why_not


# -- the minimum of the Hamiltonian ----------------------------------------------------------------------------------


def of(function):
    """A function of the controls (n_u, B, S) that is the same at all samples."""
    return lambda u, samples: function(u)


def test_minimum_inside_and_at_the_bounds():
    """A quadratic with cross terms; linear functions go to their bounds; in a double well each stays in its own."""
    u = np.array([[0.0, 0.9, -0.9], [0.0, 0.2, 0.4]])
    box = np.array([[-1.0, -1.0], [1.0, 1.0]])
    least = minimise(of(lambda u: (u[0] - 0.3) ** 2 + u[0] * u[1] + u[1] ** 2), u, box)
    assert least.found.all()
    assert least.u == pytest.approx(np.tile([[0.4], [-0.2]], 3), abs=1e-6)
    least = minimise(of(lambda u: 2 * u[0] - u[1]), u, box)
    assert least.u == pytest.approx(np.tile([[-1.0], [1.0]], 3))
    assert least.value == pytest.approx(-3.0)
    least = minimise(of(lambda u: (u[0] ** 2 - 0.25) ** 2), np.array([[0.3, -0.4]]), box[:, :1])
    assert least.u == pytest.approx(np.array([[0.5, -0.5]]), abs=1e-4)


def test_minimum_without_bounds_far_away_or_none():
    free = np.array([[-np.inf], [np.inf]])
    least = minimise(of(lambda u: (u[0] - 400.0) ** 2), np.array([[1.0]]), free)
    assert least.found.all() and least.u == pytest.approx(400.0, rel=1e-6)
    assert not minimise(of(lambda u: -(u[0] ** 2)), np.array([[1.0]]), free).found.any()
    assert not minimise(of(lambda u: -(u[0] ** 2)), np.array([[0.0]]), free).found.any()
    assert not minimise(of(lambda u: u[0]), np.array([[1.0]]), free).found.any()


@pytest.mark.parametrize("multiplier", [0.0, 0.5])
def test_minimum_subject_to_constraints(multiplier):
    """On a circle, and below a line; the multipliers need not be good."""
    u, box = np.array([[0.6, 0.9], [0.7, 0.1]]), np.array([[-10.0, -10.0], [10.0, 10.0]])
    circle = Constrained(
        of(lambda u: np.stack([u[0] ** 2 + u[1] ** 2])), np.ones(1), np.ones(1), np.full((1, 2), multiplier)
    )
    least = minimise(of(lambda u: -u[0] - u[1]), u, box, circle)
    assert least.value == pytest.approx(-np.sqrt(2), abs=1e-5)
    line = Constrained(
        of(lambda u: np.stack([u[0] + u[1]])), np.full(1, -np.inf), np.ones(1), np.full((1, 2), multiplier)
    )
    least = minimise(of(lambda u: (u[0] - 1) ** 2 + (u[1] - 1) ** 2), u, box, line)
    assert least.value == pytest.approx(0.5, abs=1e-5)
