"""What comes out if all is right: numbers of the paper and of its supplement, exact ones, and independent computations.

A number that is given as printed must agree in all its digits. None of them was computed by trajopt.
"""

from __future__ import annotations

from decimal import Decimal
from math import inf, sqrt

from ...problems.lean.records import dataclass

PAPER = "Kelly 2017"
EXACT = "exact"
INDEPENDENT = "CasADi and IPOPT, tol 1e-8"
"""The same problem statement, transcribed by another program."""


@dataclass(frozen=True)
class Value:
    """A number by its name in an example's measurements, and the range [low, high] in which it is right."""

    name: str
    expected: str
    low: float
    high: float
    source: str

    def holds(self, number: float) -> bool:
        return bool(self.low <= number <= self.high)  # False for NaN


def printed(name: str, digits: str, source: str = INDEPENDENT) -> Value:
    """A number that agrees in every digit given: within half a unit of the last one.

    name: of the number in an example's measurements.
    digits: as printed, such as "12.568966".
    source: who computed it.
    """
    half = 0.5001 * 10.0 ** int(Decimal(digits).as_tuple().exponent)  # 0.0001 for the rounding of binary numbers
    return Value(name, digits, float(digits) - half, float(digits) + half, source)


def near_value(name: str, value: float, tolerance: float, source: str = EXACT) -> Value:
    """A number that is right within a tolerance.

    name: of the number in an example's measurements.
    value: what it should be.
    tolerance: the largest absolute difference.
    source: who says so.
    """
    expected = f"{value:.8g} ± {tolerance:.0e}" if tolerance else f"{value:.8g}"
    return Value(name, expected, value - tolerance, value + tolerance, source)


def at_most(name: str, limit: float, source: str = EXACT) -> Value:
    """A number that is right up to a limit.

    name: of the number in an example's measurements.
    limit: the largest value that is right.
    source: who says so.
    """
    return Value(name, f"at most {limit:.6g}", -inf, limit, source)


def at_least(name: str, limit: float, source: str = EXACT) -> Value:
    """A number that is right from a limit on.

    name: of the number in an example's measurements.
    limit: the smallest value that is right.
    source: who says so.
    """
    return Value(name, f"at least {limit:.6g}", limit, inf, source)


# -- block move, minimum force: section 2, appendix B ----------------------------------------------------------------

BLOCK = (
    printed("J, trapezoid, 9 segments", "12.568966"),
    printed("J, trapezoid, 29 segments", "12.055858"),
    printed("J, trapezoid, 59 segments", "12.013629"),
    printed("u(0), trapezoid, 9 segments", "5.58621"),
    printed("u(0), trapezoid, 29 segments", "5.82007"),
    near_value("J, Hermite-Simpson, 1 segment", 12, 1e-7),
    near_value("J, Hermite-Simpson, 10 segments", 12, 1e-7),
    near_value("J, Hermite-Simpson, 100 segments", 12, 1e-7),
    at_most("largest |x - (3 t^2 - 2 t^3)|", 1e-8, f"{PAPER}, (B.26)"),
    at_most("largest |v - (6 t - 6 t^2)|", 1e-8, f"{PAPER}, (B.27)"),
    at_most("largest |u - (6 - 12 t)|", 1e-7, f"{PAPER}, (B.28)"),
    at_most("largest |costate of x - c0|, c0 = -24", 1e-6, f"{PAPER}, (B.17)"),
    at_most("largest |costate of v - (c1 - c0 t)|, c1 = -12", 1e-6, f"{PAPER}, (B.18)"),
    at_most("feasible trajectories: largest eta", 1e-4, f"{PAPER}, (2.1)"),
    at_least("feasible trajectories: least J", 12, f"{PAPER}, section 1.3"),
)

# -- splines and refinement: sections 3 to 5 -------------------------------------------------------------------------

SPLINES = (
    at_most("linear control (3.7) against the scheme", 1e-14, PAPER),
    at_most("quadratic state (3.10) against the scheme", 1e-14, PAPER),
    at_most("quadratic control (4.10) against the scheme", 1e-14, PAPER),
    at_most("cubic state (4.13) against the scheme", 1e-14, f"{PAPER}, as corrected"),
    at_least("error of the linear spline / error of the quadratic one", 5, f"{PAPER}, Figure 5: far more accurate"),
)

REFINEMENT = (
    near_value("least number of subsegments", 1, 0, f"{PAPER}, Figure 7"),
    near_value("largest number of subsegments", 4, 0, f"{PAPER}, Figure 7"),
    at_least("largest error before / after", 4, f"{PAPER}, section 5.2"),
)

