"""Chains against Lagrange's equations by SymEngine, and against files with the equations written out."""

import numpy as np
import pytest

from trajopt.problems.build import build
from trajopt.problems.load import load_text

from .lagrange import Link, Robot

HEAD = 'trajopt: 1\ntime: {initial: 0, final: {lower: 1, upper: 2}}\nobjective: {minimize: {terminal: "t[final]"}}\n'


def model(robot: Robot) -> str:
    """The section `model:` of a robot, in numbers."""
    lines = [f"model:\n  kind: chain\n  base: {robot.base}\n  gravity: {robot.g}\n"]
    lines += ["  angles: relative\n"] * robot.relative
    lines += [f"  cart: {{mass: {robot.cart}, force: {robot.push}}}\n"] * (robot.base == "cart")
    lines += ["  links:\n"]
    for i, link in enumerate(robot.links):
        on = "base" if link.on < 0 else f"b{link.on}"
        keys = [f"name: b{i}, mass: {link.m}, length: {link.l}, com: {link.d}, inertia: {link.I}, parent: {on}"]
        keys += [f"at: {link.at}"] * (link.at is not None)
        joint = f"prismatic, force: {link.force}" if link.slides else "fixed"
        keys += [f"joint: {joint}, turn: {link.turn}"] * (link.turn is not None)
        pointed = link.on < 0 if link.slides else link.turn is None and not (robot.relative and link.on >= 0)
        keys += [f"zero: {link.zero}"] * pointed
        keys += [f"torque: {link.torque}"] * (link.torque != 0)
        lines.append(f"    - {{{', '.join(keys)}}}\n")
    lines += ["  forces:\n"] * bool(robot.forces)
    lines += [f"    - {{link: b{n}, at: {d}, x: {fx}, y: {fy}}}\n" for n, d, fx, fy in robot.forces]
    return "".join(lines)


def values_at(phase, q, dq, ddq) -> dict[str, float]:
    names = [state.name for state in phase.states]
    half = len(names) // 2
    rates = [own.name for own in phase.algebraic]
    return {"t": 0.0, **dict(zip((*names, *rates), (*q, *dq, *ddq), strict=True)), "half": half}


def residuals(phase, q, dq, ddq) -> np.ndarray:
    values = values_at(phase, q, dq, ddq)
    return np.array([row.function(values, np) for row in phase.residuals])


