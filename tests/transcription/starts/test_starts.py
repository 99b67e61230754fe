"""Other starts: tried where the problem's own fails or where a control has no effect on it, and told."""

import json

import numpy as np
import pytest
from command_line import trajopt
from named import share
from scipy.optimize import brentq

from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.transcription.starts.other import CHANGES, both_sides, other_starts, without_effect

TOO_SHORT = """
trajopt: 1
name: too short
time: {initial: 0, final: {lower: 0, upper: 10}}
states:
  POS: {rate: VEL, initial: 1, final: 0, lower: 0, upper: 5}
  VEL: {rate: FORCE, initial: 2, final: 0, lower: -2, upper: 3}
controls: {FORCE: {lower: -1, upper: 1}}
objective: {minimize: {terminal: "t[final]"}}
"""
WIRE = """
trajopt: 1
name: wire
parameters: {g: 9.81}
time: {initial: 0, final: {lower: 0.01, upper: 10, guess: 1}}
states:
  x: {rate: v*sin(theta), initial: 0, final: 1}
  y: {rate: v*cos(theta), initial: 0, final: 1}
  v: {rate: g*cos(theta), initial: 0}
controls: {theta: {lower: 0, upper: 2*pi}}
objective: {minimize: {terminal: "t[final]"}}
"""
ROPE = """\
trajopt: 1
name: the largest area below a rope
time: {initial: 0, final: 1}
states: {y: {rate: u, initial: 0, final: 0}}
controls: {u: {}}
objective: {maximize: {integral: y}}
constraints: {integral: [{name: length, expression: sqrt(1 + u**2), equals: 1.3}]}
"""
CUBE = """
trajopt: 1
name: cube
time: {initial: 0, final: 1}
states: {v: {rate: RATE, initial: 2}}
controls: {u: {lower: -1, upper: 1}}
objective: {minimize: {integral: 2*v**2}}
"""


def solved(folder, text: str, *arguments) -> dict:
    (folder / "start.yaml").write_text(text)
    return json.loads(trajopt("solve", "start.yaml", "--json", *arguments).stdout)


@pytest.mark.parametrize("names", share([("q", "v", "u"), ("height", "speed", "thrust")], 2, 1))
def test_a_final_time_that_is_too_short(names, folder):
    """The shortest time of the double integrator from (1, 2) is 2 + 2 sqrt 3; the linear guess ends infeasible."""
    text = TOO_SHORT
    for old, new in zip(("POS", "VEL", "FORCE"), names, strict=True):
        text = text.replace(old, new)
    summary = solved(folder, text)
    assert summary["solved"]
    assert summary["objective"] == pytest.approx(2 + 2 * np.sqrt(3), abs=1e-6)
    (note,) = summary["notes"]
    assert "the start of the file failed" in note and "the time shrank" in note and "a longer time" in note


def test_a_start_where_nothing_acts(folder):
    """The bead stands still along the guess v = 0: the path through (1, 1) is a cycloid, T = 0.5829 s."""
    summary = solved(folder, WIRE)
    assert summary["objective"] == pytest.approx(0.58289546, abs=1e-6)
    (note,) = summary["notes"]
    assert note.startswith("theta had no effect at the start of the file")


def test_a_start_where_a_constraint_has_no_slope(folder):
    """A rope along its chord cannot become longer to first order; the largest area is that of a circular arc."""
    summary = solved(folder, ROPE)
    angle = brentq(lambda a: 1.3 / a * 2 * np.sin(a / 2) - 1, 0.1, 6)
    area = (1.3 / angle) ** 2 * (angle - np.sin(angle)) / 2
    assert abs(summary["objective"] - area) <= summary["objective_error"] < 1e-5


@pytest.mark.parametrize("rate", share(["u**3", "u**2*sin(u)", "v*u**3"], 2))
def test_a_stationary_guess(rate, folder):
    """u = 0 is stationary and no optimum: with u = -1 the objective is far smaller."""
    summary = solved(folder, CUBE.replace("RATE", rate))
    assert summary["objective"] < 6
    assert "u had no effect at the start of the file" in summary["notes"][0]


def test_a_solution_without_any_effect_is_told(folder):
    """Here u = 0 is the optimum; df/du = 0 cannot tell it from a stationary point that is none."""
    text = CUBE.replace("RATE", "-u**2").replace("{minimize: {integral: 2*v**2}}", "{maximize: {terminal: 'v[final]'}}")
    summary = solved(folder, text)
    assert summary["solved"] and summary["objective"] == pytest.approx(2, abs=1e-6)
    tried, doubt = summary["notes"]
    assert "none led to a better solution; give a guess of u at which it acts" in tried
    assert "u has no effect along this solution" in doubt


