"""Guesses from CSV files, formulas and simulations; velocities from positions; in phases too."""

import broken
import numpy as np
import pytest

from trajopt.problems.build import build
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load, load_text
from trajopt.results.file.reload import stored_spec
from trajopt.results.file.write import write
from trajopt.transcription.settings import schedule_of, settings_of, steps
from trajopt.transcription.solve import solve

PROBLEM = """\
trajopt: 1
parameters: {k: 2}
time: {initial: 0, final: 2}
states:
  q: {unit: m, accel: u - q, velocity: {name: w, final: 0}, initial: 0}
  z: {rate: u - z, initial: 1}
controls: {u: {lower: -20, upper: 20}}
objective: {minimize: {integral: u**2, terminal: "(q[final] - 1)**2"}}
mesh: [{method: hermite-simpson, segments: 10}]
guess: GUESS
"""
CSV = "# motion capture\ntime, q, marker\n0, 0, 9\n0.5, 1, 9\n1.5, 2, 9\n2.5, 4, 9\n"


def phases(guess, text=PROBLEM, folder=None):
    return build(load_text(text.replace("GUESS", guess), "problem.yaml", folder=folder)).phases


def samples(phase, *times):
    guess = phase.guess
    s = (np.array(times) - guess.initial_time) / (guess.final_time - guess.initial_time)
    return guess.samples(s)


def test_a_file_stands_at_its_own_times_where_those_of_the_problem_are_given(tmp_path):
    (tmp_path / "capture.csv").write_text(CSV)
    (phase,) = phases("{file: capture.csv, constants: {u: 3}}", folder=tmp_path)
    found = samples(phase, 0.0, 0.25, 1.0, 2.0)
    assert found["q"] == pytest.approx([0, 0.5, 1.5, 3]) and found["u"] == pytest.approx([3] * 4)
    assert samples(phase, 0.25, 1.0, 1.8)["w"] == pytest.approx([1.75, 4 / 3, 1.75], abs=0.5)  # slopes 2, 1, 2


def test_a_file_goes_from_end_to_end_where_a_time_is_free(tmp_path):
    (tmp_path / "capture.csv").write_text(CSV)
    free = PROBLEM.replace("final: 2}", "final: {lower: 1, upper: 9}}")
    (phase,) = phases("{file: capture.csv}", free, tmp_path)
    assert samples(phase, 0.0, 1.0, 5.0)["q"] == pytest.approx([0, 1, 4])


def test_a_file_is_told_of_what_it_has_too_much(tmp_path):
    (tmp_path / "capture.csv").write_text(CSV)
    spec = load_text(PROBLEM.replace("GUESS", "{file: capture.csv}"), "problem.yaml", folder=tmp_path)
    assert [w.what for w in spec.warnings if "guess" in w.where] == [
        "capture.csv has columns that are no states or controls: marker"
    ]


def test_a_result_needs_no_csv_file(tmp_path):
    (tmp_path / "capture.csv").write_text(CSV)
    spec = load_text(PROBLEM.replace("GUESS", "{file: capture.csv}"), "problem.yaml", folder=tmp_path)
    solution = solve(build(spec), steps(spec.mesh), settings_of(spec))
    write(tmp_path / "a.h5", solution, spec.text, spec.model_dump_json(), "trajopt solve it")
    again = stored_spec(tmp_path / "a.h5")
    assert again.guess.data["q"] == [0, 1, 2, 4] and again.guess.source == "capture.csv"
    assert samples(*build(again).phases, 1.0)["q"] == pytest.approx([1.5])


def test_formulas_of_time():
    (phase,) = phases("{formulas: {q: k*t**2, u: sin(pi*t)}}")
    found = samples(phase, 0.5, 1.0, 1.5)
    assert found["q"] == pytest.approx([0.5, 2, 4.5], abs=1e-3) and found["u"] == pytest.approx([1, 0, -1], abs=1e-3)
    assert found["w"] == pytest.approx([2, 4, 6], abs=1e-3)


def test_keyframes_of_several_lengths_beside_constants():
    (phase,) = phases("{keyframes: {q: [0, 1], u: [0, 4, 0]}, constants: {z: 5}}")
    found = samples(phase, 0.0, 0.5, 1.0, 2.0)
    assert found["q"] == pytest.approx([0, 0.25, 0.5, 1]) and found["u"] == pytest.approx([0, 2, 4, 0])
    assert found["z"] == pytest.approx([5] * 4)


@pytest.mark.parametrize(
    ("guess", "expected"),
    [
        ("{keyframes: {q: [0, 3]}}", [1.5, 1.5]),  # paper, 7.10: the slope of the guess
        ("{keyframes: {q: [0, 3]}, constants: {w: 7}}", [7, 7]),
        ("{constants: {q: 3}}", [0, 0]),
        ("linear", [0, 0]),  # nothing is known of the position at the end
    ],
)
def test_a_velocity_is_the_slope_of_its_position(guess, expected):
    (phase,) = phases(guess)
    assert samples(phase, 0.0, 1.0)["w"] == pytest.approx(expected)


