"""Vectors: they are the scalars that they stand for, and their functions are right."""

import re

import numpy as np
import pytest
import yaml
from repository import ROOT
from scipy.spatial.transform import Rotation

import trajopt
from trajopt.problems.build import build
from trajopt.problems.errors import SpecError
from trajopt.problems.expressions.expression import parse
from trajopt.problems.language.json_schema import schema
from trajopt.problems.load import load_text
from trajopt.problems.vectors.algebra import Scalar
from trajopt.problems.vectors.reader import evaluate
from trajopt.transcription.loading import load_yaml

SHORT = """\
trajopt: 1
name: all of it
parameters: {N: 2, g: {value: [0, -9.81], unit: m/s^2}, A: [[1, 2], [3, 4]], m: 2}
time: {initial: 0, final: 2}
tables:
  rho: {points: {h: [-9, 0, 9]}, values: [1, 2, 4]}
expressions:
  drag(v): "-norm(v)*v"
  twice(x): 2*x
  L: r[1]*v[2] - r[2]*v[1]
  air: {value: rho(r), note: of each}
states:
  r: {size: N, unit: m, rate: v, lower: -5, initial: 0, final: [1, {lower: 2, upper: 3}]}
  v: {size: 2, rate: "A @ (F + drag(v))/m + g + twice(L)*F", initial: [0, m]}
  p: {size: 2, accel: -p, velocity: {name: s, initial: [1, 2]}, history: 0}
  w: {size: 2}
  y: {rate: "dot(F, v) + s[1] + p_dot*0"}
controls:
  F: {size: 2, lower: [-1, -2], upper: 9}
residuals: ["w[rate] - [F[2], F[1]]"]
integrals: {work: F*v}
constraints:
  path: [{name: box, expression: r, lower: [0, -1], upper: 9}, {expression: norm(r - v), upper: 9}]
  boundary: [{expression: "r[final] - v[initial]", equals: 0}, {expression: "sum(integral.work)", upper: 5}]
guess: {constants: {F: [1, 2], "w[rate]": 3}, keyframes: {time: [0, 1], r: [[0, 0], [1, 2]]}}
scaling: {r: 2}
drawing: [{point: r}, {line: [[0, 0], "2*r"]}]
objective: {minimize: {integral: "dot(F, F) + sum(i in 1..N, r[{i}]**2)", terminal: "norm(v[final])"}}
"""

LONG = """\
trajopt: 1
name: all of it
parameters: {N: 2, g1: {value: 0, unit: m/s^2}, g2: {value: -9.81, unit: m/s^2}, A11: 1, A12: 2, A21: 3, A22: 4, m: 2}
time: {initial: 0, final: 2}
tables:
  rho: {points: {h: [-9, 0, 9]}, values: [1, 2, 4]}
expressions:
  twice(x): 2*x
  L: r1*v2 - r2*v1
  air1: {value: rho(r1), note: of each}
  air2: {value: rho(r2), note: of each}
states:
  r1: {unit: m, rate: v1, lower: -5, initial: 0, final: 1}
  r2: {unit: m, rate: v2, lower: -5, initial: 0, final: {lower: 2, upper: 3}}
  v1: {rate: "(A11*(F1 - norm(v1, v2)*v1) + A12*(F2 - norm(v1, v2)*v2))/m + g1 + twice(L)*F1", initial: 0}
  v2: {rate: "(A21*(F1 - norm(v1, v2)*v1) + A22*(F2 - norm(v1, v2)*v2))/m + g2 + twice(L)*F2", initial: m}
  p1: {accel: -p1, velocity: {name: s1, initial: 1}, history: 0}
  p2: {accel: -p2, velocity: {name: s2, initial: 2}, history: 0}
  w1: {}
  w2: {}
  y: {rate: "F1*v1 + F2*v2 + s1"}
controls:
  F1: {lower: -1, upper: 9}
  F2: {lower: -2, upper: 9}
residuals: ["w1[rate] - F2", "w2[rate] - F1"]
integrals: {work1: F1*v1, work2: F2*v2}
constraints:
  path:
    - {name: box 1, expression: r1, lower: 0, upper: 9}
    - {name: box 2, expression: r2, lower: -1, upper: 9}
    - {expression: "norm(r1 - v1, r2 - v2)", upper: 9}
  boundary:
    - {expression: "r1[final] - v1[initial]", equals: 0}
    - {expression: "r2[final] - v2[initial]", equals: 0}
    - {expression: "integral.work1 + integral.work2", upper: 5}
guess: {constants: {F1: 1, F2: 2, "w1[rate]": 3, "w2[rate]": 3}, keyframes: {time: [0, 1], r1: [0, 1], r2: [0, 2]}}
scaling: {r1: 2, r2: 2}
drawing: [{point: [r1, r2]}, {line: [[0, 0], [2*r1, 2*r2]]}]
objective: {minimize: {integral: "F1*F1 + F2*F2 + (r1**2 + r2**2)", terminal: "norm(v1[final], v2[final])"}}
"""


