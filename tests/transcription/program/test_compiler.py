"""Compiled templates against Pyomo's own expansion, and what cannot be compiled, on models made by hand."""

import logging
import warnings
from math import inf

import numpy as np
import pyomo.core.base.constraint as pyomo_constraint
import pytest
import symengine as se
from derivatives import check_derivatives
from exact import growth, integration
from pyomo import core as pyo
from pyomo.core import Block, ConcreteModel, Constraint, Objective, Param, RangeSet, Var, inequality, maximize
from pyomo.core.expr.visitor import identify_variables

from trajopt.transcription.program import machine_code
from trajopt.transcription.program.backend import available_backend
from trajopt.transcription.program.compiler import compile_model
from trajopt.transcription.program.contract import NotFinite
from trajopt.transcription.program.templates import TemplateError, templated
from trajopt.transcription.schemes.mesh import Mesh
from trajopt.transcription.schemes.table import HERMITE_SIMPSON
from trajopt.transcription.transcribe import transcribe

from .pyomo_models import free, random_point, small, trajectory, two_phases

BACKENDS = ("llvm", "lambda")


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("scheme", ["trapezoid", "hermite-simpson"])
def test_values_are_those_of_the_expanded_expressions(scheme, backend):
    model = two_phases(scheme)
    variables = free(model)
    nlp = compile_model(model, variables, backend=backend)
    z = random_point(nlp)
    g = nlp.constraints(z)
    for v, number in zip(variables, z, strict=True):
        v.set_value(number)
    assert nlp.objective(z) == pytest.approx(pyo.value(model.cost.expr), rel=1e-13)
    seen = []
    for component in model.component_objects(Constraint):
        rows = nlp.rows(component)
        assert len(rows) == len(component)
        for row, (index, data) in zip(rows, component.items(), strict=True):
            assert nlp.row_name(row) == (component.name, index)
            expression = data.expr
            body, lower, upper = pyo.value(data.body), data.lb, data.ub
            assert expression.is_relational()
            assert g[row] - nlp.cl[row] == pytest.approx(inf if lower is None else body - lower, abs=1e-12)
            assert nlp.cu[row] - g[row] == pytest.approx(inf if upper is None else upper - body, abs=1e-12)
        seen.extend(rows)
    assert sorted(seen) == list(range(nlp.m))


def test_rows_of_components_on_one_set_interleave():
    model = ConcreteModel()
    trajectory(model, 5, "hermite-simpson")
    nlp = compile_model(model, free(model))
    np.testing.assert_array_equal(nlp.rows(model.defect_q), np.arange(0, 20, 4))
    np.testing.assert_array_equal(nlp.rows(model.mid_v), np.arange(3, 20, 4))


def test_fixed_variables_are_data():
    def rule(m, s):
        return m.x[s] * m.x[s + 1] ** 2 == m.y

    values = {}
    for fixed in (0.25, 0.75):
        model = small(rule)
        model.x[2].fix(fixed)
        model.y.fix(fixed)
        compiled = len(machine_code._code)
        nlp = compile_model(model, free(model))
        assert nlp.n == 4
        z = np.array([0.1, 0.2, 0.3, 0.4])
        x = np.array([0.1, 0.2, fixed, 0.3, 0.4])
        values[fixed] = nlp.constraints(z)
        np.testing.assert_allclose(values[fixed], x[:-1] * x[1:] ** 2 - fixed, atol=1e-15)
        check_derivatives(nlp, z)
    assert len(machine_code._code) == compiled  # the value is no part of the code


