"""Files with phases, and chains of links, polished: more phases, with what each says of its ends at the right ones."""

import numpy as np
import pytest

from trajopt.problems.load import load_text
from trajopt.problems.phases.split import PhasePart
from trajopt.problems.phases.split_each import split
from trajopt.results.file.write import write
from trajopt.results.polish.polish import polish
from trajopt.results.verify import verify
from trajopt.transcription.arcs import LOWER, UPPER

from .polished import first, limited_energy

SHARED = """\
trajopt: 1
time: {initial: 0, final: {lower: 0.1, upper: 20, guess: 5}}
states: {x: {rate: v, initial: 0}, v: {rate: a*u, initial: 0, final: 0}}
controls: {u: {lower: -1, upper: 1}}
parameters: {a: 1, d: 1}
"""
LEGS = (
    SHARED
    + """\
phases:
  out:
    states: {v: {final: 0}}
    constraints: {boundary: [{name: far, expression: "x[final] - x[initial]", equals: d}]}
    objective: {minimize: {terminal: "2*t[duration]"}}
  back:
    parameters: {a: 4, d: -2}
    states: {v: {initial: 0}}
    constraints: {boundary: [{expression: "(x[final] - x[initial])/d", equals: 1}]}
    objective: {minimize: {terminal: "a*t[duration]"}}
links:
  - {from: out, to: back, except: [x]}
  - {name: lifted, expression: "back.x[initial] - out.x[final]", equals: 0.5}
"""
)
"""Each from rest to rest, in 2 sqrt(|d|/a)."""

RATIONED = (
    SHARED
    + """\
phases:
  free: {states: {x: {final: 1}, v: {final: 0}}}
  rationed: {states: {x: {final: 2}}, constraints: {integral: [{name: energy, expression: u**2, upper: 1.8}]}}
objective: {minimize: {terminal: "t[final]"}}
"""
)

APART = (
    SHARED
    + """\
phases:
  near: {states: {x: {final: 1}}}
  far: {states: {x: {final: 4}}, parameters: {a: 2}}
links: none
objective: {minimize: {terminal: "near.t[final] + far.t[duration]"}}
"""
)

WAYPOINT = SHARED + 'waypoints: [{x: 1, v: 0}]\nobjective: {minimize: {terminal: "t[final]"}}\n'
WAYPOINT = WAYPOINT.replace("states: {x: {rate: v, initial: 0}", "states: {x: {rate: v, initial: 0, final: 0}")

ARM = """\
trajopt: 1
time: {initial: 0, final: {lower: 0.1, upper: 20, guess: 3}}
model: {kind: chain, gravity: 0, links: [{mass: 2, length: 1.5, com: 1.5, inertia: 0, motor: true}]}
states: {q1: {initial: 0, final: 1}, dq1: {initial: 0, final: 0}}
controls: {u1: {lower: -1, upper: 1}}
objective: {minimize: {terminal: "t[final]"}}
"""

EXACT = [
    (LEGS, 4 + 4 * 2 * 0.5**0.5, ["out_1", "out_2", "back_1", "back_2"], 1e-9),
    (RATIONED, 2 + limited_energy(), ["free_1", "free_2", "rationed_1", "rationed_2", "rationed_3"], 1e-8),
    (APART, 2 + 2 * 2**0.5, ["near_1", "near_2", "far_1", "far_2"], 1e-9),
    (WAYPOINT, 4, ["leg1_1", "leg1_2", "leg2_1", "leg2_2"], 1e-9),
    (ARM, 2 * 4.5**0.5, ["arc1", "arc2"], 1e-9),
]


@pytest.mark.parametrize(("text", "exact", "phases", "within"), EXACT)
def test_each_phase_becomes_its_arcs(text, exact, phases, within, tmp_path):
    own = first(text)
    new = polish(own.spec, own.solution)
    solution = new.solution
    assert [trajectory.phase.name for trajectory in solution.trajectories] == phases, solution.notes
    assert solution.objective == pytest.approx(exact, abs=within)
    assert abs(solution.objective - exact) <= solution.objective_error.bar < own.solution.objective_error.bar
    path = tmp_path / "polished.h5"
    write(path, solution, new.spec.text, new.spec.model_dump_json(), "", new.spec.overrides)
    assert [check for check in verify(path, anew=False) if not check.passed] == []


def test_what_a_phase_says_of_its_ends_is_said_of_its_first_and_last_arc():
    spec = load_text(LEGS, "x.yaml")
    parts = {"out": [PhasePart(1.0, {"u": UPPER}), PhasePart(2.0, {"u": LOWER})], "back": [PhasePart(4.0)]}
    again = load_text(split(spec, parts, 1e-10, 1e-9), "y.yaml")
    assert list(again.phases) == ["out_1", "out_2", "back"]
    told = [own.expression.text for own in again.constraints.boundary]
    assert told == ["out_2.x[final] - out_1.x[initial]", "(back.x[final] - back.x[initial])/back.d"]
    assert again.objective.terms.terminal.text == (
        "(2*(out_2.t[final] - out_1.t[initial])) + (back.a*(back.t[final] - back.t[initial]))"
    )
    assert (again.links[0].source, again.links[0].target) == ("out_2", "back")
    assert again.links[1].expression.text == "back.x[initial] - out_2.x[final]"
    assert again.phases["out_2"].states["v"].final is not None and np.isclose(again.mesh[0].tolerance, 1e-10)
