"""Equations that follow from others: told by name, held nearly, and the problem is solved as it is without them."""

import pytest

import trajopt
from trajopt.problems.build import build
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load_text

QUATERNION = """\
trajopt: 1
time: {initial: 0, final: 1}
states:
  q0: {rate: -0.5*(q1*w1 + q2*w2 + q3*w3), initial: 1, final: cos(1.3)}
  q1: {rate: 0.5*(q0*w1 + q2*w3 - q3*w2), initial: 0, final: 0.6*sin(1.3)}
  q2: {rate: 0.5*(q0*w2 + q3*w1 - q1*w3), initial: 0, final: 0.8*sin(1.3)}
  q3: {rate: 0.5*(q0*w3 + q1*w2 - q2*w1), initial: 0, final: 0}
  w1: {rate: u1 + 0.3*w2*w3, initial: 0, final: 0}
  w2: {rate: u2 - 0.2*w1*w3, initial: 0, final: 0}
  w3: {rate: u3 - 0.1*w1*w2, initial: 0, final: 0}
controls: {u1: {}, u2: {}, u3: {}}
objective: {minimize: {integral: u1**2 + u2**2 + u3**2}}
"""
REACTION = """\
trajopt: 1
time: {initial: 0, final: 2}
states:
  a: {rate: -u*a*b + 0.2*c, initial: 1, final: 0.4}
  b: {rate: -u*a*b + 0.2*c, initial: 0.8, final: 0.2}
  c: {rate: u*a*b - 0.2*c, initial: 0, final: 0.6}
controls: {u: {lower: 0}}
objective: {minimize: {integral: u**2}}
"""
PLANE = """\
trajopt: 1
time: {initial: 0, final: 1}
states:
  c: {rate: -w*s, initial: 1, final: cos(2)}
  s: {rate: w*c, initial: 0, final: sin(2)}
  w: {rate: u, initial: 0, final: 0}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
"""
"""A turn by 2 rad in 1 s from rest to rest: w = 12 t (1 - t), J = 12 * 2^2."""

MOVE = """\
trajopt: 1
time: {initial: 0, final: 1}
states:
  x: {rate: v, initial: 0}
  v: {rate: u - 0.1*v**2, initial: 0}
  y: {rate: w, initial: 0}
  w: {rate: a, initial: 0}
controls: {u: {}, a: {}}
objective: {minimize: {integral: u**2 + a**2}}
constraints:
  boundary:
    - {name: sum, expression: "x[final] + y[final]", equals: 1}
    - {name: difference, expression: "x[final] - y[final]", equals: 0.5}
MORE
"""
TWICE = '    - {name: again, expression: "2*x[final] + 2*y[final]", equals: 2}'
THIRD = '    - {name: third, expression: "2*x[final]", equals: 1.5}'
SQUARE = '    - {name: area, expression: "x[final]**2 - y[final]**2", equals: 0.5}'


def bar(found):
    return found.meshes[-1].objective_error


def built(text):
    (phase,) = build(load_text(text, "file.yaml")).phases
    return phase


@pytest.mark.parametrize(
    ("text", "free", "iterations"),
    [(QUATERNION, "0.8*sin(1.3)", 20), (REACTION, "0.2}", 40), (PLANE, "sin(2)", 20)],
)
def test_final_values_that_the_dynamics_tie_together(text, free, iterations):
    """As exact as the same problem with one of them free: 82 iterations and a bar of 0.02 for the quaternion before."""
    found = trajopt.solve(trajopt.load(text))
    assert found.solved and sum(mesh.iterations for mesh in found.meshes) <= iterations
    assert bar(found) < 1e-5
    assert "follows from the other final values" in " ".join(found.notes)
    start = text.rindex(", final: ", 0, text.index(free))
    without = trajopt.solve(trajopt.load(text[:start] + text[text.index("}", start) :]), guess=found)
    assert abs(found.objective - without.objective) <= bar(found) + bar(without)


def test_a_turn_has_its_exact_optimum():
    found = trajopt.solve(trajopt.load(PLANE))
    assert abs(found.objective - 48) <= bar(found) < 1e-5
    assert found["c"](1.0) ** 2 + found["s"](1.0) ** 2 == pytest.approx(1, abs=1e-6)