def test_vectors_are_the_scalars_that_they_stand_for():
    with pytest.raises(SpecError, match=r"p_dot.*unknown|unknown.*p_dot"):
        load_text(SHORT, "x.yaml")  # the velocity has another name
    made, written = (
        load_text(text, "x.yaml").model_dump(mode="json") for text in (SHORT.replace(" + p_dot*0", ""), LONG)
    )
    rates = {"v1", "v2"}
    for spec in made, written:
        for name in rates:  # the same function in other words
            text = spec["states"][name].pop("rate")
            values = {n: np.sin(i + 1.0) for i, n in enumerate(sorted(VALUES))}
            spec["states"][name]["rate"] = round(float(parse(text.replace("twice(L)", "(2*L)"))(values, np)), 12)
    assert made == written


VALUES = ("A11", "A12", "A21", "A22", "F1", "F2", "v1", "v2", "m", "g1", "g2", "L")


class Vectors:
    """A scope with a few vectors in it."""

    called = frozenset()

    def __init__(self, **sizes):
        self.sizes = sizes

    def vector(self, name):
        size = self.sizes.get(name)
        return [Scalar(f"{name}{i + 1}") for i in range(size)] if size else None

    def function(self, name):
        return None

    def fixed(self, name):
        return False


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("cross(a, b)", lambda a, b, p, q: np.cross(a, b)),
        ("cross(a, cross(a, b))", lambda a, b, p, q: np.cross(a, np.cross(a, b))),
        ("dot(a - 2*b, a + b)", lambda a, b, p, q: (a - 2 * b) @ (a + b)),
        ("a @ b", lambda a, b, p, q: a @ b),
        ("-a/(b - a)*2 - (a - (b - a))", lambda a, b, p, q: -a / (b - a) * 2 - (a - (b - a))),
        ("(a + b)**2/3 - sin(a)", lambda a, b, p, q: (a + b) ** 2 / 3 - np.sin(a)),
        ("sum(a*b) + a[2] - norm(b[2..3])", lambda a, b, p, q: np.sum(a * b) + a[1] - np.hypot(*b[1:])),
        ("[a[1], 0, dot(a, b)]", lambda a, b, p, q: np.array([a[0], 0, a @ b])),
        ("[[1, 2, 0], [0, -1, 1]] @ a", lambda a, b, p, q: np.array([[1, 2, 0], [0, -1, 1]]) @ a),
        ("transpose([[1, 2], [0, -1]]) @ b[1..2]", lambda a, b, p, q: np.array([[1, 2], [0, -1]]).T @ b[:2]),
        ("min(a) - max(a, b)[1]", lambda a, b, p, q: min(a) - max(a[0], b[0])),
        ("quat_mul(p, q)", lambda a, b, p, q: (Rotation.from_quat(p) * Rotation.from_quat(q)).as_quat()),
        ("quat_mul(p, quat_conj(p))", lambda a, b, p, q: np.array([0, 0, 0, 1])),
        ("rotate(p, a)", lambda a, b, p, q: Rotation.from_quat(p).apply(a)),
        (
            "quat_mul(quat_mul(p, [a[1], a[2], a[3], 0]), quat_conj(p))[1..3]",
            lambda a, b, p, q: Rotation.from_quat(p).apply(a),
        ),
    ],
)
def test_functions_and_operators(text, wanted):
    random = np.random.default_rng(3)
    a, b = random.normal(size=(2, 3))
    p, q = (Rotation.random(random_state=i).as_quat() for i in (1, 2))
    expected = wanted(a, b, p, q)
    values = {f"{n}{i + 1}": x for n, v in zip("abpq", (a, b, p, q), strict=True) for i, x in enumerate(v)}
    found = evaluate(text, Vectors(a=3, b=3, p=4, q=4))
    scalars = found if isinstance(found, list) else [found]
    numbers = [float(parse(own.text)(values, np)) for own in scalars]
    if "quat" in text and np.shape(expected) == (4,) and np.dot(numbers, expected) < 0:
        expected = -expected  # the same rotation
    assert numbers == pytest.approx(np.atleast_1d(expected), abs=1e-12)


