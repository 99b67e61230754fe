"""Compiled functions that look tables of data up: values and derivatives, wherever a table stands."""

import numpy as np
import pyomo.core as pyomo
import pytest
from derivatives import check_derivatives
from named import crossed

from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.problems.tables.table import fitted
from trajopt.transcription.collocation.model import compiled_model
from trajopt.transcription.program import machine_code
from trajopt.transcription.program.compiler import compile_model
from trajopt.transcription.program.contract import NotFinite
from trajopt.transcription.program.pointwise import PointFunctions
from trajopt.transcription.settings import steps
from trajopt.transcription.transcribe import compiled, transcribe

PROBLEM = """\
trajopt: 1
tables:
  f: {{points: {{v: [-1, 0, 0.5, 1, 2, 3]}}, values: [0, 0.1, 0.3, 1, 1.4, 2], outside: extrapolate}}
  g:
    points: {{x: [-1, 0, 0.5, 1, 2], v: [-1, 0, 1, 2]}}
    values: [[0, 1, 2, 3], [0.5, 1.5, 1, 2], [1, 2, 2, 2], [1, 3, 2, 5], [0, 2, 5, 7]]
    outside: hold
  h:
    points: {{x: [-1, 1, 2], v: [0, 1, 2], u: [-1, 0, 3]}}
    values: [[[1, 2, 3], [2, 3, 1], [2, 1, 4]], [[0, 1, 2], [5, 2, 3], [1, 1, 1]], [[3, 2, 1], [1, 1, 2], [1, 2, 3]]]
    outside: extrapolate
expressions:
  drag: {drag}
time: {{initial: 0, final: {{lower: 1, upper: 3, guess: 2}}}}
states:
  x: {{rate: v, initial: 0, final: 1}}
  v: {{rate: "u - drag", initial: 0, final: 0}}
controls: {{u: {{lower: -10, upper: 10}}}}
optimize: {{p: {{lower: 0, upper: 1, guess: 0.5}}}}
objective: {{minimize: {{integral: "{integral}", terminal: "{terminal}"}}}}
constraints:
  path: [{{expression: "{path}", upper: 9}}]
  boundary: [{{expression: "{boundary}", upper: 9}}]
  integral: [{{expression: "{integrated}", upper: 9}}]
mesh: [{{method: {method}, segments: 3}}]
"""
PLAIN = {
    "drag": "v",
    "integral": "u**2",
    "terminal": "p",
    "path": "v",
    "boundary": "x[initial]*p",
    "integrated": "x*p",
}
PLACES = {
    "one argument": {"drag": "f(v)"},
    "two arguments": {"drag": '"g(x, v)*p"'},
    "three arguments": {"drag": '"h(x, v*p, u)"'},
    "an integral": {"integral": "u**2*f(v + x)"},
    "a terminal objective": {"terminal": "g(x[final], v[final] + p)*p"},
    "a path constraint": {"path": "f(u)**2 + g(x, u*v)"},
    "a boundary constraint": {"boundary": "f(x[initial] + p) - f(t[final])"},
    "an integral constraint": {"integrated": "h(x, v, u)*f(x)"},
    "a table in a table": {"drag": '"g(f(v), f(f(x)) - u/20)"', "boundary": "drag[final]*p"},
    "a table twice": {"drag": '"f(v)*f(x) + f(v)**2 + sin(f(p))"'},
    "time": {"drag": '"g(t/2, v)"', "path": "f(t)*u"},
    "a constant": {"drag": '"f(0.3)*v + g(0.2, v)"'},
}
METHODS = ("hermite-simpson", "trapezoid", "radau", "gauss", "runge-kutta-4")


def program(method, **expressions):
    spec = load_text(PROBLEM.format(method=method, **{**PLAIN, **expressions}), "table.yaml")
    meshes = [steps(spec.mesh)[0].mesh()]
    return transcribe(build(spec), meshes), meshes


def point(nlp, low=0.2, high=0.9):
    return np.random.default_rng(7).uniform(low, high, nlp.n)


@pytest.mark.parametrize(("place", "method"), crossed([*PLACES], [*METHODS]))
def test_derivatives(place, method):
    nlp = compiled(program(method, **PLACES[place])[0])
    check_derivatives(nlp, point(nlp), 1e-7)


