"""Other values of static parameters: tried by solve where there is no time, and by verify."""

import pytest
from command_line import solved_once

import trajopt
from trajopt.results.verify import verify

WELLS = """\
trajopt: 1
optimize:
  a: {lower: -3, upper: 3, guess: 2.6}
  b: {guess: -2.5}
objective: {minimize: 0.1*(a**2 + b**2) - cos(3*a) - cos(3*b)}
"""
"""The optimum is -2 at the origin; from the guess a solve ends at -0.79."""

CHOICE = """\
trajopt: 1
time: {initial: 0, final: 1}
optimize: {a: {lower: -3, upper: 3, guess: 2.5}}
states: {x: {rate: u + sin(5*a), initial: 0, final: 1}}
controls: {u: {}}
objective: {minimize: {integral: u**2, terminal: "0.1*a**2"}}
"""


def test_a_problem_without_time_is_solved_from_other_parameters():
    solution = trajopt.solve(trajopt.load(WELLS))
    assert solution.objective < -1.5
    assert "may have other optima than that near its guess" in " ".join(solution.notes)


@pytest.mark.parametrize("objective", ["a**2 + b**2 - a*b", "3*a + b"])
def test_a_convex_one_is_solved_once(objective):
    text = WELLS.replace(WELLS[WELLS.index("0.1") :], objective + "}\n")
    solution = trajopt.solve(trajopt.load(text + "constraints: [{expression: a + b, lower: 0}]\n"))
    assert solution.solved and not solution.notes


HEADING = """\
trajopt: 1
time: {initial: 0, final: 1}
optimize: {heading: {guess: 5.5}}
states: {reach: {rate: cos(heading) - 0.1*u, initial: 0}, cost: {rate: 0.05*heading**2 + u**2, initial: 0}}
controls: {u: {lower: 0, upper: 1}}
objective: {maximize: {terminal: "reach[final] - cost[final]"}}
"""
"""The best heading is 0; from the guess a solve ends a turn away."""


@pytest.mark.parametrize(("text", "before", "best"), [(CHOICE, 0.7588, 0.007879264), (HEADING, -0.8, 1.0)])
def test_parameters_of_dynamics_are_tried_too(text, before, best):
    solution = trajopt.solve(trajopt.load(text))
    assert solution.objective == pytest.approx(best, rel=1e-4)
    (note,) = [own for own in solution.notes if "may have other optima" in own]
    assert float(note.split("which led to ")[1].split(";")[0]) == pytest.approx(before, rel=1e-1)


def test_verify_varies_the_parameters(tmp_path):
    """A guess that is given is kept to."""
    (tmp_path / "choice.yaml").write_text(CHOICE)
    near = solved_once(tmp_path / "near.h5", tmp_path / "choice.yaml", "--set", "optimize.a.lower=2")
    path = solved_once(tmp_path / "choice.h5", tmp_path / "choice.yaml", "--guess", str(near))
    check = verify(path)[-1]
    assert check.name == "no better objective from other starts, relative" and not check.passed
    assert "from a = " in check.where


def test_verify_passes_the_best_parameter(tmp_path):
    (tmp_path / "choice.yaml").write_text(CHOICE)
    path = solved_once(tmp_path / "choice.h5", tmp_path / "choice.yaml", "--set", "optimize.a.guess=0.3")
    assert all(check.passed for check in verify(path))
