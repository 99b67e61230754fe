"""Measurements: exact solutions, every kind of method, the order of estimates, knots, what results hold."""

import json

import broken
import numpy as np
import pyomo.core as pyomo
import pytest
from derivatives import check_derivatives
from scipy.interpolate import make_smoothing_spline
from typer.testing import CliRunner

from trajopt.cli.app import app
from trajopt.problems.build import build
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load, load_text
from trajopt.results.file.read import read
from trajopt.results.file.write import write
from trajopt.results.pictures.plots import trajectory_figure
from trajopt.results.verify import verify
from trajopt.transcription.layout import bounded_start
from trajopt.transcription.measured.knots import knots_at, measured_fractions, with_knots
from trajopt.transcription.schemes.mesh import Mesh
from trajopt.transcription.schemes.table import find
from trajopt.transcription.settings import meshes_of, schedule_of, settings_of
from trajopt.transcription.solve import solve
from trajopt.transcription.transcribe import compiled, program, transcribe

NONLINEAR = """\
trajopt: 1
time: {initial: 0.5, final: 2}
states: {x: {rate: -a*x**2 + u, initial: 1}, y: {rate: x - b*y}}
controls: {u: {}}
optimize: {a: {guess: 0.5}, b: {guess: 0.7}}
expressions: {both: x*y}
measurements:
  first:
    data: {time: [0.5, 0.8, 1.3, 2], x: [1, 0.9, null, 0.5], both: [0.1, 0.2, 0.3, 0.4], s: [0.1, 0.1, 0.2, 0.3]}
    deviations: {x: 0.1, both: s}
  second: {data: {time: [0.9, 1.3, 1.3], q: [0.2, 0.5, 0.6]}, compare: {q: "a*y**2*sin(t) + x"}, deviations: 0.2}
objective: {minimize: {integral: 0.1*u**2}}
mesh: [{method: METHOD, segments: 3}]
"""

PHASES = NONLINEAR.replace("measurements:\n", "phases:\n  one:\n    time: {final: 2}\n    measurements:\n")
PHASES = PHASES.replace("\n    d", "\n        d").replace("  first", "      first").replace("  second", "      second")
PHASES = PHASES.replace(
    "objective: {min", "  two: {time: {final: 3}, mesh: [{method: runge-kutta-4, segments: 2}]}\nobjective: {min"
)


def transcribed(text):
    spec = load_text(text, "measured.yaml")
    problem = build(spec)
    return problem, meshes_of(problem, schedule_of(spec)[-1])


def solution_of(text, *overrides):
    spec = load_text(text, "measured.yaml", overrides)
    return solve(build(spec), schedule_of(spec), settings_of(spec)), spec


@pytest.mark.parametrize(
    "method", ["radau", "gauss", "hermite-simpson-compressed", "trapezoid", "runge-kutta-4", "phases"]
)
def test_derivatives_are_exact(method):
    text = PHASES.replace("METHOD", "radau") if method == "phases" else NONLINEAR.replace("METHOD", method)
    problem, meshes = transcribed(text)
    found, nlp, _ = program(problem, meshes)
    z = bounded_start(found)[0]
    check_derivatives(nlp, z + 0.1 * np.random.default_rng(1).standard_normal(len(z)))


def test_what_is_exported_is_the_same_objective():
    problem, meshes = transcribed(NONLINEAR.replace("METHOD", "hermite-simpson"))
    written, solved = transcribe(problem, meshes, templates=False), transcribe(problem, meshes)
    nlp, z = compiled(solved), bounded_start(solved)[0]
    assert pyomo.value(written.model.cost) == pytest.approx(nlp.objective(z), rel=1e-14)


TIMES = np.array([0, 0.1, 0.25, 0.4, 0.55, 0.8, 1])
VALUES = np.array([0, 0.8, 0.3, 0.9, 1.4, 0.2, 0.7])
SPLINE = f"""\
trajopt: 1
time: {{initial: 0, final: 1}}
states: {{x: {{rate: v}}, v: {{rate: u}}}}
controls: {{u: {{}}}}
measurements: {{d: {{data: {{time: {TIMES.tolist()}, x: {VALUES.tolist()}}}}}}}
objective: {{minimize: {{integral: 0.001*u**2}}}}
mesh: [{{method: METHOD, segments: 4}}]
"""


