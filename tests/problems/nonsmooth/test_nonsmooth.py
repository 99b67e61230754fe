"""abs, min and max made consistent: stand-ins against the exact functions, the analysis of signs."""

import random
from math import inf, tanh

import numpy as np
import pytest

from trajopt.problems.build import build, build_all
from trajopt.problems.expressions.expression import parse
from trajopt.problems.quantities import Range

from .nonsmooth_files import loaded


def told(spec) -> list:
    """The warnings that slack variables need more than (8.9)-(8.11)."""
    return [warning for warning in spec.warnings if "slack variables are exact only with" in warning.what]


# -- smoothing -----------------------------------------------------------------------------------------------------

POINT = {"u": -0.7, "v": 0.4, "x": 0.2, "w": 0.6, "p": 0.1, "t": 0.5}


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("abs(u)", lambda a: a(-0.7)),
        ("3*abs(u*v) + x", lambda a: 3 * a(-0.28) + 0.2),
        ("min(u, v)", lambda a: (-0.7 + 0.4 - a(-1.1)) / 2),
        ("max(u, v)", lambda a: (-0.7 + 0.4 + a(-1.1)) / 2),
        ("abs(abs(u) - v)", lambda a: a(a(-0.7) - 0.4)),
        ("max(u, v, x)", lambda a: ((-0.3 + a(-1.1)) / 2 + 0.2 + a((-0.3 + a(-1.1)) / 2 - 0.2)) / 2),
        ("abs(n)*max(k, n, 1)*u", lambda a: 2 * -0.7),  # constants stay exact
    ],
)
@pytest.mark.parametrize(
    ("nonsmooth", "absolute"),
    [
        ("{tanh: 0.5}", lambda y: y * tanh(y / 0.5)),  # (8.12)
        ("{sqrt: 0.5}", lambda y: (y**2 + 0.25) ** 0.5),  # (8.13)
        ("{tanh: k/4}", lambda y: y * tanh(y / 0.5)),
    ],
)
def test_smoothing_follows_the_paper(expression, expected, nonsmooth, absolute):
    problem = build(loaded(nonsmooth=nonsmooth, rate=f"u + ({expression})"))
    found = problem.phases[0].states[1].rate(POINT, np) - POINT["u"]
    assert found == pytest.approx(expected(absolute), rel=1e-14)
    assert [c.name for c in problem.phases[0].controls] == ["u", "w"]


@pytest.mark.parametrize("kind", ["tanh", "sqrt"])
def test_smoothing_tends_to_the_exact_function(kind):
    exact = min(abs(-0.7), 0.4, max(0.2, -0.7))
    errors = []
    for width in (1e-1, 1e-2, 1e-3):
        rate = (
            build(loaded(nonsmooth=f"{{{kind}: {width}}}", rate="min(abs(u), v, max(x, u))")).phases[0].states[1].rate
        )
        errors.append(abs(rate(POINT, np) - exact))
    assert errors[0] > errors[1] > errors[2] or errors[2] < 1e-9
    assert errors[2] < 1e-5


def test_smoothing_reaches_into_definitions_and_both_ends():
    spec = loaded(
        nonsmooth="{sqrt: 0.1}",
        expressions="power: abs(u*v)",
        objective="minimize: {integral: power, terminal: 'power[final] + abs(x[final])'}",
    )
    (phase,) = build(spec).phases
    ends = {"u[final]": 2.0, "v[final]": -3.0, "x[final]": 0.0}
    assert phase.lagrange({"u": 2.0, "v": -3.0}, np) == pytest.approx((36 + 0.01) ** 0.5)
    assert phase.mayer(ends, np) == pytest.approx((36 + 0.01) ** 0.5 + 0.1)
    assert not phase.path and not phase.boundary and not told(spec)


def test_a_schedule_gives_each_mesh_its_width():
    two = "segments: 20}, {method: any, segments: 9}"
    spec = loaded(nonsmooth="{tanh: [5, 1]}", objective="minimize: {integral: abs(u)}", mesh=two)
    values = [problem.phases[0].lagrange({"u": 2.0}, np) for problem in build_all(spec)]
    assert values == pytest.approx([2 * tanh(2 / 5), 2 * tanh(2)])
    assert build(spec, 0).phases[0].lagrange({"u": 2.0}, np) == values[0]
    first, second = build_all(loaded(mesh=two))
    assert first is second


# -- slack variables -----------------------------------------------------------------------------------------------


def names_of(constraints) -> list[str]:
    return [constraint.name for constraint in constraints]


