"""Solutions that are stationary, and whose controls do not minimise the Hamiltonian."""

from functools import cache

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from trajopt.problems.build import build_all
from trajopt.transcription.loading import load_yaml
from trajopt.transcription.settings import schedule_of, settings_of
from trajopt.transcription.solve import solve

NOSE = """\
trajopt: 1
name: Newton's body of least resistance
time: {initial: 0, final: 1}
states: {y: {rate: u, initial: 0, final: 1}}
controls: {u: {lower: 0}}
objective: {minimize: {integral: t/(1 + u**2)}}
"""
WELLS = """\
trajopt: 1
name: two wells
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: 0, final: 0}}
controls: {u: {lower: -2, upper: 2}}
objective: {minimize: {integral: 10*x**2 + (u**2 - 1)**2}}
"""
CONCAVE = """\
trajopt: 1
name: fuel that grows less and less with thrust
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: 0, final: 0.5}}
controls: {u: {lower: 0, upper: 1}}
objective: {minimize: {integral: "u*(2 - u) + (x - t/2)**2"}}
"""
ROOT = """\
trajopt: 1
name: fuel by a root that ends beside the bound
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: 0, final: 0.5}}
controls: {u: {lower: 0, upper: 1}}
objective: {minimize: {integral: "sqrt(u + 0.01)"}}
"""
SLIDE = """\
trajopt: 1
name: slide in feet
time: {initial: 0, final: {lower: 0, upper: 20}}
states:
  across: {rate: s*cos(angle), initial: 0, final: REACH}
  drop: {rate: s*sin(angle), initial: 0, final: 6}
  s: {rate: 32.174*sin(angle), initial: 0}
controls: {angle: {lower: -pi, upper: pi}}
objective: {minimize: {terminal: "t[final]"}}
"""
LOWER = "has a lower Hamiltonian"


@cache
def solved(text, *overrides):
    spec = load_yaml(text, overrides)
    return solve(build_all(spec), schedule_of(spec), settings_of(spec))


def least_resistance():
    """Of a body as long as its base is wide, by Newton's parametric solution: its slope p jumps from 0 to 1."""
    end = brentq(lambda p: p / (1 + p**2) ** 2 * (3 * p**4 / 4 + p**2 - np.log(p) - 7 / 4) - 1, 1.001, 20)
    a = end / (1 + end**2) ** 2
    slope = quad(lambda p: (1 + p**2) / p * (4 * (1 + p**2) - (1 + p**2) ** 2 / p**2), 1, end, epsabs=1e-12)[0]
    return (4 * a) ** 2 / 2 + a**2 * slope


def test_a_jump_that_is_not_where_it_should_be_is_moved_or_in_the_bar():
    solution = solved(NOSE)
    assert any("from them a better one was found" in note for note in solution.notes)
    assert abs(solution.objective - least_resistance()) <= solution.objective_error.bar < 1e-3


@pytest.mark.parametrize(
    ("text", "relaxed", "meshes"),
    [(WELLS, 0.0, 10), (CONCAVE, 0.5, 3)],  # the infimum: between two values, ever faster
)
def test_the_bar_covers_the_infimum_that_a_control_which_switches_ever_faster_tends_to(text, relaxed, meshes):
    solution = solved(text, f"refine.max_meshes={meshes}")
    assert solution.inaccurate
    assert any("lower Hamiltonian" in note for note in solution.notes)
    assert abs(solution.objective - relaxed) <= solution.objective_error.bar
    assert solution.meshes[-1].objective_error == solution.objective_error.bar
    assert solution.meshes[-1].segments < 700  # finer meshes are of no use, and it stops


def test_an_integrand_without_a_value_beyond_a_bound_has_an_error_bar():
    """Between the points u overshoots; there the nearest control within the bounds counts."""
    solution = solved(ROOT, "refine.max_meshes=2")
    assert solution.objective_error.applies
    assert all(np.isfinite(error.relative).all() for error in solution.errors)
    assert abs(solution.objective - (np.sqrt(0.01) + np.sqrt(1.01)) / 2) <= solution.objective_error.bar


def test_where_no_mesh_makes_it_better_that_is_told():
    notes = solved(WELLS, "refine.max_meshes=10").notes
    assert any(LOWER in note and "chattering" in note for note in notes)


def test_on_a_given_mesh_too():
    solution = solved(NOSE, "mesh=[{method: radau, segments: 10, tolerance: 1e-8}]", "refine=null")
    assert abs(solution.objective - least_resistance()) <= solution.objective_error.bar


def test_of_a_minimum_nothing_is_told():
    assert not any(LOWER in note for note in solved(WELLS.replace("(u**2 - 1)**2", "u**2")).notes)


@pytest.mark.parametrize("reach", [20, 23])
def test_what_stays_to_be_gained_from_mesh_to_mesh_is_gone_for_at_once(reach):
    """A stationary ride turns on its way; the one without a turn was found after the last of eleven meshes only."""
    solution = solved(SLIDE.replace("REACH", str(reach)))
    assert solution.solved and not solution.inaccurate and len(solution.meshes) < 9
    assert any("from them a better one was found" in note for note in solution.notes)