@pytest.mark.parametrize("place", PLACES)
def test_the_interpreter_gives_the_same(place):
    transcription, _ = program("hermite-simpson", **PLACES[place])
    fast = compiled_model(transcription)
    slow = compile_model(transcription.model, transcription.variables, backend="lambda")
    z, y = point(fast), np.random.default_rng(2).standard_normal(fast.m)
    for name, arguments in (("constraints", ()), ("jacobian", ()), ("hessian", (y, 0.5))):
        np.testing.assert_allclose(getattr(slow, name)(z, *arguments), getattr(fast, name)(z, *arguments), atol=1e-11)


@pytest.mark.parametrize("place", PLACES)
def test_the_templates_mean_what_pyomo_makes_of_the_model(place):
    """Pyomo evaluates the expanded model by itself, through `Table.evaluate` for each number."""
    transcription, meshes = program("radau", **PLACES[place])
    nlp = compiled(transcription)
    expanded = transcribe(transcription.problem, meshes, templates=False)
    z = point(nlp)
    for variable, value in zip(expanded.variables, z, strict=True):
        variable.set_value(value, skip_validation=True)
    values = nlp.constraints(z)
    templates = {family.component.name: family.component for family in transcription.families}
    for component in {family.component.name: family.component for family in expanded.families}.values():
        rows = nlp.rows(templates[component.name])
        for row, constraint in zip(rows, component.values(), strict=True):
            bound = constraint.upper if constraint.lower is None else constraint.lower
            limit = nlp.cl[row] if np.isfinite(nlp.cl[row]) else nlp.cu[row]
            assert pyomo.value(constraint.body - bound) == pytest.approx(values[row] - limit, abs=1e-10)
    assert pyomo.value(next(expanded.model.component_data_objects(pyomo.Objective))) == pytest.approx(nlp.objective(z))


def test_pointwise_functions_are_the_chain_rule_of_the_table():
    points = {"a": [0, 1, 2, 3], "b": [0, 1, 2, 4]}
    table = fitted("f", points, np.random.default_rng(0).random((4, 4)), "cubic", dict.fromkeys("ab", "hold"), {})
    functions = PointFunctions(
        [lambda v, m: table.evaluate(m, [v["x"] ** 2, 3 * v["y"]])], ["x", "y"], [], {"differentiate": 0, "compile": 0}
    )
    at = np.random.default_rng(1).uniform(0, 1.7, (50, 2))
    x, arguments = at[:, 0], (at[:, 0] ** 2, 3 * at[:, 1])

    def d(*orders):
        return table.derivative(arguments, orders)

    np.testing.assert_allclose(functions.values(at)[:, 0], d(0, 0), rtol=1e-12)
    np.testing.assert_allclose(functions.jacobian(at)[:, 0].T, [2 * x * d(1, 0), 3 * d(0, 1)], rtol=1e-11, atol=1e-12)
    hessian = functions.hessian(at, np.ones((50, 1)))
    exact = [2 * d(1, 0) + 4 * x**2 * d(2, 0), 6 * x * d(1, 1), 9 * d(0, 2)]
    np.testing.assert_allclose([hessian[:, 0, 0], hessian[:, 1, 0], hessian[:, 1, 1]], exact, rtol=1e-10, atol=1e-10)


def test_the_code_is_the_same_for_other_data():
    """What is compiled knows how many arguments a table has, not its numbers."""
    first = compiled(program("radau", drag="f(v) + 0*x")[0])
    known, z = len(machine_code._code), point(first)
    text = PROBLEM.format(method="radau", **{**PLAIN, "drag": "f(v) + 0*x"})
    spec = load_text(text, "table.yaml", ["tables.f.values=[0, 1, 2, 3, 4, 5]"])
    second = compiled(transcribe(build(spec), [steps(spec.mesh)[0].mesh()]))
    assert len(machine_code._code) == known
    assert np.abs(first.constraints(z) - second.constraints(z)).max() > 0.1


def test_what_is_not_finite_is_named():
    nlp = compiled(program("trapezoid", drag="sqrt(f(v) - 2)")[0])
    with pytest.raises(NotFinite) as error:
        nlp.hessian(point(nlp), np.ones(nlp.m), 1.0)
    assert {name for name, _ in error.value.names} == {"phase[main].defect0_v_0"}
