"""Pyomo expressions as LaTeX: each formula as text, and its value when the text is read back."""

import math

import pyomo.core as pyomo
import pytest
from pyomo.core import ConcreteModel, Var

from trajopt.transcription.export.formula import LINE, Printer, lines, tex_name, tex_number
from trajopt.transcription.program.symbolic import SYMENGINE

from .exported import evaluate_tex

MODEL = ConcreteModel()
MODEL.x, MODEL.y, MODEL.z = Var(), Var(), Var()
X, Y, Z = MODEL.x, MODEL.y, MODEL.z
NAMES = {id(X): tex_name("x", "q1", "3"), id(Y): tex_name("u", "force_2", "0"), id(Z): tex_name("p", "z")}
A, B, C = r"x_{q1,3}", r"u_{\mathrm{force\_2},0}", r"p_{z}"


@pytest.mark.parametrize(
    ("expression", "text"),
    [
        (X + Y - Z, f"{A} + {B} - {C}"),
        (X - (Y - Z), f"{A} - ({B} - {C})"),
        (-X - 2 * Y, f"- {A} - 2\\,{B}"),
        (-(X + Y), f"- ({A} + {B})"),
        (X * -Y * -0.5, f"{A}\\,{B}\\cdot 0.5"),
        (X * (Y + Z), f"{A}\\,({B} + {C})"),
        (X / Y / Z, rf"\frac{{{A}}}{{{B}}} / {C}"),
        (X / Y * Z, rf"\frac{{{A}}}{{{B}}}\,{C}"),
        (X * (Y / (1 + Z / Y)), rf"{A}\,\biggl({B} / \biggl(1 + \frac{{{C}}}{{{B}}}\biggr)\biggr)"),
        (X / (Y * Z), rf"\frac{{{A}}}{{{B}\,{C}}}"),
        (-X / Y, rf"- \frac{{{A}}}{{{B}}}"),
        ((X / Y) ** 2, rf"\biggl(\frac{{{A}}}{{{B}}}\biggr)^{{2}}"),
        ((-X) ** 2, f"(- {A})^{{2}}"),
        (-(X**2), f"- {A}^{{2}}"),
        ((X**Y) ** Z, f"({A}^{{{B}}})^{{{C}}}"),
        (X ** (Y**Z), f"{A}^{{{B}^{{{C}}}}}"),
        (2 ** (-X), f"2^{{- {A}}}"),
        (pyomo.sin(X) ** 2, rf"\sin^{{2}}({A})"),
        (pyomo.sin(X) ** 0.5, rf"(\sin({A}))^{{0.5}}"),
        (pyomo.atan(-X), rf"\arctan(- {A})"),
        (pyomo.sqrt(X + 1) ** 2, rf"(\sqrt{{{A} + 1}})^{{2}}"),
        (0.1 * X + 1e-7, rf"0.1\,{A} + 10^{{-7}}"),
        (1 / 3 + X * -2.5e22, rf"0.3333333333333333 - 2.5\cdot 10^{{22}}\,{A}"),
    ],
)
def test_formulas(expression, text):
    assert lines(Printer(NAMES)(expression)) == [text]
    values = {"x_{q1,3}": 0.3, "u_{force_2,0}": 0.7, "p_{z}": 1.3}
    for variable, number_ in zip((X, Y, Z), values.values(), strict=True):
        variable.set_value(number_)
    assert evaluate_tex(text, values) == pytest.approx(pyomo.value(expression), rel=1e-14)


def test_every_function_of_a_problem_has_a_command():
    for function in SYMENGINE:
        text = Printer(NAMES)(getattr(pyomo, function)(X)).text
        assert evaluate_tex(text, {"x_{q1,3}": 0.3}) == pytest.approx(getattr(math, function)(0.3), rel=1e-14)


@pytest.mark.parametrize(
    ("x", "text"),
    [(2, "2"), (0.1, "0.1"), (1 / 3, "0.3333333333333333"), (1e16, "10^{16}"), (-1.5e-7, r"- 1.5\cdot 10^{-7}")],
)
def test_numbers_are_the_shortest_that_mean_the_same(x, text):
    assert lines(tex_number(x)) == [text]


def test_long_formulas_are_broken_where_they_may_be():
    long = sum((k * X) ** 2 * (Y + k * Z * X * Y * sum(pyomo.cos(i * X) for i in range(5))) for k in range(1, 9))
    rows = lines(Printer(NAMES)(long / (1 + long) <= 3))
    assert len(rows) > 10
    assert all(row[0] in "+-/=" or row.startswith(r"\leq") for row in rows[1:])
    assert all(row.count("{") == row.count("}") for row in rows)
    assert all(60 < len(row) < 3 * LINE for row in rows[:-1])
    text = " ".join(rows)
    assert text.count("(") == text.count(")")
