"""Derivatives of compiled programs against central differences, and their sparsity, on models made by hand."""

import numpy as np
import pytest
from derivatives import check_derivatives, dense
from named import share
from pyomo import core as pyo
from pyomo.core import ConcreteModel, Constraint, Param

from trajopt.transcription.program.compiler import compile_model
from trajopt.transcription.program.symbolic import SYMENGINE
from trajopt.transcription.program.templates import templated

from .pyomo_models import free, random_point, small, trajectory, two_phases

BACKENDS = ("llvm", "lambda")


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("scheme", ["trapezoid", "hermite-simpson"])
def test_derivatives_and_sparsity_of_a_transcription(scheme, backend):
    model = ConcreteModel()
    trajectory(model, 4, scheme)
    variables = free(model)
    nlp = compile_model(model, variables, backend=backend)
    jac, hess = check_derivatives(nlp, random_point(nlp))
    # Exactly the nonzeros: none that is zero at a random point.
    rows, cols = nlp.jacobianstructure()
    assert set(zip(rows, cols, strict=True)) == set(zip(*np.nonzero(jac), strict=True))
    rows, cols = nlp.hessianstructure()
    assert set(zip(rows, cols, strict=True)) == set(zip(*np.nonzero(np.tril(hess)), strict=True))


EACH = [*((name, "llvm") for name in SYMENGINE), *((name, "lambda") for name in share([*SYMENGINE], 3))]


@pytest.mark.parametrize(("name", "backend"), EACH)
def test_every_function(name, backend):
    function = getattr(pyo, name)
    model = small(
        lambda m, s: function(m.x[s] * m.y) * m.x[s + 1] == m.d[s],
        lambda m: sum(m.d[k] * function(m.x[k]) for k in m.point),
    )
    nlp = compile_model(model, free(model), backend=backend)
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
    nlp = compile_model(model := small(lambda m, s: body(m, s) <= 1), free(model), backend=backend)
    check_derivatives(nlp, random_point(nlp, low=0.3, high=0.8))


@pytest.mark.parametrize("backend", BACKENDS)
def test_arguments_that_are_one_variable_at_some_indices(backend):
    """x[s] * x[first[s]]: a square at s = 0 only, and the mirror image x[last[s]] * x[s] elsewhere."""
    model = small()
    model.near = Param(model.inner, initialize={0: 0, 1: 3, 2: 1, 3: 3})
    with templated():
        model.alias = Constraint(model.inner, rule=lambda m, s: m.x[s] * m.x[m.near[s]] ** 2 + m.x[s + 1] * m.x[s] == 0)
        model.whole = Constraint(rule=lambda m: sum(m.x[s] * m.x[m.near[s]] * m.y for s in m.inner) == 0)
    nlp = compile_model(model, free(model), backend=backend)
    jac, _ = check_derivatives(nlp, random_point(nlp))
    places = list(zip(*nlp.jacobianstructure(), strict=True))
    assert set(places) == set(zip(*np.nonzero(jac), strict=True))
    assert len([p for p in places if p[0] < 4]) == np.count_nonzero(jac[:4])  # each place once


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
    nlp = compile_model(model, free(model), backend=backend)
    check_derivatives(nlp, random_point(nlp))
    assert len(set(nlp.jacobianstructure()[1])) == nlp.n
    rows, cols = nlp.hessianstructure()
    assert len(set(zip(rows, cols, strict=True))) == 31 + 30 + 1  # diagonal, first subdiagonal, y


@pytest.mark.parametrize("scheme", ["trapezoid", "hermite-simpson"])
def test_terms_of_the_lagrangian_add_up_to_its_gradient(scheme):
    model = two_phases(scheme)
    nlp = compile_model(model, free(model))
    z, y = random_point(nlp), np.random.default_rng(1).standard_normal(nlp.m)
    total, sets = np.zeros(nlp.n), set()
    for over, index, columns, terms in nlp.lagrangian_terms(z, y):
        assert columns.shape == terms.shape == (1 if index is None else len(index), columns.shape[1])
        sets.add(over)
        free_terms = columns < nlp.n
        np.add.at(total, columns[free_terms], terms[free_terms])
    jac, _ = dense(nlp, z, y, 1.0)
    np.testing.assert_allclose(total, nlp.gradient(z) + y @ jac, atol=1e-12)
    assert {None, "a.segment", "b.segment", "a.point", "b.point"} == sets
