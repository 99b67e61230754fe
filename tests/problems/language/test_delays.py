"""States at earlier times: the optimum of the method of steps, the order of each method, costates, what is refused."""

import numpy as np
import pytest
from command_line import trajopt as run
from scipy.integrate import solve_bvp

import trajopt
from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load
from trajopt.transcription.collocation.delays import delay_rows, interpolation
from trajopt.transcription.loading import load_yaml
from trajopt.transcription.settings import Step
from trajopt.transcription.solve import solve
from trajopt.transcription.transcribe import program, transcribe

SYSTEM = shipped()["delayed_system"].read_text()


@pytest.fixture(scope="module")
def exact():
    """J and lambda(0) of `delayed_system`: x = x1 on [0, 1] and x2 on [1, 2], H = x'x + u'u + lambda (dynamics)."""

    def slopes(s, y):
        x1, x2, l1, l2 = y
        return np.array(
            [s * x1 + 1 - l1 / 2, (1 + s) * x2 + x1 - l2 / 2, -2 * x1 - s * l1 - l2, -2 * x2 - (1 + s) * l2]
        )

    def ends(a, b):
        return np.array([a[0] - 1, a[1] - b[0], b[2] - a[3], b[3]])

    found = solve_bvp(slopes, ends, np.linspace(0, 1, 50), np.ones((4, 50)), tol=1e-11, max_nodes=5000)
    nodes, weights = np.polynomial.legendre.leggauss(40)
    x1, x2, l1, l2 = found.sol((nodes + 1) / 2)
    return float(weights @ (x1**2 + x2**2 + (l1**2 + l2**2) / 4) / 2), float(found.y[2, 0])


def errors(exact, method, degree, segments):
    """Of J and of lambda(0), on each mesh."""
    problem, found = build(load_yaml(SYSTEM)), []
    for n in segments:
        solution = solve(problem, [Step(method, n, 1e-12, degree=degree)])
        costate = float(solution.trajectories[0].costate[0, 0])
        found.append((abs(solution.objective - exact[0]), abs(costate - exact[1])))
        assert found[-1][0] <= solution.objective_error.bar
    return np.array(found)


@pytest.mark.parametrize(
    ("method", "degree", "orders"),
    [("trapezoid", None, (2, 2)), ("midpoint", None, (2, 2)), ("hermite-simpson", None, (4, 3)),
     ("gauss", 2, (4, 4)), ("radau", 2, (3, 3)), ("radau-left", 2, (3, 3)), ("lobatto", 3, (4, 3))],
)  # fmt: skip
def test_with_knots_at_the_delay_a_method_keeps_its_order(exact, method, degree, orders):
    found = errors(exact, method, degree, (8, 16, 32))
    slopes = np.log2(found[-2] / found[-1])
    assert (slopes > np.array(orders) - 0.25).all(), slopes


@pytest.mark.parametrize(("method", "degree"), [("hermite-simpson", None), ("gauss", 4), ("radau", 3)])
def test_without_them_the_order_is_two_and_the_error_bar_holds(exact, method, degree):
    found = errors(exact, method, degree, (9, 17, 33))
    assert np.log2(found[-2, 0] / found[-1, 0]) > 1.6


@pytest.mark.parametrize(("name", "degree"), [("gauss", 3), ("radau", 4), ("lobatto", 5), ("trapezoid", None)])
def test_the_rows_are_the_interpolant_of_the_scheme(name, degree):
    """Exact for polynomials of the degree that the state has, in between and at the nodes."""
    scheme = Step(name, 1, 1e-8, degree=degree).mesh().schemes[0]
    theta = np.array([0.0, 0.13, 0.5, 0.87, 1.0])
    A, G = interpolation(scheme, theta)
    for k in range(len(scheme.c) + 1):
        slope = float(k == 1)
        assert A @ scheme.sigma**k + G * slope == pytest.approx(theta**k, abs=1e-12)


def test_which_points_see_the_history_and_who_owns_a_row():
    mesh = Step("hermite-simpson", 4, 1e-8).mesh()
    past, rows = delay_rows(mesh, 0.25)
    assert past.tolist() == [0, 1] and rows.point.tolist() == [2, 3, 4, 5, 6, 7, 8]
    assert rows.knot.tolist() == [0, -1, 1, -1, 2, -1, 3]
    assert rows.before.tolist() == [0.5] * 6 + [1.0] and rows.after[-1] == 0
    past, rows = delay_rows(
        Step("radau", 4, 1e-8, degree=2).mesh(), 0.25
    )  # its points look back from the end of a segment
    assert past.tolist() == [1, 2] and rows.segment.tolist() == [0, 0, 1, 1, 2, 2]


def test_derivatives_are_exact():
    """Those of the compiled program, against central differences of its own values."""
    text = SYSTEM.replace("x(t - tau) + u", "x(t - 0.3)**2*x + sin(x(t - tau)) + u").replace(
        "gauss, degree: 6", "lobatto, degree: 4"
    )
    problem = build(load_yaml(text))
    mesh = [Step("lobatto", 3, 1e-8, degree=4).mesh()]
    _, nlp, _ = program(problem, mesh)
    rng = np.random.default_rng(1)
    z, y = rng.uniform(0.5, 1.5, nlp.n), rng.uniform(-1, 1, nlp.m)
    dense = np.zeros((nlp.m, nlp.n))
    np.add.at(dense, nlp.jacobianstructure(), nlp.jacobian(z))
    step = 1e-6
    for j in range(nlp.n):
        e = np.eye(nlp.n)[j] * step
        assert (nlp.constraints(z + e) - nlp.constraints(z - e)) / (2 * step) == pytest.approx(dense[:, j], abs=2e-8)
    assert np.count_nonzero(dense.any(axis=0)) == nlp.n and y.size == nlp.m