def test_slack_variables_of_the_paper():
    """(8.9)-(8.11)."""
    (phase,) = build(
        loaded(objective="minimize: {integral: abs(u*v)}", constraints="path: [{expression: w, upper: 1}]")
    ).phases
    plus, minus = phase.controls[2:]
    assert (plus.name, minus.name) == ("abs1_plus", "abs1_minus")
    assert plus.bounds == minus.bounds == Range(0, inf)
    assert phase.lagrange({"abs1_plus": 3.0, "abs1_minus": 4.0}, np) == 7
    assert names_of(phase.path) == ["w", "abs1"] and phase.path[1].bounds == Range(0, 0)
    assert phase.path[1].function({"abs1_plus": 3.0, "abs1_minus": 4.0, "u": 5.0, "v": 2.0}, np) == 11
    assert phase.guess.values["abs1_plus"].tolist() == [0, 0]


def test_slack_at_the_ends_and_of_constants_to_be_found_is_static():
    spec = loaded(objective="minimize: {terminal: 'abs(v[final]) + abs(p)', integral: abs(p - 1)*w}")
    problem = build(spec)
    (phase,) = problem.phases
    names = [parameter.name for parameter in problem.parameters]
    assert names == ["p", *(f"abs{i}_{side}" for i in (1, 2, 3) for side in ("plus", "minus"))]
    assert names_of(phase.boundary) == ["abs1", "abs2", "abs3"] and not phase.path
    assert [variable.name for variable in phase.controls] == ["u", "w"]
    assert phase.guess.parameters["abs1_plus"] == 0


def test_a_definition_is_written_out_at_the_ends():
    spec = loaded(
        expressions="speed: abs(v)*k, cost: speed + w",
        objective="minimize: {integral: cost, terminal: 'cost[final]'}",
    )
    problem = build(spec)
    (phase,) = problem.phases
    assert [v.name for v in problem.parameters] == ["p", "abs2_plus", "abs2_minus"]
    assert phase.mayer.names == {"abs2_plus", "abs2_minus", "w[final]"}
    assert phase.mayer({"abs2_plus": 1.0, "abs2_minus": 0.5, "w[final]": 0.25}, np) == 3.25
    (relation,) = phase.boundary
    assert relation.function({"abs2_plus": 1.0, "abs2_minus": 0.5, "v[final]": 0.5}, np) == 0
    assert not told(spec)


def test_names_of_slack_variables_leave_those_of_the_file_alone():
    spec = loaded(expressions="abs1: u", objective="minimize: {integral: 'abs(abs1) + min(u, v)**2'}")
    assert [v.name for v in build(spec).phases[0].controls] == [
        "u", "w", "abs2_plus", "abs2_minus", "min1_plus", "min1_minus",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("parts", "hard"),
    [
        ({"objective": "minimize: {integral: abs(u)}"}, 0),
        ({"objective": "maximize: {integral: abs(u)}"}, 1),
        ({"objective": "maximize: {integral: -abs(u)}"}, 0),
        ({"objective": "minimize: {integral: 'max(u, v, x)'}"}, 0),
        ({"objective": "minimize: {integral: 'min(u, v, x)'}"}, 2),
        ({"objective": "maximize: {integral: 'min(u, v, x)'}"}, 0),
        ({"objective": "minimize: {integral: k*abs(u)/3}"}, 0),
        ({"objective": "minimize: {integral: n*abs(u)}"}, 1),
        ({"objective": "minimize: {integral: abs(u)/n}"}, 1),
        ({"objective": "minimize: {integral: w*abs(u)}"}, 0),  # w >= 0 by its bounds
        ({"objective": "minimize: {integral: v*abs(u)}"}, 1),
        ({"objective": "minimize: {integral: t*abs(u)}"}, 0),
        ({"objective": "minimize: {integral: abs(u)**2 + exp(abs(v)) + sqrt(1 + abs(x))}"}, 0),
        ({"objective": "minimize: {integral: abs(u)**-2}"}, 1),
        ({"objective": "minimize: {integral: 1/(1 + abs(u))}"}, 1),
        ({"objective": "minimize: {integral: sin(abs(u))}"}, 1),
        ({"objective": "minimize: {integral: abs(abs(u) + w)}"}, 0),
        ({"objective": "minimize: {integral: abs(abs(u) - 1)}"}, 1),
        ({"objective": "minimize: {integral: 'max(abs(u) - 1, v)**2'}"}, 2),
        ({"objective": "minimize: {integral: 'max(abs(u), v)**2'}"}, 0),
        ({"objective": "minimize: {terminal: 'abs(v[final])'}"}, 0),
        ({"objective": "minimize: {terminal: '-abs(v[final])'}"}, 1),
        ({"constraints": "path: [{expression: abs(v), upper: 2}]"}, 0),
        ({"constraints": "path: [{expression: abs(v), lower: 2}]"}, 1),
        ({"constraints": "path: [{expression: abs(v), lower: 0, upper: 2}]"}, 0),
        ({"constraints": "path: [{expression: abs(v), equals: 2}]"}, 1),
        ({"constraints": "path: [{expression: 'min(v, u)', lower: -2}]"}, 0),
        ({"constraints": "integral: [{expression: abs(u), upper: 2}]"}, 0),
        ({"constraints": "boundary: [{expression: 'abs(v[final])', upper: 2}]"}, 0),
        ({"rate": "u - abs(v)*v"}, 1),
        ({"expressions": "a: abs(u)", "objective": "minimize: {integral: a}"}, 0),
        ({"expressions": "a: abs(u)", "rate": "u - a", "objective": "minimize: {integral: a}"}, 1),
        ({"expressions": "a: abs(u), b: '1 - a'", "objective": "maximize: {integral: b}"}, 0),
        ({"expressions": "a: abs(u), b: '1 - a'", "objective": "minimize: {integral: b}"}, 1),
    ],
    ids=str,
)
def test_where_slack_alone_is_exact(parts, hard):
    spec = loaded(**parts)
    problem = build(spec)
    relations = names_of((*problem.phases[0].path, *problem.phases[0].boundary))
    assert sum(name.endswith("_complementary") for name in relations) == hard
    assert len(told(spec)) == hard and all("tanh" in warning.remedy for warning in told(spec))