def test_the_slope_of_the_straight_line_between_known_ends():
    """Paper, 2.10: x = t, v = 1 for the block that is moved over a distance of 1 in a time of 1."""
    (phase,) = phases("linear", PROBLEM.replace("initial: 0}\n  z", "initial: 0, final: 1}\n  z"))
    assert samples(phase, 0.0, 1.0, 2.0)["w"] == pytest.approx([0.5] * 3)


def test_a_simulated_guess_meets_the_dynamics():
    """z' = u - z under u = -z: z = exp(-2 t)."""
    (phase,) = phases("{simulate: {u: -z}}")
    found = samples(phase, 0.0, 0.5, 1.0, 2.0)
    assert found["z"] == pytest.approx(np.exp(-2 * np.array([0, 0.5, 1, 2])), abs=3e-4)  # straight lines between points
    assert found["u"] == pytest.approx(-found["z"])


def test_a_simulated_control_keeps_its_bounds():
    (phase,) = phases("{simulate: {u: 100*t}}")
    assert samples(phase, 0.1, 1.5)["u"] == pytest.approx([10, 20])


def test_a_simulation_under_what_is_guessed_otherwise():
    """z' = u - z under u = 3, from 1."""
    (phase,) = phases("{constants: {u: 3}, simulate: {}}")
    assert samples(phase, 1.0)["z"] == pytest.approx([3 - 2 * np.exp(-1)], abs=1e-3)
    (idle,) = phases("simulate")
    assert samples(idle, 1.0)["z"] == pytest.approx([np.exp(-1)], abs=1e-3)


def test_a_simulation_that_runs_away_is_told():
    with pytest.raises(SpecError, match=r"cannot be simulated for a guess: z runs away: it is .* at t = 1;"):
        phases("simulate", PROBLEM.replace("rate: u - z", "rate: u + z**2"))  # 1/(1 - t)


PHASES = PROBLEM.replace("final: 2}", "final: 2}\nphases: {a: {time: {final: 0.5}}, b: {}}", 1)


def test_a_simulation_goes_on_from_phase_to_phase():
    first, second = phases("{simulate: {u: -z}}", PHASES)
    assert samples(first, 0.5)["z"] == pytest.approx(samples(second, 0.5)["z"])
    assert samples(second, 2.0)["z"] == pytest.approx([np.exp(-4)], abs=1e-3)


def test_a_file_over_all_phases_and_one_of_a_phase(tmp_path):
    (tmp_path / "capture.csv").write_text(CSV)
    (tmp_path / "own.csv").write_text("t,u\n0.5,1\n2,4\n")
    text = PHASES.replace("b: {}", "b: {guess: {file: own.csv}}")
    first, second = phases("{file: capture.csv}", text, tmp_path)
    assert samples(first, 0.25)["q"] == pytest.approx([0.5]) and samples(first, 0.25)["w"] == pytest.approx([2])
    assert samples(second, 0.5, 1.0)["q"] == pytest.approx([1, 1.5])
    assert samples(second, 0.5, 2.0)["u"] == pytest.approx([1, 4])
    formula_first, formula_second = phases("{formulas: {u: t}}", PHASES)
    assert samples(formula_first, 0.5)["u"] == samples(formula_second, 0.5)["u"] == pytest.approx([0.5])


@pytest.mark.parametrize("name", broken.BAD_GUESS)
def test_a_broken_csv_file(name, tmp_path):
    content, says = broken.BAD_GUESS[name]
    (tmp_path / "data.csv").write_bytes(content)
    path = tmp_path / "problem.yaml"
    before, after = broken.GOOD.split("  constants: {u: 1}\n")
    path.write_text(f"{before}  file: data.csv\n{after[after.index('mesh:') :]}")
    with pytest.raises(SpecError) as error:
        load(path, (), broken.METHODS)
    sentences = [str(mistake) for mistake in error.value.mistakes]
    assert len(sentences) == 1 and says in sentences[0], "\n".join(sentences)
    assert sentences[0].startswith((f"{path}:26: guess", f"{path}:27: guess"))


@pytest.mark.parametrize(("control", "expected"), [("0", [1, 1, 1, 1]), ("t", [1, 1, 2, 4]), ("x", [1, 2, 4, 8])])
def test_in_discrete_time_a_simulation_takes_the_steps(control, expected):
    text = (
        "trajopt: 1\ntime: {initial: 0, final: 3}\nstates: {x: {next: x + u, initial: 1}}\ncontrols: {u: {}}\n"
        "objective: {minimize: {integral: u**2}}\nguess: GUESS\n"
    )
    (phase,) = phases(f'{{simulate: {{u: "{control}"}}}}', text)
    assert samples(phase, 0, 1, 2, 3)["x"] == pytest.approx(expected, rel=1e-12)


