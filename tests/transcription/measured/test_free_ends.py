"""Measurements while an end of the time is free: exact fits, by regressions without any differential equation."""

import numpy as np
import pytest
from scipy.optimize import least_squares

import trajopt
from trajopt.problems.build import build
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load_text
from trajopt.results.file.write import write
from trajopt.results.verify import verify
from trajopt.transcription.settings import schedule_of, settings_of
from trajopt.transcription.solve import solve

TIMES, VALUES, DEVIATION, LEVEL = np.array([0.5, 1, 2]), np.array([0.62, 0.35, 0.14]), 0.02, 0.01

DECAY = f"""\
trajopt: 1
time: {{initial: INITIAL, final: FINAL}}
states: {{x: {{rate: -k*x, initial: 1, final: {LEVEL}}}}}
optimize: {{k: {{lower: 0, upper: 10, guess: 0.6}}}}
measurements:
  d: {{data: {{time: {TIMES.tolist()}, x: {VALUES.tolist()}}}, deviations: {DEVIATION}}}
"""
EARLY, LATE = "{lower: -5, upper: 0.4, guess: 0}", "{lower: 0.1, upper: 20, guess: 4}"


def solution_of(text):
    spec = load_text(text, "measured.yaml")
    return solve(build(spec), schedule_of(spec), settings_of(spec)), spec