def test_bounds():
    model = small()
    model.hi = Param(model.inner, initialize={k: 3.0 + k for k in range(4)}, mutable=True)
    with templated():
        model.ranged = Constraint(model.inner, rule=lambda m, s: inequality(-m.hi[s] / 2, m.x[s] ** 2, m.hi[s]))
        model.pair = Constraint(model.inner, rule=lambda m, s: (-1, m.x[s] + 2, 5.5))
        model.lower = Constraint(model.inner, rule=lambda m, s: m.x[s] >= 3)
        model.upper = Constraint(model.inner, rule=lambda m, s: m.x[s] <= m.x[s + 1] + 4)
        model.equal = Constraint(rule=lambda m: m.y == 7)
    nlp = compile_model(model, free(model))

    def bounds(c):
        return nlp.cl[nlp.rows(c)].tolist(), nlp.cu[nlp.rows(c)].tolist()

    assert bounds(model.ranged) == ([-1.5, -2, -2.5, -3], [3, 4, 5, 6])
    assert bounds(model.pair) == ([-1] * 4, [5.5] * 4)
    assert bounds(model.lower) == ([3] * 4, [inf] * 4)
    assert bounds(model.upper) == ([-inf] * 4, [0] * 4)
    assert bounds(model.equal) == ([7], [7])


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("body", "z", "kind"),
    [
        (lambda x, y: pyo.log(x), -1.0, "constraints"),
        (lambda x, y: pyo.sqrt(x), -1.0, "constraints"),
        (lambda x, y: y / x, 0.0, "constraints"),
        (lambda x, y: pyo.exp(x), 1e4, "constraints"),
        (lambda x, y: pyo.sqrt(x), 0.0, "jacobian"),
        (lambda x, y: x**1.5, 0.0, "hessian"),
        (lambda x, y: pyo.asin(x), 2.0, "constraints"),
        (lambda x, y: x**2.5 * y, -1.0, "constraints"),
    ],
)
def test_not_finite_names_the_component_and_index(body, z, kind, backend):
    model = ConcreteModel()
    model.phase = Block()
    block = model.phase
    block.point = RangeSet(0, 9)
    block.x, block.y = Var(block.point), Var()
    with templated():
        block.sound = Constraint(block.point, rule=lambda m, s: m.x[s] ** 2 == 0)
        block.sick = Constraint(block.point, rule=lambda m, s: body(m.x[s], m.y) == m.y)
        model.total = Constraint(rule=lambda m: sum(body(m.phase.x[k], m.phase.y) for k in m.phase.point) == 0)
        model.cost = Objective(rule=lambda m: sum(body(m.phase.x[k], m.phase.y) for k in m.phase.point))
    nlp = compile_model(model, [*block.x.values(), block.y], backend=backend)
    at = np.full(11, 0.5)
    at[7] = z
    calls = {"objective": (), "constraints": (), "gradient": (), "jacobian": (), "hessian": (np.ones(nlp.m), 1.0)}
    fail_at = {
        "constraints": {"objective", "constraints"},
        "jacobian": {"gradient", "jacobian"},
        "hessian": {"hessian"},
    }
    raised = {}
    for name, args in calls.items():
        try:
            getattr(nlp, name)(at, *args)
        except NotFinite as error:
            raised[name] = error
    assert fail_at[kind] <= set(raised)
    for name, error in raised.items():
        expected = {("cost", 7)} if name in ("objective", "gradient") else {("phase.sick", 7), ("total", 7)}
        assert error.kind == name
        assert set(error.names) - {("cost", 7)} == expected - {("cost", 7)}
        assert "7" in str(error)
    assert np.isfinite(nlp.objective(np.full(11, 0.5)))


@pytest.mark.parametrize("size", [1e120, 1e155, 1e300])
def test_what_is_large_and_finite_is_taken_without_a_warning(size):
    """Also where the sum of the squares of all values is none: 1e300 squared is infinite."""
    model = small(lambda m, s: size * m.x[s] == 0)
    nlp = compile_model(model, [*model.x.values(), model.y])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        values = nlp.constraints(np.ones(nlp.n))
    assert np.abs(values).max() == pytest.approx(size)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    "body",
    [lambda x: 1 / (x - x), lambda x: pyo.log(x - x), lambda x: pyo.sqrt(x - x - 2), lambda x: (x - x - 2) ** 0.3],
)
def test_what_is_never_finite_fails_when_evaluated(body, backend):
    model = small(lambda m, s: body(m.x[s]) + m.x[s] == 0)
    nlp = compile_model(model, free(model), backend=backend)
    with pytest.raises(NotFinite):
        nlp.constraints(random_point(nlp))


