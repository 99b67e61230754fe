"""The table of functions of the expression language: what each row says is true, and a row is all it takes."""

import itertools
import math
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import symengine as se
from command_line import trajopt
from matplotlib.mathtext import MathTextParser
from pyomo import core as pyo

from trajopt.problems.expressions.composed import ROUNDING
from trajopt.problems.expressions.expression import parse
from trajopt.problems.expressions.functions import EITHER, FUNCTIONS, NEGATIVE, POSITIVE
from trajopt.problems.expressions.smooth import TANH, smooth_abs
from trajopt.results.verify import verify
from trajopt.transcription.export.formula import Printer, tex_name
from trajopt.transcription.program.pointwise import PointFunctions

ROWS = [row for row in FUNCTIONS.values() if row.arguments == (1, 1)]
SMOOTH = [row for row in ROWS if not row.in_abs]
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
    np.testing.assert_allclose(program.jacobian(x[:, None])[:, 0, 0], slopes, rtol=1e-10, atol=1e-14)
    slope = PointFunctions([parse(row.derivative)], ["x"], [], {"differentiate": 0.0, "compile": 0.0})
    curvature = slope.jacobian(x[:, None])[:, 0, 0]
    found = program.hessian(x[:, None], np.ones((len(x), 1)))[:, 0, 0]
    np.testing.assert_allclose(found, curvature, rtol=1e-8, atol=1e-8)
    assert row.composed is not None or hasattr(se, row.name)


@pytest.mark.parametrize("row", SMOOTH, ids=lambda row: row.name)
def test_its_command_is_printed(row):
    model = pyo.ConcreteModel()
    model.x = pyo.Var()
    printed = Printer({id(model.x): tex_name("x", "1")})(row.evaluate(pyo, [model.x])).text
    assert bool(row.latex) != bool(row.composed)
    assert printed.startswith(row.latex) and "x_{1}" in printed


# -- functions that are made of others -------------------------------------------------------------------------------

REFERENCES = {
    "log10": math.log10,
    "cot": lambda x: 1 / math.tan(x),
    "sec": lambda x: 1 / math.cos(x),
    "csc": lambda x: 1 / math.sin(x),
    "erf": math.erf,
    "atan2": math.atan2,
    "hypot": math.hypot,
    "norm": math.hypot,
    "sign": lambda x, eps: math.tanh(x / eps),
    "step": lambda x, eps: 1 / (1 + math.exp(-2 * x / eps)),
    "smooth_abs": lambda x, eps: x * math.tanh(x / eps),
}
COMPOSED = [row for row in FUNCTIONS.values() if row.composed and not row.in_abs]
SEVERAL = [row for row in COMPOSED if row.arguments != (1, 1)]
by_name = {"ids": lambda row: row.name}


def operands_of(row) -> np.ndarray:
    """Points of all quadrants (K, number of operands), widths positive."""
    several = 3 if row.name == "norm" else row.arguments[1]
    points = np.array(list(itertools.product([-2.5, -0.3, 0.1, 1.7], repeat=several)))
    return (
        np.abs(points)
        if row.name == "log10"
        else np.column_stack([points[:, :-1], abs(points[:, -1:])])
        if (row.width)
        else points
    )


def compiled_function(row, several: int) -> PointFunctions:
    names = [f"x{i}" for i in range(several)]
    return PointFunctions([parse(f"{row.name}({', '.join(names)})")], names, [], {"differentiate": 0, "compile": 0})


def complex_slopes(row, points: np.ndarray) -> np.ndarray:
    """The derivatives (K, number of operands) by the complex step."""
    shifts = 1e-30j * np.eye(points.shape[1])
    return np.stack([np.imag(row.evaluate(np, list((points + shift).T))) / 1e-30 for shift in shifts], axis=1)


@pytest.mark.parametrize("row", COMPOSED, **by_name)
def test_values_are_those_of_the_standard_library(row):
    points = operands_of(row)
    expected = [REFERENCES[row.name](*point) for point in points]
    np.testing.assert_allclose(row.evaluate(np, list(points.T)), expected, rtol=1e-14, atol=1e-16)
    found = compiled_function(row, points.shape[1]).values(points)[:, 0]
    np.testing.assert_allclose(found, expected, rtol=1e-14, atol=1e-16)


