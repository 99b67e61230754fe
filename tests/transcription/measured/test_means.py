"""Measured controls and algebraic variables: means around the times, with exact solutions."""

import numpy as np
import pyomo.core as pyomo
import pytest
from derivatives import check_derivatives
from scipy.optimize import least_squares

from trajopt.problems.build import build
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load_text
from trajopt.problems.measured import spans
from trajopt.problems.units.check import check_units
from trajopt.results.file.read import read
from trajopt.results.file.write import write
from trajopt.results.pictures.plots import trajectory_figure
from trajopt.results.verify import verify
from trajopt.transcription.layout import bounded_start
from trajopt.transcription.settings import meshes_of, schedule_of, settings_of
from trajopt.transcription.solve import solve
from trajopt.transcription.transcribe import compiled, program, transcribe

TIMES, VALUES = np.array([0.5, 1.5, 2, 3.5]), np.array([1, 2, -1, 0.5])
CONTROL = f"""\
trajopt: 1
time: {{initial: 0, final: 5}}
states: {{x: {{rate: u}}}}
controls: {{u: {{unit: N}}}}
measurements: {{d: {{data: {{time: {TIMES.tolist()}, u: {VALUES.tolist()}}}, deviations: 0.5, units: {{u: N}}}}}}
objective: {{minimize: {{integral: 0.3*u**2}}}}
mesh: [{{method: METHOD, segments: 3}}]
"""


def solution_of(text):
    spec = load_text(text, "measured.yaml")
    return solve(build(spec), schedule_of(spec), settings_of(spec)), spec


def test_a_mean_is_from_halfway_to_halfway():
    assert spans(TIMES, 0, 5).tolist() == [[0, 1], [1, 1.75], [1.75, 2.75], [2.75, 4.25]]
    assert spans(np.array([0, 0, 2, 3]), 0, 3.2).tolist() == [[0, 1], [0, 1], [1, 2.5], [2.5, 3.2]]
    assert spans(np.array([1.0]), 0, 3).tolist() == [[0, 3]]


@pytest.mark.parametrize("method", ["radau", "gauss", "midpoint"])
def test_a_measured_control(method, tmp_path):
    """u is constant over each span of duration d: w (u - y)^2 + 0.3 d u^2 is least for u = w y/(w + 0.3 d)."""
    a, b = spans(TIMES, 0, 5).T
    w, cost = 4.0, 0.3 * (b - a)
    solution, spec = solution_of(CONTROL.replace("METHOD", method))
    assert solution.objective == pytest.approx((w * cost / (w + cost) * VALUES**2).sum(), rel=1e-8)
    (trajectory,) = solution.trajectories
    np.testing.assert_allclose(trajectory.at((a + b) / 10).u[0], w * VALUES / (w + cost), rtol=1e-7)
    write(tmp_path / "a.h5", solution, spec.text, spec.model_dump_json(), "x")
    assert [check for check in verify(tmp_path / "a.h5") if not check.passed] == []
    result = read(tmp_path / "a.h5")
    (measured,) = result.phases[0].measured
    np.testing.assert_allclose(measured.model, w * VALUES / (w + cost), rtol=1e-7)
    assert (measured.expression, measured.unit, measured.time.tolist()) == ("u", "N", TIMES.tolist())
    lines = [line for ax in trajectory_figure(result).axes for line in ax.lines if line.get_label() == "measured"]
    assert len(lines) == 1


def test_a_parameter_from_measured_algebraic_variables():
    """z = x^2 = exp(-2 k t), whose means are known in closed form."""
    times, values = np.array([0.5, 1.5, 2.5]), np.array([0.45, 0.08, 0.02])
    solution, _ = solution_of(
        f"""\
trajopt: 1
time: {{initial: 0, final: 3}}
states: {{x: {{rate: -k*x, initial: 1}}}}
algebraic: {{z: {{}}}}
residuals: [z - x**2]
optimize: {{k: {{lower: 0, upper: 5, guess: 1}}}}
measurements:
  d: {{data: {{time: {times.tolist()}, signal: {values.tolist()}}}, compare: {{signal: z}}, deviations: 0.1}}
"""
    )
    a, b = times - 0.5, times + 0.5
    mean = lambda k: (np.exp(-2 * k * a) - np.exp(-2 * k * b)) / (2 * k)  # noqa: E731
    fit = least_squares(lambda k: (mean(k[0]) - values) / 0.1, [1.0], xtol=1e-15, ftol=1e-15, gtol=1e-15)
    assert solution.estimates.values[0] == pytest.approx(fit.x[0], rel=1e-7)
    assert solution.objective == pytest.approx(2 * fit.cost, rel=1e-7)


