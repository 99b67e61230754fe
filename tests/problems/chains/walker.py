"""The walking problem of the paper's section 7, with numbers, constraints and meshes of a test's own."""

import numpy as np

from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.problems.problem import Problem
from trajopt.transcription.settings import Step
from trajopt.transcription.solve import solve

HS = "hermite-simpson"
LINKS = range(1, 6)
TABLE_4 = {
    "m": (3.2, 6.8, 20.0, 6.8, 3.2),
    "I": (0.93, 1.08, 2.22, 1.08, 0.93),
    "l": (0.4, 0.4, 0.625, 0.4, 0.4),
    "d": (0.128, 0.163, 0.2, 0.163, 0.128),
}
LOPSIDED = {  # no two links alike: nothing may be right by symmetry
    "m": (3.2, 6.8, 20.0, 5.1, 2.3),
    "I": (0.93, 1.08, 2.22, 0.71, 0.55),
    "l": (0.41, 0.37, 0.625, 0.44, 0.39),
    "d": (0.128, 0.163, 0.2, 0.21, 0.19),
}
G, STEP, T = 9.81, 0.5, 0.7
Q0 = np.array([-0.3, 0.7, 0.0, -0.5, -0.6])  # (7.8)
SUPPLEMENT = {"d3": 0.425}
KNEES = (
    {"name": "stance_knee", "expression": "q1 - q2", "upper": 0},
    {"name": "swing_knee", "expression": "q5 - q4", "upper": 0},
)
STRIDE = "step: {foot: swing_tibia, swap: [[stance_tibia, swing_tibia], [stance_femur, swing_femur]]}"
CHAIN = """
kind: chain, gravity: g, zero: up, links: [
  {name: stance_tibia, mass: m1, length: l1, com: l1 - d1, inertia: I1, motor: true},
  {name: stance_femur, mass: m2, length: l2, com: l2 - d2, inertia: I2, motor: true},
  {name: torso, mass: m3, length: l3, com: d3, inertia: I3, motor: true},
  {name: swing_femur, parent: torso, at: 0, mass: m4, length: l4, com: d4, inertia: I4, motor: true, zero: down},
  {name: swing_tibia, mass: m5, length: l5, com: d5, inertia: I5, motor: true, zero: down}]"""


def parameters(table=TABLE_4, **changes) -> dict[str, float]:
    rows = {f"{symbol}{i}": value for symbol, row in table.items() for i, value in zip(LINKS, row, strict=True)}
    return {**rows, "g": G, "step_length": STEP, **changes}


def biped(path=(), table=TABLE_4, model="five_link_biped", **changes) -> Problem:
    """The walking problem of the paper's section 7, for Table 4 with some parameters changed."""
    frames = {f"q{i}": [float(Q0[i - 1]), float(Q0[5 - i])] for i in LINKS}  # (7.8), (7.9)
    bounds = {"q": "lower: -pi/2, upper: pi/2", "dq": "lower: -10, upper: 10"}
    states = ", ".join(f"{name}{i}: {{{own}}}" for name, own in bounds.items() for i in LINKS)
    motors = ", ".join(f"u{i}: {{lower: -100, upper: 100}}" for i in LINKS[1:])
    rates = {f"dq{i}": (last - first) / T for i, (first, last) in zip(LINKS, frames.values(), strict=True)}  # (7.10)
    text = f"""
trajopt: 1
model: {model}
parameters: {parameters(table, **changes)}
time: {{initial: 0, final: {T}}}
states: {{{states}}}
controls: {{u1: {{lower: 0, upper: 0}}, {motors}}}  # the ankle has no motor
constraints: {{path: {list(path)}}}
objective: {{minimize: {{integral: u1**2 + u2**2 + u3**2 + u4**2 + u5**2}}}}  # (7.1)
guess: {{keyframes: {frames}, constants: {rates}}}
"""
    return build(load_text(text, "biped.yaml"))


def run(problem: Problem, *schedule: tuple):
    solution = solve(problem, [Step(*entry) for entry in schedule])
    assert solution.solved, solution.status
    return solution
