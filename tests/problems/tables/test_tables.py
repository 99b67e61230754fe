"""Tables of data as functions: against SciPy and mpmath, how smooth they are, and what they are outside."""

import pickle
from itertools import pairwise, product

import mpmath
import numpy as np
import pytest
from derivatives import differences
from scipy.interpolate import CubicSpline, PchipInterpolator, RectBivariateSpline

from trajopt.problems.tables.table import fitted

X = np.array([-1.0, 0.0, 0.4, 1.5, 2.0, 3.5])
Y = np.array([0.0, 10.0, 15.0, 40.0, 70.0])
F = np.array([0.3, 1.0, 0.2, 0.9, 2.0, -1.0])
KINDS = ("cubic", "monotone", "linear")
WAYS = ("error", "hold", "extrapolate")


def curve(kind="cubic", outside="error", points=X, values=F, smooth=0.1):
    return fitted("f", {"x": points}, values, kind, {"x": outside}, {"x": smooth})


def surface(values, points, outside="error"):
    names = "xyz"[: np.ndim(values)]
    given = dict(zip(names, points, strict=True))
    return fitted("f", given, values, "cubic", dict.fromkeys(names, outside), {})


def test_a_cubic_of_one_argument_is_that_of_scipy():
    table, spline, x = curve(), CubicSpline(X, F), np.linspace(-2, 4, 101)
    for order in range(4):
        np.testing.assert_allclose(table.derivative([x], [order]), spline(x, order), rtol=1e-12, atol=1e-12)


def test_a_monotone_curve_is_that_of_scipy_and_rises_where_its_points_do():
    steps = np.array([0.0, 0.0, 1.0, 1.0, 5.0, 5.1])
    table, x = curve("monotone", values=steps), np.linspace(-1, 3.5, 201)
    for order in range(2):
        expected = PchipInterpolator(X, steps).derivative(order)(x) if order else PchipInterpolator(X, steps)(x)
        np.testing.assert_allclose(table.derivative([x], [order]), expected, atol=1e-12)
    assert (np.diff(table(x)) >= -1e-15).all() and (np.diff(curve(values=steps)(x)) < -1e-3).any()


@pytest.mark.parametrize("orders", [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)])
def test_a_cubic_of_two_arguments_is_that_of_scipy(orders):
    values = np.cos(X)[:, None] * np.exp(-Y / 30) + 0.01 * np.add.outer(X**2, Y)
    table, spline = surface(values, (X, Y)), RectBivariateSpline(X, Y, values, s=0)
    x, y = np.random.default_rng(1).uniform((-1, 0), (3.5, 70), (200, 2)).T
    expected = spline.ev(x, y, dx=orders[0], dy=orders[1])
    np.testing.assert_allclose(table.derivative([x, y], orders), expected, rtol=1e-10, atol=1e-11)


def test_a_cubic_of_three_arguments_is_exact_for_cubics():
    """Values and derivatives of a polynomial, by mpmath with 40 digits."""

    def polynomial(x, y, z):
        return (x**3 - 2 * x) * (y**2 / 100 + 1) * (z - z**3 / 3) + x * y

    z = np.array([-2.0, -1.0, 0.5, 1.0])
    table = surface(polynomial(X[:, None, None], Y[:, None], z), (X, Y, z))
    with mpmath.workdps(40):
        for point in ((0.1, 12.0, 0.3), (3.0, 60.0, -1.7), (-0.9, 1.0, 0.9)):
            for orders in (o for o in product(range(3), repeat=3) if sum(o) <= 2):
                exact = float(mpmath.diff(polynomial, point, orders)) if sum(orders) else polynomial(*point)
                assert float(table.derivative(point, orders)) == pytest.approx(exact, rel=1e-10, abs=1e-8)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("outside", WAYS)
def test_how_many_derivatives_are_continuous(kind, outside):
    table, continuous = curve(kind, outside), 1 if kind == "monotone" else 2
    sizes = [np.abs(table.derivative([np.linspace(-2, 5, 400)], [k])).max() for k in range(4)]
    jumps = []
    for at in table.axes[0].inner:
        left, right = (np.array([table.derivative([at + d], [k]) for k in range(3)]) for d in (-1e-9, 1e-9))
        jumps.append(np.abs(left - right))
    allowed = [1e-8 * (1 + size) for size in sizes[1:]]
    assert (np.array(jumps)[:, : continuous + 1] < allowed[: continuous + 1]).all()
    assert kind != "monotone" or (np.array(jumps)[:, 2] > 0.1).any()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("outside", WAYS)
