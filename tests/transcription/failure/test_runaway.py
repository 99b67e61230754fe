"""Unbounded problems name what runs away; equations that say the same thing are named."""

import numpy as np
import pytest

from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.transcription.engines.outcome import Outcome, Status
from trajopt.transcription.failure.dependent import dependent
from trajopt.transcription.layout import bounded_start
from trajopt.transcription.settings import Settings, steps
from trajopt.transcription.solve import solve
from trajopt.transcription.transcribe import compiled, transcribe

from .test_failures import failed, problem

UNBOUNDED = {
    "a control": (problem(states="x: {rate: u, initial: 0}", u="", objective='terminal: "-x[final]"'), "u runs to "),
    "a time": (
        problem(
            states="x: {rate: u, initial: 0}",
            objective='terminal: "-t[final]"',
            final="{lower: 0.1, guess: 1}",
        ),
        "the final time runs to ",
    ),
    "a time under a bounded force": (
        problem(
            states="x: {rate: v, initial: 0}, v: {rate: u, initial: 0}",
            objective='terminal: "-x[final] - t[final]"',
            final="{lower: 1, guess: 2}",
        ),
        "the final time runs to ",
    ),
    "a parameter": (
        problem(
            states="x: {rate: u + 0*p, initial: 0, final: 1}",
            objective='terminal: "-p", integral: u**2',
            extra="optimize: {p: {guess: 1}}",
        ),
        "p runs to ",
    ),
}


@pytest.mark.parametrize("case", UNBOUNDED)
def test_what_runs_away_is_named(case):
    text, words = UNBOUNDED[case]
    solution = failed(text, max_iter=300)
    assert solution.trouble.startswith(words)
    assert "give it bounds, or check the sign of the objective" in solution.trouble


@pytest.mark.parametrize(("initial", "cost"), [(0.3, "2*u**2/(0.1 + x)"), (0.4, "u**2/(x - 0.2)")])
def test_a_division_by_what_changes_its_sign(initial, cost):
    """With u = 0 the cost is 0 and stationary whatever its divisor is; with another u it has no limit."""
    solution = failed(problem(states=f"x: {{rate: u - 1, initial: {initial}}}", objective=f"integral: {cost}"))
    assert solution.trouble.startswith("the objective divides by ")
    assert "which changes its sign" in solution.trouble and "give x a bound" in solution.trouble


INTEGRATOR = "x: {rate: v, initial: 0, final: 1}, v: {rate: u, initial: 0, final: 0}"
SHRINKING = {
    "a double integrator": problem(
        u="", states=INTEGRATOR, objective='terminal: "t[final]"', final="{lower: 0, guess: 2}",
    ),
    "a free start, and a bound on the other side": problem(
        u="lower: 0", states="h: {rate: w - 1, initial: 0, final: 30}, w: {rate: 2*u, initial: 0}",
        objective='terminal: "t[final] - t[initial]"', final="{guess: 40}", method="trapezoid",
    ).replace("initial: 0, final: {", "initial: {guess: 0}, final: {"),
    "one of two": problem(
        u="", states="x: {rate: v, initial: 0, final: 1}, v: {rate: u + sin(w), initial: 0, final: 0}",
        objective='terminal: "t[final]"', final="{lower: 0, guess: 3}", method="runge-kutta-4",
    ).replace("controls: {", "controls: {w: {lower: -1, upper: 1}, "),
}  # fmt: skip


@pytest.mark.parametrize("case", SHRINKING)
def test_a_time_that_shrinks_while_nothing_limits_a_control(case):
    """There is no shortest time, which is told after few iterations."""
    solution = failed(SHRINKING[case])
    assert solution.status is Status.DIVERGING and solution.meshes[-1].iterations < 400
    what = "duration goes to zero" if "free start" in case else "final time goes to its lower bound"
    assert solution.trouble.startswith(f"the {what} as u grows (to ")
    assert solution.trouble.endswith("give u bounds, or a price in the objective") and "w grows" not in solution.trouble


@pytest.mark.parametrize("price", [1e-9, 1e-14])
def test_a_short_time_at_a_small_price_is_none_that_shrinks(price):
    """t + p * integral of u^2 is least at T^4 = 36 p, where u is 6/T^2 at the ends: up to 1e7."""
    text = problem(
        u="", states=INTEGRATOR, objective=f'terminal: "t[final]", integral: {price}*u**2', final="{guess: 20}"
    )
    spec = load_text(text, "x.yaml")
    solution = solve(build(spec), steps(spec.mesh), Settings())
    assert solution.solved
    assert solution.objective == pytest.approx(4 / 3 * (36 * price) ** 0.25, rel=1e-6)


def named_dependent(extra: str) -> str:
    spec = load_text(problem(extra=extra), "x.yaml")
    transcription = transcribe(build(spec), [steps(spec.mesh)[0].mesh()])
    nlp = compiled(transcription)
    z, none = bounded_start(transcription)[0], np.zeros(nlp.n)
    outcome = Outcome(Status.STEP_FAILED, z, np.zeros(nlp.m), none, none, 0.0, {})
    return str(dependent(transcription, nlp, outcome))


def test_equations_that_say_the_same_thing():
    twice = "{name: one, expression: x, equals: 0.4}, {name: two, expression: 2*x, equals: 0.8}"
    words = named_dependent(f"constraints: {{integral: [{twice}]}}")
    assert words.startswith("these say the same thing")
    assert "integral constraint 'one'" in words or "integral constraint 'two'" in words


def test_a_constraint_that_the_ends_imply():
    words = named_dependent("constraints: {integral: [{name: sum, expression: u, equals: 0}]}")
    for part in ("integral constraint 'sum'", "value of v"):
        assert part in words


def test_independent_equations_name_nobody():
    assert named_dependent("") == ""


@pytest.mark.parametrize(("apart", "name"), [(1e-3, False), (1e-5, False), (1e-12, True), (0.0, True)])
def test_equations_that_say_nearly_the_same_thing(apart, name):
    """The second is that of the first, times 2, plus a little of another: 1e-5 of it is more than rounding."""
    twice = f"{{name: one, expression: x, equals: 0.4}}, {{name: two, expression: 2*x + {apart}*t*x, equals: 0.8}}"
    assert named_dependent(f"constraints: {{integral: [{twice}]}}").startswith("these say the same thing") == name


@pytest.mark.parametrize(
    ("division", "base"), [("1/g(x, 0.5)", "g(x, 0.5)"), ("1/(f(f(x) + 1) - 1e-9*u)", "f(1.0 + f(x)) - 1e-09*u")]
)
def test_a_division_by_a_table(division, base):
    """The objective falls without limit as the table, x - 1, comes to zero from below."""
    tables = (
        "tables: {f: {points: {x: [0, 1, 2]}, values: [-1, 0, 1], outside: extrapolate}, "
        "g: {points: {x: [0, 2], y: [0, 1]}, values: [[-1, -1], [1, 1]], outside: extrapolate}}"
    )
    solution = failed(problem(states="x: {rate: u, initial: 0.3}", objective=f'integral: "{division}"', extra=tables))
    assert "the objective divides by " in solution.trouble and "which runs to zero" in solution.trouble
    assert base in solution.trouble, solution.trouble
