"""More digits than the default has: bounds that are hardly relaxed, and an end where the barrier is all."""

import pytest

from trajopt.problems.build import build_all
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load
from trajopt.transcription.continuation import solve_spec

EXACT = {"bryson_denham": 4.0, "clamped_beam": 80 / 9, "speed_limit": 125 / 9}
"""Bounds on states whose multipliers are 36, 89 and more: what relaxes them by 1e-10 moves the objective by 4e-9."""


def solved(name: str, accuracy: float):
    spec = load(shipped()[name], [f"refine.objective={accuracy}"])
    return solve_spec(spec, build_all(spec))


@pytest.mark.parametrize("name", EXACT)
def test_relaxed_bounds_are_below_the_accuracy_that_is_asked_for(name):
    solution = solved(name, 2e-10)
    error = abs(solution.objective - EXACT[name])
    assert error <= 2e-10 * (1 + EXACT[name])
    assert error <= solution.objective_error.bar


ARCS = {"clark_fishery": 0.9674006706, "jackson": 0.1918143563, "catalyst_mixing": -0.0480556859}
"""Bang, singular, bang: every further segment has bounds, whose multipliers the engine leaves above zero."""


@pytest.mark.parametrize("name", ARCS)
def test_refinement_ends_where_the_barrier_is_the_error(name):
    solution = solved(name, 1e-10)
    assert "the engine's barrier leaves at the bounds" in solution.stopped or "is kept, not that of" in solution.stopped
    assert abs(solution.objective - ARCS[name]) <= solution.objective_error.bar + 1e-10
    assert solution.objective_error.bar < 1e-8 and solution.meshes[-1].segments < 250