@pytest.mark.parametrize("method", ["radau", "gauss", "hermite-simpson", "lobatto", "runge-kutta-4"])
def test_a_smoothing_spline(method, tmp_path):
    """The curve of least squares and least second derivative is a natural cubic spline, which SciPy has as well."""
    spline = make_smoothing_spline(TIMES, VALUES, lam=0.001)
    u = spline.derivative(2)(TIMES)
    bent = (np.diff(TIMES) * (u[:-1] ** 2 + u[:-1] * u[1:] + u[1:] ** 2) / 3).sum()
    solution, spec = solution_of(SPLINE.replace("METHOD", method))
    (trajectory,) = solution.trajectories
    at = trajectory.at(TIMES)
    assert solution.objective == pytest.approx(((spline(TIMES) - VALUES) ** 2).sum() + 0.001 * bent, rel=1e-9)
    np.testing.assert_allclose(at.x[0], spline(TIMES), atol=1e-8)
    np.testing.assert_allclose(at.u[0], u, atol=1e-5)
    assert solution.objective_error.bar < 1e-8
    write(tmp_path / "a.h5", solution, spec.text, spec.model_dump_json(), "x")
    assert [check for check in verify(tmp_path / "a.h5") if not check.passed] == []


STEPS = SPLINE.replace("states: {x: {rate: v}, v: {rate: u}}", "states: {x: {rate: u}}")


@pytest.mark.parametrize(
    "method", ["radau", "radau-left", "gauss", "midpoint", "lobatto", "hermite-simpson", "trapezoid"]
)
def test_a_control_that_jumps_where_something_is_measured(method):
    """x' = u: u is constant between two times, and a linear system gives the values there. Methods whose segments share
    the control at a knot cannot jump there; their error bar says how far off they are."""
    h, n = np.diff(TIMES), len(TIMES)
    K = np.zeros((n, n))
    for i in range(n - 1):
        K[i : i + 2, i : i + 2] += 0.001 / h[i] * np.array([[1, -1], [-1, 1]])
    x = np.linalg.solve(K + np.eye(n), VALUES)
    exact = x @ K @ x + ((x - VALUES) ** 2).sum()
    solution, _ = solution_of(STEPS.replace("METHOD", method))
    shared = method in ("lobatto", "hermite-simpson", "trapezoid")
    assert abs(solution.objective - exact) <= solution.objective_error.bar
    assert shared or solution.objective == pytest.approx(exact, rel=1e-9)
    (trajectory,) = solution.trajectories
    mesh, inner = trajectory.mesh, knots_at(trajectory.mesh, TIMES[1:-1])
    jump = trajectory.costate[0, mesh.offset[inner] - 1] - trajectory.costate[0, mesh.offset[inner]]
    residuals = trajectory.x[0, mesh.knots[inner]] - VALUES[1:-1]
    np.testing.assert_allclose(jump, 2 * residuals, atol=1e-9)


DECAY = """\
trajopt: 1
time: {initial: 0, final: 2}
states: {x: {rate: -k*x, initial: 1}}
optimize: {k: {guess: 1}}
measurements: {d: {data: {time: [2], x: [0.05]}}}
mesh: [{method: METHOD, segments: 4, tolerance: 1e-12DEGREE}]
"""


@pytest.mark.parametrize(
    ("method", "degree", "order"),
    [
        ("trapezoid", None, 2),
        ("hermite-simpson", None, 4),
        ("radau", 2, 3),
        ("gauss", 2, 4),
        ("runge-kutta-4", None, 4),
    ],
)
def test_an_estimate_has_the_order_of_the_method_at_the_knots(method, degree, order):
    text = DECAY.replace("METHOD", method).replace("DEGREE", f", degree: {degree}" if degree else "")
    exact, errors = -np.log(0.05) / 2, []
    for segments in (8, 16):
        solution, _ = solution_of(text, f"mesh.0.segments={segments}")
        errors.append(abs(solution.trajectories[0].parameters["k"] - exact))
    assert np.log2(errors[0] / errors[1]) > order - 0.3


def test_knots_stand_at_the_times_and_slivers_do_not():
    for seed in range(50):
        rng = np.random.default_rng(seed)
        mesh = Mesh.of(find("radau", 3), rng.uniform(0.5, 2, rng.integers(1, 12)))
        s = np.sort(rng.uniform(0, 1, rng.integers(1, 12)))
        found = with_knots(mesh, s)
        assert (knots_at(found, s) >= 0).all()
        others = np.setdiff1d(found.edges, s)
        assert set(others) <= set(mesh.edges) and found.segments <= mesh.segments + len(s)


def test_refinement_leaves_the_knots_where_they_are():
    text = NONLINEAR.replace("METHOD", "hermite-simpson").replace(
        "segments: 3}", "segments: 3}\nrefine: {tolerance: 1e-8"
    )
    solution, _ = solution_of(
        text.replace(
            "mesh: [{method: hermite-simpson, segments: 3}", "mesh: [{method: hermite-simpson, segments: 3}]"
        ).replace("1e-8]", "1e-8}")
    )
    s = measured_fractions(solution.problem.phases[0])
    assert len(solution.meshes) > 1 and all((knots_at(record.mesh, s) >= 0).all() for record in solution.meshes)


