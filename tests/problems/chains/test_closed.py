"""Closed loops of chains: a linkage against its one coordinate, and one mechanism that is written down in two ways."""

import numpy as np
import pytest

from trajopt.problems.build import build, build_all
from trajopt.problems.catalog import shipped
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load, load_text
from trajopt.transcription.continuation import solve_spec

LENGTHS = {"crank": 0.3, "coupler": 0.9, "rocker": 0.7}
RHO, GRAVITY, PINS = 2.0, 9.81, 1.0


def solved(text: str):
    spec = load_text(text, "text.yaml") if "\n" in text else load(shipped()[text])
    return solve_spec(spec, build_all(spec))


@pytest.fixture(scope="module")
def linkage():
    return solved("four_bar")


def test_a_linkage_stays_closed_and_has_the_objective_of_its_one_coordinate(linkage):
    assert linkage.solved and linkage.objective == pytest.approx(28.46693667, abs=1e-7)
    curves = linkage.trajectories[0].samples(np.linspace(0, 1, 301))
    tip = [
        sum(long * f(curves[q]) for q, long in zip(("q1", "q2", "q3"), LENGTHS.values(), strict=True))
        for f in (np.cos, np.sin)
    ]
    assert np.hypot(tip[0] - PINS, tip[1]).max() < 1e-7


def test_the_power_of_the_crank_is_the_gain_of_energy(linkage):
    """The pin does no work: E(t) - E(0) = integral of u dq1."""
    s = np.linspace(0, 1, 2001)
    curves = linkage.trajectories[0].samples(s)
    angles = [curves[q] for q in ("q1", "q2", "q3")]
    speeds = [curves[f"d{q}"] for q in ("q1", "q2", "q3")]
    place, speed, energy = np.zeros((2, s.size)), np.zeros((2, s.size)), np.zeros(s.size)
    for length, angle, rate in zip(LENGTHS.values(), angles, speeds, strict=True):
        along, side = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        middle, moving = place + length / 2 * along, speed + length / 2 * rate * side
        mass = RHO * length
        energy += mass * ((moving**2).sum(axis=0) / 2 + (length * rate) ** 2 / 24 + GRAVITY * middle[1])
        place, speed = place + length * along, speed + length * rate * side
    power = curves["u"] * speeds[0]
    work = np.concatenate([[0], np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(s))])
    assert energy - energy[0] == pytest.approx(work, abs=1e-4 * np.ptp(energy))


ENDS = "time: {initial: 0, final: 1}\nobjective: {minimize: {integral: ul**2 + ur**2}}\n"
ARMS = (
    """\
trajopt: 1
name: five-bar, two arms
model:
  kind: chain
  zero: right
  gravity: 3
  links:
    - {name: left, mass: 1, length: 0.5, motor: ul, angle: a}
    - {name: far_left, mass: 0.8, length: 0.7, angle: b}
    - {name: base_bar, parent: base, joint: fixed, mass: 1, length: 0.4}
    - {name: right, mass: 1, length: 0.5, motor: ur, angle: d, parent: base_bar}
    - {name: far_right, mass: 0.8, length: 0.7, angle: c}
  loops: [{link: far_left, to: far_right}]
states:
  a: {initial: 1.9, final: 1.4}
  da: {initial: 0, final: 0}
  d: {initial: 1.2, final: 0.7}
  dd: {initial: 0, final: 0}
guess: {constants: {b: 0.9, c: 2.2}}
"""
    + ENDS
)
CHAIN = (
    """\
trajopt: 1
name: five-bar, one chain
model:
  kind: chain
  zero: right
  gravity: 3
  links:
    - {name: left, mass: 1, length: 0.5, motor: ul, torque: ur, angle: a}
    - {name: far_left, mass: 0.8, length: 0.7, torque: ur, angle: b}
    - {name: far_right, mass: 0.8, length: 0.7, torque: ur, angle: c}
    - {name: right, mass: 1, length: 0.5, torque: ur, angle: d}
  loops: [{link: right, x: 0.4}]
states:
  a: {initial: 1.9, final: 1.4}
  da: {initial: 0, final: 0}
  d: {initial: 1.2 - pi, final: 0.7 - pi}
  dd: {initial: 0, final: 0}
controls: {ur: {}}
guess: {constants: {b: 0.9, c: 2.2 - pi}}
"""
    + ENDS
)


def test_a_five_bar_is_the_same_as_two_arms_and_as_one_chain():
    """The motor on the right turns the last link against the ground; in the chain it hangs on the link before it, which
    the same torque on every link makes up for."""
    arms, one = solved(ARMS), solved(CHAIN)
    assert arms.solved and one.solved
    assert arms.objective == pytest.approx(one.objective, rel=1e-6)


def test_loops_have_no_place_in_phases():
    with pytest.raises(SpecError, match="closed at the initial time of one phase"):
        load_text(CHAIN + "phases: {one: {time: {final: 0.5}}, two: {}}\n", "text.yaml")


def test_the_force_in_the_pin_is_an_unknown_and_the_gap_an_output():
    (phase,) = build(load(shipped()["four_bar"])).phases
    assert [variable.name for variable in phase.algebraic][:2] == ["loop1_fx", "loop1_fy"]
    assert {"loop1_gap_x", "loop1_gap_y"} <= phase.outputs.keys()
