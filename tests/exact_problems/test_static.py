"""Problems without time: exact optima, multipliers, what kind of program it is, and what verify can tell."""

import numpy as np
import pytest
from command_line import strict_json, trajopt

from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.results.file.reload import reload
from trajopt.results.file.write import write
from trajopt.results.verify import verify
from trajopt.transcription.continuation import solve_spec

HYPERBOLA = """\
trajopt: 1
parameters: {c: 3}
optimize:
  x1: {guess: 1}
  x2: {guess: 2}
objective: {minimize: x1**2 + x2**2}
constraints:
  - {name: hyperbola, expression: x1*x2, equals: c}
"""


def solved(text, *overrides):
    spec = load_text(text, "static.yaml", overrides)
    return solve_spec(spec, [build(spec)])


def written(text, folder, name="static"):
    (folder / f"{name}.yaml").write_text(text)
    assert trajopt("solve", folder / f"{name}.yaml", "-q", "-o", folder / f"{name}.h5").exit_code == 0
    return folder / f"{name}.h5"


@pytest.mark.parametrize("c", [3.0, 0.5])
def test_the_multiplier_of_the_hyperbola(c):
    solution = solved(HYPERBOLA, f"parameters.c={c}")
    assert solution.objective == pytest.approx(2 * c, abs=1e-9)
    assert abs(solution.objective - 2 * c) <= solution.objective_error.bar
    assert solution.prices[0]["hyperbola"] == pytest.approx(2.0, abs=1e-7)  # dJ/dc
    assert solution.program == ""


def test_newton_on_the_kkt_system_finds_the_same():
    solution = solved(HYPERBOLA, "solver.engine=newton")
    assert solution.objective == pytest.approx(6, abs=1e-10)


def test_the_roots_of_the_introduction():
    text = "{trajopt: 1, optimize: {x1: {guess: -3}, x2: {guess: %s}}, constraints: [%s, %s]}"
    first, second = "{expression: x1 + x2**2, equals: 0}", "{expression: 2*x2 + 4, equals: 0}"
    values = solved(text % (-1, first, second)).trajectories[0].parameters
    assert values == pytest.approx({"x1": -4, "x2": -2})
    for guess, root in ((1, (1 + 21**0.5) / 4), (-1, (1 - 21**0.5) / 4)):
        values = solved(text % (guess, first, "{expression: 4*x1 + 2*x2 + 5, equals: 0}")).trajectories[0].parameters
        assert values["x2"] == pytest.approx(root, abs=1e-9)


def quadratic(H, g, A, b):
    """min x'Hx/2 + g'x, A x <= b, as a file."""
    names = [f"x{i}" for i in range(len(g))]
    terms = [f"{H[i, j] / 2}*{a}*{c}" for i, a in enumerate(names) for j, c in enumerate(names)]
    terms += [f"{value}*{name}" for value, name in zip(g, names, strict=True)]
    rows = [" + ".join(f"{value}*{name}" for value, name in zip(row, names, strict=True)) for row in A]
    constraints = ", ".join(f"{{expression: {row}, upper: {bound}}}" for row, bound in zip(rows, b, strict=True))
    optimize = ", ".join(f"{name}: {{lower: -10, upper: 10, guess: 0.3}}" for name in names)
    objective = " + ".join(terms)
    return f"""{{trajopt: 1, optimize: {{{optimize}}}, constraints: [{constraints}],
      objective: {{minimize: '{objective}'}}}}"""