def test_controls_of_phases_are_told_with_their_phase(folder):
    summary = solved(folder, CUBE.replace("RATE", "u**3") + "phases: {one: {time: {final: 0.5}}, two: {}}\n")
    assert summary["objective"] < 6
    assert summary["notes"][0].startswith("u of phase one, u of phase two had no effect at the start of the file")


def test_a_good_start_is_left_alone(folder):
    summary = json.loads(trajopt("solve", "brachistochrone", "--json").stdout)
    assert not summary["notes"]


def test_a_problem_without_a_solution_says_that_other_starts_failed_too(folder):
    text = TOO_SHORT.replace("upper: 10}", "upper: 3}").replace("POS", "q").replace("VEL", "v").replace("FORCE", "u")
    summary = solved(folder, text, "--method", "trapezoid", "--segments", "8")
    assert not summary["solved"]
    assert "other starts failed too" in summary["notes"][0]


def test_which_controls_act():
    problem = build(load_text(WIRE + "guess: {constants: {theta: 1}}", "wire.yaml"))
    assert without_effect(problem, [problem.phases[0].guess]) == []  # v' = g cos(theta) changes with it
    problem = build(load_text(WIRE, "wire.yaml"))
    assert without_effect(problem, [problem.phases[0].guess]) == ["theta"]  # where theta = 0, nothing does
    problem = build(load_text(CUBE.replace("RATE", "u**3"), "cube.yaml"))
    assert without_effect(problem, [problem.phases[0].guess]) == ["u"]


def test_other_starts_stay_inside_the_bounds():
    problem = build(load_text(TOO_SHORT.replace("POS", "q").replace("VEL", "v").replace("FORCE", "u"), "short.yaml"))
    (phase,) = problem.phases
    starts = list(other_starts(problem, doubtful=False))
    assert len(starts) == len(CHANGES)
    for start in starts:
        (guess,) = start.guesses
        assert phase.final_time.lower <= guess.final_time <= phase.final_time.upper
        for variable in (*phase.states, *phase.inputs):
            values = guess.values[variable.name]
            assert (values >= variable.bounds.lower).all() and (values <= variable.bounds.upper).all()


FAST = """
trajopt: 1
name: fast decay towards a control
time: {initial: 0, final: 1}
states: {x: {rate: "-RATE*(x - u)", initial: 1}}
controls: {u: {lower: 0, upper: 4}}
objective: {minimize: {integral: x**2}}
"""


@pytest.mark.parametrize("rate", [500, 2e4])
def test_an_integrator_is_asked_only_where_the_start_has_failed(rate):
    """Equal steps run away from a rate as fast, so that the guess of the states stays; x goes to u = 3 at once."""
    problem = build(load_text(FAST.replace("RATE", str(rate)), "fast.yaml"))
    for exactly, end in ((True, 3.0), (False, 1.0)):
        first, _ = both_sides(problem, exactly)
        assert first.guesses[0].samples(np.array([1.0]))["x"] == pytest.approx(end, abs=1e-2)


COASTS = """
trajopt: 1
name: a second burn at the apex
mesh: [{method: trapezoid, segments: 8}]
parameters: {g: 9.81, c: 2500}
controls: {T: {lower: 0, upper: THRUST}}
states:
  h: {rate: v}
  v: {rate: T/m - g}
  m: {rate: -T/c}
phases:
  first:
    time: {initial: 0, final: {lower: 1, upper: 200, guess: 60}}
    states: {h: {initial: 0}, v: {initial: 0}, m: {initial: 1000, lower: 500}}
  second: {time: {final: {upper: 500, guess: 150}}, states: {m: {initial: 400, lower: 150}}}
links: [{from: first, to: second, except: [m]}]
objective: {maximize: {terminal: "second.h[final] + second.v[final]**2/(2*9.81)"}}
"""


@pytest.mark.parametrize("thrust", [20000, 25000])
def test_a_phase_that_shrank_to_nothing(thrust, folder):
    """At the apex, where v = 0, burning gains nothing in first order: a second stage that is not used is stationary."""
    summary = solved(folder, COASTS.replace("THRUST", str(thrust)))
    (note,) = (note for note in summary["notes"] if "shrank" in note)
    assert note.startswith("phase second shrank to nothing") and "this is the solution from another" in note
    burns = 500 * 2500 / thrust, 250 * 2500 / thrust
    speed = 2500 * np.log(2) + 2500 * np.log(400 / 150) - 9.81 * sum(burns)
    assert summary["objective"] > speed**2 / (2 * 9.81)


def test_a_phase_that_is_best_left_out_is_told(folder):
    text = COASTS.replace("THRUST", "20000").replace("/(2*9.81)", "/(2*9.81) - 1e4*(400 - second.m[final])")
    (note,) = (note for note in solved(folder, text)["notes"] if "shrank" in note)
    assert "none led to a better solution" in note
