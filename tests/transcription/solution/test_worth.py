"""What a segment adds to the error bar counts, even where it meets the dynamics exactly."""

import numpy as np
import pytest
from scipy.optimize import minimize

from trajopt.problems.build import build_all
from trajopt.transcription.loading import load_yaml
from trajopt.transcription.settings import schedule_of, settings_of
from trajopt.transcription.solve import solve

CEILING = """\
trajopt: 1
name: a state under a ceiling
time: {initial: 0, final: 1}
states: STATES
controls: {u: {}}
objective: {minimize: {integral: u**2/2}}
"""
SECOND = "{x: {rate: v, initial: 0, final: 0, upper: LIMIT}, v: {rate: u, initial: 1, final: -1}}"
THIRD = (
    "{x: {rate: v, initial: 0, final: 0, upper: LIMIT}, v: {rate: a, initial: 1, final: -1}, "
    "a: {rate: u, initial: 0, final: 0}}"
)


def solved(states, limit):
    spec = load_yaml(CEILING.replace("STATES", states.replace("LIMIT", str(limit))))
    return solve(build_all(spec), schedule_of(spec), settings_of(spec))


def least(T, before, after):
    """The least integral of u^2/2 from one full state to another of x''' = u, a quadratic u, in time T."""
    x, v, a = before
    A = np.array([[T**3 / 6, T**4 / 24, T**5 / 60], [T**2 / 2, T**3 / 6, T**4 / 12], [T, T**2 / 2, T**3 / 3]])
    c = np.linalg.solve(A, np.array(after) - [x + v * T + a * T**2 / 2, v + a * T, a])
    powers = T ** np.arange(1, 6) / np.arange(1, 6)
    return c @ powers[np.add.outer(np.arange(3), np.arange(3))] @ c / 2


def touching_twice(limit):
    """The optimum of THIRD where it touches the ceiling at two instants, symmetric in time."""

    def cost(where):
        t, a = where
        return 2 * least(t, (0, 1, 0), (limit, 0, a)) + least(1 - 2 * t, (limit, 0, a), (limit, 0, a))

    start = min(((t, a) for t in (0.2, 0.25, 0.3) for a in (-0.5, -2.0)), key=cost)
    return minimize(cost, start, method="Nelder-Mead", options={"xatol": 1e-10, "fatol": 1e-10, "maxiter": 4000}).fun


@pytest.mark.parametrize(
    ("states", "limit", "optimum"),
    [
        (THIRD, 0.15, touching_twice(0.15)),
        (SECOND, 0.1, 4 / (9 * 0.1)),  # an arc on the ceiling
        (SECOND, 0.2, 2 + 6 * (1 - 4 * 0.2) ** 2),  # an instant
    ],
)
def test_a_state_constraint_between_the_points_is_worth_no_more_than_the_tolerance(states, limit, optimum):
    solution = solved(states, limit)
    assert solution.solved and not solution.inaccurate
    (error,) = solution.errors
    assert error.worth.max() <= 1e-6
    assert solution.objective_error.bar <= 5e-6 * (1 + optimum)
    assert abs(solution.objective - optimum) <= solution.objective_error.bar


def test_what_misses_the_tolerance_by_its_worth_says_so():
    spec = load_yaml(CEILING.replace("STATES", THIRD.replace("LIMIT", "0.15")), ["refine.max_meshes=2"])
    solution = solve(build_all(spec), schedule_of(spec), settings_of(spec))
    assert solution.inaccurate
    assert any("of 1 + |J| to the error bar" in told for told in solution.unmet)