@pytest.mark.parametrize("row", SEVERAL, **by_name)
def test_derivatives_of_several_operands(row):
    """The complex step, SymEngine's first and second derivatives, and differences of each: all agree."""
    points = operands_of(row)
    n = points.shape[1]
    program, slopes, h = compiled_function(row, n), complex_slopes(row, points), 1e-6 * np.eye(points.shape[1])
    values = [[row.evaluate(np, list((points + sign * step).T)) for step in h] for sign in (1, -1)]
    np.testing.assert_allclose(np.subtract(*values).T / 2e-6, slopes, rtol=1e-5, atol=1e-8)
    np.testing.assert_allclose(program.jacobian(points)[:, 0], slopes, rtol=1e-11, atol=1e-13)
    curvature = [complex_slopes(row, points + step) - complex_slopes(row, points - step) for step in h]
    found = program.hessian(points, np.ones((len(points), 1)))
    np.testing.assert_allclose(found, np.stack(curvature, axis=1) / 2e-6, rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize("row", SEVERAL, **by_name)
def test_signs_and_slopes_of_several_operands(row):
    points = operands_of(row)
    values, slopes = row.evaluate(np, list(points.T)), complex_slopes(row, points)
    for point, value, slope in zip(points, values, slopes, strict=True):
        signs = [POSITIVE if x > 0 else NEGATIVE for x in point]
        assert {np.sign(value)} - {0} <= row.sign(signs)
        assert all({np.sign(s)} - {0} <= wanted for s, wanted in zip(slope, row.slopes(signs), strict=True))


def test_erf_is_accurate_everywhere():
    x = np.concatenate([np.geomspace(1e-300, 1e-3, 300), np.linspace(1e-3, 7, 3000), [30, 1e10, 1e150]])
    expected = np.array([math.erf(value) for value in x])
    for sign in (1, -1):
        np.testing.assert_allclose(FUNCTIONS["erf"].evaluate(np, [sign * x]), sign * expected, rtol=1e-14)
    assert FUNCTIONS["erf"].evaluate(np, [0.0]) == 0


@pytest.mark.parametrize("radius", [1e-6, 1.0, 0.37, 1e6])
def test_atan2_is_right_in_all_quadrants_up_to_the_cut(radius):
    """Also its derivatives, -y/r^2 and x/r^2, which are finite but at the origin and on the cut."""
    small = np.geomspace(1e-12, 1, 100)
    angle = np.concatenate([np.linspace(-3.14, 3.14, 400), np.pi - small, small - np.pi, small, -small])
    exact = np.array([(0.0, 1.0), (1.0, 0.0), (-1.0, 0.0)])  # x = 0 and y = 0 themselves
    points = radius * np.concatenate([np.column_stack([np.sin(angle), np.cos(angle)]), exact])
    np.testing.assert_allclose(FUNCTIONS["atan2"].evaluate(np, list(points.T)), np.arctan2(*points.T), rtol=2e-15)
    expected = points[:, ::-1] * [1, -1] / radius**2
    np.testing.assert_allclose(complex_slopes(FUNCTIONS["atan2"], points), expected, rtol=1e-12, atol=1e-14 / radius)
    compiled = compiled_function(FUNCTIONS["atan2"], 2)
    np.testing.assert_allclose(compiled.values(points)[:, 0], np.arctan2(*points.T), rtol=2e-15)
    away = np.pi - abs(np.arctan2(*points.T)) > 1e-6
    slopes = compiled.jacobian(points)[:, 0]
    np.testing.assert_allclose(slopes[away], expected[away], rtol=1e-8, atol=1e-8 / radius)


@pytest.mark.parametrize(("y", "x"), [(0.0, -1.0), (0.0, 0.0), (0.0, -0.37)])
def test_atan2_has_no_value_on_the_cut(y, x):
    fault = parse("1 + atan2(y, x)").fault({"y": y, "x": x})
    assert fault.text == "atan2(y, x)" and "jumps from pi to -pi" in fault.why


@pytest.mark.parametrize("name", ["hypot", "norm"])
def test_hypot_and_norm_are_smooth_at_zero(name):
    row, zero = FUNCTIONS[name], np.zeros((1, 2))
    program = compiled_function(row, 2)
    for value in (row.evaluate(np, [0.0, 0.0]), program.values(zero)[0, 0]):
        assert value == pytest.approx(ROUNDING, rel=1e-15)
    assert not program.jacobian(zero).any() and not complex_slopes(row, zero).any()
    np.testing.assert_allclose(program.hessian(zero, np.ones((1, 1)))[0], np.eye(2) / ROUNDING)
    for size in (1e-12, 1e-9, 1e-5, 1.0):
        assert 0 <= row.evaluate(np, [3 * size, 4 * size]) - 5 * size <= ROUNDING


def test_norm_takes_up_to_twenty_operands():
    operands = [0.1 * i for i in range(1, 21)]
    names = {f"x{i}": value for i, value in enumerate(operands)}
    assert parse(f"norm({', '.join(names)})")(names, np) == pytest.approx(math.hypot(*operands), rel=1e-15)


def test_smooth_abs_is_what_nonsmooth_tanh_makes_of_abs():
    y = np.linspace(-1, 1, 21)
    assert np.array_equal(FUNCTIONS["smooth_abs"].evaluate(np, [y, 0.1]), smooth_abs(TANH, np, y, 0.1))


@pytest.mark.parametrize("row", SEVERAL, **by_name)
def test_a_width_that_is_not_positive_is_a_fault(row):
    fault = parse(f"1 + {row.name}(x, w)").fault({"x": np.ones(2), "w": np.array([0.1, -0.1])})
    assert fault == (row.width and (f"{row.name}(x, w)", 1, {"x": 1, "w": -0.1}, "has a width that is not positive"))


ALL_OF_THEM = """
trajopt: 1
time: {initial: 0, final: 1}
parameters: {eps: 0.1}
states:
  x: {rate: "v*sec(v/9) + step(t - 0.5, eps)/9", initial: 0, final: 1}
  v: {rate: "u - sign(v, eps)/9 - erf(v)/9 + norm(v, u, x)/99", initial: 0, final: 0}
controls: {u: {lower: -30, upper: 30}}
objective: {minimize: {integral: "u**2 + smooth_abs(u, eps) + hypot(x, v) + atan2(v, x - 2)**2/9"}}
constraints: {path: [{name: c, expression: "log10(2 + x) + cot(2 + x/9) + csc(2 + x/9)", upper: 30}]}
"""


def test_a_problem_with_all_of_them_is_solved_verified_and_printed(folder):
    """By the method and the mesh that are chosen where a file names none."""
    Path("all.yaml").write_text(ALL_OF_THEM.replace("x - 2", "x + 2"))
    solved = trajopt("solve", "all.yaml", "-o", "all.h5")
    assert solved.exit_code == 0 and "all: solved" in solved.stdout, solved.output
    assert all(check.passed for check in verify(Path("all.h5"), anew=False))
    assert trajopt("export", "all.yaml", "all.tex", "--segments", "1").exit_code == 0
    bodies = re.findall(r"\\begin\{align\*\}\n(.*?)\\end\{align\*\}", Path("all.tex").read_text(), re.DOTALL)
    parser = MathTextParser("path")
    for body in bodies:
        rows = re.sub(r"\\bigg[lr]", "", body).split("\\\\\n")
        for row in {re.sub(r"\d+", "0", row): row for row in rows}.values():
            parser.parse(f"${row[2:].strip()}$")


def test_a_guess_on_the_cut_is_told(folder):
    """Along it v = 0 and x - 2 < 0."""
    Path("cut.yaml").write_text(ALL_OF_THEM)
    told = trajopt("solve", "cut.yaml")
    print(told.output)
    assert "jumps from pi to -pi" in " ".join(told.output.split())


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