def test_the_next_mesh_compiles_nothing(monkeypatch):
    meshes = []
    for n in (4, 9):
        model = ConcreteModel()
        trajectory(model, n, "hermite-simpson")
        meshes.append(model)
    first = compile_model(meshes[0], free(meshes[0]))
    compiled = len(machine_code._code)
    monkeypatch.setattr(se, "Lambdify", None)
    second = compile_model(meshes[1], free(meshes[1]))
    assert len(machine_code._code) == compiled
    assert second.seconds["compile"] == 0
    assert second.m == first.m + 5 * (4 + 2 * 2)
    check_derivatives(second, random_point(second))


def test_the_interpreter_stands_in_where_llvm_is_missing(monkeypatch, caplog):
    available_backend.cache_clear()
    try:
        with monkeypatch.context() as patch, caplog.at_level(logging.WARNING):
            patch.setattr(se, "have_llvm", False)
            assert available_backend() == available_backend() == "lambda"
        assert len(caplog.records) == 1
        model = small(lambda m, s: m.x[s] ** 2 == m.y)
        assert compile_model(model, free(model)).constraints(np.full(6, 0.5)).tolist() == [-0.25] * 4
    finally:
        available_backend.cache_clear()


def test_templated_restores_the_switches():
    with pytest.raises(ZeroDivisionError), templated():
        assert pyomo_constraint.TEMPLATIZE_CONSTRAINTS
        raise ZeroDivisionError
    assert not pyomo_constraint.TEMPLATIZE_CONSTRAINTS


def loops_over_a_set(m, s):
    total = 0
    for k in m.point:
        total += m.x[k]
    return total == m.x[s]


@pytest.mark.parametrize(
    ("rule", "message"),
    [
        (loops_over_a_set, "c is not a template"),
        (lambda m, s: abs(m.x[s]) == 0, "abs"),
        (lambda m, s: m.x[s] * s == 0, "outside the brackets"),
        (lambda m, s: m.x[s + 2] == 0, "no index"),
        (lambda m, s: sum(m.x[k] for k in m.point) == m.x[s], "sum over a Set"),
    ],
)
def test_what_is_no_template_is_refused(rule, message):
    model = small(rule)
    with pytest.raises(TemplateError, match=message):
        compile_model(model, free(model))


def test_objectives_and_variables_are_checked():
    model = small()
    model.cost.sense = maximize
    with pytest.raises(TemplateError, match="minimise"):
        compile_model(model, free(model))
    model = small(lambda m, s: m.x[s] == m.y)
    with pytest.raises(TemplateError, match="y is neither"):
        compile_model(model, list(model.x.values()))
    with pytest.raises(TemplateError, match="x at index"):
        compile_model(model, [model.y])


def test_seconds_by_part():
    model = small(lambda m, s: m.x[s] ** 2 == m.y)
    nlp = compile_model(model, free(model))
    nlp.constraints(np.ones(nlp.n))
    nlp.jacobian(np.ones(nlp.n))
    assert set(nlp.seconds) == {"differentiate", "compile", "evaluate"}
    assert nlp.seconds["evaluate"] > 0


def test_every_variable_of_the_model_is_read():
    model = ConcreteModel()
    trajectory(model, 3, "trapezoid")
    nlp = compile_model(model, free(model))
    read = {id(v) for c in model.component_data_objects(Constraint) for v in identify_variables(c.expr) if not v.fixed}
    assert len(read) == nlp.n == len(set(nlp.jacobianstructure()[1]))


def test_unchecked_constraints_keep_nan():
    model = small(lambda m, s: pyo.log(m.x[s]) == 0)
    nlp = compile_model(model, free(model))
    z = np.array([1.0, -1.0, 1.0, 1.0, 1.0, 1.0])  # y stands first
    assert np.isnan(nlp.constraints_unchecked(z)).tolist() == [True, False, False, False]
    with pytest.raises(NotFinite):
        nlp.constraints(z)


def test_times_of_the_points_are_data_only_where_a_function_asks_for_them():
    for problem, asked in ((growth(), False), (integration(), True)):
        block = transcribe(problem, [Mesh.of(HERMITE_SIMPSON, 3)]).model.phase["main"]
        assert (block.component("fraction") is not None) == asked
