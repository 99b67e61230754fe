"""What would have to give way: exact where the least change is known, and as `solve` and `explain` tell it."""

import json
import warnings
from functools import cache

import numpy as np
import pytest
from command_line import trajopt
from derivatives import check_derivatives

from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.transcription.engines.outcome import Status
from trajopt.transcription.failure.elastic import ElasticProgram
from trajopt.transcription.failure.relax import explain
from trajopt.transcription.failure.soft import soft_constraints
from trajopt.transcription.layout import bounded_start
from trajopt.transcription.settings import Refine, Settings, steps
from trajopt.transcription.solve import solve
from trajopt.transcription.transcribe import compiled, transcribe

from .test_failures import INFEASIBLE, PATH, problem

SHORT = """\
trajopt: 1
name: too short
time: {initial: 0, final: {lower: 0, upper: 3}}
states:
  q: {rate: v, initial: 1, final: 0, lower: 0, upper: 5}
  v: {rate: u, initial: 2, final: 0, lower: -2, upper: 3}
controls: {u: {lower: -1, upper: 1}}
objective: {minimize: {terminal: "t[final]"}}
mesh: [{method: hermite-simpson, segments: 6}]
"""


@cache
def explained(text: str):
    spec = load_text(text, "x.yaml")
    own = build(spec)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # NumPy's would reach the user's terminal
        return explain(own, [steps(spec.mesh)[0].mesh()] * len(own.phases))


def moved(explanation) -> dict[str, tuple[float, float]]:
    return {own.what: (own.after.lower, own.after.upper) for own in explanation.alternatives}


def test_the_least_change_of_each_by_itself():
    """x from 0 to 1 in time 1, at rest at both ends, |u| <= 1: time 2 would do, |u| <= 4, or a quarter of the way."""
    found = explained(INFEASIBLE["bounds of a control"][0])
    assert found.settled and not found.feasible
    after = moved(found)
    assert after["the final time"] == pytest.approx((2, 2), rel=1e-3)
    assert after["the bounds of u"] == pytest.approx((-4, 4), rel=1e-2)
    assert after["the final value of x"] == pytest.approx((0.25, 0.25), rel=1e-2)
    shares = [own.share for own in found.alternatives]
    assert shares == sorted(shares)


def test_an_integral_a_free_time_and_a_boundary_constraint():
    assert moved(explained(INFEASIBLE["an integral constraint"][0]))["integral constraint 'fuel'"][1] == pytest.approx(
        12, rel=1e-3
    )
    assert moved(explained(SHORT))["the final time"][1] == pytest.approx(2 + 2 * np.sqrt(3), rel=2e-3)
    assert moved(explained(INFEASIBLE["a boundary constraint"][0]))["boundary constraint 'too fast'"] == (0, 0)


def test_a_constraint_over_time_says_when():
    found = explained(problem(extra=PATH))
    own = next(own for own in found.alternatives if own.what.startswith("path constraint"))
    assert 0 < own.start < 0.2 and 0.8 < own.end < 1
    assert str(own).startswith("path constraint 'speed limit' from 0.5 to 1.1")


@pytest.mark.parametrize("method", ["hermite-simpson", "gauss", "runge-kutta-4"])
def test_what_can_hold_holds(method):
    found = explained(problem(method=method))
    assert found.settled and found.feasible and not found.relief
    trajectory = found.curves[0]
    assert trajectory.x[:, -1] == pytest.approx([1, 0], abs=1e-6)


def test_derivatives_of_the_elastic_program():
    own = build(load_text(problem(extra=PATH), "x.yaml"))
    transcription = transcribe(own, [steps(load_text(problem(extra=PATH), "x.yaml").mesh)[0].mesh()])
    nlp = compiled(transcription)
    soft = list(soft_constraints(own, transcription, nlp))
    elastic = ElasticProgram(transcription, nlp, soft, bounded_start(transcription)[0], np.ones(len(soft)))
    generator = np.random.default_rng(1)
    check_derivatives(elastic, elastic.first(bounded_start(transcription)[0]) + generator.random(elastic.n))


def test_solve_tells_what_would_do(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "short.yaml").write_text(SHORT)
    run = trajopt("solve", "short.yaml")
    assert run.exit_code == 1
    first = run.stdout.splitlines()[:6]
    assert any(line.startswith(("relax ", "or ")) and "the final time from 3 to 5.4" in line for line in first)
    told = json.loads(trajopt("show", "short.h5", "--json").stdout)
    assert any("the final time" in own for own in told["relief"])