ROBOTS = {
    "one link": Robot([Link(1.3, 0.7, 0.3, 0.05)]),
    "a double pendulum": Robot(
        [Link(1.3, 0.7, 0.3, 0.05, zero="up"), Link(0.8, 0.5, 0.2, 0.02, on=0, torque=1.7, zero="up")]
    ),
    "relative angles": Robot(
        [
            Link(1.3, 0.7, 0.3, 0.05, torque=-2.0, zero="right"),
            Link(0.8, 0.5, 0.2, 0.02, on=0, torque=1.7),
            Link(0.4, 0.3, 0.1, 0.01, on=1, torque=0.3),
        ],
        relative=True,
    ),
    "a tree": Robot(
        [
            Link(1.3, 0.7, 0.3, 0.05, zero="up"),
            Link(0.8, 0.5, 0.2, 0.02, on=0, torque=2.0),
            Link(0.4, 0.3, 0.1, 0.01, on=0, at=0.45, zero="left"),
            Link(0.3, 0.2, 0.1, 0.005, on=2, torque=-0.4, zero="right"),
        ],
        forces=[(3, 0.15, 1.2, -0.7), (0, 0.2, 0.5, 0.0)],
    ),
    "two poles on a cart": Robot(
        [Link(0.5, 1.0, 0.5, 0.04), Link(0.2, 0.6, 0.3, 0.01)], base="cart", cart=2.0, push=1.5
    ),
    "a fixed joint": Robot(
        [
            Link(1.3, 0.7, 0.3, 0.05),
            Link(0.8, 0.5, 0.2, 0.02, on=0, turn=0.6),
            Link(0.4, 0.3, 0.1, 0.01, on=1, torque=0.9),
        ],
        base="cart",
        cart=1.1,
    ),
    "a tree of relative angles that flies": Robot(
        [
            Link(1.3, 0.7, 0.3, 0.05, zero="up"),
            Link(0.8, 0.5, 0.2, 0.02, on=0, torque=2.0),
            Link(0.4, 0.3, 0.1, 0.01, on=0, at=0.45, turn=-0.3),
            Link(0.3, 0.2, 0.1, 0.005, on=2, torque=-0.4),
        ],
        base="floating",
        relative=True,
        g=1.62,
        forces=[(1, 0.5, 3.0, 4.0)],
    ),
    "an arm that slides out": Robot(
        [Link(1.3, 0.7, 0.3, 0.05, torque=1.1), Link(0.8, 0.5, 0.2, 0.02, on=0, turn=0, slides=True, force=2.3)],
        forces=[(1, 0.4, 3.0, 4.0)],
    ),
    "two slides, one across the other, and an arm on them": Robot(
        [
            Link(1.3, 0.7, 0.3, 0.05, zero="right", turn=0.2, slides=True, force=-1.0),
            Link(0.8, 0.5, 0.2, 0.02, on=0, at=0.3, turn=1.4, slides=True, force=0.7),
            Link(0.4, 0.3, 0.1, 0.01, on=1, at=0.0, torque=0.9),
            Link(0.3, 0.2, 0.1, 0.005, on=1, torque=-0.4),
        ]
    ),
    "legs that slide and turn, in flight": Robot(
        [
            Link(1.3, 0.7, 0.3, 0.05, zero="up"),
            Link(0.8, 0.5, 0.2, 0.02, on=0, torque=2.0),
            Link(0.4, 0.3, 0.1, 0.01, on=1, turn=0.0, slides=True, force=5.0),
            Link(0.3, 0.2, 0.1, 0.005, on=2, torque=-0.4),
            Link(0.2, 0.2, 0.1, 0.005, on=3, at=0.1, turn=-0.5, slides=True, force=-1.5),
        ],
        base="floating",
        relative=True,
        forces=[(4, 0.15, 1.2, -0.7)],
    ),
    "a hoist on a cart": Robot(
        [Link(0.1, 0.2, 0.1, 0.01), Link(2.0, 0.3, 0.15, 0.02, on=0, at=0.0, turn=0.0, slides=True, force=-18.0)],
        base="cart",
        cart=3.0,
        push=4.0,
    ),
    "in a horizontal plane": Robot([Link(1.3, 0.7, 0.3, 0.05), Link(0.8, 0.5, 0.2, 0.02, on=0)], g=0.0),
}


@pytest.mark.parametrize("name", ROBOTS)
def test_the_equations_are_those_of_lagrange(name):
    robot, rng = ROBOTS[name], np.random.default_rng(3)
    (phase,) = build(load_text(HEAD + model(robot), "chain.yaml")).phases
    for _ in range(3):
        q, dq, ddq = rng.uniform(-2, 2, (3, robot.coordinates))
        found = residuals(phase, q, dq, ddq)
        assert found == pytest.approx(robot.residuals(q, dq, ddq), rel=1e-11, abs=1e-11)


@pytest.mark.parametrize("robot", ["a tree of relative angles that flies", "legs that slide and turn, in flight"])
def test_a_moving_tip_and_the_centre_of_mass(robot):
    """Positions, velocities and accelerations of points against finite differences along a motion."""
    robot = ROBOTS[robot]
    asked = [f"{name}_{kind}{axis}" for name in ("b3", "com") for kind in ("", "v", "a") for axis in "xy"]
    text = (
        model(robot)
        + "constraints:\n  path:\n"
        + "".join(f"    - {{expression: {own}, upper: 100}}\n" for own in asked)
    )
    (phase,) = build(load_text(HEAD + text, "chain.yaml")).phases
    rows = dict(zip(asked, phase.path, strict=True))
    rng = np.random.default_rng(5)
    q, dq, ddq = rng.uniform(-2, 2, (3, robot.coordinates))
    step = 1e-4

    def at(time, name):
        values = values_at(phase, q + dq * time + ddq * time**2 / 2, dq + ddq * time, ddq)
        return rows[name].function(values, np)

    for name in ("b3", "com"):
        for axis in "xy":
            for low, high in (("", "v"), ("v", "a")):
                slope = (at(step, f"{name}_{low}{axis}") - at(-step, f"{name}_{low}{axis}")) / (2 * step)
                assert at(0.0, f"{name}_{high}{axis}") == pytest.approx(slope, rel=1e-6, abs=1e-6)
    assert robot.equations
    tip = [float(own.subs(dict(zip(robot.z, q, strict=True)))) for own in robot.tips[3]]
    assert [at(0.0, f"b3_{axis}") for axis in "xy"] == pytest.approx(tip, rel=1e-13)
