"""Expressions: the values of Python's own arithmetic, with NumPy and Pyomo; what is not arithmetic is refused."""

import math
import random
import re

import numpy as np
import pyomo.core
import pytest

from trajopt.problems.expressions.expression import parse
from trajopt.problems.expressions.functions import FUNCTIONS
from trajopt.problems.expressions.tokens import ExpressionError

from .texts import NAMES, random_text

PYTHON = {
    **{name: getattr(math, name) for name, row in FUNCTIONS.items() if row.composed is None},
    "pi": math.pi,
    "__builtins__": {},
}


@pytest.mark.parametrize("seed", range(40))
def test_values_are_those_of_python(seed):
    rng = random.Random(seed)
    text = random_text(rng, 4)
    expected = eval(text, PYTHON, dict(NAMES))  # a text of our own making
    expression = parse(text)
    assert expression(NAMES, np) == pytest.approx(expected, rel=1e-13, abs=1e-13)

    model = pyomo.core.ConcreteModel()
    model.v = pyomo.core.Var(list(NAMES), initialize=NAMES)
    symbolic = expression({name: model.v[name] for name in NAMES}, pyomo.core)
    assert pyomo.core.value(symbolic) == pytest.approx(expected, rel=1e-13, abs=1e-13)

    arrays = {name: np.array([value, value / 2]) for name, value in NAMES.items()}
    assert np.broadcast_to(expression(arrays, np), 2)[0] == pytest.approx(expected, rel=1e-13, abs=1e-13)


@pytest.mark.parametrize("text", ["2*-x", "-x**2", "2**-1", "2**3**2", "x - y - q1", "x/y/q1", "+x", "- -x", "x*+y"])
def test_precedence_is_that_of_python(text):
    assert parse(text)(NAMES, np) == pytest.approx(eval(text, PYTHON, dict(NAMES)), rel=1e-14)


def test_whole_exponents_stay_whole():
    """x**2 must reach the derivatives as a product, also where the exponent is a parameter."""
    model = pyomo.core.ConcreteModel()
    model.x = pyomo.core.Var()
    for expression in (parse("x**2"), parse("x**n").bind({"n": 2.0}, {})):
        exponent = expression({"x": model.x}, pyomo.core).args[1]
        assert isinstance(exponent, int)


@pytest.mark.parametrize(
    ("text", "value"),
    [("abs(y)", 0.3), ("min(x, y, 0.1)", -0.3), ("max(x, min(q1, u_max))", 1.9), ("-abs(-x)**2", -0.49)],
)
def test_abs_min_and_max_are_read(text, value):
    """Their values are exact as they stand; nonsmooth.py replaces them before they reach a solver."""
    assert parse(text)(NAMES, np) == pytest.approx(value)
    arrays = {name: np.array([value, -value]) for name, value in NAMES.items()}
    assert parse(text)(arrays, np)[0] == pytest.approx(value)
    assert parse(text).names == set(re.findall(r"x|y|q1|u_max", text.replace("max(", "(")))


def test_the_rate_of_a_state_is_a_name():
    expression = parse("m*v[rate] - u + v[initial]")
    assert expression.names == {"m", "v[rate]", "u", "v[initial]"}
    assert parse("2*v[rate]")({"v[rate]": 3.0}, np) == 6
    assert parse("a[final]").bind({}, {"a": parse("2*v[rate]")})({"v[rate][final]": 3.0}, np) == 6


def test_line_breaks_and_spaces_do_not_matter():
    assert parse("x +\n   y\t* q1 ").text == "x + y * q1"


PIECES = [
    "x",
    "y",
    "2",
    "0.5",
    "1e3",
    "pi",
    "sin",
    "log",
    "(",
    ")",
    "(",
    ")",
    "+",
    "-",
    "*",
    "/",
    "**",
    "**",
    ",",
    ".",
    "[",
    "]",
    "[final]",
    "initial",
    "=",
    "^",
    "t",
    "lambda",
    "if",
    "'a'",
    "abs",
    "min",
    "atan2",
    "step",
    "floor",
    "x(t - 1)",
    "[rate]",
    "~",
    ":",
    "@",
]