POINTS = (
    at_most("largest |P4| at the Gauss points", 1e-13, f"{PAPER}, appendix D.1"),
    at_most("largest |P4 + P3| at the Radau points", 1e-13, f"{PAPER}, appendix D.1"),
    at_most("largest |(1 - t^2) dP3/dt| at the Lobatto points", 1e-13, f"{PAPER}, appendix D.1"),
    at_most("Gauss weights by (D.9) against the scheme", 1e-13, f"{PAPER}, (D.9)"),
    at_most("Lobatto weights by (D.10) against the scheme", 1e-13, f"{PAPER}, (D.10)"),
)

# -- cart-pole: section 6 --------------------------------------------------------------------------------------------

CARTPOLE = (
    printed("J, Hermite-Simpson, 25 segments", "58.805425"),
    printed("J, Hermite-Simpson, 100 segments", "58.807666"),
    printed("J, trapezoid, 9 segments", "59.6379"),
    printed("J, trapezoid, 19 segments", "60.5969"),
    printed("J, trapezoid, 29 segments", "59.7442"),
    printed("J, trapezoid, 49 segments", "59.1611"),
    printed("J, trapezoid, 200 segments", "58.8304"),
    printed("J, converged: Hermite-Simpson, 2000 segments", "58.8076675"),
    printed("u(0)", "2.21157"),
    printed("u(T)", "-1.79084"),
    printed("largest |u|", "13.8034"),
    printed("largest q1", "1.1774"),
    printed("least q2", "-0.9209"),
    printed("largest |dq2/dt|", "8.085"),
    printed("largest |epsilon| of q1", "9.77e-3"),
    printed("largest |epsilon| of q2", "2.60e-2"),
    printed("largest eta of q1", "5.08e-4"),
    printed("largest eta of q2", "1.35e-3"),
    near_value("largest eta of dq1/dt", 3.96e-3, 2e-5, INDEPENDENT),
    near_value("largest eta of dq2/dt", 1.27e-2, 6e-5, INDEPENDENT),
    near_value("segment of the largest eta of q1", 11, 0, INDEPENDENT),
    near_value("segment of the largest eta of q2", 11, 0, INDEPENDENT),
)

# -- five-link biped: section 7 --------------------------------------------------------------------------------------

_EXPLICIT = f"{INDEPENDENT}; accelerations eliminated"

BIPED = (
    printed("J, Hermite-Simpson, 5 segments", "390.73094"),
    printed("J, Hermite-Simpson, 15 segments", "390.78984"),
    printed("J, Hermite-Simpson, 5 then 25 segments", "390.79044"),
    printed("J, Hermite-Simpson, 60 segments", "390.79053"),
    printed("J, trapezoid, 24 segments", "393.497"),
    printed("J, trapezoid, 100 segments", "390.96116"),
    near_value("J, directly on 25 segments - J on two meshes", 0, 1e-5, f"{PAPER}, section 7.6: similar results"),
    *(printed(f"largest eta of q{i}", digits, _EXPLICIT) for i, digits in enumerate(
        ("3.8e-6", "3.9e-6", "1.2e-6", "1.7e-6", "1.8e-6"), start=1)),
    *(printed(f"q{i}(0)", digits) for i, digits in enumerate(
        ("0.07129", "0.50165", "-0.22793", "-0.35099", "-0.36192"), start=1)),
    *(printed(f"u{i}(0)", digits) for i, digits in enumerate(("-22.955", "41.965", "8.670", "12.613"), start=2)),
    *(printed(f"u{i}(T)", digits) for i, digits in enumerate(("13.452", "8.722", "-22.109", "9.460"), start=2)),
    printed("largest height of the swing foot", "0.0704"),
    at_least("least height of the swing foot between the ends", 0, f"{PAPER}, section 7.4: (7.5) is unnecessary"),
)  # fmt: skip

BIPED_SUPPLEMENT = (
    printed("supplement: J, Hermite-Simpson, 5 segments", "469.46885"),
    printed("supplement: J, Hermite-Simpson, 15 segments", "469.64333"),
    printed("supplement: J, Hermite-Simpson, 5 then 25 segments", "469.64678"),
    printed("supplement: J, Hermite-Simpson, 60 segments", "469.6500"),
    printed("supplement: J, trapezoid, 24 segments", "473.86487"),
    printed("supplement: J, trapezoid, 100 segments", "469.91994"),
    printed("supplement: J, without the knee constraint, 25 segments", "469.50107"),
    *(printed(f"supplement: q{i}(0)", digits) for i, digits in enumerate(
        ("0.08645", "0.49319", "-0.12735", "-0.34672", "-0.35800"), start=1)),
    *(printed(f"supplement: u{i}(0)", digits) for i, digits in enumerate(
        ("-25.118", "53.669", "1.696", "16.103"), start=2)),
    *(printed(f"supplement: largest eta of q{i}", digits, _EXPLICIT) for i, digits in enumerate(
        ("9.4e-6", "1.02e-5", "1.8e-6", "2.3e-6", "1.7e-6"), start=1)),
    # The source sampled epsilon 200 times a segment, which misses 0.02 % of its peak: the last digit of q2 is at stake.
    *(near_value(f"supplement: largest |epsilon| of q{i}", value, 1e-6, _EXPLICIT) for i, value in enumerate(
        (5.18e-4, 5.59e-4, 1.01e-4, 1.27e-4, 9.4e-5), start=1)),
    printed("supplement: largest height of the swing foot", "0.0712"),
)  # fmt: skip

