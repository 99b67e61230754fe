"""Templates against Pyomo's own expansion, derivatives against central differences, on models made here."""

import logging
from math import inf

import numpy as np
import pyomo.core.base.constraint as pyomo_constraint
import pytest
import symengine as se
from pyomo import core as pyo
from pyomo.core import Block, ConcreteModel, Constraint, Objective, Param, RangeSet, Set, Var, inequality, maximize
from pyomo.core.expr.visitor import identify_variables

from trajopt.transcription import machine_code
from trajopt.transcription.compiler import CompiledNLP
from trajopt.transcription.family import NotFinite
from trajopt.transcription.machine_code import available_backend
from trajopt.transcription.symbolic import FUNCTIONS
from trajopt.transcription.templates import TemplateError, templated

BACKENDS = ("llvm", "lambda")


def pendulum_rates(m, k):
    return {"q": m.x["v", k], "v": m.u[k] * m.p["torque"] - m.g * pyo.sin(m.x["q", k]) / (1 + m.x["v", k] ** 2)}


def trajectory(model, n, scheme):
    """A pendulum of free end time and one static parameter, in two schemes; x[q, 0], x[v, last] are fixed."""
    per = {"trapezoid": 1, "hermite-simpson": 2}[scheme]
    last = per * n
    model.segment, model.point = RangeSet(0, n - 1), RangeSet(0, last)
    model.state = Set(initialize=["q", "v"])
    model.x = Var(model.state, model.point, initialize=0.0)
    model.u = Var(model.point, initialize=0.0)
    model.p = Var(["torque"], initialize=1.0)
    model.tf = Var(initialize=2.0)
    model.g = Param(initialize=9.81, mutable=True)
    model.first = Param(model.segment, initialize={s: per * s for s in range(n)})
    model.width = Param(model.segment, initialize=dict(enumerate(np.linspace(1, 2, n) / n)), mutable=True)
    model.w = Param(model.point, initialize=dict(enumerate(np.linspace(0.5, 1, last + 1) / n)))

    def defect(m, s, i):
        h, k = m.width[s] * (m.tf - 0.5), m.first[s]
        f = [pendulum_rates(m, k + j)[i] for j in range(per + 1)]
        rule = (f[0] + f[1]) / 2 if per == 1 else (f[0] + 4 * f[1] + f[2]) / 6
        return m.x[i, k + per] - m.x[i, k] == h * rule

    def midpoint(m, s, i):
        f = [pendulum_rates(m, 2 * s + j)[i] for j in (0, 2)]
        ends = m.x[i, 2 * s] + m.x[i, 2 * s + 2]
        return m.x[i, 2 * s + 1] == 0.5 * ends + m.tf * m.width[s] / 8 * (f[0] - f[1])

    with templated():
        for i in ("q", "v"):
            model.add_component(f"defect_{i}", Constraint(model.segment, rule=lambda m, s, i=i: defect(m, s, i)))
            if per == 2:
                model.add_component(f"mid_{i}", Constraint(model.segment, rule=lambda m, s, i=i: midpoint(m, s, i)))
        model.path = Constraint(model.point, rule=lambda m, k: inequality(-1.5, m.u[k] * m.x["q", k], 2.5))
        model.below = Constraint(model.point, rule=lambda m, k: m.u[k] ** 2 <= 4 + m.x["v", k])
        model.energy = Constraint(
            rule=lambda m: (
                m.x["q", last] ** 2
                - sum(m.w[k] * m.u[k] ** 2 for k in m.point) * 3
                + m.tf * sum(m.w[k] * pyo.cos(m.x["q", k]) for k in m.point)
                <= 100
            )
        )
        model.close = Constraint(rule=lambda m: m.x["v", 0] * m.x["v", last] == m.p["torque"] - 1)
        model.cost = Objective(
            rule=lambda m: (
                m.tf**2
                + (m.tf - 0.5) * sum(m.w[k] * m.u[k] ** 2 for k in m.point)
                - sum(m.x["q", s] * m.x["v", s + 1] for s in m.segment) / 3
            )
        )
    model.x["q", 0].fix(0.3)
    model.x["v", last].fix(-0.2)


def free(model):
    """The free variables, point by point where they have a point."""
    leaves = [v for v in model.component_data_objects(Var) if not v.fixed]

    def point(v):
        index = v.index()[-1] if isinstance(v.index(), tuple) else v.index()
        return index if isinstance(index, int) else -1

    return sorted(leaves, key=point)


