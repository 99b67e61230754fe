"""Newton's method on the KKT system: the exercises of the introduction to direct collocation, sections 2 to 5."""

import numpy as np
import pytest
from pyomo.core import ConcreteModel, Constraint, Objective, Var, exp, log
from scipy.sparse import csc_matrix

from trajopt.problems.errors import SpecError
from trajopt.transcription.engines import linear, newton
from trajopt.transcription.engines.outcome import Status
from trajopt.transcription.program.compiler import compile_model
from trajopt.transcription.program.templates import templated


def program(objective=lambda x1, x2: 0 * x1, *constraints):
    """A compiled program in x1 and x2; each constraint is a relation of them."""
    model = ConcreteModel()
    model.x1, model.x2 = Var(), Var()
    with templated():
        model.cost = Objective(rule=lambda m: objective(m.x1, m.x2))
        for i, constraint in enumerate(constraints):
            model.add_component(f"g{i}", Constraint(rule=lambda m, c=constraint: c(m.x1, m.x2)))
    return compile_model(model, [model.x1, model.x2])


def run(nlp, start, lower=(-np.inf, -np.inf), upper=(np.inf, np.inf), **options):
    return newton.solve_program(nlp, np.array(start, float), np.array(lower, float), np.array(upper, float), options)


@pytest.mark.parametrize("line_search", ["no", "yes"])
@pytest.mark.parametrize(("start", "root"), [((2, 1), 1), ((-3, -4), -1)])
def test_least_squares_on_a_hyperbola(start, root, line_search):
    """Section 5: minimise x1^2 + x2^2 with x1 x2 = 3. (36) has lambda = 2, so y = -2."""
    outcome = run(program(lambda a, b: a**2 + b**2, lambda a, b: a * b == 3), start, line_search=line_search)
    assert outcome.status is Status.SOLVED
    assert outcome.z == pytest.approx(root * np.sqrt([3, 3]), abs=1e-12)
    assert outcome.y == pytest.approx([-2], abs=1e-12)
    assert outcome.objective == pytest.approx(6, abs=1e-12)


def test_unconstrained_quadratic_takes_one_step():
    """Section 3: minimise x1^2 + x2^2 from (-5, 5); a quadratic is solved by the first step."""
    outcome = run(program(lambda a, b: a**2 + b**2), (-5, 5))
    assert outcome.status is Status.SOLVED
    assert outcome.z == pytest.approx([0, 0], abs=1e-12)
    assert outcome.iterations["objective"][1] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("sign", [1, -1])
def test_roots_of_a_line_and_a_parabola(sign):
    """Section 2: x1 + x2^2 = 0 and -2 x2 - 4 x1 - 5 = 0, so 4 x2^2 - 2 x2 - 5 = 0."""
    nlp = program(lambda a, b: 0 * a, lambda a, b: a + b**2 == 0, lambda a, b: -2 * b - 4 * a == 5)
    x2 = (1 + sign * np.sqrt(21)) / 4
    outcome = run(nlp, (-1, 2 * sign))
    assert outcome.status is Status.SOLVED
    assert outcome.z == pytest.approx([-(x2**2), x2], abs=1e-12)


def test_convergence_is_quadratic():
    outcome = run(program(lambda a, b: a**2 + b**2, lambda a, b: a * b == 3), (2, 1))
    errors = outcome.iterations["step_norm"][2:]
    errors = errors[(errors > 1e-13) & (errors < 0.5)]
    assert len(errors) >= 2
    assert (np.log(errors[1:]) <= 1.7 * np.log(errors[:-1])).all()


def test_a_fixed_variable_stays():
    outcome = run(program(lambda a, b: (a - 1) ** 2 + (b - a) ** 2), (0, 0), lower=(3, -np.inf), upper=(3, np.inf))
    assert outcome.z == pytest.approx([3, 3], abs=1e-12)


def test_line_search_reaches_where_full_steps_overshoot():
    nlp = program(lambda a, b: log(exp(a) + exp(-a)) + b**2)
    assert run(nlp, (3, 0), max_iter=30).status is not Status.SOLVED
    outcome = run(nlp, (3, 0), line_search="yes", max_iter=30)
    assert outcome.status is Status.SOLVED
    assert outcome.z == pytest.approx([0, 0], abs=1e-9)


def test_constraints_that_repeat_each_other_have_no_step():
    nlp = program(lambda a, b: a**2 + b**2, lambda a, b: a + b == 1, lambda a, b: 2 * a + 2 * b == 2)
    assert run(nlp, (0, 0)).status is Status.STEP_FAILED


def test_iteration_limit_and_interruption():
    nlp = program(lambda a, b: a**2 + b**2, lambda a, b: a * b == 3)
    assert run(nlp, (2, 1), max_iter=1).status is Status.MAX_ITERATIONS
    free = np.full(2, np.inf)
    assert newton.solve_program(nlp, np.ones(2), -free, free, stop=lambda: True).status is Status.INTERRUPTED


def test_a_function_without_value_is_named():
    outcome = run(program(lambda a, b: log(a) + b**2), (-1, 0))
    assert outcome.status is Status.INVALID_NUMBER
    assert outcome.failed[1] == [("cost", None)]


def test_inequalities_bounds_and_unknown_options_are_refused():
    with pytest.raises(SpecError, match="g0 is an inequality"):
        run(program(lambda a, b: a**2, lambda a, b: a + b >= 1), (0, 0))
    with pytest.raises(SpecError, match="no bounds on variables"):
        run(program(lambda a, b: a**2), (0, 0), lower=(-1, -np.inf))
    with pytest.raises(SpecError, match="no such option"):
        run(program(lambda a, b: a**2), (0, 0), mu_strategy="adaptive")


@pytest.mark.parametrize("matrix, expected", [
    ([[2.0, 1.0], [1.0, 3.0]], [0.4, 0.2]),
    ([[1.0, 2.0], [2.0, 4.0]], None),  # by its numbers
    ([[1.0, 1.0, 1.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]], None),  # whatever its numbers are: two rows, one column
    ([[1.0, 0.0], [0.0, 0.0]], None),  # an empty row
])  # fmt: skip
def test_a_singular_system_has_no_solution(matrix, expected):
    found = linear.solved(csc_matrix(matrix), np.ones(len(matrix)))
    assert found is None if expected is None else found == pytest.approx(expected, rel=1e-12)
