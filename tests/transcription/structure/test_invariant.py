"""Path equalities that the dynamics keep: asked for once, with the optimum of the problem without them."""

import math

import pytest

import trajopt
from trajopt.problems.build import build
from trajopt.problems.load import load_text

ATTITUDE = """\
trajopt: 1
time: {initial: 0, final: 10}
states:
  q1: {rate: 0.5*(w1*q4 - w2*q3), initial: 0, final: sin(1.2)}
  q2: {rate: 0.5*(w1*q3 + w2*q4), initial: 0, final: 0}
  q3: {rate: 0.5*(-w1*q2 + w2*q1), initial: 0}
  q4: {rate: 0.5*(-w1*q1 - w2*q2), initial: 1}
  w1: {rate: u1/5, initial: 0, final: 0}
  w2: {rate: u2/4, initial: 0, final: 0}
controls: {u1: {lower: -1, upper: 1}, u2: {lower: -1, upper: 1}}
constraints: {path: [{name: norm, expression: q1**2 + q2**2 + q3**2 + q4**2, equals: 1}]}
objective: {minimize: {integral: u1**2 + u2**2}}
"""
EPIDEMIC = """\
trajopt: 1
time: {initial: 0, final: 50}
parameters: {N: 1000, m: 0.01}
states:
  S: {rate: m*(N - S) - 0.5*S*I/N - u*S, initial: 990}
  I: {rate: 0.5*S*I/N - 0.2*I - m*I, initial: 10}
  R: {rate: 0.2*I + u*S - m*R, initial: 0}
controls: {u: {lower: 0, upper: 0.05}}
constraints: {path: [{name: all, expression: S + I + R, equals: N}]}
objective: {minimize: {integral: I/N + 5*u**2}}
"""
"""The sum is N at all times if it is at one, and not otherwise."""

SWING = """\
trajopt: 1
time: {initial: 0, final: 1}
states: {x: {rate: v + 0*u}, v: {rate: -x}}
controls: {u: {lower: -1, upper: 1}}
constraints: {path: [{name: energy, expression: x**2 + v**2, equals: 4}]}
objective: {minimize: {terminal: "x[final]", integral: u**2}}
"""


@pytest.mark.parametrize(("text", "name"), [(ATTITUDE, "norm"), (EPIDEMIC, "all")])
def test_it_does_not_change_the_optimum(text, name):
    found = trajopt.solve(trajopt.load(text))
    without = trajopt.solve(trajopt.load(text.replace(text[text.index("constraints:") : text.index("objective:")], "")))
    assert found.solved and found.objective == pytest.approx(without.objective, rel=1e-9)
    assert f"path constraint '{name}' is kept by the dynamics" in " ".join(found.notes)
    assert found[name](1.0) == pytest.approx(1 if name == "norm" else 1000, rel=1e-6)  # and is drawn all the same


REST = ATTITUDE.replace("w1*q2 + w2*q1), initial: 0}", "w1*q2 + w2*q1), initial: 0, final: 0}").replace(
    "w2*q2), initial: 1}", "w2*q2), initial: 1, final: cos(1.2)}"
)
COMPARTMENTS = """\
trajopt: 1
time: {initial: 0, final: 2}
states:
  a: {rate: -u*a, initial: 3, final: 1}
  b: {rate: u*a - v*b, initial: 0, final: 1.5}
  c: {rate: v*b, initial: 0, final: 0.5}
controls: {u: {}, v: {}}
constraints: {path: [{name: all, expression: a + b + c, equals: 3}]}
objective: {minimize: {integral: u**2 + v**2}}
"""


@pytest.mark.parametrize(
    ("text", "state", "value"),
    [(REST, "q1", math.sin(1.2)), (REST.replace("1.2", "0.5"), "q4", math.cos(0.5)), (COMPARTMENTS, "a", 1)],
)
def test_a_final_value_that_follows_from_the_others_is_met_and_costs_nothing(text, state, value):
    found = trajopt.solve(trajopt.load(text))
    assert found.solved and sum(mesh.iterations for mesh in found.meshes) < 80
    assert f"the final value of {state} follows from the other final values" in " ".join(found.notes)
    assert found[state](10.0 if text is not COMPARTMENTS else 2.0) == pytest.approx(value, abs=2.1e-6)


def test_final_values_stay_as_they_are_where_one_is_free():
    (phase,) = build(load_text(COMPARTMENTS.replace(", final: 0.5", ""), "file.yaml")).phases
    assert phase.kept and not phase.follows and [state.final.fixed for state in phase.states] == [True, True, False]


def test_it_is_asked_for_at_the_initial_time_where_that_is_free():
    solution = trajopt.solve(trajopt.load(SWING))
    assert solution.objective == pytest.approx(-2, abs=1e-7) and solution["energy"](0.7) == pytest.approx(4, abs=1e-6)


@pytest.mark.parametrize(
    ("text", "old", "new"),
    [
        (SWING, "v: {rate: -x}", "v: {rate: -x - 0.1*v}"),  # the energy falls
        (SWING, "x**2 + v**2", "x**2 + v**2 + u"),
        (EPIDEMIC, "- m*R", ""),  # the dead are not born again
    ],
)
def test_others_stay_as_they_are(text, old, new):
    (phase,) = build(load_text(text.replace(old, new), "file.yaml")).phases
    assert len(phase.path) == 1 and not phase.kept