def test_linear_and_quadratic_programs_are_those_of_scipy():
    from scipy.optimize import linprog

    random = np.random.default_rng(4)
    A, b = random.normal(size=(6, 4)).round(3), random.uniform(1, 3, 6).round(3)
    g = random.normal(size=4).round(3)
    linear = solved(quadratic(np.zeros((4, 4)), g, A, b))
    exact = linprog(g, A, b, bounds=(-10, 10))
    assert linear.objective == pytest.approx(exact.fun, abs=1e-6)
    assert [*linear.prices[0].values()][:6] == pytest.approx(exact.ineqlin.marginals, abs=1e-6)
    assert linear.program == "linear program: the optimum is global"
    M = random.normal(size=(4, 4)).round(3)
    assert solved(quadratic(M @ M.T, g, A, b)).program == "convex quadratic program: the optimum is global"
    shifted = M @ M.T - 1.1 * np.linalg.eigvalsh(M @ M.T)[1] * np.eye(4)
    assert "not convex" in solved(quadratic(shifted, g, A, b)).program


def test_a_program_that_is_convex_along_its_equations_only_is_convex():
    text = """{trajopt: 1, optimize: {x: {}, y: {}}, objective: {minimize: x*y},
      constraints: [{expression: x - y, equals: 1}]}"""
    solution = solved(text)
    assert solution.program.startswith("convex") and solution.objective == pytest.approx(-0.25, abs=1e-9)


@pytest.mark.parametrize("term", ["step(x - 100, 0.01)", "exp(x)", "x**3"])
def test_what_only_looks_linear_is_not_called_so(term):
    text = f"{{trajopt: 1, optimize: {{x: {{lower: 0, upper: 1}}}}, objective: {{minimize: '{term}'}}}}"
    assert solved(text).program == ""


def test_the_quadratic_program_of_a_mesh_is_recognised():
    """The one of the paper's section 2.5."""
    text = """{trajopt: 1, time: {initial: 0, final: %s}, states: {x: {rate: v, initial: 0, final: 1},
      v: {rate: u, initial: 0, final: 0}}, controls: {u: {}}, objective: {minimize: {integral: u**2}},
      mesh: [{method: trapezoid, segments: 8}]}"""
    assert solved(text % 1).program == "convex quadratic program: the optimum on this mesh is global"
    assert solved(text % "{lower: 1, upper: 2}").program == ""


def test_verify_passes_a_minimum(tmp_path):
    checks = {check.name: check for check in verify(written(HYPERBOLA, tmp_path))}
    assert all(check.passed for check in checks.values())
    assert {"stationarity dL/dx1, relative", "d2L/dz2 without negative eigenvalues, relative"} <= checks.keys()


@pytest.mark.parametrize(
    ("objective", "failing"),
    [
        ("y**2 - x**2 + x**4", "d2L/dz2 without negative eigenvalues"),  # stationary at the guess, a saddle
        ("(x - y)**2 - 2*x*y + x**4 + y**4", "d2L/dz2 without negative eigenvalues"),
        ("(x**2 - 1)**2*(1 + y**2) + 0.3*x + 0*y", "no better objective from other starts"),
    ],
)
def test_verify_fails_what_is_no_minimum_or_the_lesser_one(tmp_path, objective, failing):
    guess = 1 if "0.3" in objective else 0
    text = f"""{{trajopt: 1, objective: {{minimize: '{objective}'}},
      optimize: {{x: {{lower: -2, upper: 2, guess: {guess}}}, y: {{lower: -2, upper: 2, guess: 0}}}}}}"""
    spec = load_text(text, "static.yaml")
    problem = build(spec)
    only = solve_spec(spec, [problem], guess=[phase.guess for phase in problem.phases])  # a start that is given
    write(tmp_path / "only.h5", only, spec.text, spec.model_dump_json(), "a test")
    failed = [check.name for check in verify(tmp_path / "only.h5") if not check.passed]
    assert any(name.startswith(failing) for name in failed), failed
    assert solved(text).objective < only.objective - 0.1  # other starts are tried without being asked for


def test_verify_sees_a_wrong_multiplier(tmp_path):
    import h5py

    path = written(HYPERBOLA, tmp_path)
    with h5py.File(path, "r+") as file:
        file["solver/y"][:] *= 1.01
    failed = [check.name for check in verify(path) if not check.passed]
    assert any(name.startswith("stationarity") for name in failed)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("static")
    written(HYPERBOLA, folder, "hyperbola")
    return folder


