"""Chains in files: the same optimum as with equations written out, and all that works with any file."""

import json
import re

import pytest
import yaml
from repository import ROOT

import trajopt
from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load, load_text
from trajopt.problems.units.check import check_units

DOCS = ROOT / "docs" / "chains.md"

CARTPOLE = """\
model:
  kind: chain
  base: cart
  gravity: g
  cart: {mass: m1, motor: true}
  links: [{mass: m2, length: l, com: l, inertia: 0}]
parameters: {m1: 1.0, m2: 0.3, l: 0.5, g: 9.81}
time: {initial: 0, final: 2}
states:
  x: {lower: -2, upper: 2, initial: 0, final: 1}
  dx: {initial: 0, final: 0}
  q1: {lower: -2*pi, upper: 2*pi, initial: 0, final: pi}
  dq1: {initial: 0, final: 0}
controls: {u0: {lower: -20, upper: 20}}
objective: {minimize: {integral: u0**2}}
mesh: [{method: hermite-simpson, segments: 25}]
"""

ACROBOT = """\
parameters: {m: 1, l: 0.5, g: 9.81}
time: {initial: 0, final: 2}
controls: {u: {lower: -20, upper: 20}}
objective: {minimize: {integral: u**2}}
guess:
  keyframes: {time: [0, 0.5, 1.5, 2], q1: [0, -pi/2, pi/2, pi], q2: [0, 0, pi, pi]}
mesh: [{method: hermite-simpson, segments: 20}]
"""
BY_CHAIN = """\
model:
  kind: chain
  gravity: g
  links: [{mass: m, length: l, com: l, inertia: 0}, {mass: m, length: l, com: l, inertia: 0, motor: u}]
states:
  q1: {lower: -2*pi, upper: 2*pi, initial: 0, final: pi}
  q2: {lower: -2*pi, upper: 2*pi, initial: 0, final: pi}
  dq1: {initial: 0, final: 0}
  dq2: {initial: 0, final: 0}
"""
BY_HAND = """\
states:
  q1: {lower: -2*pi, upper: 2*pi, initial: 0, final: pi, velocity: {name: dq1, initial: 0, final: 0}}
  q2: {lower: -2*pi, upper: 2*pi, initial: 0, final: pi, velocity: {name: dq2, initial: 0, final: 0}}
residuals:
  - m*l**2*(2*dq1[rate] + cos(q1 - q2)*dq2[rate] + sin(q1 - q2)*dq2**2) + 2*m*g*l*sin(q1) + u
  - m*l**2*(cos(q1 - q2)*dq1[rate] + dq2[rate] - sin(q1 - q2)*dq1**2) + m*g*l*sin(q2) - u
"""


def spec_of(text: str, *overrides: str):
    return load_text("trajopt: 1\n" + text, "robot.yaml", overrides)


def solved(text: str, *overrides: str):
    solution = trajopt.solve(trajopt.load("trajopt: 1\n" + text, overrides))
    assert solution.solved
    return solution


def test_the_cart_pole_is_a_chain():
    by_hand = trajopt.solve(trajopt.load("cartpole"))
    assert solved(CARTPOLE).objective == pytest.approx(by_hand.objective, rel=1e-11)


def test_a_cart_is_a_link_that_slides():
    """The same cart-pole, its cart on a rail; and the path of its tip."""
    rail = CARTPOLE.replace("  base: cart\n", "").replace("  cart: {mass: m1, motor: true}\n", "").replace(
        "links: [", "links: [{joint: prismatic, zero: right, mass: m1, length: 1, distance: x, motor: u0}, "
    ).replace("{mass: m2,", "{at: 0, angle: q1, mass: m2,")  # fmt: skip
    assert "base: cart" not in rail
    on_rail, on_cart = solved(rail), solved(CARTPOLE)
    assert on_rail.objective == pytest.approx(on_cart.objective, rel=1e-11)
    assert on_rail["link2_x"](1.3) == pytest.approx(on_cart["link1_x"](1.3), abs=1e-8)


def test_the_acrobot_is_a_chain():
    by_hand = solved(ACROBOT + BY_HAND)
    assert solved(ACROBOT + BY_CHAIN).objective == pytest.approx(by_hand.objective, rel=1e-11)


def test_the_biped_of_the_docs_is_that_of_the_library_and_of_its_name():
    """docs/chains.md shows the model of `biped`; `model: five_link_biped` is it with its constraints: the same J."""
    snippet = next(own for own in re.findall(r"```yaml\n(.*?)```", DOCS.read_text(), re.S) if "step:" in own)
    data = yaml.safe_load(shipped()["biped"].read_text())
    shown = yaml.safe_load(snippet)
    assert data["model"] == shown["model"]
    assert [row["expression"] for row in data["constraints"]["boundary"]] == [
        row["expression"] for row in shown["constraints"]["boundary"]
    ]
    del data["constraints"]
    named = trajopt.solve(trajopt.load(json.dumps(data | {"model": "five_link_biped"}, indent=1)))
    assert named.objective == pytest.approx(trajopt.solve(trajopt.load("biped")).objective, rel=1e-11)


# -- what a chain is short for ---------------------------------------------------------------------------------------