def test_the_state_that_runs_away_is_told_with_its_own_value():
    """q grows from 0 and runs away; z, which begins with 1e9, is larger still, and does not."""
    text = PROBLEM.replace("initial: 0}", "initial: 0}", 1).replace(
        "rate: u - z, initial: 1", "rate: 0, initial: 1.0e9"
    )
    with pytest.raises(SpecError, match=r"w runs away: it is 1\.\de\+08"):
        phases("{simulate: {u: 1.2e8 + q}}", text.replace("lower: -20, upper: 20", ""))


@pytest.mark.parametrize(
    "condition",
    [
        '{expression: "q[final]", equals: 3}', '{expression: "2*q[final] - k", equals: 4}',
        '{expression: "1 - q[final]", lower: -3, upper: -1}', '"q[final] = 3"',
        '"q[final] - q[initial] = 3"', '"q[final] = 1.5*t[final]"',
    ],
)  # fmt: skip
def test_a_condition_on_one_end_is_where_the_line_ends(condition):
    text = PROBLEM.replace("guess: GUESS", f"constraints: {{boundary: [{condition}]}}")
    (phase,) = phases("", text)
    assert samples(phase, 0.0, 1.0, 2.0)["q"] == pytest.approx([0, 1.5, 3])


@pytest.mark.parametrize(
    "condition", ['q[final]**2", equals: 9', 'q[final] - z[final]", equals: 3', 'q[final]", lower: 3']
)
def test_other_conditions_say_nothing_of_the_line(condition):
    text = PROBLEM.replace("guess: GUESS", f'constraints: {{boundary: [{{expression: "{condition}}}]}}')
    (phase,) = phases("", text)
    assert samples(phase, 2.0)["q"] == pytest.approx([0])


THROW = """\
trajopt: 1
parameters: {g: 9.81, drag: 0.005, speed: 30}
optimize: {angle: {lower: 0, upper: 1.57, guess: 0.5}}
time: {initial: 0, final: {lower: 0.1, upper: 20, guess: 3}}
states:
  x: {rate: vx, initial: 0}
  y: {rate: vy, initial: 1.5, final: 0}
  vx: {rate: -drag*sqrt(vx**2 + vy**2)*vx}
  vy: {rate: -g - drag*sqrt(vx**2 + vy**2)*vy}
constraints: {boundary: ["vx[initial] = speed*cos(angle)", "vy[initial] = speed*sin(angle)"]}
objective: {maximize: {terminal: "x[final]"}}
"""


def test_conditions_with_parameters_to_optimise():
    """At rest, where the guess was, the norm of the velocity has no slope."""
    spec = load_text(THROW, "throw.yaml")
    problem = build(spec)
    values = problem.phases[0].guess.values
    assert [values["vx"][0], values["vy"][0]] == pytest.approx([30 * np.cos(0.5), 30 * np.sin(0.5)])
    found = solve(problem, schedule_of(spec))
    assert found.solved and found.objective == pytest.approx(70.0216338, abs=1e-3)


GAIT = """\
trajopt: 1
states: {x: {rate: v}, y: {rate: w, lower: 0.5}, w: {rate: u}}
controls: {u: {}}
optimize: {v: {lower: 0.5, upper: 4}}
time: {initial: 0}
phases:
  down: {time: {final: 1}, states: {x: {initial: 0}}}
  up: {time: {final: 3}, integrals: {work: u**2}}
links:
  - {from: down, to: up, except: [y]}
  - {from: up, to: down, except: [x]}
  - {expression: "down.y[initial]", equals: 1}
  - "down.y[final] = 0.8"
  - {expression: "up.y[initial] - 0.9", equals: 0}
constraints: {boundary: [{expression: "x[final]", equals: 1.5}]}
objective: {minimize: {terminal: "(1 + up.work[final])/x[final]"}}
"""


def test_conditions_between_phases_are_known_values_of_the_line():
    """Without them x is 0 along the guess, and the objective has no value."""
    problem = build(load_text(GAIT, "gait.yaml"))
    down, up = (phase.guess.values for phase in problem.phases)
    assert [down["x"][0], down["x"][-1], up["x"][-1]] == pytest.approx([0, 0.5, 1.5])
    assert [down["y"][0], down["y"][-1], up["y"][0], up["y"][-1]] == pytest.approx([1, 0.8, 0.9, 0.9])
    assert solve(problem, schedule_of(load_text(GAIT, "gait.yaml"))).solved
