"""Refinement does not leave the basin of an optimum for a worse one without a word."""

from dataclasses import replace

import pytest

from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.transcription.loading import load_file
from trajopt.transcription.refinement.basin import left_basin, out_of_reach
from trajopt.transcription.settings import settings_of, steps
from trajopt.transcription.solve import solve

TWO_OPTIMA = """\
trajopt: 1
name: two ways round a post
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: 0, final: 1}, y: {rate: v, initial: 0, final: 0}}
controls: {u: {}, v: {}}
objective: {minimize: {integral: u**2 + v**2}}
constraints: {path: [{name: post, expression: (x - 0.5)**2 + (y - 0.05)**2, lower: 0.04}]}
guess: {keyframes: {x: [0, 0.5, 1], y: [0, SIDE, 0]}}
"""


@pytest.fixture(scope="module")
def ways():
    """The short way below the post, and the long one above it."""
    found = []
    for side in ("-0.3", "0.4"):
        spec = load_text(TWO_OPTIMA.replace("SIDE", side), "x.yaml")
        found.append(solve(build(spec), steps(spec.mesh), settings_of(spec)))
    return found


def test_the_two_ways_are_two_optima(ways):
    below, above = ways
    assert below.solved and above.solved
    assert above.objective > below.objective + below.objective_error.bar + above.objective_error.bar


def test_a_worse_optimum_is_another_basin(ways):
    below, above = ways
    assert left_basin(below, above)
    assert not left_basin(above, below)  # a better one is welcome
    assert not left_basin(below, below)


@pytest.mark.parametrize(("times", "left"), [(3.0, False), (10.0, True)])
def test_a_bar_that_is_too_small_by_half_is_no_other_basin(ways, times, left):
    """Bars are estimates; a lunar or Martian descent on 18 segments moved by twice the bars, towards the optimum."""
    below, _ = ways
    both = 2 * below.objective_error.bar
    assert left_basin(below, replace(below, objective=below.objective + times * both)) is left


DESCENT = """\
trajopt: 1
time: {initial: 0, final: {lower: 5, upper: 60, guess: 25}}
states:
  h: {rate: v, initial: 1000, final: 0, lower: 0}
  x: {rate: w, initial: 300, final: 0, lower: -20}
  v: {rate: c*a - 3.7, initial: -40, final: 0}
  w: {rate: s*a, initial: -30, final: 0}
controls: {c: {lower: 0.3, upper: 1}, s: {lower: -1, upper: 1}, a: {lower: 1, upper: 12}}
constraints: {path: [{expression: c**2 + s**2, equals: 1}, {expression: h - 0.2*x, lower: -5}]}
objective: {minimize: {integral: a}}
"""


def test_a_descent_is_refined_to_the_end():
    found = load_text(DESCENT, "descent.yaml")
    solution = solve(build(found), steps(found.mesh), settings_of(found))
    assert solution.solved and not solution.inaccurate


@pytest.mark.parametrize(("grown", "left"), [(1.0, False), (100.0, True)])
def test_a_wide_bar_excuses_no_worse_optimum_where_the_error_has_grown(ways, grown, left):
    """8.4 +- 2 on a finer mesh after 7.18547 +- 5e-6, or 20820 +- 1500 after 20842.283 +- 0.03, is another optimum."""
    below, _ = ways
    wide = replace(below.objective_error, bar=1e5 * below.objective_error.bar)
    last = replace(below.meshes[-1], relative_error=grown * below.meshes[-1].relative_error)
    moved = below.objective + 1e3 * below.objective_error.bar
    worse = replace(below, objective=moved, objective_error=wide, meshes=(*below.meshes[:-1], last))
    assert left_basin(below, worse) is left


def test_for_a_maximum_the_smaller_one_is_worse(ways):
    below, above = (replace(own, problem=replace(own.problem, sense=-1)) for own in ways)
    assert left_basin(above, below) and not left_basin(below, above)


def test_without_error_bars_nothing_is_claimed(ways):
    below, above = ways
    unknown = replace(above, objective_error=replace(above.objective_error, why_not="not measured"))
    assert not left_basin(below, unknown)


def test_refinement_on_one_optimum_does_not_move_against_its_bars(ways):
    for way in ways:
        for before, after in zip(way.meshes, way.meshes[1:], strict=False):
            assert abs(after.objective - before.objective) <= before.objective_error + after.objective_error
        assert not way.notes


def test_a_mesh_too_large_to_solve_leaves_the_one_before(monkeypatch):
    monkeypatch.setattr("trajopt.transcription.transcribe.MAX_UNKNOWNS", 400)
    spec = load_file("cartpole", ["refine.tolerance=1e-9"])
    solution = solve(build(spec), steps(spec.mesh), settings_of(spec))
    assert solution.solved and solution.unmet and len(solution.meshes) == 1
    assert solution.stopped.startswith("the next mesh cannot be solved: ")
    assert "unknowns are more than" in solution.stopped
    assert solution.inaccurate


@pytest.mark.parametrize(
    ("segments", "errors", "asked", "told"),
    [
        ([331, 1263], [6.0e-8, 1.1e-8], 1e-11, "3e+05 segments"),  # goddard --accuracy 1e-11 went on to 19459
        ([116, 331], [6.0e-7, 6.0e-8], 1e-11, ""),  # it may still fall fast
        ([331, 1263], [6.0e-8, 1.1e-8], 5e-9, ""),
        ([331, 1263], [6.0e-8, 1.1e-8], 2e-8, ""),
        ([1263, 1300], [1.1e-8, 1.09e-8], 1e-11, ""),  # hardly any new segments tell nothing
        ([105, 328, 948], [1e-2, 4e-3, 2e-3], 1e-6, "1e+08 segments"),  # a race car whose control is a jerk
        ([331, 1263], [6.0e-8, float("nan")], 1e-11, ""),
    ],
)
def test_digits_that_would_take_too_many_segments_are_not_tried(segments, errors, asked, told):
    why = out_of_reach(segments, errors, asked)
    assert bool(why) == bool(told) and told in why
