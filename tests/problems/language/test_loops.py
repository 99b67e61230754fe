"""Repeated structure: what templates make, how they are overridden, and where mistakes in them are told."""

import pytest

import trajopt
from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load, load_text

CHAIN = """\
trajopt: 1
name: chain
parameters: {N: 3, k: 2}
time: {initial: 0, final: 1}
expressions:
  x0: "0"
  for i in 1..N:
    stretch{i}: x{i} - x{i-1}
states:
  x{i}: {for: i in 1..N, rate: "v{i}", initial: "{i}"}
  v{i}: {for: i in 1..N, rate: "k*(0 - stretch{i}) + f{i}"}
controls:
  f{j}: {for: j in 1..N, lower: -5, upper: 5}
constraints:
  path:
    - {for: "i in 2..N", name: "order {i}", expression: "stretch{i}", lower: 0.01}
objective: {minimize: {integral: "sum(i in 1..N, f{i}**2 + sum(j in 1..2, x{i}**{2*j}))"}}
"""

WRITTEN = """\
trajopt: 1
name: chain
parameters: {N: 3, k: 2}
time: {initial: 0, final: 1}
expressions: {x0: "0", stretch1: x1 - x0, stretch2: x2 - x1, stretch3: x3 - x2}
states:
  x1: {rate: v1, initial: 1}
  x2: {rate: v2, initial: 2}
  x3: {rate: v3, initial: 3}
  v1: {rate: k*(0 - stretch1) + f1}
  v2: {rate: k*(0 - stretch2) + f2}
  v3: {rate: k*(0 - stretch3) + f3}
controls: {f1: {lower: -5, upper: 5}, f2: {lower: -5, upper: 5}, f3: {lower: -5, upper: 5}}
constraints:
  path:
    - {name: order 2, expression: stretch2, lower: 0.01}
    - {name: order 3, expression: stretch3, lower: 0.01}
objective:
  minimize:
    integral: "((f1**2 + ((x1**2) + (x1**4))) + (f2**2 + ((x2**2) + (x2**4))) + (f3**2 + ((x3**2) + (x3**4))))"
"""


def test_templates_are_what_they_stand_for():
    made, written = (load_text(text, "x.yaml").model_dump(mode="json") for text in (CHAIN, WRITTEN))
    assert made == written


def test_words_several_variables_and_phases():
    text = """\
trajopt: 1
time: {initial: 0, final: 6}
states:
  x_{leg}{i}: {for: ["leg in left, right", i in 1..2], rate: u, initial: 0}
controls: {u: {}}
phases: {"p{i}": {for: i in 1..3, time: {final: "2*{i}"}}}
objective: {minimize: {integral: u**2}}
"""
    problem = build(load_text(text, "x.yaml"))
    assert [phase.name for phase in problem.phases] == ["p1", "p2", "p3"]
    assert [state.name for state in problem.phases[0].states] == ["x_left1", "x_left2", "x_right1", "x_right2"]
    assert [phase.final_time.upper for phase in problem.phases] == [2, 4, 6]


def test_overrides_of_numbers_and_of_what_is_made():
    spec = load_text(CHAIN, "x.yaml", ["parameters.N=5", "states.x5.initial=7", "controls.f5.upper=9"])
    assert len(spec.states) == 10 and spec.states["x5"].initial.value.text == "7"
    assert spec.controls["f5"].upper.text == "9" and spec.controls["f1"].upper.text == "5"


def test_mistakes_are_told_at_the_line_of_the_template():
    text = CHAIN.replace("k*(0 - stretch{i})", "kk*(0 - stretch{i+1})")
    with pytest.raises(SpecError) as error:
        load_text(text, "x.yaml")
    told = [str(mistake) for mistake in error.value.mistakes]
    assert told[0].startswith("x.yaml:11: states.v{i}.rate: ") and 'unknown name "kk"' in told[0]
    assert any(line.startswith("x.yaml:11: states.v3.rate: ") and "stretch4" in line for line in told)


def test_texts_outside_of_templates_keep_their_braces():
    spec = load_text(CHAIN.replace("name: chain", "name: chain {i}\nnote: sum(1), {N}"), "x.yaml")
    assert spec.name == "chain {i}" and spec.note == "sum(1), {N}"


def test_the_shipped_chain():
    solution = trajopt.solve(trajopt.load("heated_rod"))
    assert solution.solved and not load(shipped()["heated_rod"]).warnings
    assert solution.objective == pytest.approx(load(shipped()["heated_rod"]).reference.objective, rel=1e-7)


@pytest.mark.parametrize("template", ["x{i}_{j}", "x{i}", "x{6/(i-1)}", "sum"])
def test_what_has_no_end_is_told_at_once(template):
    """Two long ranges, which took all memory; a number that is none, in a key and in a sum."""
    ranges = {"x{i}_{j}": "[i in 1..10000, j in 1..10000]", "x{i}": "i in 1..300000"}.get(template, "i in 1..3")
    key = "x{i}" if template == "sum" else template
    integral = "sum(i in 1..3, {1/(i-1)}*u)" if template == "sum" else "u**2"
    text = (
        f"trajopt: 1\ntime: {{initial: 0, final: 1}}\nstates:\n  {key}: {{for: {ranges}, rate: u}}\n"
        f'controls: {{u: {{}}}}\nobjective: {{minimize: {{integral: "{integral}"}}}}\n'
    )
    with pytest.raises(SpecError) as error:
        load_text(text, "x.yaml")
    words = "more than 10000 entries" if "0000" in ranges else "is inf, no whole number"
    assert any(words in mistake.what for mistake in error.value.mistakes)
