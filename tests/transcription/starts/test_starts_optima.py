"""Where the first solve fails, or the guess hides a control from the solver, other starts are tried and told of."""

from math import sqrt

import numpy as np
import pytest
from named import share
from scipy.optimize import brentq

from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.transcription.engines.outcome import Status
from trajopt.transcription.settings import settings_of, steps
from trajopt.transcription.solve import solve

MINIMUM_TIME = 'objective: {minimize: {terminal: "t[final]"}}'


def text(final: str, states: str, controls: str, objective: str = MINIMUM_TIME, extra: str = "") -> str:
    return f"""\
trajopt: 1
name: a poor guess
time: {{initial: 0, final: {final}}}
states: {{{states}}}
controls: {{{controls}}}
{objective}
{extra}
"""


def braking(q: str, v: str, first: float, speed: float) -> str:
    """To rest at 0 in the least time, from a place and a speed that carries it away at first."""
    states = (
        f"{q}: {{rate: {v}, initial: {first}, final: 0, lower: -5, upper: 5}},"
        f"{v}: {{rate: u, initial: {speed}, final: 0, lower: -3, upper: 3}}"
    )
    return text("{lower: 0, upper: 10}", states, "u: {lower: -1, upper: 1}")


def braking_time(first: float, speed: float) -> float:
    """Bang-bang: down to rest, back to half the way, and rest."""
    return speed + 2 * sqrt(first + speed**2 / 2)


def slide(angle: str, down: float) -> str:
    states = (
        f"x: {{rate: v*sin({angle}), initial: 0, final: 2}}, y: {{rate: v*cos({angle}), initial: 0, final: {down}}},"
        f"v: {{rate: 9.81*cos({angle}), initial: 0}}"
    )
    return text("{lower: 0.01, upper: 10}", states, f"{angle}: {{lower: 0, upper: 2*pi}}")


def slide_time(down: float) -> float:
    """The cycloid through (2, down): x = r (s - sin s), y = r (1 - cos s), time s sqrt(r/g)."""
    end = brentq(lambda s: (s - np.sin(s)) * down - 2 * (1 - np.cos(s)), 0.5, 6.2, xtol=1e-14)
    return end * sqrt(down / (1 - np.cos(end)) / 9.81)


def particle(control: str, least: float = -1.0) -> str:
    states = (
        f"x: {{rate: y*{control} - 0.75*{control}**2, initial: 1, final: 2}},y: {{rate: {control} - y, initial: 0}}"
    )
    return text("{lower: 0, upper: 100}", states, f"{control}: {{lower: {least}, upper: 1}}")


def flat(power: int, control: str, weight: float = 1.0) -> str:
    objective = f'objective: {{minimize: {{integral: "v**2 + {weight}*{control}**2"}}}}'
    states = f"v: {{rate: {control}**{power}, initial: 2}}"
    return text("1", states, f"{control}: {{lower: -2, upper: 2}}", objective)


def solved(problem: str, **options):
    spec = load_text(problem, "start.yaml")
    return solve(build(spec), steps(spec.mesh), settings_of(spec), **options)


OPTIMA = [
    (braking("q", "v", 1, 2), braking_time(1, 2)),
    (braking("way", "speed", 0.5, 2.5), braking_time(0.5, 2.5)),
    (braking("height", "climb", 2, 1.5), braking_time(2, 1.5)),
    (slide("theta", 2), slide_time(2)),
    (slide("steepness", 1), slide_time(1)),
    (slide("phi", 3), slide_time(3)),
    (particle("u"), 7.811311),
    (particle("throttle"), 7.811311),
    (particle("push", -0.5), 7.811311),
]


@pytest.mark.parametrize(("problem", "optimum"), share(OPTIMA, 2))
def test_the_optimum_is_found_from_a_poor_guess(problem, optimum):
    solution = solved(problem)
    assert solution.status is Status.SOLVED
    assert solution.objective == pytest.approx(optimum, abs=2e-6)


@pytest.mark.parametrize(
    ("power", "control", "weight"), share([(3, "u", 1.0), (3, "force", 0.5), (5, "torque", 1.0)], 2)
)
def test_a_stationary_guess_is_left_and_one_that_the_user_gives_is_named(power, control, weight):
    problem = flat(power, control, weight)
    better = solved(problem)
    spec = load_text(problem, "start.yaml")
    stuck = solved(problem, guess=[build(spec).phases[0].guess])
    assert stuck.objective == pytest.approx(4.0)  # v stays 2
    note, lower = stuck.notes
    assert note.startswith(f"{control} has no effect along this solution") and f"another guess of {control}" in note
    assert lower.startswith("another control has a lower Hamiltonian")
    assert better.solved and better.objective < 0.8 * stuck.objective
    note = better.notes[0]  # what is said of its Hamiltonian may come after
    assert note.startswith(f"{control} had no effect at the start of the file, which led to 4;")


def test_a_failure_that_no_start_cures_stays_what_it_was():
    states = "x: {rate: v, initial: 0, final: 100}, v: {rate: u, initial: 0, final: 0}"
    solution = solved(text("1", states, "u: {lower: -1, upper: 1}", 'objective: {minimize: {integral: "u**2"}}'))
    assert solution.status is Status.INFEASIBLE and len(solution.meshes) == 1
    assert "other starts failed too" in " ".join(solution.notes) and solution.violations


def test_a_good_guess_needs_no_other():
    solution = solved(
        text("1", "x: {rate: u, initial: 0, final: 1}", "u: {}", 'objective: {minimize: {integral: "u**2"}}')
    )
    assert solution.solved and solution.notes == () and solution.objective == pytest.approx(1.0)
