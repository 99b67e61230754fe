"""Problems as LaTeX and MathML."""

from xml.etree import ElementTree

import pytest
from named import share

from trajopt.problems.build import build
from trajopt.problems.catalog import find_problem, shipped
from trajopt.problems.load import load, load_text
from trajopt.results.report.mathematics import parameters, shown_equations
from trajopt.transcription.export.equations import equations
from trajopt.transcription.export.written import Notation, Writer

FILE = """
trajopt: 1
parameters: {m_1: 2, u_max: 5, c: {value: u_max/2, unit: N, note: half}}
time: {initial: 0, final: {lower: 1, upper: 9}}
states:
  x: {rate: v, initial: 0, final: 1, lower: 0}
  v: {rate: "F/m_1 - RATE", initial: 0, final: {lower: -1, upper: 1}}
controls: {F: {lower: -u_max, upper: u_max}}
expressions: {drag: v**2}
objective: {minimize: {integral: F**2, terminal: "t[final]"}}
constraints:
  path: [{expression: drag + x, upper: 3}]
  boundary: [{expression: "x[final] - x[initial]", equals: 1}]
  integral: [{expression: F**2, upper: 100}]
"""


def groups(text):
    spec = load_text(text, "own.yaml")
    return {group.title: [line for e in group.equations for line in e.lines] for group in equations(spec, build(spec))}


def written(expression):
    (_, line) = groups(FILE.replace("RATE", expression))["Dynamics"]
    return line.partition(r"\frac{F}{m_{1}} - ")[2]


def test_every_part_of_a_problem_is_there():
    assert groups(FILE.replace("RATE", "0")) == {
        "Objective": [r"\min\ t_{\mathrm{F}} + \int_{t_{0}}^{t_{\mathrm{F}}} F^{2}\,\mathrm{d}t"],
        "Dynamics": [r"\dot{x} = v", r"\dot{v} = \frac{F}{m_{1}} - 0"],
        "where": [r"\text{drag} = v^{2}"],
        "At every time": [r"\text{drag} + x \leq 3"],
        "Bounds": [r"0 \leq x", r"- u_{\text{max}} \leq F \leq u_{\text{max}}"],
        "At the ends": [
            "t_{0} = 0", "x(t_{0}) = 0", "v(t_{0}) = 0", r"1 \leq t_{\mathrm{F}} \leq 9", r"x(t_{\mathrm{F}}) = 1",
            r"- 1 \leq v(t_{\mathrm{F}}) \leq 1", r"x(t_{\mathrm{F}}) - x(t_{0}) = 1",
        ],
        "Over all time": [r"\int_{t_{0}}^{t_{\mathrm{F}}} F^{2}\,\mathrm{d}t \leq 100"],
    }  # fmt: skip


@pytest.mark.parametrize(
    ("expression", "latex"),
    [
        ("v - (x - F)", "v - (x - F)"),
        ("(x - (v - 1))*2", r"(x - (v - 1))\cdot 2"),
        ("sin(x)**2/3", r"\frac{\sin^{2}(x)}{3}"),
        ("2*pi*x", r"2\,\pi \,x"),
        ("atan2(x, v)", r"\mathrm{atan2}(x,\  v)"),
        ("sqrt(x + 1)", r"\sqrt{x + 1}"),
        ("exp(-x/2)", r"\exp\biggl(- \frac{x}{2}\biggr)"),
    ],
)
def test_an_expression_keeps_its_meaning(expression, latex):
    line = groups(FILE.replace("F/m_1 - RATE", expression))["Dynamics"][1]
    assert line.replace(" ", "") == (r"\dot{v} = " + latex).replace(" ", "")


def test_functions_of_the_file_stand_as_they_are_written():
    text = FILE.replace("RATE", "drag(v)").replace("{drag: v**2}", '{"drag(w)": c*w**2}').replace("drag + x", "x")
    found = groups(text)
    assert found["where"] == [r"\mathrm{drag}(w) = c\,w^{2}"]
    assert found["Dynamics"][1] == r"\dot{v} = \frac{F}{m_{1}} - \mathrm{drag}(v)"


def test_what_is_subtracted_stands_in_parentheses():
    assert written("(x + v)").replace(" ", "") == "(x+v)"
    assert groups(FILE.replace("F/m_1 - RATE", "-(x - v) - (-x)"))["Dynamics"][1].endswith("= - (x - v) + x")


def test_names_that_would_look_the_same_are_spelled():
    notation = Notation(["q1", "q_1", "theta_dot", "omega", "Isp", "t0"])
    assert [notation(name) for name in notation.known] == [
        "q_{1}", r"\text{q\_1}", r"\dot{\theta}", r"\omega", r"\text{Isp}", r"\text{t0}",
    ]  # fmt: skip
    assert notation("q1[rate]") == r"\dot{q}_{1}"
    assert Writer(notation).notation.formula("boost.q1", "final").text == r"q_{1}^{(\text{boost})}(t_{\mathrm{F}})"


@pytest.mark.parametrize("name", share([*shipped()], 3, 1))
def test_every_shipped_problem_is_mathml(name):
    spec = load(find_problem(name))
    found = shown_equations(spec, build(spec))
    assert {"Dynamics", "Objective", "Between phases"} & {group.title.partition(",")[0] for group in found}
    for lines in (lines for group in found for lines in group.equations):
        for line in lines:
            if line.startswith("<"):
                assert ElementTree.fromstring(line).tag.endswith("}math")


def test_parameters_have_value_unit_and_note():
    rows = parameters(load_text(FILE.replace("RATE", "0"), "own.yaml"))
    assert [(row.name, row.value, row.formula, row.unit, row.note) for row in rows] == [
        ("m_1", 2, "", "", ""), ("u_max", 5, "", "", ""), ("c", 2.5, "u_max/2", "N", "half"),
    ]  # fmt: skip
