"""Conditions as they are written, and the rates of states by their names: they are what they stand for."""

import pytest
import yaml

import trajopt
from trajopt.problems.errors import SpecError
from trajopt.problems.language.json_schema import schema
from trajopt.problems.load import load_text

FILE = """\
trajopt: 1
parameters: {b: 2, c: 0.5}
time: {initial: 0, final: 1}
states:
  x: {rate: v*b, initial: 0, final: 1}
  q: {accel: u - q, velocity: {name: v, initial: 0}}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
constraints:
  path: []
  boundary: []
"""


def constraints(*written, kind="path", base=FILE):
    text = base.replace(
        f"{kind}: []", f"{kind}: {yaml.safe_dump(list(written), default_flow_style=True, width=999).strip()}"
    )
    assert text != base
    entries = getattr(load_text(text, "x.yaml").constraints, kind)
    shown = [{k: getattr(e, k).text for k in ("lower", "upper", "equals") if getattr(e, k)} for e in entries]
    return [(entry.expression.text, own) for entry, own in zip(entries, shown, strict=True)]


@pytest.mark.parametrize(
    ("written", "expression", "bounds"),
    [
        ("x <= 1", "x", {"upper": "1"}),
        ("2*b >= x + u", "x + u", {"upper": "2*b"}),
        ("x**2 + q**2 > c**2", "x**2 + q**2", {"lower": "c**2"}),
        ("-1 <= x*v <= sqrt(b)", "x*v", {"lower": "-1", "upper": "sqrt(b)"}),
        ("b >= x*v >= -1e-3*c", "x*v", {"upper": "b", "lower": "-1e-3*c"}),
        ("x = v", "x - (v)", {"equals": "0"}),
        ("x < 3 - q", "x - (3 - q)", {"upper": "0"}),
        ({"name": "n", "expression": "t >= x"}, "t - (x)", {"lower": "0"}),
        ({"expression": "x", "upper": "b"}, "x", {"upper": "b"}),
    ],
)
def test_conditions_are_their_parts(written, expression, bounds):
    assert constraints(written) == [(expression, bounds)]


def test_conditions_at_the_ends_between_phases_and_without_time():
    assert constraints("q[final] = 2*q[initial]", kind="boundary") == [("q[final] - (2*q[initial])", {"equals": "0"})]
    phases = FILE + "phases: {a: {time: {final: 0.5}, parameters: {d: 3}, constraints: {path: [u <= d]}}, e: {}}\n"
    spec = load_text(phases + 'links: [{from: a, to: e}, "e.v[initial] - a.v[final] <= b"]\n', "x.yaml")
    assert spec.phases["a"].constraints.path[0].upper.text == "d" and spec.links[1].upper.text == "b"
    static = "trajopt: 1\noptimize: {x: {guess: 1}, y: {guess: 2}}\nobjective: {minimize: x + y}\n"
    assert trajopt.solve(trajopt.load(static + "constraints: [x*y >= 4, x >= y]\n")).objective == pytest.approx(
        4, rel=1e-6
    )


def test_mistakes_in_conditions_are_told_at_their_place():
    with pytest.raises(SpecError) as error:
        constraints("x <= kk", "2 <= x <= q", "x*jj >= 1", "sin(x <= 2")
    told = [str(mistake) for mistake in error.value.mistakes]
    assert len(told) == 4 and all(line.startswith("x.yaml:10: constraints.path.") for line in told)
    assert any('unknown name "kk"' in line for line in told) and any('"jj"' in line for line in told)
    jsonschema = pytest.importorskip("jsonschema")
    jsonschema.validate(yaml.safe_load(FILE.replace("path: []", "path: [x <= 1]")), schema())


def test_the_rate_of_a_state_is_what_it_is_given_by():
    by_name = FILE.replace("integral: u**2", 'integral: "u**2 + x[rate]**2 + q[rate]*v[rate] + drift"')
    by_name = by_name.replace("controls:", 'expressions: {drift: "c*x[rate]", twice(a): "a*v[rate]"}\ncontrols:')
    written = FILE.replace("integral: u**2", 'integral: "u**2 + (v*b)**2 + v*(u - q) + c*v*b"')
    first, second = (trajopt.solve(trajopt.load(text)).objective for text in (by_name, written))
    assert first == pytest.approx(second, rel=1e-10)


@pytest.mark.parametrize(
    ("old", "new"),
    [("rate: v*b", 'rate: "x[rate] + v"'), ("boundary: []", 'boundary: ["x[rate] = 0"]'), ("u - q,", '"u - v[rate]",')],
)
def test_a_rate_that_has_no_value_is_told(old, new):
    with pytest.raises(SpecError, match=r"\[rate\]"):
        load_text(FILE.replace(old, new), "x.yaml")