def test_derivatives_are_those_of_the_values(kind, outside):
    table = curve(kind, outside)
    x = np.random.default_rng(4).uniform(-2, 5, 40)
    x = x[np.abs(x[:, None] - np.append(table.axes[0].inner, X)).min(axis=1) > 1e-3]
    for order in range(2):
        numeric = [differences(lambda z, k=order: table.derivative([z[0]], [k]), np.array([own])) for own in x]
        exact = table.derivative([x], [order + 1])
        np.testing.assert_allclose(exact, np.array(numeric)[:, 0], rtol=1e-7, atol=1e-7)
    stepped = table(x + 1e-30j).imag / 1e-30
    np.testing.assert_allclose(stepped, table.derivative([x], [1]), rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("kind", ["cubic", "monotone"])
@pytest.mark.parametrize("outside", WAYS)
@pytest.mark.parametrize("points", [2, 3, 4, 6])
def test_curves_go_through_their_points(kind, outside, points):
    table = curve(kind, outside, X[:points], F[:points])
    np.testing.assert_allclose(table(X[:points]), F[:points], rtol=0, atol=1e-13)


def test_what_is_held_is_the_value_at_the_end():
    for kind in ("cubic", "monotone"):
        table = curve(kind, "hold")
        assert table(np.array([-50.0, -1.0, 3.5, 1e6])) == pytest.approx([F[0], F[0], F[-1], F[-1]], abs=1e-13)
        assert table.derivative([np.array([-1.0, 3.5, 9.0])], [1]) == pytest.approx(0, abs=1e-12)
    held = fitted("f", {"x": X, "y": Y}, np.add.outer(F, Y), "cubic", {"x": "hold", "y": "extrapolate"}, {})
    assert held(99.0, 20.0) == pytest.approx(F[-1] + 20) and held(0.0, 100.0) == pytest.approx(1.0 + 100)


@pytest.mark.parametrize("outside", WAYS)
def test_rounded_lines_are_straight_away_from_their_kinks(outside):
    table, x = curve("linear", outside, smooth=0.1), np.linspace(-0.89, 3.39, 500)
    straight = np.abs(x[:, None] - X).min(axis=1) > 0.1
    np.testing.assert_allclose(table(x[straight]), np.interp(x[straight], X, F), atol=1e-13)
    between = np.abs(table(x) - np.interp(x, X, F)).max()
    slopes = np.diff(F) / np.diff(X)
    assert between <= np.abs(np.diff(slopes)).max() * 0.1 / 6 + 1e-13  # as docs say
    ends = table(np.array([-2.0, 5.0]))
    if outside == "hold":
        assert ends == pytest.approx([F[0], F[-1]])
    else:
        assert ends == pytest.approx([F[0] - slopes[0], F[-1] + 1.5 * slopes[-1]])


def test_lines_between_two_points_have_no_kink_or_two():
    line, held = (curve("linear", way, X[:2], F[:2]) for way in ("extrapolate", "hold"))
    assert line(np.array([-2.0, -0.5, 1.0])) == pytest.approx([-0.4, 0.65, 1.7])
    assert held(np.array([-2.0, -0.5, 1.0])) == pytest.approx([0.3, 0.65, 1.0])


def test_a_surface_of_lines_is_that_of_its_sections():
    values = np.multiply.outer(F, Y)
    given = {"x": X, "y": Y}, values, "linear", {"x": "error", "y": "hold"}, {"x": 0.1, "y": 1.0}
    table = fitted("f", *given)
    for (a, b), (c, d) in product(pairwise(X), pairwise(Y)):
        x, y = (a + b) / 2, (c + d) / 2
        assert table(x, y) == pytest.approx(np.interp(x, X, F) * y)


def test_only_an_argument_that_may_not_leave_the_points_is_outside():
    table = fitted("f", {"x": X, "y": Y}, np.add.outer(F, Y), "cubic", {"x": "error", "y": "hold"}, {})
    assert table.outside([np.array([-1.0, 4.0, 0.0]), np.array([0.0, 5.0, 99.0])]).tolist() == [False, True, False]


def test_a_table_can_be_sent_to_another_process():
    table = surface(np.add.outer(F, Y), (X, Y))
    again = pickle.loads(pickle.dumps(table))
    assert again(0.3, 20.0) == table(0.3, 20.0) and again.called == "f(x, y)"
    assert np.isnan(table(np.nan, 1.0)) and len(repr(table)) < 300
