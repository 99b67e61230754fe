"""The mathematics of the table of schemes: exactness, and agreement with the paper's formulas."""

import numpy as np
import pytest
from named import COLLOCATION, FAMILIES

from trajopt.problems.errors import SpecError
from trajopt.transcription.schemes.polynomials import LARGEST, integrated_basis, lagrange_basis
from trajopt.transcription.schemes.scheme import Scheme
from trajopt.transcription.schemes.table import FINITE_DIFFERENCE, HERMITE_SIMPSON, TRAPEZOID, find

ALL = {name: find(name) for name in COLLOCATION}
ALL |= {
    f"{name} {n} {form}": find(name, n, form)
    for name in FAMILIES
    for n in (1, 2, 3, 7, 20, 60)
    for form in ("integral", "differential")
}
SCHEMES = pytest.mark.parametrize("scheme", ALL.values(), ids=ALL)
TAU = np.linspace(0, 1, 11)


def chebyshev(k):
    """The Chebyshev polynomial of degree k on [0, 1]: of size 1 everywhere, unlike a monomial."""
    return np.polynomial.Chebyshev.basis(k, domain=[0, 1])


@SCHEMES
def test_quadrature_is_exact_to_its_order_and_no_further(scheme):
    for k in range(scheme.order):
        polynomial = np.polynomial.Legendre.basis(k, domain=[0, 1])
        assert scheme.b @ polynomial(scheme.c) == pytest.approx(float(k == 0), abs=2e-14)
    beyond = np.polynomial.Legendre.basis(scheme.order, domain=[0, 1])
    assert abs(scheme.b @ beyond(scheme.c)) > 1e-7
    assert (scheme.b > 0).all()


@SCHEMES
def test_defects_vanish_for_polynomials_and_only_for_them(scheme):
    n = len(scheme.c)
    size = np.abs(scheme.L).max()
    for k in range(n + 1):
        defect = scheme.L @ chebyshev(k)(scheme.sigma) - scheme.R @ chebyshev(k).deriv()(scheme.c)
        assert defect == pytest.approx(0, abs=2e-14 * size * (1 + k**2))
    k = n + 1 + (n % 2)  # the next degree vanishes too where the points are symmetric
    defect = scheme.L @ chebyshev(k)(scheme.sigma) - scheme.R @ chebyshev(k).deriv()(scheme.c)
    assert np.abs(defect).max() > 1e-3


@SCHEMES
def test_state_interpolant_has_the_collocated_slopes(scheme):
    n = len(scheme.c)
    f = np.cos(3 * scheme.c)
    at_nodes = scheme.interpolant(scheme.c)
    assert at_nodes.dF @ f == pytest.approx(f, abs=1e-13)
    assert pytest.approx(0, abs=1e-15) == scheme.interpolant(np.zeros(1)).F
    # The integral of a polynomial that f carries exactly.
    polynomial = chebyshev(n - 1)
    integral = polynomial.integ(lbnd=0)
    assert scheme.interpolant(TAU).F @ polynomial(scheme.c) == pytest.approx(integral(TAU), abs=1e-13)


@pytest.mark.parametrize("name", FAMILIES)
@pytest.mark.parametrize("n", [1, 2, 3, 7, 20, 60])
def test_integral_and_differential_form_have_the_same_solutions(name, n):
    """The state nodes that either form gives for arbitrary dynamics."""
    f = np.cos(3 * find(name, n).c)
    states = []
    for form in ("integral", "differential"):
        scheme = find(name, n, form)
        states.append(np.linalg.solve(scheme.L[:, 1:], scheme.R @ f - scheme.L[:, 0]))  # x_0 = 1, h = 1
        assert form == "integral" or np.count_nonzero(scheme.R, axis=1).max() <= 2
    assert states[1] == pytest.approx(states[0], abs=1e-12)


