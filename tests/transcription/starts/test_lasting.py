"""Free durations that shrink to nothing, from where no failed solve comes back; and states that move in no time."""

from __future__ import annotations

import numpy as np
import pytest

from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.transcription.settings import settings_of, steps
from trajopt.transcription.solve import solve

TROLLEY = """
trajopt: 1
name: trolley
time: {initial: 0, final: {lower: 0, upper: 40, guess: 3}, unit: s}
states:
  s: {rate: w, initial: 250, final: 100, lower: 0, upper: 900, unit: cm}
  w: {rate: a, initial: 60, final: 0, lower: -50, upper: 80, unit: cm/s}
controls: {a: {lower: -20, upper: 15, unit: cm/s^2}}
objective: {minimize: {terminal: "t[final]"}}
mesh: [{method: hermite-simpson, segments: 30}]
"""
ENDS = """
trajopt: 1
name: until noon
time: {initial: {lower: 0, upper: 40, guess: 37}, final: 40}
states:
  s: {rate: w, initial: 2.5, final: 1, lower: 0, upper: 9}
  w: {rate: a, initial: 0.6, final: 0, lower: -0.5, upper: 0.8}
controls: {a: {lower: -0.2, upper: 0.15}}
objective: {maximize: {terminal: "t[initial]"}}
mesh: [{method: hermite-simpson, segments: 30}]
"""
BOTH_FREE = ENDS.replace("final: 40}", "final: {lower: 0, upper: 60, guess: 40}}").replace(
    "t[initial]", "t[initial] - t[final]"
)
EXACT = 3 + 2.5 + (340 - 100 - 62.5 - 250 / 3) / 50 + 10 / 3
"""Of the trolley: brakes to a stand at 340 cm, speeds up to 50 cm/s on 62.5 cm, goes on, and brakes on 250/3 cm."""


def solved(text: str):
    spec = load_text(text, "a.yaml")
    return solve(build(spec), steps(spec.mesh), settings_of(spec))


@pytest.mark.parametrize(
    ("text", "expected"), [(TROLLEY, EXACT), (ENDS, 40 - EXACT), (BOTH_FREE, -EXACT)], ids=["final", "initial", "both"]
)
def test_a_duration_that_shrinks_is_held_longer(text, expected):
    """From guesses of 3 s all starts ended at no duration, "the constraints contradict each other"."""
    solution = solved(text)
    assert solution.status.usable
    assert abs(solution.objective - expected) < solution.objective_error.bar


GAIN = """
trajopt: 1
name: gain
time: {initial: 0, final: {lower: 0, upper: 50}}
states:
  x: {rate: y*u - 0.75*u**2, initial: 1, final: 2}
  y: {rate: u - y, initial: 0}
controls: {u: {BOUNDS}}
objective: {minimize: {terminal: "t[final]"}}
"""


@pytest.mark.parametrize("bounds", ["lower: -1, upper: 1", "lower: 0, upper: 1", ""])
def test_no_solution_takes_negative_time(bounds):
    """Without bounds of u, the infimum is the time to the conjugate point: from there on large u gain without limit.
    "solved" was a final time of -2.4e-12, at which x rises by -0.75 u**2 times a negative duration."""
    solution = solved(GAIN.replace("BOUNDS", bounds))
    if bounds:
        assert solution.status.usable and solution.objective == pytest.approx(7.811311, abs=1e-5)
    else:
        assert not solution.status.usable or solution.objective > 2 * np.pi / np.sqrt(3) - 1e-6


SHORT = """
trajopt: 1
name: a short move
time: {initial: {lower: 0, upper: 3, guess: 1}, final: {lower: 0, upper: 6, guess: 2}}
states: {x: {rate: v, initial: 0, final: 1}, v: {rate: u, initial: 0, final: 0}}
controls: {u: {lower: -4, upper: 4}}
objective: {minimize: {integral: u**2}}
mesh: [{method: radau, segments: 4}]
constraints: {boundary: [{name: limit, expression: "t[final] - t[initial]", upper: 2.5}]}
"""
PHASES = """phases: {first: {}, second: {states: {x: {initial: 0, final: 2}}}}
links: [{from: first, to: second, apart: true}]
"""
TWO = SHORT.replace("mesh:", PHASES + "mesh:")
HELD = BOTH_FREE + SHORT[SHORT.index("constraints:") :].replace("2.5}", "25}")


@pytest.mark.parametrize("name", ["duration", "duration_2"])
@pytest.mark.parametrize("text", [SHORT, TWO, HELD], ids=["one phase", "two phases", "held"])
def test_a_constraint_of_the_file_may_be_called_as_that_of_the_order_of_times(text, name):
    """Both were called so: the bound of the one was taken for that of the other."""
    told = []
    for own in (text, text.replace("name: limit", f"name: {name}")):
        solution = solved(own)
        told.append((solution.objective, *((s.path, s.derivative, s.note) for s in solution.sensitivities.all)))
    assert told[0] == told[1]
