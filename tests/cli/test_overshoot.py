"""What is exceeded between the points stands in the table, in its own unit."""

import json

import numpy as np
import pytest
from command_line import trajopt

from trajopt.problems.quantities import Range

DISC = """
trajopt: 1
name: disc
time: {initial: 0, final: 1}
states:
  x: {unit: m, rate: u, initial: 0, final: 1}
  y: {unit: m, rate: w, initial: 0, final: 0}
controls: {u: {unit: m/s}, w: {unit: m/s}}
constraints: {path: [{name: disc, expression: (x - 0.5)**2 + y**2, lower: 0.04}]}
objective: {minimize: {integral: u**2 + w**2}}
guess: {keyframes: {y: [0, 0.4, 0]}}
mesh: [{method: trapezoid, segments: 5}]
"""


def test_a_cut_corner_is_told_in_its_unit_and_as_a_share(folder):
    (folder / "disc.yaml").write_text(DISC)
    run = trajopt("solve", "disc.yaml")
    (line,) = (line for line in run.stdout.splitlines() if line.startswith("bounds"))
    assert line.startswith("bounds      path constraint 'disc' is exceeded by 0.0")
    summary = json.loads(trajopt("show", "disc.h5", "--json").stdout)
    overshoot = summary["overshoot"]
    assert overshoot["name"] == "path constraint 'disc'" and overshoot["phase"] == "main"
    assert 0.001 < overshoot["amount"] < 0.04 and 0 < overshoot["time"] < 1
    assert f"{100 * overshoot['share']:.2g} % of its range" in line
    assert line.endswith(f", for {overshoot['lasts']:.2g} s") and 0 < overshoot["lasts"] < 1


SWITCH = """
trajopt: 1
name: there and back
time: {initial: 0, final: {lower: 0, upper: 10, guess: 3}, unit: UNIT}
states: {q: {rate: v, initial: 0, final: DISTANCE}, v: {rate: u - 0.01*v**2, initial: 0, final: 0}}
controls: {u: {lower: -1, upper: 1}}
objective: {minimize: {terminal: "t[final]"}}
"""


@pytest.mark.parametrize(("distance", "unit"), [(3, "min"), (7, "s"), (2, "")])
def test_how_long_a_control_overshoots_beside_its_jump_is_told(distance, unit, folder):
    """The jump is closed in: however much its polynomial overshoots there, it does so for next to no time."""
    text = SWITCH.replace("DISTANCE", str(distance)).replace("UNIT", unit or '""')
    (folder / "switch.yaml").write_text(text)
    (line,) = (line for line in trajopt("solve", "switch.yaml").stdout.splitlines() if line.startswith("bounds"))
    overshoot = json.loads(trajopt("show", "switch.h5", "--json").stdout)["overshoot"]
    if overshoot["share"] > 1e-4:
        assert line.endswith(f" at t = {overshoot['time']:.4g}, for {overshoot['lasts']:.2g} {unit}".rstrip())
        assert overshoot["lasts"] < 0.01 * overshoot["time"]
    else:
        assert line == "bounds      held between the points"


OFF = """
trajopt: 1
time: {initial: 0, final: 1}
states: {m: {rate: -a*T, initial: 1}}
controls: {T: {lower: 0, upper: 0.14}}
parameters: {a: 1}
objective: {maximize: {terminal: "m[final]"}}
"""


@pytest.mark.parametrize("override", ["parameters.a=1", "parameters.a=-1", "controls.T.upper=1e5"])
def test_what_the_engine_moves_a_bound_by_is_no_excess_though_the_control_spans_less(folder, override):
    (folder / "off.yaml").write_text(OFF)
    run = trajopt("solve", "off.yaml", "--set", override)
    assert "bounds      held between the points" in run.stdout.splitlines()


@pytest.mark.parametrize(
    ("name", "words"), [("shot_put", "none to hold"), ("bryson_denham", "held between the points")]
)
def test_what_holds_is_said_to(name, words, folder):
    run = trajopt("solve", name)
    assert f"bounds      {words}" in run.stdout.splitlines()


def test_beyond_is_in_the_unit_of_the_values():
    assert Range(-1, 2).beyond(np.array([-3.0, 0.0, 2.5])) == pytest.approx([2, 0, 0.5])
    assert Range().beyond(np.array([1e300])) == pytest.approx([0])