@pytest.mark.parametrize("n", [1, 2, 5, 20, 60])
def test_nodes_are_the_roots_that_define_their_family(n):
    """To 1e-14: one Newton step from a node, with the polynomials evaluated by mpmath, moves it by less."""
    mpmath = pytest.importorskip("mpmath")
    mpmath.mp.dps = 40

    def newton(function, tau):
        x = 2 * mpmath.mpf(float(tau)) - 1
        return float(function(x) / mpmath.diff(function, x) / 2)

    P = mpmath.legendre
    families = {
        "gauss": (find("gauss", n).c, lambda x: P(n, x)),
        "radau": (find("radau", n).c[:-1], lambda x: (P(n, x) - P(n - 1, x)) / (x - 1)),
        "radau-left": (find("radau-left", n).c[1:], lambda x: (P(n, x) + P(n - 1, x)) / (x + 1)),
        "lobatto": (find("lobatto", n).c[1:-1], lambda x: n * (P(n - 1, x) - x * P(n, x)) / (1 - x**2)),
        "chebyshev": (find("chebyshev", n).c[1:-1], lambda x: mpmath.chebyu(n - 1, x)),
    }
    assert families.keys() == set(FAMILIES)
    for name, (nodes, polynomial) in families.items():
        assert [newton(polynomial, tau) for tau in nodes] == pytest.approx([0] * len(nodes), abs=1e-14), name