def two_phases(scheme, n=4):
    model = ConcreteModel()
    model.a, model.b = Block(), Block()
    trajectory(model.a, n, scheme)
    trajectory(model.b, n + 1, scheme)
    with templated():
        model.link = Constraint(rule=lambda m: m.a.tf * m.b.x["q", 1] == m.b.x["v", 0])
        model.cost = Objective(rule=lambda m: m.a.tf + sum(m.b.w[k] * m.b.u[k] ** 2 for k in m.b.point))
    model.a.cost.deactivate(), model.b.cost.deactivate()
    return model


def small(constraint=None, objective=lambda m: m.y, n=4):
    """x[0..n], a scalar y and the given rules."""
    m = ConcreteModel()
    m.point = RangeSet(0, n)
    m.inner = RangeSet(0, n - 1)
    m.x, m.y = Var(m.point, initialize=0.5), Var(initialize=0.5)
    m.d = Param(m.point, initialize={k: 0.1 * (k + 1) for k in range(n + 1)})
    with templated():
        if constraint:
            m.c = Constraint(m.inner, rule=constraint)
        m.cost = Objective(rule=objective)
    return m


def dense(nlp, z, y, sigma):
    """Jacobian (m, n) and full Hessian (n, n)."""
    jac, low = np.zeros((nlp.m, nlp.n)), np.zeros((nlp.n, nlp.n))
    np.add.at(jac, nlp.jacobianstructure(), nlp.jacobian(z))
    rows, cols = nlp.hessianstructure()
    assert (rows >= cols).all()
    np.add.at(low, (rows, cols), nlp.hessian(z, y, sigma))
    return jac, low + np.tril(low, -1).T


def differences(function, z, step=1e-5):
    return np.array([(function(z + e) - function(z - e)) / (2 * step) for e in step * np.eye(len(z))]).T


def check_derivatives(nlp, z, tolerance=1e-7):
    rng = np.random.default_rng(5)
    y, sigma = rng.standard_normal(nlp.m), 0.7
    jac, hess = dense(nlp, z, y, sigma)
    scale = 1 + np.abs(jac).max(initial=0) + np.abs(hess).max(initial=0)
    close = {"atol": tolerance * scale, "rtol": 0}
    np.testing.assert_allclose(nlp.gradient(z), differences(nlp.objective, z), **close)
    np.testing.assert_allclose(jac, differences(nlp.constraints, z), **close)

    def lagrangian_gradient(z):
        jac, _ = dense(nlp, z, y, sigma)
        return sigma * nlp.gradient(z) + y @ jac

    np.testing.assert_allclose(hess, differences(lagrangian_gradient, z), **close)
    return jac, hess


def random_point(nlp, seed=0, low=-1.0, high=1.0):
    return np.random.default_rng(seed).uniform(low, high, nlp.n)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("scheme", ["trapezoid", "hermite-simpson"])
def test_values_are_those_of_the_expanded_expressions(scheme, backend):
    model = two_phases(scheme)
    variables = free(model)
    nlp = CompiledNLP(model, variables, backend=backend)
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


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("scheme", ["trapezoid", "hermite-simpson"])
def test_derivatives_and_sparsity_of_a_transcription(scheme, backend):
    model = ConcreteModel()
    trajectory(model, 4, scheme)
    variables = free(model)
    nlp = CompiledNLP(model, variables, backend=backend)
    jac, hess = check_derivatives(nlp, random_point(nlp))
    # Exactly the nonzeros: none that is zero at a random point.
    rows, cols = nlp.jacobianstructure()
    assert set(zip(rows, cols, strict=True)) == set(zip(*np.nonzero(jac), strict=True))
    rows, cols = nlp.hessianstructure()
    assert set(zip(rows, cols, strict=True)) == set(zip(*np.nonzero(np.tril(hess)), strict=True))


def test_rows_of_components_on_one_set_interleave():
    model = ConcreteModel()
    trajectory(model, 5, "hermite-simpson")
    nlp = CompiledNLP(model, free(model))
    np.testing.assert_array_equal(nlp.rows(model.defect_q), np.arange(0, 20, 4))
    np.testing.assert_array_equal(nlp.rows(model.mid_v), np.arange(3, 20, 4))


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_function(name, backend):
    function = getattr(pyo, name)
    model = small(
        lambda m, s: function(m.x[s] * m.y) * m.x[s + 1] == m.d[s],
        lambda m: sum(m.d[k] * function(m.x[k]) for k in m.point),
    )
    nlp = CompiledNLP(model, free(model), backend=backend)
    z = random_point(nlp, low=0.3, high=0.8)
    check_derivatives(nlp, z, 1e-6)
    values = dict(zip(map(id, free(model)), z, strict=True))
    x, y = np.array([values[id(v)] for v in model.x.values()]), values[id(model.y)]
    exact = getattr(np, {"asin": "arcsin", "acos": "arccos", "atan": "arctan"}.get(name, name))
    rows = nlp.constraints(z)
    np.testing.assert_allclose(rows - nlp.cu, exact(x[:4] * y) * x[1:] - 0.1 * np.arange(1, 5), rtol=0, atol=1e-14)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    "body",
    [
        lambda m, s: m.x[s] ** 2 * m.y + m.x[s + 1] ** 3,
        lambda m, s: m.x[s] ** -1 / m.y,
        lambda m, s: m.x[s] ** 0.5,
        lambda m, s: m.x[s] ** 2.5 - m.x[s] ** 1.7,
        lambda m, s: m.x[s] ** m.y,
        lambda m, s: 2 ** m.x[s],
        lambda m, s: m.x[s] ** m.d[s],
        lambda m, s: -(m.x[s] - 1.5) * (m.y / 3 + 1e-3) * m.x[s + 1],
    ],
)
def test_arithmetic(body, backend):
    nlp = CompiledNLP(model := small(lambda m, s: body(m, s) <= 1), free(model), backend=backend)
    check_derivatives(nlp, random_point(nlp, low=0.3, high=0.8))


