"""The table of functions of the expression language: what each row says is true, and a row is all it takes."""

import subprocess
import sys

import numpy as np
import pytest
import symengine as se
from pyomo import core as pyo

from trajopt.problems.expressions.expression import parse
from trajopt.problems.expressions.functions import EITHER, FUNCTIONS, NEGATIVE, POSITIVE, smooth_names
from trajopt.transcription.export.formula import Printer, name
from trajopt.transcription.program.pointwise import PointFunctions

ROWS = [row for row in FUNCTIONS.values() if row.arguments == (1, 1)]
SMOOTH = [FUNCTIONS[function] for function in smooth_names()]
POINTS = np.concatenate([-np.geomspace(4, 1e-3, 40), np.geomspace(1e-3, 4, 40)])


def points_of(row) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points at which a function is finite, its values and its derivatives there by the row."""
    with np.errstate(all="ignore"):
        values, slopes = (parse(text)({"x": POINTS}, np) for text in (f"{row.name}(x)", row.derivative))
    inside = np.isfinite(values) & np.isfinite(slopes)
    assert np.count_nonzero(inside) > 10
    return POINTS[inside], values[inside], slopes[inside]


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_the_derivative_is_that_of_the_value(row):
    x, _, slopes = points_of(row)
    h = 1e-6 * np.abs(x)
    with np.errstate(all="ignore"):
        ahead, behind = (row.evaluate(np, [x + step]) for step in (h, -h))
    near = np.isfinite(ahead) & np.isfinite(behind)
    difference = ((ahead - behind) / (2 * h))[near]
    np.testing.assert_allclose(difference, slopes[near], rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.name)
def test_signs_and_slopes_are_those_that_the_row_tells(row):
    x, values, slopes = points_of(row)
    for signs, side in ((NEGATIVE, x < 0), (POSITIVE, x > 0), (EITHER, x != 0)):
        assert set(np.sign(values[side])) - {0.0} <= row.sign([signs])
        assert set(np.sign(slopes[side])) - {0.0} <= row.slope(signs)


@pytest.mark.parametrize("row", [FUNCTIONS["min"], FUNCTIONS["max"]], ids=lambda row: row.name)
def test_signs_and_slopes_of_min_and_max(row):
    samples = np.array([-2.0, -0.5, 0.3, 4.0])
    for a in samples:
        for b in samples[samples != a]:
            signs = [POSITIVE if value > 0 else NEGATIVE for value in (a, b)]
            assert int(np.sign(row.evaluate(np, [a, b]))) in row.sign(signs)
            assert row.evaluate(np, [a + 0.1, b]) >= row.evaluate(np, [a, b]) and row.slope(signs[0]) == POSITIVE


@pytest.mark.parametrize("row", [row for row in FUNCTIONS.values() if row.in_abs], ids=lambda row: row.name)
def test_abs_min_and_max_are_made_of_abs(row):
    operands = [-0.7, 0.4, -2.0][: row.arguments[1]]
    assert row.from_abs(operands, abs) == pytest.approx(row.evaluate(np, operands), abs=1e-15)


@pytest.mark.parametrize("row", SMOOTH, ids=lambda row: row.name)
def test_symengine_knows_it_with_both_derivatives(row):
    """Value, slope and curvature of the compiled function, from Pyomo's expression, against the row's."""
    x, values, slopes = points_of(row)
    program = PointFunctions([parse(f"{row.name}(x)")], ["x"], [], {"differentiate": 0.0, "compile": 0.0})
    np.testing.assert_allclose(program.values(x[:, None])[:, 0], values, rtol=1e-13)
    np.testing.assert_allclose(program.jacobian(x[:, None])[:, 0, 0], slopes, rtol=1e-10)
    slope = PointFunctions([parse(row.derivative)], ["x"], [], {"differentiate": 0.0, "compile": 0.0})
    curvature = slope.jacobian(x[:, None])[:, 0, 0]
    found = program.hessian(x[:, None], np.ones((len(x), 1)))[:, 0, 0]
    np.testing.assert_allclose(found, curvature, rtol=1e-8, atol=1e-8)
    assert row.composed is not None or hasattr(se, row.name)


@pytest.mark.parametrize("row", SMOOTH, ids=lambda row: row.name)
def test_its_command_is_printed(row):
    model = pyo.ConcreteModel()
    model.x = pyo.Var()
    printed = Printer({id(model.x): name("x", "1")})(row.evaluate(pyo, [model.x])).text
    assert row.latex and printed.startswith(row.latex) and "x_{1}" in printed


ONE_NEW_ROW = r"""
import sys
from trajopt.problems.expressions.functions import FUNCTIONS, POSITIVE, FunctionRow, always, sign_kept

FUNCTIONS["asinh"] = FunctionRow("asinh", "1/sqrt(1 + x**2)", r"\operatorname{arsinh}", sign_kept, always(POSITIVE))
FUNCTIONS["softplus"] = FunctionRow(
    "softplus", "1/(1 + exp(-x))", r"\log", always(POSITIVE), always(POSITIVE),
    composed=lambda functions, operands: functions.log(1 + functions.exp(operands[0])),
)
from trajopt.cli.app import app

for command in ("solve new.yaml -o new.h5", "export new.yaml new.tex", "verify new.h5"):
    sys.argv = ["trajopt", *command.split()]
    try:
        app()
    except SystemExit as end:
        assert not end.code, (command, end.code)
"""

NEW = """
trajopt: 1
time: {initial: 0, final: 1}
states: {x: {rate: asinh(u)**2 + u, initial: 0, final: 1}}
controls: {u: {lower: -9, upper: 9}}
objective: {minimize: {integral: softplus(u) + abs(asinh(u)) + u**2}}
nonsmooth: slack
mesh: [{method: trapezoid, segments: 5}]
"""


def test_a_new_function_is_one_new_row(tmp_path):
    """From the text of an expression to the solution, its audit and a formula, with nothing but two rows added."""
    (tmp_path / "new.yaml").write_text(NEW)
    (tmp_path / "run.py").write_text(ONE_NEW_ROW)
    run = subprocess.run([sys.executable, "run.py"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    assert "new: solved" in run.stdout
    formulas = (tmp_path / "new.tex").read_text()
    assert r"\operatorname{arsinh}^{2}(u" in formulas.replace(" ", "") and r"\exp" in formulas
