"""The mathematics of the table of schemes: exactness, and agreement with the paper's formulas."""

import numpy as np
import pytest

from trajopt.problems.errors import SpecError
from trajopt.transcription.polynomials import integrated_basis, lagrange_basis
from trajopt.transcription.schemes import COLLOCATION, FINITE_DIFFERENCE, HERMITE_SIMPSON, TRAPEZOID, Scheme, find

SCHEMES = pytest.mark.parametrize("scheme", COLLOCATION.values(), ids=COLLOCATION)
TAU = np.linspace(0, 1, 11)


@SCHEMES
def test_quadrature_is_exact_to_its_degree(scheme):
    # Points symmetric about the middle integrate one degree more than they interpolate.
    n = len(scheme.c)
    degree = n if n % 2 else n - 1
    for k in range(degree + 1):
        assert scheme.b @ scheme.c**k == pytest.approx(1 / (k + 1), abs=1e-14)
    assert abs(scheme.b @ scheme.c ** (degree + 1) - 1 / (degree + 2)) > 1e-3


@SCHEMES
def test_defects_vanish_for_polynomials_and_only_for_them(scheme):
    n = len(scheme.c)
    for k in range(1, n + 1):
        assert scheme.L @ scheme.sigma**k == pytest.approx(scheme.R @ (k * scheme.c ** (k - 1)), abs=1e-14)
    k = n + 2
    assert np.abs(scheme.L @ scheme.sigma**k - scheme.R @ (k * scheme.c ** (k - 1))).max() > 1e-3


@SCHEMES
def test_state_interpolant_has_the_collocated_slopes(scheme):
    rng = np.random.default_rng(1)
    f = rng.normal(size=len(scheme.c))
    step = 1e-6
    slope = (scheme.interpolant(scheme.c + step).F - scheme.interpolant(scheme.c - step).F) @ f / (2 * step)
    assert slope == pytest.approx(f, abs=1e-8)
    assert scheme.interpolant(scheme.c).dF @ f == pytest.approx(f, abs=1e-14)


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
    with pytest.raises(SpecError, match="did you mean 'hermite-simpson'"):
        find("hermite-simson")