@pytest.mark.parametrize(
    ("states", "budget", "least"),
    [
        ("x: {rate: u, initial: 0, final: 3}", "{name: energy, expression: u**2, upper: 4}", "'energy' from 4 to 9"),
        (
            "y: {rate: u - y, initial: 0, final: 2}",
            "{name: effort, expression: 3*u**2, upper: 1}",
            "'effort' from 1 to 27.7",
        ),
    ],
)
def test_a_budget_that_cannot_be_kept(states, budget, least):
    """IPOPT crawls there: what has to give way is asked for then, and not after 3000 iterations more.

    The second needs 3*8/(1 - exp(-2)) = 27.756.
    """
    extra = f"constraints: {{integral: [{budget}]}}"
    text = problem(states=states, u="", objective=f"integral: {states[0]}**2", extra=extra, segments=3, method="radau")
    spec = load_text(text, "x.yaml")
    solution = solve(build(spec), steps(spec.mesh), Settings(refine=Refine()))
    assert solution.status is Status.INFEASIBLE and solution.meshes[-1].iterations < 1000
    assert any(least in own for own in solution.relief), solution.relief
    assert "relax one of the constraints" in solution.remedy


def test_the_command(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "short.yaml").write_text(SHORT)
    run = trajopt("explain", "short.yaml")
    assert run.exit_code == 1
    assert "too short: the constraints cannot all hold" in run.stdout
    told = json.loads(trajopt("explain", "short.yaml", "--json").stdout)
    assert told["feasible"] is False and told["settled"] is True
    times = next(own for own in told["alternatives"] if own["what"] == "the final time")
    assert times["before"] == [0, 3] and times["after"][1] == pytest.approx(2 + 2 * np.sqrt(3), rel=2e-3)
    assert "the final time" in run.stdout and f"{times['after'][1]:.6g}" in run.stdout
    longer = trajopt("explain", "short.yaml", "--set", "time.final.upper=10")
    assert longer.exit_code == 0 and "the constraints can all hold" in longer.stdout


def test_the_command_on_a_result(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "short.yaml").write_text(SHORT)
    trajopt("solve", "short.yaml", "-q", "--set", "solver.max_iter=2")  # so that solve itself does not ask why
    assert "the final time" in trajopt("explain", "short.h5").stdout
    refused = trajopt("explain", "short.h5", "--set", "time.final.upper=10")
    assert refused.exit_code == 2 and "give the problem file with --set" in refused.stderr
    missing = trajopt("explain", "none.h5")
    assert missing.exit_code == 3


HALTED = """\
trajopt: 1
time: {initial: 0, final: 1}
states: {x: {accel: u, initial: 0, final: 1, velocity: {name: v, initial: 0, final: 0, upper: 1}}}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
mesh: [{method: METHOD, segments: 12}]
"""


@pytest.mark.parametrize("method", ["hermite-simpson-compressed", "runge-kutta-4", "finite-difference"])
def test_the_bounds_of_a_state_that_is_computed_are_told_once(method):
    """From rest to rest over 1 in time 1 with v <= 1: more is needed, nearly 1 + 1/12 with these segments at most."""
    found = explained(HALTED.replace("METHOD", method))
    assert [own.what for own in found.alternatives].count("the bounds of v") == 1
    after = moved(found)
    assert 1.01 < after["the bounds of v"][1] < 1.1
    assert after["the initial value of v"][0] > 1 and after["the final value of v"][0] > 1


BATTERY = """
trajopt: 1
name: battery
time: {initial: 0, final: 10, unit: h}
states: {charge: {rate: p - 2, initial: 8, lower: 1, upper: 10, unit: kWh}}
controls: {p: {lower: 0, upper: 1, unit: kW}}
objective: {minimize: {integral: p**2}}
mesh: [{method: METHOD, segments: 5}]
"""
TANK = """
trajopt: 1
name: tank
time: {initial: 0, final: 8}
states: {level: {rate: inflow - 0.5, initial: 2, upper: 10}}
controls: {inflow: {lower: 2, upper: 3}}
objective: {minimize: {integral: inflow**2}}
mesh: [{method: METHOD, segments: 5}]
"""


@pytest.mark.parametrize("method", ["radau", "trapezoid"])
@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (BATTERY, {"the bounds of charge": (-2, 10), "the bounds of p": (0, 1.3), "the final time": (7, 7)}),
        (
            TANK,
            {
                "the bounds of level": (-np.inf, 14),
                "the bounds of inflow": (1.5, 3),
                "the initial value of level": (-2, -2),
            },
        ),
    ],
)
def test_a_bound_that_cannot_hold_until_a_free_end(text, expected, method):
    """The bound gives way as a whole; its end had a name of its own, "the final value", and neither would do alone."""
    after = moved(explained(text.replace("METHOD", method)))
    assert not any("final value" in what for what in after)
    for what, bounds in expected.items():
        assert after[what] == pytest.approx(bounds, rel=1e-2, abs=1e-2)