# -- block move, minimum work: section 8 -----------------------------------------------------------------------------

U_MAX = 20.0
"""The bound of the force; the paper does not give its own."""
SWITCH = (1 - sqrt(1 - 4 / U_MAX)) / 2
"""t* of (8.5), s."""
WORK = (U_MAX * SWITCH) ** 2
"""The least work, J: the block is pushed to the speed u_max t* and braked again."""

_MESHES = {  # method -> objective by number of segments
    "slack": {9: "0.03553", 19: "0.90388", 29: "1.01202", 39: "1.06423", 49: "1.07952", 99: "1.10651", 199: "1.11234"},
    "tanh 0.01": {9: "0.03511", 19: "0.90323", 39: "1.06351", 99: "1.10574"},
    "tanh 1": {9: "0.00331", 19: "0.83982", 39: "0.99300", 99: "1.03092"},
    "tanh 5": {9: "0.00066", 19: "0.45957", 39: "0.62239", 99: "0.64588"},
}

_LOSS = 0.27846
"""The largest value of y - y tanh(y) over y > 0."""

MIN_WORK = (
    *(printed(f"J, {method}, {n} segments", digits) for method, row in _MESHES.items() for n, digits in row.items()),
    printed("J, schedule tanh 5, 1, 0.01, 99 segments", "1.10574"),
    near_value("J, slack, 399 segments", WORK, 6e-4, "(u_max t*)^2, (8.5)"),
    near_value("J, slack, 799 segments", WORK, 1.5e-4, "(u_max t*)^2, (8.5)"),
    at_least("order of convergence of J to the exact value", 1.5, f"{PAPER}, section 8.7: converges"),
    *(at_most(f"J, slack - J, tanh {alpha:g}, largest over meshes", _LOSS * alpha, "max of |y| - y tanh(y/alpha)")
      for alpha in (0.01, 1.0, 5.0)),
    *(at_least(f"J, slack - J, tanh {alpha:g}, least over meshes", 0, f"{PAPER}, section 8.6: always less than |x|")
      for alpha in (0.01, 1.0, 5.0)),
    printed("work done, slack", "1.1065"),
    printed("work done, tanh 0.01", "1.1073"),
    near_value("work done, tanh 1", 1.1851, 1e-4, INDEPENDENT),  # J is flat there, so tol settles no more digits of it
    printed("work done, tanh 5", "1.5154"),
    at_most("largest of x tanh(x) - |x|", 0, f"{PAPER}, section 8.6"),
    at_least("least of sqrt(x^2 + 1) - |x|", 0, f"{PAPER}, section 8.6"),
    printed("largest error of tanh smoothing / alpha", "0.27846", "max of y - y tanh(y)"),
    near_value("largest error of square-root smoothing / beta", 1, 1e-12),
)  # fmt: skip

# -- pendulum: the introduction, section 6 ---------------------------------------------------------------------------

PENDULUM = (
    printed("J, finite differences, 1001 points", "37.598137"),
    printed("J, finite differences, 101 points", "37.647360"),
    printed("J, converged: Hermite-Simpson, 400 segments", "37.5926865"),
    at_most("|J of IPOPT - J of Newton|", 1e-8, "one problem, two solvers"),
    at_most("largest |q of IPOPT - q of Newton|", 1e-8, "one problem, two solvers"),
    at_most("largest |u of IPOPT - u of Newton|", 1e-8, "one problem, two solvers"),
)

VALUES = {
    "block": BLOCK,
    "splines": SPLINES,
    "refinement": REFINEMENT,
    "cartpole": CARTPOLE,
    "biped": (*BIPED, *BIPED_SUPPLEMENT),
    "min_work": MIN_WORK,
    "points": POINTS,
    "pendulum": PENDULUM,
}


@dataclass(frozen=True)
class Effort:
    """What a solve took in the paper: FMINCON on a 3.4 GHz Intel i5-3570K. mesh: its number in our run's schedule."""

    what: str
    example: str
    run: str
    mesh: int
    iterations: int
    seconds: float


EFFORTS = (
    Effort("cart-pole, Hermite-Simpson, 25 segments", "cartpole", "cartpole", 0, 71, 5.91),
    Effort("biped, first mesh, 5 segments", "biped", "biped", 0, 29, 0.96),
    Effort("biped, second mesh, 25 segments", "biped", "biped", 1, 56, 21.3),
    Effort("biped of the supplement, first mesh", "biped", "biped_supplement", 0, 29, 0.96),
    Effort("biped of the supplement, second mesh", "biped", "biped_supplement", 1, 56, 21.3),
)