def test_a_result_has_the_data_and_shows_them(tmp_path):
    solution, spec = solution_of(NONLINEAR.replace("METHOD", "radau"))
    write(tmp_path / "a.h5", solution, spec.text, spec.model_dump_json(), "x")
    result = read(tmp_path / "a.h5")
    (phase,) = result.phases
    assert [own.name for own in phase.measured] == ["first.x", "first.both", "second.q"]
    assert phase.measured[0].time.tolist() == [0.5, 0.8, 2] and phase.measured[1].deviation.tolist() == [
        0.1,
        0.1,
        0.2,
        0.3,
    ]
    total = sum((((own.model - own.value) / own.deviation) ** 2).sum() for own in phase.measured)
    assert total == pytest.approx(solution.estimates.residuals)
    lines = [line for ax in trajectory_figure(result).axes for line in ax.lines if line.get_label() == "measured"]
    assert sorted(len(line.get_xdata()) for line in lines) == [3, 4]
    xarray = pytest.importorskip("xarray")
    with xarray.open_datatree(tmp_path / "a.h5") as tree:
        assert float(tree["phase/main/measured/first.x"]["value"][1]) == 0.9
        assert tree["estimates"]["correlation"].shape == (2, 2)


def test_a_command_prints_and_gives_the_estimates(folder):
    (folder / "decay.yaml").write_text(
        DECAY.replace("METHOD", "radau")
        .replace("DEGREE", "")
        .replace("time: [2], x: [0.05]", "time: [1, 2], x: [0.2, 0.05]")
    )
    run = CliRunner().invoke(app, ["solve", "decay.yaml"])
    assert run.exit_code == 0 and "estimate    k = " in run.stdout and "2 measurements, 1 unknown;" in run.stdout
    shown = json.loads(CliRunner().invoke(app, ["show", "decay.h5", "--json"]).stdout)["estimates"]
    assert shown["parameters"]["k"]["standard_error"] > 0 and shown["correlation"] == {"k": {"k": 1.0}}


def test_experiments_do_not_go_on_in_each_other():
    with pytest.raises(SpecError, match="and should go on"):
        build(load_text(stored_experiments().replace("links: none\n", ""), "x.yaml"))
    problem = build(load_text(stored_experiments(), "x.yaml"))
    assert not problem.links and all(phase.initial_time.lower == 0 for phase in problem.phases)


@pytest.mark.parametrize("name", broken.BAD_MEASURED)
def test_a_broken_csv_file(name, tmp_path):
    content, says = broken.BAD_MEASURED[name]
    (tmp_path / "data.csv").write_bytes(content)
    path = tmp_path / "problem.yaml"
    path.write_text(broken.MEASURED.replace("data: {time: [0, 1, 2], x: [0, 0.4, 1]}", "file: data.csv"))
    with pytest.raises(SpecError) as error:
        load(path, (), broken.METHODS)
    sentences = [str(mistake) for mistake in error.value.mistakes]
    assert len(sentences) == 1 and says in sentences[0], "\n".join(sentences)
    assert sentences[0].startswith(f"{path}:20: measurements.run.file")


@pytest.mark.parametrize("name", ["t", "time"])
@pytest.mark.parametrize("inline", [True, False])
def test_the_column_of_times_has_two_names_wherever_it_is_named(name, inline, tmp_path):
    (tmp_path / "run.csv").write_text(f"{name},x\n0.5,1\n1,2\n")
    given = f"data: {{{name}: [0.5, 1], x: [1, 2]}}" if inline else "file: run.csv"
    (tmp_path / "a.yaml").write_text(f"""
trajopt: 1
time: {{initial: 0, final: 2, unit: h}}
states: {{x: {{rate: k*x, initial: 1, unit: g}}}}
optimize: {{k: {{guess: 0.1}}}}
measurements: {{run: {{{given}, units: {{{name}: h, x: g}}}}}}
""")
    own = load(tmp_path / "a.yaml").measurements["run"]
    assert own.data == {"time": [0.5, 1], "x": [1, 2]} and own.units == {"time": "h", "x": "g"}


def test_missing_cells_and_columns_that_count_for_nothing(tmp_path):
    (tmp_path / "data.csv").write_text("time,x,v,marker\n0,0,0,1\n1,,0.4,2\n2,1,,3\n")
    path = tmp_path / "problem.yaml"
    path.write_text(broken.MEASURED.replace("data: {time: [0, 1, 2], x: [0, 0.4, 1]}", "file: data.csv"))
    spec = load(path, (), broken.METHODS)
    assert [w.what for w in spec.warnings] == ["columns count for nothing: marker"]
    assert [own.values.tolist() for own in build(spec).phases[0].measured] == [[0, 1], [0, 0.4]]


