"""dJ/dp of the numbers of a file, beside the change of the objective when they are changed and solved again."""

import json
from functools import cache
from math import isnan

import numpy as np
import pytest
from command_line import trajopt as command
from named import share

import trajopt
from trajopt.problems.build import build, build_all
from trajopt.problems.names.given import difference
from trajopt.results.file.write import image_of
from trajopt.transcription.loading import load_file, load_yaml
from trajopt.transcription.settings import schedule_of, settings_of
from trajopt.transcription.solve import solve

STEP = 1e-4

EVERYWHERE = """
trajopt: 1
name: a parameter everywhere
parameters:
  b: 0
  n: 2
  T: {value: 1, unit: s}
  xf: {value: 1, unit: m}
  k: 2*T
  c: 0.5
  limit: 5.5
  unused_here: 3
  at: 0.4
tables:
  push: {points: {s: [0, 0.5, 1, 1.5]}, values: [0, 0.3, 0.2, 0.4], outside: extrapolate}
time: {initial: 0, final: T}
states:
  x: {unit: m, rate: v, initial: 0, final: xf}
  v: {rate: "u - b*v - c*tanh(k*x) + push(at*x + 0.1)", initial: 0, final: 0}
controls: {u: {lower: -limit, upper: limit}}
expressions: {shown: unused_here*x}
objective: {minimize: {integral: "(u*u)**(n/2) + c*x", terminal: "xf*v[final]"}}
constraints:
  path: [{name: speed, expression: c*v, upper: 0.35*limit/2.2}]
  integral: [{expression: v**2, upper: 1.2*xf}]
mesh: [{method: hermite-simpson, segments: 8, tolerance: 1.0e-10}]
"""

TWO = """
trajopt: 1
name: two phases
parameters: {m: 2, jump: 0.3, end: 1.5}
time: {initial: 0}
states:
  x: {rate: v, initial: 0}
  v: {rate: u/m, initial: 0}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
phases:
  first: {time: {final: {lower: 0.2, upper: 0.8}}}
  second: {parameters: {m: 1.2}, time: {final: end}, states: {x: {final: 1}, v: {final: 0}}}
links:
  - {from: first, to: second, except: [v]}
  - {name: kick, expression: "second.v[initial] - first.v[final]", equals: jump}
mesh: [{method: METHOD, segments: 6, tolerance: 1.0e-10}]
"""


def solution_of(spec, guess=None):
    return solve(build_all(spec), schedule_of(spec), settings_of(spec), guess=guess)


def again(load, solution, path, value):
    """The objective with another number in the file, from the solution."""
    return solution_of(load([f"{path}={value!r}"]), solution.trajectories).objective


def assert_are_slopes(load, wanted=(), rel=2e-4, of=1):
    """That each derivative, or one of so many, is the change of the objective, and that those of the wanted numbers are
    not zero."""
    solution = solution_of(load([]))
    found = {own.path: own for own in solution.sensitivities.all}
    scale = 1 + abs(solution.objective)
    checked = [path for path, own in found.items() if abs(own.derivative) > 1e-6 * scale and not own.note]
    assert set(wanted) <= set(checked)
    for path in share(checked, of):
        own = found[path]
        step = STEP * (abs(own.value) or 1.0)
        ahead, behind = (again(load, solution, path, own.value + side * step) for side in (1, -1))
        assert own.derivative == pytest.approx((ahead - behind) / (2 * step), rel=rel, abs=1e-5 * scale), path
    return found


@pytest.mark.parametrize(
    "method", share(["hermite-simpson", "hermite-simpson-compressed", "lobatto", "gauss", "runge-kutta-4"], 2)
)
def test_parameters_in_dynamics_bounds_ends_exponents_and_tables(method):
    wanted = ["b", "n", "T", "xf", "c", "k", "limit", "at"]
    found = assert_are_slopes(
        lambda overrides: load_yaml(EVERYWHERE, [f"mesh.0.method={method}", *overrides]),
        [f"parameters.{name}" for name in wanted],
        of=1 if method == "hermite-simpson" else 3,
    )
    assert found["parameters.unused_here"].derivative == 0.0
    assert found["states.x.final"].unit == "m"


@pytest.mark.parametrize("method", ["hermite-simpson", "radau", "runge-kutta-4"])
def test_phases_have_parameters_of_their_own(method):
    found = assert_are_slopes(
        lambda overrides: load_yaml(TWO.replace("METHOD", method), overrides),
        ["parameters.m", "phases.second.parameters.m", "links.1.equals", "parameters.end", "phases.second.time.final"],
        of=1 if method == "hermite-simpson" else 3,
    )
    assert found["parameters.jump"].derivative == found["links.1.equals"].derivative


def test_phases_of_several_methods():
    mixed = TWO.replace("METHOD", "hermite-simpson")
    mixed = mixed.replace("second: {", "second: {mesh: [{method: runge-kutta-4, segments: 4, tolerance: 1.0e-10}], ")
    assert_are_slopes(lambda overrides: load_yaml(mixed, overrides), ["parameters.m", "phases.second.parameters.m"])


def test_the_maximised_objective_and_optimised_parameters():
    assert_are_slopes(
        lambda overrides: load_file("shot_put", overrides), ["parameters.g"]
    )  # of a maximum, with a free parameter


