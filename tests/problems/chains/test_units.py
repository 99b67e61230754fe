"""Units in a chain of links: what is wrong is told at the value of the file, not in equations that were made."""

import pytest

from trajopt.problems.errors import SpecError
from trajopt.problems.load import load_text
from trajopt.problems.units.check import check_units

CHAIN = """\
trajopt: 1
parameters: {m: {value: 0.3, unit: kg}, l: {value: 0.5, unit: m}, g: {value: 9.81, unit: m/s^2}}
time: {initial: 0, final: 2}
model:
  kind: chain
  base: cart
  gravity: g
  cart: {mass: 1.0, motor: u}
  links:
    - {name: pole, mass: m, length: l, com: l, inertia: 0}
    - {name: bob, mass: 0.1, length: 0.2, motor: true}
states:
  x: {initial: 0, final: 1}
  q1: {initial: 0, final: pi}
  dq1: {initial: 0, final: 0}
controls:
  u: {lower: -20, upper: 20}
objective: {minimize: {integral: u**2}}
"""


def told(*changes: tuple[str, str]) -> list[str]:
    """What is said of the chain with pieces of it replaced, without the name of the file."""
    text = CHAIN
    for old, new in changes:
        assert text.count(old) == 1
        text = text.replace(old, new)
    try:
        spec = load_text(text, "x.yaml", more=check_units)
    except SpecError as error:
        return [str(own).removeprefix("x.yaml:") for own in error.mistakes]
    return [str(own).removeprefix("x.yaml:") for own in spec.warnings]


def test_the_chain_is_in_order():
    assert told() == []


UNITS = [
    ("mass: m", "mass: l", "10: model.links.0.mass: the mass of pole is in m, and the chain needs it in kg"),
    ("length: l", "length: m", "10: model.links.0.length: the length of pole is in kg, and the chain needs it in m"),
    ("inertia: 0", "inertia: m*l", "10: model.links.0.inertia: the inertia of pole is in kg*m, and"),
    ("gravity: g", "gravity: g*l", "7: model.gravity: the gravity is in m^2/s^2, and the chain needs it in m/s^2"),
    ("mass: 1.0", "mass: l", "8: model.cart.mass: the mass of the cart is in m, and the chain needs it in kg"),
    ("motor: true", "motor: true, torque: m*g", "11: model.links.1.torque: the torque of bob is in kg*m/s^2, and"),
    ("base: cart", "base: cart\n  forces: [{link: bob, x: m*l, y: 0}]", "7: model.forces.0.x: the force on bob is in"),
    ("u: {", "u: {unit: N*m, ", "17: controls.u.unit: the motor u is in N*m, and the chain needs it in N; "),
    ("x: {", "x: {unit: cm, ", "13: states.x.unit: the state x is in cm, and the chain needs it in m; multiply it by"),
    ("  q1: {", "  q1: {unit: deg, ", "14: states.q1.unit: the state q1 is in deg, and"),
    ("dq1: {", "dq1: {unit: m/s, ", '15: states.dq1: the rate of q1 is in rad/s, and "dq1" in m/s'),
    ("unit: kg", "unit: g", "10: model.links.0.mass: the mass of pole is in g, and the chain needs it in kg"),
    ("final: 2", "final: 2, unit: min", "3: time.unit: the time is in min, and the chain needs it in s"),
]


@pytest.mark.parametrize(("old", "new", "says"), UNITS, ids=[own[1].replace("\n", " ") for own in UNITS])
def test_a_unit_is_told_where_it_is_given(old, new, says):
    sentences = told((old, new))
    assert len(sentences) == 1 and sentences[0].startswith(says), sentences
    assert "chain_" not in sentences[0] and "pole_" not in sentences[0]


def test_another_system_of_units_is_no_mistake():
    assert not told(
        ("unit: kg", "unit: g"),
        ("unit: m}", "unit: cm}"),
        ("unit: m/s^2", "unit: cm/s^2"),
        ("u: {", "u2: {unit: g*cm^2/s^2}\n  u: {unit: g*cm/s^2, "),
        ("x: {", "x: {unit: cm, "),
    )


CONSTANTS = [
    ("gravity: g", "gravity: g*(1 + t/t[final])", "model.gravity: the gravity"),
    ("gravity: g", "gravity: g*t", "model.gravity: the gravity"),
    ("gravity: g", "gravity: g*x/l", "model.gravity: the gravity"),
    ("mass: m", "mass: m*(1 + sin(q1))", "model.links.0.mass: the mass"),
    ("com: l", "com: l*sin(q1)**2", "model.links.0.com: the com"),
    ("length: 0.2", "length: 0.2, at: l*sin(q1)**2", "model.links.1.at: the at"),
]


@pytest.mark.parametrize(("old", "new", "says"), CONSTANTS, ids=[own[1] for own in CONSTANTS])
def test_what_the_equations_take_as_constant_may_not_vary(old, new, says):
    sentences = told((old, new))
    assert len(sentences) == 1, sentences
    assert f"{says} of a chain is one number, and this varies in time; make it of numbers and pa" in sentences[0]


def test_gravity_may_be_below_zero_and_found():
    assert not told(("gravity: g", "gravity: -g"))
    assert not told(("gravity: g", "gravity: g*p"), ("objective:", "optimize: {p: {lower: 0.5, upper: 1}}\nobjective:"))