def test_the_table_and_json_have_the_point_and_its_prices(folder):
    told = trajopt("show", folder / "hyperbola.h5").stdout
    assert "point       x1 = 1.732050808, x2 = 1.732050808" in told and "prices      hyperbola 2" in told
    assert "2 unknowns, 1 constraint" in told and "mesh" not in told.split("\n\n")[0]
    shown = strict_json(trajopt("show", folder / "hyperbola.h5", "--json").stdout)
    phase = shown["phases"]["main"]
    assert phase["kind"] == "static" and phase["prices"]["hyperbola"] == pytest.approx(2)


def test_it_is_compared_drawn_exported_and_a_guess(folder, monkeypatch):
    monkeypatch.chdir(folder)
    other = trajopt("solve", "hyperbola.yaml", "-q", "--guess", "hyperbola.h5", "--tol", "1e-11", "-o", "other.h5")
    assert other.exit_code == 0, other.output
    assert "static" in trajopt("compare", "hyperbola.h5", "other.h5").stdout
    assert trajopt("plot", "hyperbola.h5").exit_code == 0 and (folder / "hyperbola.png").stat().st_size > 10_000
    assert trajopt("export", "hyperbola.yaml", "h.tex").exit_code == 0
    tex = (folder / "h.tex").read_text()
    assert "Constraint hyperbola" in tex and "t_{0}" not in tex
    assert trajopt("explain", "hyperbola.yaml").exit_code == 0
    swept = trajopt("sweep", "hyperbola.yaml", "--over", "parameters.c=1,2", "-q", "-o", "s", "--jobs", "1")
    assert swept.exit_code == 0


@pytest.mark.parametrize("option", [("--method", "gauss"), ("--segments", "5"), ("--refine", "1e-8")])
def test_there_is_no_mesh_to_choose(folder, option):
    run = trajopt("solve", folder / "hyperbola.yaml", *option)
    assert run.exit_code == 2 and f"{option[0]}: a problem without time has no mesh" in run.stderr


def test_other_numbers_of_unknowns_have_no_picture(tmp_path):
    path = written("{trajopt: 1, optimize: {x: {guess: 3}}, objective: {minimize: x**2}}", tmp_path)
    run = trajopt("plot", path, "-o", tmp_path / "x.png")
    assert run.exit_code == 2 and "there is no time to draw anything over" in run.stderr


def test_what_cannot_hold_is_told(tmp_path):
    text = "{trajopt: 1, optimize: {x: {}}, constraints: [{name: a, expression: x**2, upper: -1}]}"
    (tmp_path / "no.yaml").write_text(text)
    run = trajopt("solve", tmp_path / "no.yaml", "-o", tmp_path / "no.h5")
    assert run.exit_code == 1 and "constraint 'a' from -1 to" in run.stdout
    assert not reload(tmp_path / "no.h5").solved


def test_maximum_prices_have_the_sign_of_the_objective():
    text = """{trajopt: 1, optimize: {a: {lower: 0}, b: {lower: 0}}, objective: {maximize: 3*a + 5*b},
      constraints: [{expression: a, upper: 4}, {name: two, expression: 2*b, upper: 12},
        {name: three, expression: 3*a + 2*b, upper: 18}]}"""
    solution = solved(text)
    assert solution.objective == pytest.approx(36, abs=1e-7)
    prices = solution.prices[0]
    assert (prices["two"], prices["three"], prices["a"]) == pytest.approx((1.5, 1.0, 0.0), abs=1e-6)


def test_the_table_of_a_problem_without_time(folder):
    """Nothing in it has a time; what is printed has none either."""
    printed = trajopt("solve", "hyperbola").stdout
    assert printed.startswith("nearest point of a hyperbola: solved\n") and "\npoint       x1 = 1.73205" in printed
    assert "t =" not in printed