def test_finite_differences_and_an_exact_solution():
    found = assert_are_slopes(
        lambda overrides: load_file("pendulum", ["mesh.0.method=finite-difference", *overrides]), ["time.final"]
    )
    assert all(own.note == "" for own in found.values())
    block = load_file("block_move_min_force")  # J = 12 d^2 / T^3
    exact = {own.path: own.derivative for own in solution_of(block).sensitivities.all}
    assert exact["states.x.final"] == pytest.approx(24.0, rel=1e-6)
    assert exact["time.final"] == pytest.approx(-36.0, rel=1e-6)


@cache
def failed():
    """A problem that is not solved, and how its solve ended."""
    spec = load_file("cartpole", ["solver.max_iter=2"])
    return spec, solution_of(spec)


def test_what_is_not_defined_is_told():
    _, unsolved = failed()
    assert not unsolved.sensitivities.all and "not solved" in unsolved.sensitivities.why_not
    touched = """
trajopt: 1
name: a bound at the optimum without it
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: 0}}
controls: {u: {upper: 1}}
objective: {minimize: {integral: (u - 1)**2, terminal: "(x[final] - 1)**2"}}
mesh: [{method: trapezoid, segments: 4}]
"""
    idle = {own.path: own for own in solution_of(load_yaml(touched)).sensitivities.all}
    assert "begins to act" in idle["controls.u.upper"].note


SMOOTHED = """
trajopt: 1
name: a width that is a parameter
parameters: {w: 0.1, c: 0.5}
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: 0, final: 1}}
controls: {u: {}}
nonsmooth: {tanh: w}
objective: {minimize: {integral: "u**2 + c*abs(u - 0.5)"}}
mesh: [{method: trapezoid, segments: 4}]
"""


def test_a_width_is_not_told_as_one_that_changes_nothing():
    found = {own.path: own for own in solution_of(load_yaml(SMOOTHED)).sensitivities.all}
    assert isnan(found["parameters.w"].derivative) and "width" in found["parameters.w"].note
    assert not isnan(found["parameters.c"].derivative) and not found["parameters.c"].note


def test_where_measurements_are_compared_their_times_are_not_free():
    found = {own.path: own for own in solution_of(load_file("gas_oil_cracking")).sensitivities.all}
    assert isnan(found["time.final"].derivative) and "measured" in found["time.final"].note
    assert found["states.y1.initial"].derivative < 0


def test_differences_find_slopes_at_every_scale_and_none_at_corners():
    assert difference(np.sin, 1.0) == pytest.approx(np.cos(1.0), rel=1e-11)
    assert difference(lambda p: np.exp(1e4 * p), 0.0) == pytest.approx(1e4, rel=1e-6)
    assert difference(lambda p: 1e12 + p, 1.0, rounding=1e-4) == pytest.approx(1.0, abs=0.3)
    assert difference(lambda _: 3.0, 2.0) == 0.0
    assert isnan(difference(abs, 0.0))
    assert isnan(difference(lambda p: p**0.5 if p >= 0 else np.nan, 0.0))


def test_stored_shown_and_in_python(tmp_path):
    problem = trajopt.load("cartpole", {"parameters.u_max": 12})
    solution = trajopt.solve(problem)
    path = solution.save(tmp_path / "weak.h5")
    stored = trajopt.read(path).sensitivities
    assert dict(stored) == dict(solution.sensitivities) and stored.missing == ""
    assert stored["parameters.u_max"] < 0 < stored["controls.u.lower"]
    with pytest.raises(KeyError, match=r"did you mean parameters\.u_max"):
        stored["parameters.umax"]
    shown = command("show", path, "--sensitivities")
    row = next(line for line in shown.stdout.splitlines() if line.startswith("parameters.u_max"))
    assert row.split() == ["parameters.u_max", "12", "N", f"{stored['parameters.u_max']:.6g}", "per", "N"]
    told = json.loads(command("show", path, "--json").stdout)["sensitivities"]["numbers"]
    assert told["parameters.u_max"]["derivative"] == stored["parameters.u_max"]


def test_a_failed_solve_says_why_there_are_none(tmp_path):
    spec, unsolved = failed()
    path = tmp_path / "failed.h5"
    path.write_bytes(image_of(unsolved, spec.text, spec.model_dump_json(), "test"))
    assert "none: the problem is not solved" in command("show", path, "--sensitivities").stdout


def test_ranges_know_where_their_ends_stand_in_the_file():
    bounce = build(load_file("bounce"))
    assert bounce.phases[0].states[1].final.lower.path == "phases.falling.states.y.final"
    assert bounce.phases[1].initial_time.upper.path == bounce.phases[0].final_time.upper.path == "time.final.upper"
    drone = build(load_file("waypoint_drone"))
    assert drone.phases[0].states[0].final.lower.path == "waypoints.0.x"


def test_ends_of_velocities_by_finite_differences():
    """A cubic from 0 to 1 with velocities a and b at its ends: J = 4 (a^2 + a b + b^2) - 12 (a + b) + 12."""
    text = """
trajopt: 1
time: {initial: 0, final: 1}
states: {x: {accel: u, initial: 0, final: 1, velocity: {name: v, initial: 0.5, final: 0.25, upper: 3}}}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
mesh: [{method: finite-difference, segments: 80}]
"""
    spec = load_yaml(text)
    found = solve(build(spec), schedule_of(spec), settings_of(spec)).sensitivities
    by = {own.path.removeprefix("states.x.velocity."): own.derivative for own in found.all}
    assert by["initial"] == pytest.approx(4 * (2 * 0.5 + 0.25) - 12, rel=0.05)
    assert by["final"] == pytest.approx(4 * (0.5 + 2 * 0.25) - 12, rel=0.05)
    assert by["upper"] == pytest.approx(0, abs=1e-6)