PENDULUM = """\
parameters: {N: 3, T: 2}
model:
  kind: chain
  links: [{for: i in 1..N, mass: 1, length: 0.5, motor: true}]
time: {initial: 0, final: T}
states:
  q{i}: {for: i in 1..N, initial: 0, final: pi}
  dq{i}: {for: i in 1..N, initial: 0, final: 0}
objective: {minimize: {integral: "sum(i in 1..N, u{i}**2)"}}
"""


def test_a_pendulum_of_n_links():
    three, four = spec_of(PENDULUM), spec_of(PENDULUM, "parameters.N=4")
    assert list(three.states) == ["q1", "q2", "q3"] and list(four.states) == ["q1", "q2", "q3", "q4"]
    assert [*four.controls] == ["u1", "u2", "u3", "u4"] and len(four.residuals) == 4
    assert {"link3_x", "link3_y"} <= three.expressions.keys() and "link3_vx" not in three.expressions


@pytest.mark.parametrize(("links", "angles"), [(20, "absolute"), (10, "relative")])
def test_long_chains_can_be_written(links, angles):
    (phase,) = build(spec_of(PENDULUM, f"parameters.N={links}", f"model.angles={angles}")).phases
    assert len(phase.residuals) == links


def test_the_full_form_is_the_same_problem():
    """What a result holds, read as a file."""
    spec = spec_of(PENDULUM)
    again = load_text(spec.model_dump_json(), "robot.yaml")
    assert again.model_dump() == spec.model_dump()


def test_overrides_of_links_and_of_what_is_made():
    spec = spec_of(PENDULUM, "model.links.0.mass=3", "states.dq1.upper=9", "controls.u2.lower=-4", "states.q2.final=1")
    assert spec.expressions["link1_mass"].value.text == "3"
    assert spec.states["q1"].velocity.upper.text == "9" and spec.states["q1"].velocity.final.value.text == "0"
    assert spec.controls["u2"].lower.text == "-4"
    assert spec.overrides == {
        "model.links.0.mass": 3,
        "states.dq1.upper": 9,
        "controls.u2.lower": -4,
        "states.q2.final": 1,
    }


def test_a_motor_with_dynamics_and_a_spring():
    """A name that the file declares is what it is there."""
    text = PENDULUM.replace("{for: i in 1..N, mass", "{for: i in 1..N, torque: -0.1*dq{i}, mass").replace(
        "motor: true", "motor: tau{i}"
    )
    text = text.replace(
        "objective:",
        '  tau{i}: {for: i in 1..N, rate: "u{i}", initial: 0}\ncontrols: {"u{i}": {for: i in 1..N}}\nobjective:',
    )
    text = text.replace("torque: -0.1*dq{i}", 'torque: "-0.1*dq{i}"').replace("motor: tau{i}", 'motor: "tau{i}"')
    spec = spec_of(text)
    assert [*spec.controls] == ["u1", "u2", "u3"] and [*spec.states] == ["q1", "q2", "q3", "tau1", "tau2", "tau3"]
    assert spec.residuals[2].expression.text.endswith("- tau3 - link3_torque")


def test_a_chain_in_phases():
    """Each phase may say something of its own of angles, rates and masses."""
    text = (
        PENDULUM.replace("mass: 1", "mass: m")
        .replace("T: 2}", "T: 2, m: 1}")
        .replace(
            "objective:",
            "phases:\n  up: {time: {final: 1}, states: {dq1: {final: 1}}}\n  on: {parameters: {m: 2}}\nobjective:",
        )
    )
    phases = build(spec_of(text)).phases
    assert [phase.name for phase in phases] == ["up", "on"]
    assert next(own for own in phases[0].states if own.name == "dq1").final.lower == 1


def test_mass_and_motion_are_found_together():
    text = CARTPOLE.replace("m2: 0.3, ", "").replace("mesh:", "optimize: {m2: {lower: 0.2, upper: 0.6}}\nmesh:")
    solution = solved(text)
    assert solution["m2"] == pytest.approx(0.2, abs=1e-6) and solution.objective < 58


def test_units_of_a_chain():
    spec = load(shipped()["double_pendulum_cart"], more=check_units)
    assert not spec.warnings
    with pytest.raises(trajopt.SpecError, match="is in"):
        load(shipped()["double_pendulum_cart"], ["parameters.l1.unit=kg"], more=check_units)


@pytest.mark.parametrize(
    "empty", ["", "constraints:\n", "constraints: {boundary: }\n", "constraints: {boundary: []}\n"]
)
def test_a_step_is_there_beside_constraints_that_are_left_empty(empty):
    """`boundary:` with nothing behind it took the conditions of the step away."""
    walker = """\
model:
  kind: chain
  zero: up
  links: [{name: a, mass: 1, length: 1, motor: true}, {name: b, mass: 1, length: 1, zero: down, motor: true}]
  step: {foot: b, swap: [[a, b]]}
time: {initial: 0, final: 1}
objective: {minimize: {integral: u1**2 + u2**2}}
"""
    names = [own.name for own in spec_of(walker + empty).constraints.boundary]
    assert names == ["step q1", "step q2", "strike q1", "strike q2"]
