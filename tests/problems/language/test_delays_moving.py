"""States at earlier times with free times, and in the phase before."""

import numpy as np
import pytest
from command_line import trajopt as run

import trajopt
from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.errors import SpecError
from trajopt.transcription.collocation.moving import expansion
from trajopt.transcription.loading import load_yaml
from trajopt.transcription.settings import Step
from trajopt.transcription.starts.settled import has_moving
from trajopt.transcription.transcribe import program

SYSTEM = shipped()["delayed_system"].read_text()
OPTIMUM = 4.7967986877  # of the method of steps, see test_delays.py
FASTEST = """\
trajopt: 1
time: {initial: 0, final: {lower: 0.1, upper: 9, guess: 3}}
states:
  x: {rate: x(t - 1) + u, initial: 0, final: 2, history: 0}
controls: {u: {lower: -1, upper: 1}}
objective: {minimize: {terminal: "t[final]"}}
"""
SHORTEST = np.sqrt(3)  # u = 1: x = t to t = 1, then t + (t - 1)**2/2, which is 2 at sqrt(3)
IN_TWO = ["phases={a: {time: {final: 1}}, b: {}}"]


@pytest.mark.parametrize(
    ("mesh", "tolerance"),
    [("{method: gauss, degree: 5, segments: 3}", 1e-8), ("{method: lobatto, degree: 5, segments: 3}", 1e-8),
     ("{method: hermite-simpson, segments: 16}", 1e-5), ("{method: trapezoid, segments: 40}", 1e-2)],
)  # fmt: skip
def test_a_delay_is_read_in_the_phase_before(mesh, tolerance):
    """With the end of the first phase at tau each method has its order, on any mesh that both have."""
    solution = trajopt.solve(trajopt.load(SYSTEM, ["reference=", f"mesh=[{mesh}]", *IN_TWO]))
    assert solution.solved and abs(solution.objective - OPTIMUM) < tolerance
    assert abs(solution.objective - OPTIMUM) <= solution.error.objective


@pytest.mark.parametrize("last", [0.35, 1.5])
def test_a_phase_may_end_at_any_time(last):
    """Delays of three phases back, and of one phase that is longer than they are."""
    phases = f"phases={{a: {{time: {{final: 0.3}}}}, b: {{time: {{final: {last}}}}}, c: {{}}}}"
    solution = trajopt.solve(trajopt.load(SYSTEM, ["reference=", "mesh=", "refine={tolerance: 1.0e-7}", phases]))
    assert abs(solution.objective - OPTIMUM) <= solution.error.objective < 1e-5


@pytest.mark.parametrize(("overrides", "bar"), [([], 1e-5), (["time.final.guess=1"], 1e-5), (IN_TWO, 1e-7)])
def test_a_free_final_time(overrides, bar):
    solution = trajopt.solve(trajopt.load(FASTEST, overrides))
    assert solution.solved and solution.objective == pytest.approx(SHORTEST, abs=bar)
    assert not any("did not settle" in note for note in solution.notes)


def test_a_result_with_free_times_is_verified_and_read_back(tmp_path):
    text = FASTEST.replace("lower: -1, upper: 1", "").replace('terminal: "t[final]"', "integral: 0.3 + u**2")
    mesh = "mesh: [{method: radau, degree: 4, segments: 4}]\n"
    (tmp_path / "late.yaml").write_text(text.replace("final: 2", "final: 1") + mesh)
    result = tmp_path / "late.h5"
    assert run("solve", tmp_path / "late.yaml", "-q", "-o", result).exit_code == 0
    told = run("verify", result)
    assert told.exit_code == 0, told.stdout
    solution = trajopt.read(result)
    late = solution["x(t - 1)"]
    assert late(1.25) == pytest.approx(float(solution["x"](0.25)), abs=1e-9) and late(0.5) == 0


