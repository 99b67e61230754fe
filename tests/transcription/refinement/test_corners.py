"""Controls that jump between two minima of the Hamiltonian: it is the same on both sides of a jump; the bar holds."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import trajopt

ROOTS = {"once": [0.5], "twice": [0.31, 0.72]}
"""Of the costate, beside that at the end: there the control jumps."""

TWO_MINIMA = """
trajopt: 1
name: two minima of H
time: {{initial: 0, final: 1}}
states: {{x: {{initial: 1, rate: u}}}}
controls: {{u: {{lower: -2, upper: 2}}}}
objective: {{minimize: {{integral: "(u**2 - 1)**2 + ({slope})*x"}}}}
guess: {{keyframes: {{t: [0, {wrong}, {after}, 1], u: [{first}, {first}, {last}, {last}]}}}}
refine: {{tolerance: 1.0e-6}}
"""

SHALE = """
trajopt: 1
name: oil shale pyrolysis
time: {initial: 0, final: {lower: 5, upper: 15, guess: 10}}
states:
  x1: {initial: 1, rate: -k1*x1 - (k3 + k4 + k5)*x1*x2}
  x2: {initial: 0, rate: k1*x1 - k2*x2 + k3*x1*x2, lower: 0}
controls: {T: {lower: 698.15, upper: 748.15, unit: K}}
expressions:
  k1: exp(8.86 - 20300/(1.9872*T))
  k2: exp(24.25 - 37400/(1.9872*T))
  k3: exp(23.67 - 33800/(1.9872*T))
  k4: exp(18.75 - 28200/(1.9872*T))
  k5: exp(20.70 - 31000/(1.9872*T))
objective: {maximize: {terminal: "x2[final]"}}
"""


def exact(costate: np.poly1d) -> float:
    """J: with a cost that is linear in x the costate is known, and J = lambda(0) x(0) + the integral of the least H."""

    def least(t: float) -> float:
        slope = costate(t)
        u = -np.sign(slope) * brentq(lambda v: 4 * v * (v**2 - 1) - abs(slope), 0.9, 2)
        return (u**2 - 1) ** 2 + slope * u

    zeros = [r.real for r in costate.roots if 0 < r.real < 1]
    return costate(0) + quad(least, 0, 1, points=zeros, epsabs=1e-13, limit=200)[0]


@pytest.mark.parametrize("method", ["radau", "gauss"])
@pytest.mark.parametrize("roots", ROOTS.values(), ids=ROOTS)
def test_a_jump_is_where_the_hamiltonian_does_not_jump(roots, method):
    costate = -2 * np.poly1d([1, -1]) * np.poly1d(roots, r=True)
    terms = [f"{c!r}*t**{power}" for power, c in enumerate((-costate.deriv()).coeffs[::-1].tolist())]
    first = -float(np.sign(costate(0)))
    text = TWO_MINIMA.format(
        first=first,
        last=first * (-1) ** len(roots),
        wrong=roots[0] + 0.06,
        after=roots[0] + 0.07,
        slope=" + ".join(terms),
    )
    solution = trajopt.solve(trajopt.load(text, {"mesh": [{"method": method, "segments": 10}]}))
    bar = solution.meshes[-1].objective_error
    assert solution.solved
    assert bar < 1e-5
    assert abs(solution.objective - exact(costate)) <= bar


def test_a_temperature_that_jumps_is_moved_to_the_corner():
    """In phases, with its switches as free times, this problem has 0.3538211711; the first meshes lead to 0.353812."""
    solution = trajopt.solve(
        trajopt.load(SHALE, {"mesh": [{"method": "gauss", "segments": 10}], "refine": {"tolerance": 1e-6}})
    )
    assert solution.solved
    assert any("same before and after" in note for note in solution.notes)
    assert solution.objective == pytest.approx(0.3538211711, abs=5e-8)
    assert abs(solution.objective - 0.3538211711) <= solution.meshes[-1].objective_error + 1e-10


def test_a_mesh_that_is_not_refined_stays_and_its_bar_says_so():
    solution = trajopt.solve(trajopt.load(SHALE, {"mesh": [{"method": "radau", "segments": 20}]}))
    (record,) = solution.meshes
    assert record.segments == 20
    assert np.ptp(record.mesh.widths) < 1e-12
    assert abs(solution.objective - 0.3538211711) <= record.objective_error
