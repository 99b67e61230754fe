"""Estimates and their standard errors, against regressions of formulas and certified values."""

import numpy as np
import pytest
import stored
from scipy.optimize import least_squares
from scipy.special import lambertw

import trajopt
from trajopt.problems.build import build
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load_text
from trajopt.transcription.settings import schedule_of, settings_of
from trajopt.transcription.solve import solve


def estimates_of(text, *overrides):
    spec = load_text(text, "estimates.yaml", overrides)
    solution = solve(build(spec), schedule_of(spec), settings_of(spec))
    assert solution.solved
    return solution.estimates


def covariance(cost, p):
    """2 (d2J/dp2)^-1 by central differences of a closed form, which is what the reduced Hessian has to give."""
    n, h = len(p), 1e-4 * np.abs(p)
    H = np.empty((n, n))
    for i in range(n):
        for j in range(n):
            a, b = np.eye(n)[i] * h[i], np.eye(n)[j] * h[j]
            H[i, j] = (cost(p + a + b) - cost(p + a - b) - cost(p - a + b) + cost(p - a - b)) / (4 * h[i] * h[j])
    return 2 * np.linalg.inv(H)


MISRA = np.array(
    [
        [10.07, 77.6],
        [14.73, 114.9],
        [17.94, 141.1],
        [23.93, 190.8],
        [29.61, 239.9],
        [35.18, 289.0],
        [40.02, 332.8],
        [44.82, 378.4],
        [50.76, 434.8],
        [55.05, 477.3],
        [61.01, 536.8],
        [66.40, 593.1],
        [75.47, 689.1],
        [81.78, 760.0],
    ]
)


def test_certified_values():
    """Misra1a of NIST's Statistical Reference Datasets, y = b1 (1 - exp(-b2 x)), as dy/dx = b2 (b1 - y).

    Certified are the estimates, the sum of squares and standard errors; these are of Gauss and Newton's Hessian, which
    has no second derivatives of the model: it differs from the reduced Hessian by as little as the residuals are.
    """
    found = estimates_of(
        f"""
trajopt: 1
time: {{initial: 0, final: 760}}
states: {{y: {{rate: b2*(b1 - y), initial: 0}}}}
optimize: {{b1: {{lower: 1, upper: 1000, guess: 250}}, b2: {{lower: 1e-5, upper: 0.01, guess: 5e-4}}}}
measurements: {{misra1a: {{data: {{time: {MISRA[:, 1].tolist()}, y: {MISRA[:, 0].tolist()}}}}}}}
guess: simulate
scaling: {{b1: 200, b2: 5e-4}}
mesh: [{{method: radau, segments: 10, tolerance: 1e-10}}]
"""
    )
    assert found.values == pytest.approx([2.3894212918e2, 5.5015643181e-4], rel=1e-7)
    assert found.residuals == pytest.approx(1.2455138894e-1, rel=1e-8)
    assert found.scale == pytest.approx(1.0187876330e-1, rel=1e-8)
    assert found.deviations == pytest.approx([2.7070075241, 7.2668688436e-6], rel=5e-3)
    exact = covariance(lambda p: ((p[0] * (1 - np.exp(-p[1] * MISRA[:, 1])) - MISRA[:, 0]) ** 2).sum(), found.values)
    assert found.deviations == pytest.approx(found.scale * np.sqrt(np.diag(exact)), rel=1e-4)
    assert (found.measurements, found.free) == (14, 2)


def substrate(t, s0, vmax, km):
    return km * lambertw(s0 / km * np.exp((s0 - vmax * t) / km)).real


def test_experiments_with_shared_parameters():
    """Michaelis and Menten's kinetics has a closed form: a regression by SciPy knows no differential equation."""
    spec, solution = stored.solved("enzyme_progress_curves")
    found = estimates_of(spec.text)
    sets = [
        (phase.states[0].initial.lower, own.times, own.values)
        for phase in solution.problem.phases
        for own in phase.measured
    ]

    def residuals(p):
        return np.concatenate([(substrate(t, s0, *p) - y) / 0.02 for s0, t, y in sets])

    known = least_squares(residuals, [1, 1], xtol=1e-15, ftol=1e-15, gtol=1e-15)
    assert found.values == pytest.approx(known.x, rel=1e-6) and found.residuals == pytest.approx(
        2 * known.cost, rel=1e-8
    )
    exact = covariance(lambda p: (residuals(p) ** 2).sum(), known.x)
    assert found.deviations == pytest.approx(np.sqrt(np.diag(exact)), rel=1e-4)
    assert found.correlation[0, 1] == pytest.approx(exact[0, 1] / np.sqrt(exact[0, 0] * exact[1, 1]), rel=1e-4)
    assert found.given and found.scale == 1