def test_a_jump_between_phases_is_seen_a_delay_later():
    """x is 1 and, from t = 1, 3: y integrates x(t - 0.5), which is 1 on [0.5, 1.5] after the history of 0."""
    text = """\
trajopt: 1
time: {initial: 0, final: 2}
states:
  x: {rate: 0, initial: 1, history: 0}
  y: {rate: x(t - 0.5) + u, initial: 0}
controls: {u: {lower: 0, upper: 0.1}}
phases: {a: {time: {final: 1}}, b: {}}
links: [{from: a, to: b, except: [x]}, {expression: "b.x[initial]", equals: 3}]
objective: {minimize: {terminal: "y[final]"}}
mesh: [{method: radau, degree: 3, segments: 4}]
"""
    assert trajopt.solve(trajopt.load(text)).objective == pytest.approx(1 * 1 + 3 * 0.5, abs=1e-7)


@pytest.mark.parametrize("method", ["radau", "lobatto", "gauss"])
def test_derivatives_of_moving_rows_are_exact(method):
    """Against central differences of the program's own values, where all times are free, and away from their start."""
    text = FASTEST.replace("x(t - 1)", "x(t - 1)*x + sin(x(t - 0.4))")
    times = "phases={a: {time: {final: {lower: 0.2, upper: 2, guess: 0.7}}}, b: {}}"
    problem = build(load_yaml(text.replace("history: 0", "history: cos(t)"), [times]))
    mesh = [Step(method, n, 1e-8, degree=3).mesh() for n in (2, 3)]
    transcription, nlp, _ = program(problem, mesh)
    z = np.random.default_rng(3).uniform(0.5, 1.0, nlp.n)
    for layout, ends in zip(transcription.phases, ((0.0, 0.8), (0.8, 3.1)), strict=True):
        free = layout.t >= 0
        z[layout.t[free]] = np.array(ends)[free]
    dense = np.zeros((nlp.m, nlp.n))
    np.add.at(dense, nlp.jacobianstructure(), nlp.jacobian(z))
    for j, e in enumerate(np.eye(nlp.n) * 1e-6):
        slope = (nlp.constraints(z + e) - nlp.constraints(z - e)) / 2e-6
        assert slope == pytest.approx(dense[:, j], abs=1e-6 * (1 + np.abs(dense[:, j]).max()))


def test_a_phase_by_shooting_has_no_interpolant_to_read():
    first = "{time: {final: 1}, mesh: [{method: runge-kutta-4, segments: 4}]}"
    phases = f"phases={{a: {first}, b: {{states: {{x: {{rate: x(t - tau) + u}}}}}}}}"
    with pytest.raises(SpecError, match=r"runge-kutta-4 cannot take a state at an earlier time, and x\(t - tau\) is"):
        trajopt.load(SYSTEM.replace("rate: t*x + x(t - tau) + u", "rate: u"), [phases, "reference="])


@pytest.mark.parametrize(("name", "degree"), [("gauss", 3), ("radau", 20), ("lobatto", 5), ("lobatto", 30)])
def test_what_moves_is_expanded_exactly(name, degree):
    """Values, first and second derivatives of all polynomials that a state can be, of high degree too."""
    scheme = Step(name, 1, 1e-8, degree=degree).mesh().schemes[0]
    theta = np.array([0.0, 0.13, 0.5, 0.87, 1.0])
    A, G = expansion(scheme, theta)
    for k in range(len(scheme.c) + 1):
        monomial = np.polynomial.Polynomial.basis(k)
        expected = [monomial(theta), monomial.deriv()(theta), monomial.deriv(2)(theta) / 2]
        for m, value in enumerate(expected):
            assert A[m] @ scheme.sigma**k + G[m] * float(k == 1) == pytest.approx(
                value, abs=1e-12 * degree ** (2 * m + 1)
            )


def test_rows_move_only_where_a_time_that_they_read_is_free():
    """A phase with delays whose times are given, before one of a free end that has none."""
    text = """
trajopt: 1
time: {initial: 0}
states: {x: {rate: u, initial: 0, history: 0}}
controls: {u: {}}
phases:
  a: {time: {final: 1}, states: {x: {rate: "u - x(t - 0.25)"}}}
  b: {time: {final: {lower: 1.5, upper: 3}}, states: {x: {final: 1}}}
objective: {minimize: {integral: u**2}}
"""
    assert not has_moving(build(load_yaml(text)))
    assert has_moving(build(load_yaml(text, ["phases.a.time.final={lower: 0.5, upper: 1.2}"])))
    assert has_moving(build(load_yaml(text, ["phases.b.states.x.rate=u - x(t - 0.25)"])))