def test_clenshaw_curtis_weights():
    """Paper, D.4: the quadrature of Chebyshev points, against the classic formula for even n."""
    n = 8
    theta = np.pi * np.arange(n + 1) / n
    w = np.ones(n + 1)
    for k in range(1, n // 2):
        w -= 2 * np.cos(2 * k * theta) / (4 * k**2 - 1)
    w -= np.cos(n * theta) / (n**2 - 1)
    w *= 1 / n  # 2/n on [-1, 1]
    w[[0, -1]] /= 2
    assert find("chebyshev", n).b == pytest.approx(w, abs=1e-15)


@pytest.mark.parametrize(("name", "degree", "same"), [("lobatto", 1, "trapezoid"), ("lobatto", 2, "hermite-simpson")])
def test_the_papers_methods_are_the_lowest_lobatto_schemes(name, degree, same):
    a, b = find(name, degree, "integral"), find(same)
    assert a.c == pytest.approx(b.c)
    assert np.linalg.solve(a.L[:, 1:], a.R) == pytest.approx(np.linalg.solve(b.L[:, 1:], b.R), abs=1e-15)


@pytest.mark.parametrize(("name", "degree"), [("gauss", 61), ("radau", 0)])
def test_degrees_out_of_range_are_refused(name, degree):
    with pytest.raises(SpecError, match="1 to 60"):
        find(name, degree)


def test_a_method_of_one_degree_takes_no_degree():
    with pytest.raises(SpecError, match="has one degree"):
        find("trapezoid", 3)


def test_the_interpolant_of_differences_has_the_values_and_slopes_of_both_ends():
    x, f = np.array([0.3, -1.2]), np.array([2.0, 0.7])
    at_ends = FINITE_DIFFERENCE.interpolant(np.array([0.0, 1.0]))
    assert at_ends.X @ x + at_ends.F @ f == pytest.approx(x, abs=1e-15)
    assert at_ends.dX @ x + at_ends.dF @ f == pytest.approx(f, abs=1e-15)
    cubic = np.polynomial.Polynomial([1.0, -2.0, 0.5, 3.0])
    slope, inside = cubic.deriv(), FINITE_DIFFERENCE.interpolant(TAU)
    ends = np.array([0.0, 1.0])
    assert inside.X @ cubic(ends) + inside.F @ slope(ends) == pytest.approx(cubic(TAU), abs=1e-14)
    assert inside.dX @ cubic(ends) + inside.dF @ slope(ends) == pytest.approx(slope(TAU), abs=1e-14)


def test_trapezoid_interpolants_are_those_of_the_paper():
    h, f0, f1, x0 = 0.3, 1.7, -0.4, 0.2
    tau = TAU * h
    expected = x0 + f0 * tau + tau**2 / (2 * h) * (f1 - f0)  # (3.10)
    assert x0 + h * TRAPEZOID.interpolant(TAU).F @ [f0, f1] == pytest.approx(expected, abs=1e-15)
    assert TRAPEZOID.interpolant(TAU).U @ [f0, f1] == pytest.approx(f0 + tau / h * (f1 - f0), abs=1e-15)  # (3.6)


def test_hermite_simpson_interpolants_are_those_of_the_paper_with_its_correction():
    h, x0, (f0, fm, f1) = 0.3, 0.2, (1.7, 0.6, -0.4)
    tau = TAU * h
    # (4.13), corrected: h is constant and leaves the integral.
    state = x0 + f0 * tau + (-3 * f0 + 4 * fm - f1) * tau**2 / (2 * h)
    state += (2 * f0 - 4 * fm + 2 * f1) * tau**3 / (3 * h**2)
    assert x0 + h * HERMITE_SIMPSON.interpolant(TAU).F @ [f0, fm, f1] == pytest.approx(state, abs=1e-15)
    control = 2 / h**2 * (tau - h / 2) * (tau - h) * f0 - 4 / h**2 * tau * (tau - h) * fm
    control += 2 / h**2 * tau * (tau - h / 2) * f1  # (4.10)
    assert HERMITE_SIMPSON.interpolant(TAU).U @ [f0, fm, f1] == pytest.approx(control, abs=1e-14)


def test_hermite_simpson_defects_are_those_of_the_paper():
    h, x, f = 0.3, np.array([0.2, 0.9, -0.5]), np.array([1.7, 0.6, -0.4])
    simpson = x[2] - x[0] - h / 6 * (f[0] + 4 * f[1] + f[2])  # (4.3)
    hermite = x[1] - (x[0] + x[2]) / 2 - h / 8 * (f[0] - f[2])  # (4.4)
    defects = HERMITE_SIMPSON.L @ x - h * HERMITE_SIMPSON.R @ f
    assert defects == pytest.approx([simpson, hermite], abs=1e-15)


@pytest.mark.parametrize("degree", [2, 5, 20, 60])
def test_lagrange_basis_reproduces_and_integrates_polynomials(degree):
    c = (1 - np.cos(np.pi * np.arange(degree + 1) / degree)) / 2
    values = np.polynomial.Chebyshev.basis(degree, domain=[0, 1])
    assert lagrange_basis(c, TAU) @ values(c) == pytest.approx(values(TAU), abs=1e-13)
    integral = values.integ(lbnd=0)
    assert integrated_basis(c, TAU) @ values(c) == pytest.approx(integral(TAU), abs=1e-13)


@pytest.mark.parametrize(
    "change",
    [
        {"R": np.array([[1.0, 2.0]]) / 2},
        {"L": np.array([[-1.0, 2.0]])},
        {"sigma": np.array([0.0, 0.9])},
        {"L": np.eye(2)},
        {"eliminated": ((1, 0),)},
    ],
)
def test_a_scheme_that_contradicts_itself_is_refused(change):
    data = {name: getattr(TRAPEZOID, name) for name in ("name", "family", "order", "sigma", "c", "L", "R", "source")}
    with pytest.raises(ValueError, match="trapezoid"):
        Scheme(**{**data, **change})


def test_an_unknown_method_gets_the_nearest_name():
    with pytest.raises(SpecError, match="did you mean hermite-simpson"):
        find("hermite-simson")


@pytest.mark.parametrize("basis", [lagrange_basis, integrated_basis])
def test_values_of_a_basis_that_are_kept_are_those_of_their_nodes_and_places(basis):
    """Those of many places are not kept, and so are computed each time: part by part they are the same."""
    places = np.linspace(0, 1, LARGEST + 3)
    for nodes in ([0.0, 0.5, 1.0], [0.0, 0.25, 1.0], [0.0, 1.0]):
        c = np.array(nodes)
        kept = np.vstack([basis(c, part) for part in np.array_split(places, 7)])
        np.testing.assert_array_equal(kept, basis(c, places))
        assert basis(c, places[:5]) is basis(c, places[:5].copy())
        with pytest.raises(ValueError, match="read-only"):
            basis(c, places[:5])[0] = 0.0