PHASES = """\
trajopt: 1
parameters: {e: [1, 0]}
states:
  r: {size: 2, rate: v, initial: 0, final: [3, 1]}
  v: {size: 2, rate: u, initial: 0, final: 0}
controls: {u: {size: 2, lower: -9, upper: 9}}
expressions: {speed: norm(v), along: "dot(v, e)"}
time: {initial: 0, final: {lower: 1, upper: 9, guess: 4}}
phases:
  near: {parameters: {e: [0, 1]}, time: {final: 1}, states: {r: {final: [1, 2]}}}
  far: {controls: {b: {size: 2, lower: -1, upper: 1}}, without: [u], states: {v: {rate: b}}}
links:
  - {from: near, to: far, except: [v]}
  - {name: kick, expression: "far.v[initial] - near.v[final]", lower: -0.1, upper: [0.1, 0.2]}
objective: {minimize: {integral: along**2, terminal: "t[final] + near.speed[final]"}}
"""


def test_phases_and_links():
    spec = load_text(PHASES, "x.yaml")
    problem = build(spec)
    near, far = problem.phases
    assert [state.name for state in far.states] == ["r1", "r2", "v1", "v2"]
    assert [control.name for control in far.controls] == ["b1", "b2"]
    assert [state.final.upper for state in near.states][:2] == [1, 2]
    kicks = [link for link in problem.links if link.name.startswith("kick")]
    assert [link.name for link in kicks] == ["kick 1", "kick 2"]


COLUMNS = """\
trajopt: 1
parameters: {A: [[0, 1], [-1, 0]], B: [[0], [1]], c: [1, 0]}
time: {initial: 0, final: 1}
states:
  x: {size: 2, rate: A @ x + B @ u + B*w, initial: 1}
controls: {u: {size: 1}, w: {}}
objective: {minimize: {integral: "x @ x + dot(u, u) + w**2"}}
"""


def test_a_matrix_of_one_column_is_a_vector():
    spec = load_text(COLUMNS, "x.yaml")
    assert spec.states["x1"].rate.text == "A11*x1 + A12*x2 + B11*u1 + B11*w"
    with pytest.raises(SpecError, match="one value by"):
        load_text(COLUMNS.replace("B*w", "B @ w"), "x.yaml")


def test_overrides_of_vectors_and_of_components():
    spec = load_text(PHASES, "x.yaml", ["states.r.final=[4, 5]", "states.v2.initial=7", "parameters.e=[2, 3]"])
    assert spec.states["r2"].final.value.text == "5" and spec.states["v2"].initial.value.text == "7"
    assert spec.parameters["e2"].value.text == "3"
    with pytest.raises(SpecError) as error:
        load_text(PHASES, "x.yaml", ["states.r.final=[4, kk]", "states.v2.initial=jj"])
    assert {mistake.where for mistake in error.value.mistakes} == {"--set states.r.final", "--set states.v2.initial"}