@pytest.mark.parametrize("backend", BACKENDS)
def test_arguments_that_are_one_variable_at_some_indices(backend):
    """x[s] * x[first[s]]: a square at s = 0 only, and the mirror image x[last[s]] * x[s] elsewhere."""
    model = small()
    model.near = Param(model.inner, initialize={0: 0, 1: 3, 2: 1, 3: 3})
    with templated():
        model.alias = Constraint(model.inner, rule=lambda m, s: m.x[s] * m.x[m.near[s]] ** 2 + m.x[s + 1] * m.x[s] == 0)
        model.whole = Constraint(rule=lambda m: sum(m.x[s] * m.x[m.near[s]] * m.y for s in m.inner) == 0)
    nlp = CompiledNLP(model, free(model), backend=backend)
    jac, _ = check_derivatives(nlp, random_point(nlp))
    places = list(zip(*nlp.jacobianstructure(), strict=True))
    assert set(places) == set(zip(*np.nonzero(jac), strict=True))
    assert len([p for p in places if p[0] < 4]) == np.count_nonzero(jac[:4])  # each place once


def test_fixed_variables_are_data():
    def rule(m, s):
        return m.x[s] * m.x[s + 1] ** 2 == m.y

    values = {}
    for fixed in (0.25, 0.75):
        model = small(rule)
        model.x[2].fix(fixed)
        model.y.fix(fixed)
        compiled = len(machine_code._code)
        nlp = CompiledNLP(model, free(model))
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
    nlp = CompiledNLP(model, free(model))

    def bounds(c):
        return nlp.cl[nlp.rows(c)].tolist(), nlp.cu[nlp.rows(c)].tolist()

    assert bounds(model.ranged) == ([-1.5, -2, -2.5, -3], [3, 4, 5, 6])
    assert bounds(model.pair) == ([-1] * 4, [5.5] * 4)
    assert bounds(model.lower) == ([3] * 4, [inf] * 4)
    assert bounds(model.upper) == ([-inf] * 4, [0] * 4)
    assert bounds(model.equal) == ([7], [7])


@pytest.mark.parametrize("backend", BACKENDS)
def test_sums_make_a_dense_row_and_a_sparse_hessian(backend):
    model = small(
        objective=lambda m: 3 * sum(m.x[k] ** 3 for k in m.point) - sum(m.x[s] * m.x[s + 1] for s in m.inner), n=30
    )
    with templated():
        model.row = Constraint(
            rule=lambda m: (
                m.y**2 - sum(m.d[k] * m.x[k] ** 2 for k in m.point) / 2 + (-sum(pyo.sin(m.x[k]) for k in m.point))
                <= sum(m.x[s] for s in m.inner)
            )
        )
    nlp = CompiledNLP(model, free(model), backend=backend)
    check_derivatives(nlp, random_point(nlp))
    assert len(set(nlp.jacobianstructure()[1])) == nlp.n
    rows, cols = nlp.hessianstructure()
    assert len(set(zip(rows, cols, strict=True))) == 31 + 30 + 1  # diagonal, first subdiagonal, y


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
    nlp = CompiledNLP(model, [*block.x.values(), block.y], backend=backend)
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


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    "body",
    [lambda x: 1 / (x - x), lambda x: pyo.log(x - x), lambda x: pyo.sqrt(x - x - 2), lambda x: (x - x - 2) ** 0.3],
)
def test_what_is_never_finite_fails_when_evaluated(body, backend):
    model = small(lambda m, s: body(m.x[s]) + m.x[s] == 0)
    nlp = CompiledNLP(model, free(model), backend=backend)
    with pytest.raises(NotFinite):
        nlp.constraints(random_point(nlp))