def test_gas_oil_cracking():
    """COPS 3.0: theta = (11.847, 8.344, 1.001)."""
    _, solution = stored.solved("gas_oil_cracking")
    assert solution.objective == pytest.approx(5.236595834e-3, abs=1e-10)
    assert solution.estimates.values == pytest.approx([11.8467, 8.3445, 1.00144], rel=1e-5)
    assert not solution.estimates.given and solution.estimates.scale == pytest.approx(
        np.sqrt(5.236596e-3 / 39), rel=1e-6
    )


LINE = """
trajopt: 1
time: {initial: 0, final: 2}
states: {x: {rate: a}}
optimize: {a: {lower: -5, upper: 5}}
measurements: {m: {data: {time: [0, 0.5, 1, 2], x: [0.1, 0.9, 2.2, 3.9], s: [0.1, 0.2, 0.1, 0.3]}, weights: {x: s}}}
"""
T, X, S = np.array([0, 0.5, 1, 2]), np.array([0.1, 0.9, 2.2, 3.9]), np.array([0.1, 0.2, 0.1, 0.3])


@pytest.mark.parametrize(("weights", "w", "given"), [
    ("weights: {x: s}", S, False), ("deviations: s", 1 / S**2, True), ("weights: 4", np.full(4, 4.0), False),
    ("deviations: {x: 0.5}", np.full(4, 4.0), True), ("note: none", np.ones(4), False),
])  # fmt: skip
def test_a_straight_line_with_a_free_start(weights, w, given):
    """Linear regression: the free initial state is an unknown as the slope is."""
    found = estimates_of(LINE.replace("weights: {x: s}", weights))
    A = np.stack([np.ones(4), T], axis=1)
    normal = np.linalg.inv(A.T @ (w[:, None] * A))
    b = normal @ A.T @ (w * X)
    squares = (w * (A @ b - X) ** 2).sum()
    assert found.values == pytest.approx([b[1]], rel=1e-8) and found.residuals == pytest.approx(squares, rel=1e-8)
    scale = 1 if given else squares / 2
    assert found.deviations == pytest.approx([np.sqrt(scale * normal[1, 1])], rel=1e-6) and found.free == 2


def test_a_parameter_on_its_bound_has_no_standard_error():
    found = estimates_of(
        LINE.replace("upper: 5}", "upper: 1}")
        .replace("rate: a}", "rate: a + b}")
        .replace("a: {lower", "b: {lower: 0, upper: 0.5}, a: {lower")
    )
    assert np.isnan(found.deviations).all() and found.free == 1 and np.isnan(found.correlation).all()
    one = estimates_of(
        LINE.replace("rate: a}", "rate: a + b*t}").replace("a: {lower", "b: {lower: 0.1, upper: 0.5}, a: {lower")
    )
    assert np.isnan(one.deviations[0]) and one.deviations[1] > 0 and one.correlation[1, 1] == 1


def test_why_there_are_no_standard_errors():
    two = estimates_of(
        LINE.replace("rate: a}", "rate: a + b}").replace("a: {lower", "b: {lower: -5, upper: 5}, a: {lower")
    )
    assert two.why_not.startswith("the measurements do not determine b, a: ") and np.isnan(two.deviations).all()
    few = estimates_of(
        LINE.replace("[0, 0.5, 1, 2], x: [0.1, 0.9, 2.2, 3.9], s: [0.1, 0.2, 0.1, 0.3]", "[0, 1], x: [0, 1], s: [1, 1]")
    )
    assert few.why_not.startswith("2 measurements leave nothing over for 2 unknowns")
    steered = LINE.replace("rate: a}", "rate: a*x + u}").replace(
        "optimize", "controls: {u: {}}\nobjective: {minimize: {integral: u**2}}\noptimize"
    )
    assert estimates_of(steered).why_not.startswith("with controls, nothing tells how exact the measurements are")
    assert estimates_of(steered.replace("weights: {x: s}", "deviations: s")).deviations[0] > 0


STARTED = """
trajopt: 1
parameters: {c: 2.0, x0: 1.0}
expressions: {signal: c*x}
time: {initial: 0, final: 2}
states: {x: {rate: -k*x, initial: x0}}
optimize: {k: {lower: 0, upper: 5, guess: 1}}
measurements: {d: {data: {time: [0.5, 1, 2], signal: [1.2, 0.7, 0.3]}, deviations: 0.05}}
mesh: [{method: radau, segments: 6}]
"""


