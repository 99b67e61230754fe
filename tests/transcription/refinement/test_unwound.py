"""Angles that mean the same: a heading that jumps by 2 pi between points becomes a curve, and nothing else does."""

import numpy as np
import pytest

import trajopt
from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.transcription.layout import bounded_start
from trajopt.transcription.refinement.unwound import unwound
from trajopt.transcription.schemes.mesh import Mesh
from trajopt.transcription.schemes.table import find
from trajopt.transcription.transcribe import program

SHIP = """\
trajopt: 1
name: ship
time: {initial: 0, final: {lower: 0, upper: 20}}
states:
  x: {rate: cos(a) - y/3, initial: 0, final: -4}
  y: {rate: sin(a), initial: 0, final: 1}
controls: {a: {}}
objective: {minimize: {terminal: "t[final]"}}
"""
THRUST = """\
trajopt: 1
name: thrust, whose direction is twice the angle of a nozzle
time: {initial: 0, final: 1}
states:
  x: {rate: u, initial: 0, final: 0.2}
  y: {rate: v, initial: 0}
  u: {rate: cos(2*b), initial: 0}
  v: {rate: sin(2*b) - 0.1*u, initial: 0}
controls: {b: {}}
objective: {maximize: {terminal: "v[final]"}}
"""
WOUND = "guess: {keyframes: {%s: [0, 13, -7, 20, 3]}}\n"


@pytest.mark.parametrize(("text", "name"), [(SHIP, "a"), (THRUST, "b")])
def test_a_wild_guess_of_an_angle_leads_to_a_curve(text, name):
    """The same optimum, on as few segments, as from a guess near it."""
    wild = trajopt.solve(trajopt.load(text + WOUND % name))
    tame = trajopt.solve(trajopt.load(text))
    assert wild.solved
    assert wild.objective == pytest.approx(tame.objective, rel=1e-6)
    times = np.linspace(0, wild.time[-1], 500)
    assert np.abs(np.diff(wild[name](times))).max() < 0.3
    assert wild.meshes[-1].unknowns < 1000


def turned(text: str, control: str, method: str = "radau"):
    """A program, its unknowns, and the same with a control moved by whole turns at random points."""
    problem = build(load_text(text, "ship.yaml"))
    transcription, nlp, _ = program(problem, [Mesh.of(find(method), 6)], None)
    z, _, _ = bounded_start(transcription)
    rng = np.random.default_rng(0)
    z = z + rng.uniform(-0.2, 0.2, len(z))
    (layout,) = transcription.phases
    row = layout.u[[own.name for own in layout.phase.inputs].index(control)]
    other = z.copy()
    other[row[row >= 0]] += 2 * np.pi * rng.integers(-2, 3, np.count_nonzero(row >= 0))
    return transcription, nlp, z, other


@pytest.mark.parametrize("method", ["radau", "hermite-simpson", "trapezoid"])
def test_whole_turns_are_taken_off(method):
    transcription, nlp, z, other = turned(SHIP, "a", method)
    assert unwound(transcription, nlp, other) == pytest.approx(z, abs=1e-12)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("cos(a) - y/3", "cos(a) - y/3 + 0.01*a"),  # it counts how often the ship has turned
        ('terminal: "t[final]"', 'terminal: "t[final]", integral: "0.01*a**2"'),
        ('terminal: "t[final]"', 'terminal: "t[final]", integral: "log(a + 0.5)"'),  # not finite after a turn
        ("controls: {a: {}}", "controls: {a: {}}\nconstraints: {path: [{expression: a, lower: -50}]}"),
        ("{a: {}}", "{a: {lower: -20, upper: 20}}"),  # the mean would be within, single points are not
    ],
)
def test_what_depends_on_turns_stays(old, new):
    transcription, nlp, z, other = turned(SHIP.replace(old, new), "a")
    if "lower: -20" in new:
        assert unwound(transcription, nlp, other) == pytest.approx(z, abs=1e-12)  # all of it is within the bounds
    else:
        assert np.array_equal(unwound(transcription, nlp, other), other)


def test_bounds_of_an_angle_are_kept():
    transcription, nlp, _, other = turned(SHIP.replace("{a: {}}", "{a: {lower: 1, upper: 20}}"), "a")
    assert np.array_equal(unwound(transcription, nlp, other), other)


def test_a_jump_of_two_pi_of_a_force_is_a_jump():
    """Bang-bang between -pi and pi: the exact time is 2 sqrt(1/pi)."""
    text = SHIP.replace("cos(a) - y/3, initial: 0, final: -4", "y, initial: 0, final: 1").replace(
        "sin(a), initial: 0, final: 1", "a, initial: 0, final: 0"
    )
    solution = trajopt.solve(trajopt.load(text.replace("{a: {}}", "{a: {lower: -pi, upper: pi}}")))
    assert solution.solved and solution.objective == pytest.approx(2 / np.sqrt(np.pi), rel=1e-6)
    assert solution["a"](0.1) == pytest.approx(np.pi) and solution["a"](1.0) == pytest.approx(-np.pi)