@pytest.mark.parametrize(
    ("of_third", "idle"), [("", ["c, marker"]), ("  z: {file: a.csv, compare: {c: x}}\n", ["marker"])]
)
def test_a_column_counts_that_another_entry_of_the_same_file_compares(tmp_path, of_third, idle):
    (tmp_path / "a.csv").write_text("time,a,b,c,marker,s\n1,1,2,3,0,0.1\n2,0.4,1,2,0,0.2\n")
    path = tmp_path / "problem.yaml"
    path.write_text(f"""\
trajopt: 1
time: {{initial: 0, final: 2}}
states: {{x: {{rate: -k*x, initial: 2}}}}
optimize: {{k: {{lower: 0, upper: 3}}}}
measurements:
  x: {{file: a.csv, compare: {{a: x}}, deviations: s}}
  y: {{file: a.csv, compare: {{b: 2*x}}}}
{of_third}""")
    spec = load(path, (), broken.METHODS)
    assert {w.what for w in spec.warnings} == {f"columns count for nothing: {own}" for own in idle}


def test_a_new_problem_has_the_data_of_the_shipped_one(folder):
    run = CliRunner()
    assert run.invoke(app, ["init", "mine", "--from", "gas_oil_cracking"]).exit_code == 0
    assert run.invoke(app, ["check", "mine.yaml"]).exit_code == 0 and (folder / "gas_oil_cracking.csv").is_file()
    assert run.invoke(app, ["init", "other", "--from", "gas_oil_cracking"]).exit_code == 0  # the same data are there
    (folder / "gas_oil_cracking.csv").write_text("mine")
    failed = run.invoke(app, ["init", "third", "--from", "gas_oil_cracking"])
    assert failed.exit_code == 3 and "gas_oil_cracking.csv: the file exists" in failed.stderr
    assert (folder / "gas_oil_cracking.csv").read_text() == "mine" and not (folder / "third.yaml").exists()


def stored_experiments():
    from trajopt.problems.catalog import shipped

    text = shipped()["enzyme_progress_curves"].read_text()
    return (
        "\n".join(line.split(" #")[0] for line in text.splitlines() if not line.startswith("#")).replace(
            "time: {final: ", "time: {initial: 0, final: "
        )
        + "\n"
    )


MONOD = """\
trajopt: 1
time: {initial: 0, final: 4}
states: {S: {rate: -mu*S/(K + S)*X/Y, initial: 6}, X: {rate: mu*S/(K + S)*X, initial: 0.5}}
optimize:
  mu: {lower: 0.05, upper: 2, guess: 0.4}
  K: {lower: 0.01, upper: 10, guess: 1}
  Y: {lower: 0.1, upper: 1, guess: 0.5}
measurements:
  substrate: {data: {time: [0.5, 1, 1.7, 2.5, 3.2], S: [5.7, 5.1, 4, 2.13, 0.51]}, deviations: 0.08}
  cells: {data: {time: [0.5, 1, 1, 1.7, 2.5, 4], X: [0.65, 0.84, 0.86, 1.36, 2.2, 3.19]}, deviations: 0.05}
"""


def test_what_is_measured_is_the_guess():
    """The pole of the rate at S = -K lies between the straight guess and the solution: from there it was crossed."""
    guess = build(load_text(MONOD, "monod.yaml")).phases[0].guess
    at = lambda name, t: np.interp(t / 4, guess.s, guess.values[name])  # noqa: E731
    assert [at("S", t) for t in (0, 0.25, 1, 4)] == pytest.approx([6, 5.85, 5.1, 0.51])
    assert [at("X", t) for t in (0, 1, 2.5)] == pytest.approx([0.5, 0.85, 2.2])
    solution, _ = solution_of(MONOD)
    assert solution.solved and solution.estimates.residuals < 12
    assert solution.estimates.values == pytest.approx([0.6, 0.8, 0.45], abs=0.15)


@pytest.mark.parametrize(
    "guess", ["guess={constants: {S: 3}}", "guess={keyframes: {S: [3, 3]}}", "phases.two.guess={constants: {S: 3}}"]
)
def test_a_guess_of_the_file_goes_before_what_is_measured(guess):
    text = MONOD.replace("optimize:", "phases:\n  one: {time: {final: 2}}\n  two: {}\noptimize:", 1)
    moved = "\n    measurements: {substrate: {data: {time: [2.5, 3.2], S: [2.13, 0.51]}, deviations: 0.08}}"
    text = text[: text.index("measurements:")].replace("two: {}", f"two:{moved}")
    own = build(load_text(text, "monod.yaml", [guess])).phases[1].guess.values
    assert own["S"] == pytest.approx(np.full_like(own["S"], 3))
    first, second = (phase.guess.values["S"] for phase in build(load_text(text, "monod.yaml")).phases)
    assert second[-1] == pytest.approx(0.51) and first[-1] == pytest.approx(2.13) and first[0] == 6