def test_sensitivities_to_numbers_in_what_is_measured(tmp_path):
    """The signal is c x0 exp(-k t): the objective changes alike with c/2 and with x0."""
    solution = trajopt.solve(trajopt.load(STARTED))
    assert not load_text(STARTED, "x.yaml").warnings
    up, down = (trajopt.solve(trajopt.load(STARTED, {"parameters.c": 2 + h})).objective for h in (1e-4, -1e-4))
    of_c, of_x0 = (solution.sensitivities[f"parameters.{name}"] for name in ("c", "x0"))
    assert of_c == pytest.approx((up - down) / 2e-4, rel=1e-5) and of_x0 == pytest.approx(2 * of_c, rel=1e-6)
    again = trajopt.read(solution.save(tmp_path / "a.h5"))
    assert again.estimates == solution.estimates and again.estimates["k"].standard_error > 0


def test_a_mistaken_expression_that_is_measured_is_told_once():
    with pytest.raises(SpecError) as error:
        load_text(STARTED.replace("signal: c*x", "signal: c*y"), "x.yaml")
    assert [mistake.what for mistake in error.value.mistakes] == ['unknown name "y"']


DECAY = """
trajopt: 1
time: {initial: 0, final: FINAL}
states: {x: {rate: -k*x, initial: 1}}
optimize: {k: {lower: 0}}
measurements: {m: {data: {time: [0, T1, T2, FINAL], x: [1.02, 0.66, 0.45, 0.27]}}}
"""


@pytest.mark.parametrize("unit", [60.0, 3.6e3, 1e6])
def test_standard_errors_do_not_depend_on_the_unit_of_time(unit):
    """A rate constant of 4e-7 is not on its bound of 0 because it is small."""
    found = {}
    for factor in (1.0, unit):
        text = DECAY.replace("FINAL", repr(3 * factor)).replace("T1", repr(factor)).replace("T2", repr(2 * factor))
        found[factor] = estimates_of(text)
    one, other = found.values()
    assert other.values[0] * unit == pytest.approx(one.values[0], rel=1e-6)
    assert other.deviations[0] * unit == pytest.approx(one.deviations[0], rel=1e-3)
    assert one.free == other.free == 1


def test_a_rate_constant_that_is_on_its_bound_is_so_in_every_unit():
    grows = DECAY.replace("0.66, 0.45, 0.27", "1.1, 1.2, 1.3")
    for factor in (1.0, 1e6):
        text = grows.replace("FINAL", repr(3 * factor)).replace("T1", repr(factor)).replace("T2", repr(2 * factor))
        found = estimates_of(text)
        assert np.isnan(found.deviations).all() and found.free == 0


USED_UP = """
trajopt: 1
time: {initial: 0, final: 8}
states: {S: {rate: -k*S/(K + S), initial: 2}}
optimize: {k: {lower: 0.1, upper: 5, guess: 0.7}, K: {lower: 0.01, upper: 5, guess: 0.3}}
measurements:
  run: {data: {time: [0.4, 0.8, 1.2, 1.6, 2, 2.4], S: [1.62, 1.31, 0.93, 0.61, 0.41, 0.15]}, deviations: 0.02}
mesh: [{method: radau, segments: 20}]
"""


@pytest.mark.parametrize(
    "held", ["states.S.lower=0", "constraints={path: [{expression: S, lower: 0}]}", "states.S.lower=1e-12"]
)
def test_what_the_dynamics_take_to_its_bound_is_not_held_by_it(held):
    """S is 1e-9 and less at the end: as near to zero as the barrier is, but where it is follows from k and K."""
    free, bounded = estimates_of(USED_UP), estimates_of(USED_UP, held)
    assert not bounded.why_not and bounded.free == free.free == 2
    assert bounded.deviations == pytest.approx(free.deviations, rel=1e-4)
    assert bounded.correlation == pytest.approx(free.correlation, rel=1e-4)


def test_a_state_that_its_bound_holds_says_nothing():
    """x(0) is free, but not below the value that the measurements ask for: k alone is estimated."""
    text = """
trajopt: 1
time: {initial: 0, final: 1}
states: {x: {rate: -k*x, lower: 0.9, upper: 9}}
optimize: {k: {lower: -1, upper: 1}}
measurements: {run: {data: {time: [0, 0.5, 1], x: [0.5, 1.2, 1.5]}, deviations: 0.1}}
mesh: [{method: radau, segments: 4}]
"""
    held, known = estimates_of(text), estimates_of(text.replace("lower: 0.9", "initial: 0.9"))
    assert held.free == 1 and known.free == 1
    assert held.deviations == pytest.approx(known.deviations, rel=1e-4)