def test_units_of_vectors_are_checked():
    text = PHASES.replace("rate: v, initial", "unit: m, rate: v, initial").replace("rate: u,", "unit: m/s, rate: u,")
    text = text.replace("u: {size: 2,", "u: {size: 2, unit: m/s,").replace("e: [1, 0]", "e: {value: [1, 0], unit: m}")
    with pytest.raises(SpecError) as error:
        load_yaml(text.replace("norm(v)", "norm(v + r)"), file="x.yaml", units=True)
    told = [str(mistake) for mistake in error.value.mistakes]
    assert any(":5: states.v.rate: " in line and "m/s^2" in line for line in told)
    assert any(":7: expressions.speed" in line for line in told)


def test_the_example_of_the_docs_is_right():
    docs = (ROOT / "docs" / "language.md").read_text()
    example = re.search(r"## Vectors.*?```yaml\n(.*?)```", docs, re.DOTALL)[1]
    spec = load_text(f"trajopt: 1\ntime: {{initial: 0, final: 1}}\n{example}", "docs.yaml")
    assert len(spec.states) == 7 and len(spec.constraints.path) == 3


@pytest.mark.filterwarnings("error")
def test_what_python_warns_of_is_a_mistake_like_others():
    with pytest.raises(SpecError, match="an operator is missing"):
        load_text(COLUMNS.replace("B*w", "B*w*0or1"), "x.yaml")


def test_several_units_and_a_function_at_an_end():
    text = PHASES.replace("r: {size: 2, ", "r: {size: 2, unit: [m, km], ").replace(
        "speed: norm", '"far(a)": "norm(a)*e[1]", speed: norm'
    )
    spec = load_text(text.replace("near.speed[final]", "far(v[final])"), "x.yaml")
    assert [spec.states[name].unit for name in ("r1", "r2")] == ["m", "km"]
    assert spec.objective.minimize.terminal.text == "t[final] + norm(v1[final], v2[final])*e1"
    with pytest.raises(SpecError, match="uses r, and it is not clear at which end"):
        load_text(text.replace("near.speed[final]", "far(v[final])").replace("norm(a)*e", "norm(a)*r[1]*e"), "x.yaml")


def test_the_schema_for_editors_knows_vectors():
    jsonschema = pytest.importorskip("jsonschema")
    jsonschema.validate(yaml.safe_load(SHORT), schema())
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(yaml.safe_load(SHORT.replace("size: N", "size: {a: 1}")), schema())


def test_a_shipped_vector_problem():
    solution = trajopt.solve(trajopt.load("symmetric_reorientation"))
    assert solution.solved and solution.objective == pytest.approx(3.243083279, rel=1e-6)


@pytest.mark.parametrize(
    ("kind", "expression", "component"),
    [
        ("path", "cross([r[1], r[2], 0], [0, 0, 1])", "side 3"),
        ("path", "[0, r[1], r[2]]", "side 1"),
        ("boundary", "[r[1][final], 2]", "side 2"),
    ],
)
def test_a_component_that_is_constant_is_named(kind, expression, component):
    text = f"""\
trajopt: 1
states: {{r: {{size: 2, rate: u, initial: 0}}}}
controls: {{u: {{size: 2}}}}
time: {{initial: 0, final: 1}}
constraints: {{{kind}: [{{name: side, expression: "{expression}", upper: 2}}]}}
objective: {{minimize: {{integral: "dot(u, u)"}}}}
"""
    with pytest.raises(SpecError) as error:
        load_text(text, "x.yaml")
    (mistake,) = error.value.mistakes
    assert mistake.what == f"the constraint {component} is on a constant"