@pytest.mark.parametrize(
    ("more", "name", "others"),
    [(TWICE, "again", ("sum",)), (THIRD, "third", ("sum", "difference")), (SQUARE, "area", ("sum", "difference"))],
)
def test_a_constraint_that_follows_is_named_with_what_it_follows_from(more, name, others):
    text = MOVE.replace("MORE", more)
    assert built(text).implied == {name: others}
    found, without = trajopt.solve(trajopt.load(text)), trajopt.solve(trajopt.load(MOVE.replace("MORE", "")))
    assert found.solved and sum(mesh.iterations for mesh in found.meshes) < 20
    assert f"constraint '{name}' follows from {' and '.join(others)}" in " ".join(found.notes)
    assert abs(found.objective - without.objective) <= bar(found) + bar(without)


def test_one_that_follows_from_given_final_values():
    text = MOVE.replace("x: {rate: v, initial: 0}", "x: {rate: v, initial: 0, final: 0.75}").replace("MORE", THIRD)
    assert built(text).implied == {"difference": ("sum", "x[final]"), "third": ("x[final]",)}


def test_a_path_equality_given_twice():
    one, two = ("{name: one, expression: u - 2*a, equals: 0}", "{name: two, expression: 4*a - 2*u, equals: 0}")
    path = f"  path: [{one}, {two}]"
    assert built(MOVE.replace("MORE", path)).implied == {"two": ("one",)}


@pytest.mark.parametrize(
    ("text", "old", "new", "follow"),
    [
        (MOVE.replace("MORE", THIRD), "equals: 1.5", "equals: 1.4", 0),  # they contradict each other
        (MOVE.replace("MORE", THIRD), "2*x[final]", "2*x[final] + 0.1*v[final]", 0),
        (MOVE.replace("MORE", SQUARE), '**2", equals', '**2", lower', 0),
        (REACTION, "b: {rate: -u*a*b", "b: {rate: -u*a*b - 0.01*b", 1),
        (REACTION, "c: {rate: u*a*b - 0.2*c, initial: 0,", "c: {rate: u*a*b - 0.2*c,", 1),
    ],
)
def test_what_does_not_follow_stays_as_it_is(text, old, new, follow):
    assert old in text
    phase = built(text.replace(old, new))
    assert not phase.implied and len(phase.follows) == follow


@pytest.mark.parametrize(
    ("text", "old", "new", "line", "kept"),
    [
        (REACTION, "final: 0.2}", "final: 0.3}", 6, "b + c, which is 0.8 at the initial and 0.9 at the final time"),
        (PLANE, "sin(2)", "sin(2) + 1e-4", 5, "c**2 + s**2, which is 1 at the initial and 1.000182 at"),
        (QUATERNION, "0.6*sin", "0.7*sin", 7, "q0**2 + q1**2 + q2**2 + q3**2, which is 1 at the initial and 1.1206"),
    ],
)
def test_final_values_that_the_dynamics_do_not_lead_to_are_refused(text, old, new, line, kept):
    assert old in text
    with pytest.raises(SpecError) as raised:
        load_text(text.replace(old, new), "file.yaml")
    (mistake,) = raised.value.mistakes
    assert f":{line}: states" in mistake.where and f"the dynamics keep {kept}" in mistake.what


@pytest.mark.parametrize("unit", [1e-7, 1.0, 1e8])
def test_whether_final_values_agree_does_not_depend_on_their_unit(unit):
    """Held to 1e-6 of 1 + the largest value before, values of 1e-7 agreed whatever they were."""
    text = REACTION.replace("*a*b", f"*a*b/{unit}")
    for value in ("1", "0.8", "0.4", "0.2", "0.6"):
        text = text.replace(f"al: {value}", f"al: {unit}*{value}")
    (phase,) = build(load_text(text, "file.yaml")).phases
    finals = [state.final for state in phase.states if state.name in phase.follows]
    assert len(finals) == 2  # a + c and b + c are kept
    assert all(0 < final.upper - final.lower < 2.1e-6 * unit for final in finals)
    with pytest.raises(SpecError, match="cannot be reached"):
        load_text(text.replace(f"al: {unit}*0.2", f"al: {unit}*0.2001"), "file.yaml")