@pytest.mark.parametrize("seed", range(20))
def test_any_text_is_read_or_refused_with_a_sentence(seed):
    rng = random.Random(seed)
    for _ in range(200):
        text = rng.choice(["", " "]).join(rng.choices(PIECES, k=rng.randint(1, 9)))
        try:
            parse(text)
        except ExpressionError as error:
            assert error.what and error.remedy


@pytest.mark.parametrize(
    "text", ["9**9**9", "10**400", "2**" * 900 + "2", "1/0", "0**-1", "(-1)**0.5", "exp(1e9)", "1e101"]
)
def test_constants_without_a_value_are_refused(text):
    with pytest.raises(ExpressionError):
        parse(text)


def test_long_sums_are_read():
    text = "+".join(["x"] * 1900)
    assert parse(text)({"x": 1.0}, np) == 1900


def test_names_and_ends():
    assert parse("q1[final]*p - sin(t) + pi").names == {"q1[final]", "p", "t"}


def test_a_fault_is_the_innermost_part_and_its_values():
    expression = parse("3*sqrt(1 + log(x1 - a)/y)").bind({"a": 2.0}, {})
    assert expression.fault({"x1": np.array([3.0, 2.5]), "y": np.array([1.0, 1.0])}) is None
    found = expression.fault({"x1": np.array([3.0, 2.5, 1.5, 1.0]), "y": np.ones(4)})
    assert found == ("log(x1 - a)", 2, {"x1": 1.5, "a": 2.0}, "is not a real number")
    assert expression.fault({"x1": np.array([3.0, 2.5]), "y": np.array([1.0, 0.0])}) == (
        "log(x1 - a)/y",
        1,
        {"x1": 2.5, "a": 2.0, "y": 0.0},
        "divides by zero",
    )


@pytest.mark.parametrize(
    ("text", "x", "part", "why"),
    [("x**-1", 0.0, "x**-1", "is too large a number"), ("x**0.5 + 1", -1.0, "x**0.5", "is not a real number"),
     ("(x + 1)/(x - 1)*2", 1.0, "(x + 1)/(x - 1)", "divides by zero"),
     ("exp(x)", 1000.0, "exp(x)", "is too large a number"), ("x + 1", math.nan, "x", "is not finite"),
     ("1 + 2*asin(x)", 2.0, "asin(x)", "is not a real number"),
     ("2*log(x)", 0.0, "log(x)", "is the logarithm of zero")],
)  # fmt: skip
def test_faults_of_many_kinds(text, x, part, why):
    fault = parse(text).fault({"x": x})
    assert (fault.text, fault.why) == (part, why)


def test_a_fault_inside_a_definition():
    definitions = {"speed": parse("sqrt(v)"), "power": parse("2*speed")}
    bound = parse("power[final] - 1").bind({}, definitions)
    assert bound.names == {"v[final]"}
    assert bound.fault({"v[final]": -4.0}) == ("sqrt(v)", 0, {"v[final]": -4.0}, "is not a real number")
    assert bound({"v[final]": 4.0}, np) == 3.0


def test_shared_definitions_are_evaluated_once():
    """Each level doubles the last: written out, the expression would have 2**60 terms."""
    definitions = {"e0": parse("x")} | {f"e{i}": parse(f"e{i - 1}/2 + e{i - 1}/2") for i in range(1, 61)}
    bound = parse("e60 + e60").bind({}, definitions)
    assert bound({"x": 3.0}, np) == 6.0
    assert bound.names == {"x"}


def test_static_parameters_have_one_value_at_both_ends():
    definitions = {"energy": parse("m*v**2/2 + p")}
    bound = parse("energy[final] - energy[initial] + p").bind({"m": 2.0}, definitions, frozenset({"p"}))
    assert bound.names == {"v[final]", "v[initial]", "p"}
    assert bound({"v[final]": 3.0, "v[initial]": 1.0, "p": 0.5}, np) == 8.5
