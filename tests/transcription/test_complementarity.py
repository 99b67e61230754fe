"""Of two things one is zero at every time: relaxed step by step, and how exact it became is told."""

import json

import numpy as np
import pytest
from command_line import trajopt

from trajopt.problems.build import build, build_all
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load_text
from trajopt.transcription.continuation import solve_spec, way_of
from trajopt.transcription.solution.error import exactness, excesses

FALL = """
trajopt: 1
name: a block that falls and stays
parameters: {g: 9.81, h: 1, floor: 0.2}
time: {initial: 0, final: 1.2}
states:
  y: {unit: m, rate: v, initial: h}
  v: {unit: m/s, rate: u + f - g, initial: 0, final: 0}
controls: {u: {}, f: {upper: 2000}}
objective: {minimize: {integral: u**2}}
complementarity: [{name: ground, a: y - floor, b: f, relax: [0.1, 1.0e-3, 1.0e-6]}]
mesh: [{method: implicit-euler, segments: 60}]
"""


def solved(text, overrides=()):
    spec = load_text(text, "block.yaml", overrides)
    return solve_spec(spec, build_all(spec))


@pytest.fixture(scope="module")
def fallen():
    return solved(FALL)


def test_the_ground_stops_a_fall_for_nothing(fallen):
    phase = fallen.trajectories[0]
    assert fallen.solved and fallen.objective == pytest.approx(0.0, abs=1e-4)
    y, v = phase.x
    impact = phase.times[np.argmax(y < 0.2 + 1e-3)]
    assert impact == pytest.approx(np.sqrt(2 * 0.8 / 9.81), abs=2 * 1.2 / 60)  # first order
    assert y.min() > 0.2 - 1e-6 and np.abs(v[phase.times > impact + 0.05]).max() < 1e-2


def test_how_exact_it_is(fallen):
    ((pair, product, time),) = exactness(fallen.trajectories[0])
    assert (pair.name, pair.allowed) == ("ground", 1e-6)
    assert 0 < product < 1.01e-6 and 0 < time <= 1.2
    steps = [step.values["complementarity.0.relax"] for step in fallen.continuation]
    assert steps[:2] == [0.1, 1e-3] and steps[-1] == 1e-6  # with more between where one fails
    assert not any("ground'" in excess.name for excess in excesses(fallen.trajectories[0]))
    assert "not unique" in fallen.objective_error.why_not


def test_variables_get_a_bound_and_expressions_a_constraint():
    phase = build(load_text(FALL, "block.yaml")).phases[0]
    assert phase.controls[1].bounds.lower == 0.0
    assert [own.name for own in phase.path] == ["ground a", "ground"]
    named = build(load_text(FALL, "block.yaml", ["complementarity=[{a: f, b: y}]"])).phases[0]
    assert [own.name for own in named.path] == ["f_y"] and named.states[0].bounds.lower == 0.0


def test_phases_have_pairs_of_their_own_and_a_way_beside_others():
    text = (
        FALL + "phases: {first: {time: {final: 0.5}}, second: {complementarity: [{a: y, b: 1 + f, relax: [1, 0.5]}]}}\n"
    )
    spec = load_text(text + "continuation: {parameters.h: [0.5, 0.6, 0.7]}\n", "block.yaml")
    assert way_of(spec) == {
        "parameters.h": [0.5, 0.6, 0.7, 1.0],
        "complementarity.0.relax": [0.1, 1e-3, 1e-6, 1e-6],
        "phases.second.complementarity.0.relax": [1.0, 0.5, 0.5, 0.5],
    }
    first, second = build(spec).phases
    assert [own.name for own in first.complementarity] == ["ground"]
    assert [own.name for own in second.complementarity] == ["ground", "y_1_f"]


@pytest.mark.parametrize(
    ("old", "new", "where"),
    [
        ("initial: h}", "initial: nonsense}", "states.y.initial"),
        ("rate: v, initial: h}", "rate: v, initial: h, upper: 1/0}", "states.y.upper"),
        ("f: {upper: 2000}", "f: {upper: most}", "controls.f.upper"),
    ],
)
def test_an_unknown_end_of_what_may_not_be_negative_is_told(old, new, where):
    """Found by the campaign of bad problem files: a KeyError."""
    text = FALL.replace("a: y - floor", "a: y").replace(old, new)
    assert new in text
    with pytest.raises(SpecError) as caught:
        load_text(text, "block.yaml")
    assert [own.where.partition(": ")[2] for own in caught.value.mistakes] == [where]


def test_the_table_json_and_hdf5_tell_it(folder):
    (folder / "block.yaml").write_text(FALL)
    shown = trajopt("solve", "block.yaml").stdout
    assert "pair        ground: a*b is" in shown and "relaxed to 1e-06" in shown
    told = json.loads(trajopt("show", "block.h5", "--json").stdout)["phases"]["main"]["complementarity"]["ground"]
    assert told["allowed"] == 1e-6 and 0 < told["product"] < 1.01e-6
    checks = trajopt("verify", "block.h5").stdout
    assert "ground: a*b of the pair" in checks and "multipliers are not unique" in checks


def test_a_friction_cone_of_signs():
    """A block that is pushed and let go: friction acts against the velocity, by two pairs."""
    text = """
trajopt: 1
name: dry friction
time: {initial: 0, final: 1}
states: {x: {rate: v, initial: 0}, v: {rate: u - p + n, initial: 1}}
controls: {u: {lower: 0, upper: 0}, p: {upper: 0.5}, n: {lower: 0, upper: 0.5}}
complementarity:
  - {name: forwards, a: v + 1.0e-9*p, b: n, relax: [1, 1.0e-2, 1.0e-6]}
  - {name: full, a: 0.5 - p, b: v + n, relax: [1, 1.0e-2, 1.0e-6]}
objective: {minimize: {integral: u**2, terminal: "x[final]"}}
mesh: [{method: implicit-euler, segments: 40}]
"""
    own = solved(text).trajectories[0]
    assert own.x[1, -1] == pytest.approx(0.5, abs=1e-3)  # v = 1 - 0.5 t
    assert own.x[0, -1] == pytest.approx(0.75, abs=0.02)