MIXED = """\
trajopt: 1
time: {initial: 0, final: 2}
states: {x: {rate: -a*x**2 + u, initial: 1}}
controls: {u: {}}
optimize: {a: {guess: 0.5}}
expressions: {power: u*x}
measurements:
  d:
    data: {time: [0.5, 1, 2], x: [0.8, 0.6, 0.5], power: [0.1, null, 0.2], w: [1, 2, 3]}
    compare: {x: x, power: power, w: u**2}
objective: {minimize: {integral: 0.1*u**2}}
mesh: [{method: METHOD, segments: 3}]
"""


@pytest.mark.parametrize("method", ["radau", "hermite-simpson", "runge-kutta-4"])
def test_derivatives_are_exact(method):
    spec = load_text(MIXED.replace("METHOD", method), "measured.yaml")
    problem = build(spec)
    meshes = meshes_of(problem, schedule_of(spec)[-1])
    found, nlp, _ = program(problem, meshes)
    z = bounded_start(found)[0]
    check_derivatives(nlp, z + 0.1 * np.random.default_rng(1).standard_normal(len(z)))
    if method == "radau":
        written, solved = transcribe(problem, meshes, templates=False), transcribe(problem, meshes)
        nlp, z = compiled(solved), bounded_start(solved)[0]
        assert pyomo.value(written.model.cost) == pytest.approx(nlp.objective(z), rel=1e-14)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("units: {u: N}", "compare: {u: u/w}", 'measurements.d.compare.u: unknown name "w"'),
        (
            "units: {u: N}",
            "compare: {u: abs(u)}",
            'measurements.d.compare.u: "abs(u)": abs is not a consistent function',
        ),
        ("u: [1.0, 2.0, -1.0, 0.5]", "u: [1.0]", "u has 1 values, and there are 4 times"),
    ],
)
def test_mistakes_are_told_at_the_column(old, new, says):
    with pytest.raises(SpecError) as error:
        load_text(CONTROL.replace("METHOD", "radau").replace(old, new), "x.yaml")
    assert [says in str(mistake) for mistake in error.value.mistakes] == [True], error.value


IN_A_PHASE = """\
trajopt: 1
time: {initial: 0}
states: {v: {unit: m/s, rate: F/m, initial: 0}}
parameters: {m: {value: 2, unit: kg}, w: {value: 1, unit: 1/(N^2*s)}}
controls: {F: {unit: N}}
phases:
  a: {time: {final: 3}, measurements: {r: {data: {time: [1, 2], f: [1, -1]}, deviations: 0.2, compare: {f: COMPARED}}}}
  b: {time: {final: 5}, states: {v: {final: 0}}}
objective: {minimize: {integral: w*F**2}}
"""


@pytest.mark.parametrize(
    ("compared", "says"),
    [
        ("F + v", 'measurements.r.compare.f: "v" is in m/s, and cannot be added to "F"'),
        ("2*G", 'measurements.r.compare.f: unknown name "G"'),
    ],
)
def test_mistakes_in_a_phase_are_told_at_its_column(compared, says):
    with pytest.raises(SpecError) as error:
        load_text(IN_A_PHASE.replace("COMPARED", compared), "x.yaml", more=check_units)
    assert [f"x.yaml:7: phases.a.{says}" in str(mistake) for mistake in error.value.mistakes] == [True], error.value


def test_a_phase_may_measure_what_its_control_does():
    """2 u is constant over two spans of duration 1: 25 (2 u - y)^2 + u^2 is least for u = 50 y/101."""
    solution, _ = solution_of(IN_A_PHASE.replace("COMPARED", "2*F"))
    assert solution.objective == pytest.approx(2 * 25 / 101, rel=1e-8)
