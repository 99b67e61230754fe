"""Controls that are angles: whole turns between neighbouring points are taken out."""

import numpy as np
import pytest

from trajopt.problems.build import build_all
from trajopt.transcription.loading import load_yaml
from trajopt.transcription.settings import schedule_of, settings_of
from trajopt.transcription.solve import solve

ZERMELO = """\
trajopt: 1
name: a boat in a current that grows across the river
parameters: {deg: UNIT}
time: {initial: 0, final: {lower: 0.1, upper: 20, guess: 5}}
states:
  x: {rate: cos(theta*deg) - y, initial: X, final: 0}
  y: {rate: sin(theta*deg), initial: Y, final: 0}
controls: {theta: {}}
objective: {minimize: {terminal: "t[final]"}}
"""
THRUST = """\
trajopt: 1
name: a thrust of any direction, least fuel
time: {initial: 0, final: 10}
states:
  x: {rate: vx, initial: 0, final: 10}
  y: {rate: vy, initial: 0, final: 0}
  vx: {rate: T*cos(th), initial: 0, final: 0}
  vy: {rate: T*sin(th), initial: 1, final: 0}
controls: {T: {lower: 0, upper: 1}, th: {lower: -2*pi, upper: 2*pi}}
objective: {minimize: {integral: T}}
"""


def solved(text):
    spec = load_yaml(text)
    return solve(build_all(spec), schedule_of(spec), settings_of(spec))


def start_of(first, last):
    """Where the boat starts that steers from one angle to another (Bryson and Ho, 2.7); the time it takes is the
    difference of the tangents."""
    (sec, tan), (sec_f, tan_f) = ((1 / np.cos(a), np.tan(a)) for a in (first, last))
    y = sec - sec_f
    x = -(sec_f * (tan_f - tan) - tan * (sec_f - sec) + np.log((tan_f + sec_f) / (tan + sec))) / 2
    return x, y, tan_f - tan


@pytest.mark.parametrize("unit", ["1", "pi/180"])
def test_a_heading_that_any_turn_serves_is_continuous(unit):
    x, y, optimum = start_of(np.radians(105), np.radians(240))
    solution = solved(ZERMELO.replace("UNIT", unit).replace("X", repr(float(x))).replace("Y", repr(float(y))))
    assert not solution.inaccurate
    assert abs(solution.objective - optimum) <= solution.objective_error.bar <= 1e-6 * (1 + optimum)
    (trajectory,) = solution.trajectories
    turn = 2 * np.pi if unit == "1" else 360.0
    assert np.ptp(trajectory.dense.u[0]) < turn / 2  # it steers through 135 degrees


def test_the_direction_of_a_thrust_goes_straight_where_it_is_off():
    solution = solved(THRUST)
    assert not solution.inaccurate
    assert solution.objective == pytest.approx(2.75547, abs=2e-5)
    assert solution.objective_error.bar < 1e-5