def test_the_next_mesh_compiles_nothing(monkeypatch):
    meshes = []
    for n in (4, 9):
        model = ConcreteModel()
        trajectory(model, n, "hermite-simpson")
        meshes.append(model)
    first = CompiledNLP(meshes[0], free(meshes[0]))
    compiled = len(machine_code._code)
    monkeypatch.setattr(se, "Lambdify", None)
    second = CompiledNLP(meshes[1], free(meshes[1]))
    assert len(machine_code._code) == compiled
    assert second.seconds["compile"] == 0
    assert second.m == first.m + 5 * (4 + 2 * 2)
    check_derivatives(second, random_point(second))


def test_the_interpreter_stands_in_where_llvm_is_missing(monkeypatch, caplog):
    def without_llvm(*args, backend=None, **kwargs):
        raise ValueError("llvm backend is chosen, but symengine is not compiled with llvm support.")

    available_backend.cache_clear()
    try:
        with monkeypatch.context() as patch, caplog.at_level(logging.WARNING):
            patch.setattr(se, "Lambdify", without_llvm)
            assert available_backend() == available_backend() == "lambda"
        assert len(caplog.records) == 1
        model = small(lambda m, s: m.x[s] ** 2 == m.y)
        assert CompiledNLP(model, free(model)).constraints(np.full(6, 0.5)).tolist() == [-0.25] * 4
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
        CompiledNLP(model, free(model))


def test_objectives_and_variables_are_checked():
    model = small()
    model.cost.sense = maximize
    with pytest.raises(TemplateError, match="minimise"):
        CompiledNLP(model, free(model))
    model = small(lambda m, s: m.x[s] == m.y)
    with pytest.raises(TemplateError, match="y is neither"):
        CompiledNLP(model, list(model.x.values()))
    with pytest.raises(TemplateError, match="x at index"):
        CompiledNLP(model, [model.y])


def test_seconds_and_calls():
    model = small(lambda m, s: m.x[s] ** 2 == m.y)
    nlp = CompiledNLP(model, free(model))
    nlp.constraints(np.ones(nlp.n))
    nlp.jacobian(np.ones(nlp.n))
    assert nlp.calls == {"objective": 0, "gradient": 0, "constraints": 1, "jacobian": 1, "hessian": 0}
    assert set(nlp.seconds) == {"differentiate", "compile", "evaluate"}
    assert nlp.seconds["evaluate"] > 0


def test_every_variable_of_the_model_is_read():
    model = ConcreteModel()
    trajectory(model, 3, "trapezoid")
    nlp = CompiledNLP(model, free(model))
    read = {id(v) for c in model.component_data_objects(Constraint) for v in identify_variables(c.expr) if not v.fixed}
    assert len(read) == nlp.n == len(set(nlp.jacobianstructure()[1]))


@pytest.mark.parametrize("scheme", ["trapezoid", "hermite-simpson"])
def test_terms_of_the_lagrangian_add_up_to_its_gradient(scheme):
    model = two_phases(scheme)
    nlp = CompiledNLP(model, free(model))
    z, y = random_point(nlp), np.random.default_rng(1).standard_normal(nlp.m)
    total, sets = np.zeros(nlp.n), set()
    for over, index, columns, terms in nlp.lagrangian_terms(z, y):
        assert columns.shape == terms.shape == (1 if index is None else len(index), columns.shape[1])
        sets.add(None if over is None else over.name)
        free_terms = columns < nlp.n
        np.add.at(total, columns[free_terms], terms[free_terms])
    jac, _ = dense(nlp, z, y, 1.0)
    np.testing.assert_allclose(total, nlp.gradient(z) + y @ jac, atol=1e-12)
    assert {None, "a.segment", "b.segment", "a.point", "b.point"} == sets


def test_unchecked_constraints_keep_nan():
    model = small(lambda m, s: pyo.log(m.x[s]) == 0)
    nlp = CompiledNLP(model, free(model))
    z = np.array([1.0, -1.0, 1.0, 1.0, 1.0, 1.0])  # y stands first
    assert np.isnan(nlp.constraints_unchecked(z)).tolist() == [True, False, False, False]
    with pytest.raises(NotFinite):
        nlp.constraints(z)


def test_times_of_the_points_are_data_only_where_a_function_asks_for_them():
    from exact import growth, integration

    from trajopt.transcription.mesh import Mesh
    from trajopt.transcription.schemes import HERMITE_SIMPSON
    from trajopt.transcription.transcribe import transcribe

    for problem, asked in ((growth(), False), (integration(), True)):
        block = transcribe(problem, [Mesh.of(HERMITE_SIMPSON, 3)]).model.phase["main"]
        assert (block.component("fraction") is not None) == asked
