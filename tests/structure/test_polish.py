"""Solutions solved again in phases by their arcs: exact where they are known, and kept only where they are better."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from trajopt.problems.phases.split import Part, split, why_not
from trajopt.problems.quantities import Range
from trajopt.results.file.write import write
from trajopt.results.polish.polish import REFINED, TOLERANCE, Polished, _in_phases, polish
from trajopt.results.polish.signs import worth_of_leaving
from trajopt.results.verify import verify
from trajopt.transcription.arcs import LOWER, UPPER
from trajopt.transcription.continuation import solve_spec
from trajopt.transcription.loading import build_checked, load_file, load_yaml

REST = """\
trajopt: 1
name: rest to rest
time: {initial: 0, final: {lower: 0.1, upper: 20, guess: 3}}
states: {x: {rate: v, initial: 0, final: 1}, v: {rate: u, initial: 0, final: 0}}
controls: {u: {lower: -1, upper: 2}}
objective: {minimize: {terminal: "t[final]"}}
"""
ONE = REST.replace("upper: 2}", "upper: 1}")
POWER = ONE + 'constraints: {path: [{name: power, expression: "u*v", upper: 0.5}]}\n'
ENERGY = ONE + 'constraints: {integral: [{name: energy, expression: "u**2", upper: 1.8}]}\n'
JERK = """\
trajopt: 1
name: minimum-time move with bounded jerk
parameters: {d: 4}
time: {initial: 0, final: {lower: 0.1, upper: 10, guess: 4}}
states:
  x: {rate: v, initial: 0, final: d}
  v: {rate: a, lower: -2, upper: 2, initial: 0, final: 0}
  a: {rate: j, lower: -4, upper: 4, initial: 0, final: 0}
controls: {j: {lower: -40, upper: 40}}
objective: {minimize: {terminal: "t[final]"}}
mesh: [{method: radau, segments: 60, degree: 4}]
"""
STOCK = """\
trajopt: 1
name: a fish stock, harvested
time: {initial: 0, final: 10}
states: {n: {rate: n*(1 - n) - h, initial: 0.2, final: 0.2}}
controls: {h: {lower: 0, upper: 1}}
objective: {maximize: {integral: h}}
"""
RUN_DOWN = 2 / 3**0.5 * np.arctan(0.6 / 3**0.5)  # the time of the greatest harvest, from n = 1/2 to 0.2


def limited_power():
    """u = 1 until v = 1/2, u v = 1/2 until v = w, then u = -1."""
    (w,) = [root.real for root in np.roots([2 / 3, 1 / 2, 0, 1 / 24 - 1]) if abs(root.imag) < 1e-12 and root.real > 0]
    return 0.25 + w**2 + w


def limited_energy():
    """u = 1 until a, then down to -1 in a time 2 d, and -1: a + d/3 = 0.9."""

    def too_far(d):
        a = 0.9 - d / 3
        return a * (a + d) - a**2 / 2 + d**2 / 3 - 0.5

    d = brentq(too_far, 0, 2)
    return 2 * (0.9 + 2 * d / 3)


def first(text, *overrides):
    spec = load_yaml(text, overrides) if "\n" in text else load_file(text, overrides)
    (problems,) = build_checked([spec])
    return Polished(solve_spec(spec, problems), spec)


def polished(text, *overrides):
    own = first(text, *overrides)
    return polish(own.spec, own.solution)


EXACT = [
    ("double_integrator_min_time", 2, 2, 1e-10),
    (REST, 3**0.5, 2, 1e-10),
    (JERK, 2.6, 7, 1e-10),
    (STOCK, 0.25 * (10 - RUN_DOWN - np.log(4)) + RUN_DOWN, 3, 1e-9),
    (POWER, limited_power(), 3, 1e-9),
    (ENERGY, limited_energy(), 3, 1e-8),
    ("bryson_denham", 4, 3, 1e-9),
]


@pytest.mark.parametrize(("text", "exact", "phases", "within"), EXACT)
def test_problems_with_arcs_become_exact(text, exact, phases, within, tmp_path):
    own = first(text)
    new = polish(own.spec, own.solution)
    solution = new.solution
    assert f"polished in {phases} phases" in solution.notes[-1] and len(solution.trajectories) == phases
    assert solution.objective == pytest.approx(exact, abs=within)
    assert abs(solution.objective - exact) <= solution.objective_error.bar < own.solution.objective_error.bar
    assert len(solution.arcs) == phases and not solution.inaccurate
    path = tmp_path / "polished.h5"
    write(path, solution, new.spec.text, new.spec.model_dump_json(), "", new.spec.overrides)
    assert all(check.passed for check in verify(path, anew=False))
