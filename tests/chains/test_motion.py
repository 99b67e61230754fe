"""Chains against Lagrange's equations by SymPy, against files with the equations written out, and against the biped."""

import numpy as np
import pytest
from walker import LINKS, LOPSIDED, G, parameters

from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.problems.models import find_model

from .lagrange import Link, Robot

HEAD = "trajopt: 1\ntime: {initial: 0, final: {lower: 1, upper: 2}}\nobjective: {minimize: {terminal: \"t[final]\"}}\n"


def model(robot: Robot) -> str:
    """The section `model:` of a robot, with a number for each parameter, by name where that is another way to say it."""
    lines = [f"model:\n  kind: chain\n  base: {robot.base}\n  gravity: {robot.g}\n"]
    lines += ["  angles: relative\n"] * robot.relative
    lines += [f"  cart: {{mass: {robot.cart}, force: {robot.push}}}\n"] * (robot.base == "cart")
    lines += ["  links:\n"]
    for i, link in enumerate(robot.links):
        on = "base" if link.on < 0 else f"b{link.on}"
        keys = [f"name: b{i}, mass: {link.m}, length: {link.l}, com: {link.d}, inertia: {link.I}, on: {on}"]
        keys += [f"at: {link.at}"] * (link.at is not None)
        keys += [f"joint: fixed, turn: {link.turn}"] * (link.turn is not None)
        keys += [f"zero: {link.zero}"] * (link.turn is None and not (robot.relative and link.on >= 0))
        keys += [f"torque: {link.torque}"] * (link.torque != 0)
        lines.append(f"    - {{{', '.join(keys)}}}\n")
    lines += ["  forces:\n"] * bool(robot.forces)
    lines += [f"    - {{on: b{n}, at: {d}, x: {fx}, y: {fy}}}\n" for n, d, fx, fy in robot.forces]
    return "".join(lines)


def values_at(phase, q, dq, ddq) -> dict[str, float]:
    names = [state.name for state in phase.states]
    half = len(names) // 2
    rates = [own.name for own in phase.algebraic]
    return {"t": 0.0, **dict(zip((*names, *rates), (*q, *dq, *ddq), strict=True)), "half": half}


def residuals(text: str, q, dq, ddq) -> np.ndarray:
    (phase,) = build(load_text(HEAD + text, "chain.yaml")).phases
    values = values_at(phase, q, dq, ddq)
    return np.array([row.function(values, np) for row in phase.residuals])


ROBOTS = {
    "one link": Robot([Link(1.3, 0.7, 0.3, 0.05)]),
    "a double pendulum": Robot([Link(1.3, 0.7, 0.3, 0.05, zero="up"), Link(0.8, 0.5, 0.2, 0.02, on=0, torque=1.7, zero="up")]),
    "relative angles": Robot(
        [Link(1.3, 0.7, 0.3, 0.05, torque=-2.0, zero="right"), Link(0.8, 0.5, 0.2, 0.02, on=0, torque=1.7), Link(0.4, 0.3, 0.1, 0.01, on=1, torque=0.3)],
        relative=True,
    ),
    "a tree": Robot(
        [Link(1.3, 0.7, 0.3, 0.05, zero="up"), Link(0.8, 0.5, 0.2, 0.02, on=0, torque=2.0), Link(0.4, 0.3, 0.1, 0.01, on=0, at=0.45, zero="left"),
         Link(0.3, 0.2, 0.1, 0.005, on=2, torque=-0.4, zero="right")],
        forces=[(3, 0.15, 1.2, -0.7), (0, 0.2, 0.5, 0.0)],
    ),
    "two poles on a cart": Robot([Link(0.5, 1.0, 0.5, 0.04), Link(0.2, 0.6, 0.3, 0.01)], base="cart", cart=2.0, push=1.5),
    "a fixed joint": Robot(
        [Link(1.3, 0.7, 0.3, 0.05), Link(0.8, 0.5, 0.2, 0.02, on=0, turn=0.6), Link(0.4, 0.3, 0.1, 0.01, on=1, torque=0.9)], base="cart", cart=1.1,
    ),
    "a tree of relative angles that flies": Robot(
        [Link(1.3, 0.7, 0.3, 0.05, zero="up"), Link(0.8, 0.5, 0.2, 0.02, on=0, torque=2.0), Link(0.4, 0.3, 0.1, 0.01, on=0, at=0.45, turn=-0.3),
         Link(0.3, 0.2, 0.1, 0.005, on=2, torque=-0.4)],
        base="floating", relative=True, g=1.62, forces=[(1, 0.5, 3.0, 4.0)],
    ),
    "in a horizontal plane": Robot([Link(1.3, 0.7, 0.3, 0.05), Link(0.8, 0.5, 0.2, 0.02, on=0)], g=0.0),
}  # fmt: skip


@pytest.mark.parametrize("name", ROBOTS)
def test_the_equations_are_those_of_lagrange(name):
    robot, rng = ROBOTS[name], np.random.default_rng(3)
    moving = sum(link.turn is None for link in robot.links) + {"fixed": 0, "cart": 1, "floating": 2}[robot.base]
    for _ in range(3):
        q, dq, ddq = rng.uniform(-2, 2, (3, moving))
        found = residuals(model(robot), q, dq, ddq)
        assert found == pytest.approx(robot.residuals(q, dq, ddq), rel=1e-11, abs=1e-11)