def random_text(rng: random.Random, depth: int) -> str:
    if depth == 0:
        return rng.choice(["u", "v", "x", "w", "k", "n", "0.5", "(-0.3)"])
    a, b = (random_text(rng, depth - 1) for _ in range(2))
    return rng.choice(
        [f"({a} + {b})", f"({a} - {b})", f"({a})*({b})", f"({a})/(3 + w)", f"abs({a})", f"min({a}, {b})",
         f"max({a}, {b}, x)", f"-({a})", f"tanh({a})", f"exp(tanh({a}))", f"abs({a})**2", f"({a})**2", f"atan({a})**3"]
    )  # fmt: skip


def with_slack(phase, values: dict[str, float], extra) -> dict[str, float]:
    """The values with slack variables that keep their equations; extra: what is added to both of each pair."""
    values = dict(values)
    for relation in phase.path:
        if not relation.name.endswith("_complementary"):
            pair = [f"{relation.name}_plus", f"{relation.name}_minus"]
            y = relation.function({**values, **dict.fromkeys(pair, 0.0)}, np)
            more = extra(relation.name)
            values |= {pair[0]: max(y, 0.0) + more, pair[1]: max(-y, 0.0) + more}
            assert relation.function(values, np) == pytest.approx(0, abs=1e-12)
    return values


@pytest.mark.parametrize("seed", range(60))
def test_slack_is_exact_and_never_gains(seed):
    """With tight slack variables the value is the exact one; with loose ones, where nothing forbids it, it is worse."""
    rng = random.Random(seed)
    expression = f"abs(u) + {random_text(rng, 4)}"
    sense = rng.choice(["minimize", "maximize"])
    (phase,) = build(loaded(objective=f"{sense}: {{integral: '{expression}'}}")).phases
    forbidden = {
        name.removesuffix("_complementary") for name in names_of(phase.path) if name.endswith("_complementary")
    }
    for _ in range(20):
        point = {n: rng.uniform(-2, 2) for n in ("u", "v", "x")} | {"w": rng.uniform(0, 1), "p": 0.0, "t": 0.5}
        exact = parse(expression).bind({"k": 2.0, "n": -1.0}, {})(point, np)
        tight = phase.lagrange(with_slack(phase, point, lambda name: 0.0), np)
        assert tight == pytest.approx(exact, rel=1e-12, abs=1e-12)
        loose = with_slack(phase, point, lambda name: 0.0 if name in forbidden else rng.choice([0, rng.uniform(0, 3)]))
        value = phase.lagrange(loose, np)
        assert (value - exact) * (1 if sense == "minimize" else -1) >= -1e-9 * (1 + abs(exact))