def test_a_delay_longer_than_the_horizon_is_the_history_alone():
    text = SYSTEM.replace("value: 1, unit: s", "value: 3, unit: s").replace("history: 1", "history: 2*t")
    plain = (
        SYSTEM.replace("x(t - tau)", "2*(t - 3)")
        .replace(", history: 1", "")
        .replace("  tau: {value: 1, unit: s}", "  a: 1")
    )
    late, known = (trajopt.solve(trajopt.load(own)).objective for own in (text, plain))
    assert late == pytest.approx(known, rel=1e-10)


def test_sensitivities_are_costates_and_that_to_the_delay_is_not_known(exact):
    spec = load_yaml(SYSTEM)
    solution = solve(build(spec), [Step("gauss", 4, 1e-10, degree=6)])
    own = {s.path: s for s in solution.sensitivities.all}
    assert own["states.x.initial"].derivative == pytest.approx(exact[1], rel=1e-8)
    assert np.isnan(own["parameters.tau"].derivative) and "not known" in own["parameters.tau"].note


def test_results_verify_hold_and_are_read_back(tmp_path):
    path = tmp_path / "late.h5"
    assert run("solve", "delayed_regulator", "-q", "-o", path).exit_code == 0
    told = run("verify", path, "--sample-hold", "0.05")
    assert told.exit_code == 0 and "not looked at: with delays it is not constant" in told.stdout
    solution = trajopt.read(path)
    assert solution["x(t - tau)"](1.0) == pytest.approx(float(solution["x"](0.75)), abs=1e-12)
    assert solution["v(t - tau)"](0.1) == 1.0
    assert run("solve", "delayed_regulator", "-q", "--guess", path, "-o", tmp_path / "again.h5").exit_code == 0


@pytest.mark.parametrize(
    ("overrides", "says"),
    [(["mesh.0.method=runge-kutta-4", "mesh.0.degree="], "runge-kutta-4 cannot take a state at an earlier time"),
     (["mesh.0.method=hermite-simpson-compressed", "mesh.0.degree="], "has no unknowns in the middle of a segment"),
     (["guess=simulate"], "a guess is not simulated with states at earlier times")],
)  # fmt: skip
def test_what_delays_are_not_for_is_refused(overrides, says):
    with pytest.raises(SpecError) as error:
        problem = build(load_yaml(SYSTEM, overrides))
        transcribe(problem, [Step(load_yaml(SYSTEM, overrides).mesh[0].method, 4, 1e-8).mesh()])
    assert any(says in str(mistake) for mistake in error.value.mistakes), str(error.value)


def test_a_history_that_nobody_asks_for_is_a_warning():
    spec = load_yaml(SYSTEM.replace("x(t - tau)", "x*tau"))
    assert any("the history of x is used nowhere" in str(w) for w in spec.warnings)


def test_units_of_delays_and_histories():
    text = SYSTEM.replace("{rate: t*x", "{unit: m, rate: t*x").replace("history: 1", "history: tau")
    with pytest.raises(SpecError, match='x is in m, and "tau" in s'):
        load_yaml(text, units=True)


def test_the_delay_of_a_velocity_has_its_history():
    spec = load(shipped()["delayed_regulator"])
    text = spec.text.replace("  v: {rate: -10*x", "  w: {rate: -10*x")
    assert text != spec.text
    accel = "u - 10*x - 5*v - 2*x(t - tau) - v(t - tau)"
    velocity = "velocity: {name: v, initial: 1, history: 1}"
    second = text.replace(
        "{rate: v, initial: 1, history: 1}", f"{{accel: {accel}, initial: 1, history: 1, {velocity}}}"
    )
    lines = [line for line in second.splitlines() if not line.startswith("  w: ")]
    assert trajopt.solve(trajopt.load("\n".join(lines))).objective == pytest.approx(2.5257246889, abs=1e-8)


STEPS = """\
trajopt: 1
time: {initial: 0, final: 10}
states:
  x: {next: "x + u + 0.3*x(t - 2) - 0.1*x(t - 1)*x(t - 3)", initial: 3, history: cos(t)}
controls: {u: {lower: -1, upper: 1}}
objective: {minimize: {sum: u**2 + x**2}}
"""
WRITTEN_OUT = """\
trajopt: 1
time: {initial: 0, final: 10}
states:
  x: {next: "x + u + 0.3*b - 0.1*a*c", initial: 3}
  a: {next: x, initial: cos(-1)}
  b: {next: a, initial: cos(-2)}
  c: {next: b, initial: cos(-3)}
controls: {u: {lower: -1, upper: 1}}
objective: {minimize: {sum: u**2 + x**2}}
"""


def test_in_discrete_time_a_delay_is_a_chain_of_states(tmp_path):
    late, chain = (trajopt.solve(trajopt.load(own)) for own in (STEPS, WRITTEN_OUT))
    assert late.objective == pytest.approx(chain.objective, rel=1e-9)
    assert late.costate["x"].values == pytest.approx(chain.costate["x"].values, abs=1e-7)
    late.save(tmp_path / "late.h5")
    told = run("verify", tmp_path / "late.h5")
    assert told.exit_code == 0 and "costate equation" in told.stdout


@pytest.mark.parametrize("lag", ["1.5", "0.5", "2*1.25"])
def test_in_discrete_time_a_delay_is_a_whole_number(lag):
    with pytest.raises(SpecError, match=r"a state has values at whole steps, and the delay is [\d.]+; make it \d"):
        load_yaml(STEPS.replace("x(t - 2)", f"x(t - {lag})"))