def fitted(free):
    """The best k and t0 of exp(-k (t - t0)), the sum of squares, and the standard error of k; t0 is free or 0."""
    model = lambda q: np.exp(-q[0] * (TIMES - (q[1] if free else 0.0)))  # noqa: E731
    start = [0.6, 0.0][: 1 + free]
    fit = least_squares(lambda q: (model(q) - VALUES) / DEVIATION, start, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    k, t0 = np.append(fit.x, 0.0)[:2]
    f, t = np.exp(-k * (TIMES - t0)), TIMES - t0
    J = np.array([-t * f, k * f])
    second = np.array([[t**2 * f, f - k * t * f], [f - k * t * f, k**2 * f]])
    H = 2 * (J @ J.T + second @ (f - VALUES))[: len(fit.x), : len(fit.x)] / DEVIATION**2
    return (k, t0), 2 * fit.cost, np.sqrt(2 * np.linalg.inv(H)[0, 0])


@pytest.mark.parametrize(
    ("initial", "final", "phases"),
    [
        ("0", LATE, ["measured", "after"]),
        (EARLY, "4", ["before", "measured"]),
        (EARLY, LATE, ["before", "measured", "after"]),
    ],
)
def test_the_fit_is_that_of_a_regression(initial, final, phases, tmp_path):
    text = DECAY.replace("INITIAL", initial).replace("FINAL", final)
    (k, begins), squares, error = fitted(initial == EARLY)
    solution, spec = solution_of(text if final == LATE else text.replace(f", final: {LEVEL}", ""))
    assert [own.phase.name for own in solution.trajectories] == phases
    assert solution.estimates.values[0] == pytest.approx(k, rel=1e-7)
    assert solution.estimates.deviations[0] == pytest.approx(error, rel=1e-3)
    assert solution.objective == pytest.approx(squares, rel=1e-8)
    assert solution.trajectories[0].t[0] == pytest.approx(begins, abs=1e-6)
    ends = begins - np.log(LEVEL) / k if final == LATE else 4.0
    assert solution.trajectories[-1].t[1] == pytest.approx(ends, rel=1e-6)
    write(tmp_path / "a.h5", solution, spec.text, spec.model_dump_json(), "x")
    assert [check for check in verify(tmp_path / "a.h5") if not check.passed] == []


def test_one_measurement_between_two_free_ends():
    text = DECAY.replace("INITIAL", EARLY).replace("FINAL", LATE).replace("-k*x", "-x")
    text = text.replace("optimize: {k: {lower: 0, upper: 10, guess: 0.6}}\n", "")
    solution, _ = solution_of(text.replace(str(TIMES.tolist()), "[0.5]").replace(str(VALUES.tolist()), "[0.62]"))
    assert [own.phase.name for own in solution.trajectories] == ["before", "after"]
    begins = 0.5 + np.log(0.62)
    assert solution.objective == pytest.approx(0, abs=1e-12)
    assert solution.trajectories[0].t[0] == pytest.approx(begins, abs=1e-7)
    assert solution.trajectories[-1].t[1] == pytest.approx(begins - np.log(LEVEL), abs=1e-6)


def test_a_trajectory_lasts_to_its_last_measurement(tmp_path):
    """x' = u, |u| <= 1, from 0 to 1, as early as can be: 1 without measurements, and 3 with one at 3."""
    text = """\
trajopt: 1
time: {initial: 0, final: {lower: 0.1, upper: 20}}
states: {x: {rate: u, initial: 0, final: 1}}
controls: {u: {lower: -1, upper: 1}}
objective: {minimize: {terminal: "10*t[final]", integral: u**2}}
measurements: {d: {data: {time: [1, 3], x: [0.4, 1]}}}
"""
    solution, spec = solution_of(text)
    assert solution.trajectories[-1].t == pytest.approx([3, 3], abs=1e-7)
    # x(1) = a: a^2 + (1 - a)^2/2 + (a - 0.4)^2 is least for 2 a - (1 - a) + 2 (a - 0.4) = 0
    a = 1.8 / 5
    assert solution.objective == pytest.approx(30 + a**2 + (1 - a) ** 2 / 2 + (a - 0.4) ** 2, rel=1e-7)
    assert solution.arcs[-1] == ()
    write(tmp_path / "a.h5", solution, spec.text, spec.model_dump_json(), "x")
    assert [check for check in verify(tmp_path / "a.h5") if not check.passed] == []


def test_a_phase_may_be_measured_at_an_end_that_is_known():
    text = """\
trajopt: 1
time: {initial: 0}
states: {x: {rate: -x}}
phases:
  one: {time: {final: {lower: 1, upper: 3}}, measurements: {d: {data: {time: [0, 0], x: [0.9, 1.1]}}}}
  two: {time: {final: 5}, states: {x: {initial: 0.2}}, measurements: {e: {data: {time: [5], x: [0.02]}}}}
"""
    solution, _ = solution_of(text)
    c = (2 + 0.02 * np.exp(-5)) / (2 + np.exp(-10))  # x = c exp(-t), passes 0.2 at ln(5 c)
    assert solution.trajectories[0].x[0, 0] == pytest.approx(c, rel=1e-7)
    assert solution.trajectories[0].t[1] == pytest.approx(np.log(5 * c), rel=1e-7)
    with pytest.raises(SpecError, match=r"let a phase end at t = 0\.5, the last of them, and another go on from there"):
        load_text(text.replace("[0, 0]", "[0, 0.5]"), "x.yaml")
    with pytest.raises(SpecError, match=r"begin the phase at t = 4, the first of them, where one before it ends; or"):
        load_text(text.replace("[5], x: [0.02]", "[4, 5], x: [0.1, 0.02]"), "x.yaml")


CONTROLLED = """\
trajopt: 1
time: {initial: 0, final: {lower: 0.1, upper: 20}}
states: {x: {rate: u, initial: 0, final: 1}}
controls: {u: {lower: -1, upper: 1}}
objective: {minimize: {terminal: "t[final]"}}
measurements: {d: {data: {time: [1, 3], x: [0.4, 1]}}}
"""


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("upper: 20", "upper: 2", "measurements.d.data: the time 3 is not from 0 to 2"),
        ("[1, 3]", "[-1, 3]", "measurements.d.data: the time -1 is not from 0 to 20"),
        ("[1, 3], x: [0.4, 1]", "[0, 0], x: [0, 1]", "all is measured at the initial time"),
        ("rate: u,", 'rate: "u*t[duration]",', r"t\[duration\] in equations would be those of a phase"),
        (
            "measurements",
            "constraints: {integral: [{expression: u**2, upper: 3}]}\nmeasurements",
            "constraints.integral.0: .* name the integral under integrals:, and bound integral.NAME",
        ),
    ],
)
def test_what_has_no_phases_of_its_own(old, new, says):
    with pytest.raises(SpecError, match=says) as error:
        load_text(CONTROLLED.replace(old, new), "x.yaml")
    assert len(error.value.mistakes) == 1


def test_a_delay_beside_measurements_with_a_free_end():
    """The last measurement is at t = 3, and the control follows what the delay asks for."""
    controlled = CONTROLLED + "mesh: [{method: hermite-simpson, segments: 8}]\n"
    delayed = controlled.replace("rate: u,", 'rate: "u - x(t - 1)", history: 0,')
    with_delay, without = (trajopt.solve(trajopt.load(text)) for text in (delayed, controlled))
    assert with_delay.solved and with_delay.objective == pytest.approx(without.objective, rel=1e-6)
