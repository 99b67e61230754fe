"""The ends of time in what holds over time: scaled time in costs, dynamics and path constraints, by every method."""

from math import log, sqrt

import numpy as np
import pytest
from named import crossed

import trajopt
from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.results.verify import verify

HEAD = "trajopt: 1\ncontrols: {u: {}}\n"
COST = (
    HEAD
    + """\
time: {initial: 0, final: {lower: 0.1, upper: 20, guess: 3}}
states: {x: {rate: u, initial: 0, final: 1}}
expressions: {weight: "1 + t/t[final]"}
objective: {minimize: {integral: 1 + weight*u**2}}
"""
)
"""In scaled time s the best control is a/(1 + s) with a T ln 2 = 1, so J = T + 1/(T ln 2)."""
COST_OPTIMUM = 2 / sqrt(log(2))

DYNAMICS = (
    HEAD
    + """\
time: {initial: {lower: 0.5, upper: 0.9}, final: {lower: 1, upper: 20, guess: 3}}
states: {x: {rate: "u*(1 + (t - t[initial])/t[duration])", initial: 0, final: 1}}
objective: {minimize: {integral: 1 + u**2, terminal: "0.1*t[initial]**2"}}
"""
)
"""With g = 1 + s the best control is a g, so J = T + 1/(T 7/3), beside 0.1 0.5^2 for the time at which it starts."""
DYNAMICS_OPTIMUM = 2 * sqrt(3 / 7) + 0.025

PATH = (
    HEAD
    + """\
time: {initial: 0, final: {lower: 0.1, upper: 20, guess: 3}}
states: {x: {rate: u, initial: 0, final: 1}}
constraints: {path: [{name: heating up, expression: "u - t/t[final]**2 - 1/t[duration]**2", upper: 0}]}
objective: {maximize: {terminal: "t[final]"}}
"""
)
"""At its bound u goes 1/2 + 1/T far in the time T, which has to be 1: T is 2 at most."""

PHASES = (
    HEAD
    + """\
time: {initial: 0, final: {lower: 0.1, upper: 20, guess: 3}}
states: {x: {rate: "u*(1 + (t - t[initial])/t[duration])", initial: 0, final: 1}}
expressions: {length: "t[duration]"}
objective: {minimize: {integral: 1 + u**2}}
phases: {a: {time: {final: {lower: 0.05, upper: 5}}, states: {x: {final: 0.4}}}, b: {}}
links: [{name: long enough, expression: "2*a.t[duration] - b.length", upper: 9}]
"""
)
"""Each phase is a problem like DYNAMICS, over 0.4 and 0.6 of the way: J is linear in the way."""
METHODS = {
    "radau": 1e-9,
    "gauss": 1e-9,
    "lobatto": 1e-9,
    "hermite-simpson": 1e-5,
    "trapezoid": 2e-2,
    "runge-kutta-4": 1e-5,
    "dormand-prince": 1e-7,
}


def solved(text, method="radau", segments=8):
    return trajopt.solve(trajopt.load(text, {"mesh": [{"method": method, "segments": segments}]}))


EXACT = [(COST, COST_OPTIMUM), (DYNAMICS, DYNAMICS_OPTIMUM)]


@pytest.mark.parametrize(("exact", "method"), crossed(EXACT, [*METHODS]), ids=str)
def test_optima_by_every_method(exact, method):
    (text, optimum), error = exact, METHODS[method]
    solution = solved(text, method)
    assert solution.solved
    assert solution.objective == pytest.approx(optimum, abs=error)


def test_the_parameter_is_the_time(tmp_path):
    solution = solved(COST)
    assert solution["final_time"] == pytest.approx(solution.time[-1], rel=1e-12)
    assert solution["final_time"] == pytest.approx(COST_OPTIMUM / 2, rel=1e-6)
    assert solution.costate["x"](0.3) == pytest.approx(-COST_OPTIMUM, rel=1e-6)  # dH/du = 2 weight u + lambda = 0
    solution.save(tmp_path / "cost.h5")
    assert all(check.passed for check in verify(tmp_path / "cost.h5"))


def test_finite_differences():
    """The motor of the library, by the method that knows positions only; it is of second order."""
    objectives = [
        trajopt.solve(trajopt.load("warming_motor", FINITE | {"mesh.0.segments": n})).objective for n in (20, 40, 80)
    ]
    first, second = np.abs(np.diff(objectives))
    limit = objectives[-1] + (objectives[-1] - objectives[-2])
    assert first / second == pytest.approx(2, rel=0.1)
    assert limit == pytest.approx(14.2611977083, rel=1e-3)


FINITE = {"mesh": [{"method": "finite-difference", "segments": 20}]}


def test_phases(tmp_path):
    solution = solved(PHASES)
    assert solution.objective == pytest.approx(2 * sqrt(3 / 7), rel=1e-8)
    assert all(f"{end}_time_of_{phase}" in solution.phases[phase] for end, phase in NAMES)
    solution.save(tmp_path / "phases.h5")
    assert all(check.passed for check in verify(tmp_path / "phases.h5"))
    again = trajopt.solve(trajopt.load(PHASES), guess=tmp_path / "phases.h5")
    assert again.objective == pytest.approx(solution.objective, rel=1e-8)


NAMES = [("final", "a"), ("initial", "b"), ("final", "b")]


def test_a_time_that_is_given():
    """J = T + 1/(T ln 2) at T = 1.5."""
    text = COST.replace("{lower: 0.1, upper: 20, guess: 3}", "T").replace("controls", "parameters: {T: 1.5}\ncontrols")
    assert solved(text).objective == pytest.approx(1.5 + 1 / (1.5 * log(2)), rel=1e-9)


def test_names_that_the_file_has_are_left_alone():
    text = COST.replace("controls", "parameters: {final_time: 2}\ncontrols").replace(
        "1 + weight", "final_time + weight"
    )
    assert [own.name for own in build(load_text(text, "x.yaml")).parameters] == ["final_time_"]
    assert solved(text).objective == pytest.approx(2 * sqrt(2 / log(2)), rel=1e-7)


def test_path_constraint():
    assert solved(PATH).objective == pytest.approx(2, rel=1e-6)


@pytest.mark.parametrize("method", ["radau", "hermite-simpson", "runge-kutta-4"])
def test_error_bar_holds_on_a_coarse_mesh(method):
    text = COST.replace("1 + weight*u**2", "'1 + exp(3*t/t[final])*u**2 + x**2*t[duration]'")
    coarse, fine = solved(text, method, 4), solved(text, "gauss", 20)
    assert 1e-9 < abs(coarse.objective - fine.objective) <= coarse.error.objective < 0.1 * fine.objective
