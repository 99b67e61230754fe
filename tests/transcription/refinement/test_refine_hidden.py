"""What the error of the states does not show, refinement sees all the same."""

import pytest

from trajopt.problems.build import build_all
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load, load_text
from trajopt.transcription.settings import settings_of, steps
from trajopt.transcription.solve import solve

MINIMUM_TIME = """
trajopt: 1
time: {initial: 0, final: {lower: 0.1, upper: 10, guess: 3}}
states:
  x: {rate: v, initial: 0, final: 1}
  v: {rate: u, initial: 0, final: 0}
controls: {u: {lower: -1, upper: 1}}
objective: {minimize: {terminal: "t[final]"}}
mesh: [{method: hermite-simpson, segments: 7}]
refine: {tolerance: 1e-7}
"""
COSTLY_END = """
trajopt: 1
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: 0, final: 1}}
controls: {u: {lower: 0.999999, upper: 1.000001}}
objective: {minimize: {integral: exp(8*t)*u**2}}
mesh: [{method: runge-kutta-4, segments: 2}]
"""
COST = 372.494748  # (e^8 - 1) / 8


def run(spec):
    return solve(build_all(spec), steps(spec.mesh), settings_of(spec))


@pytest.mark.parametrize("method", ["hermite-simpson", "runge-kutta-4", "dormand-prince"])
def test_a_jump_inside_a_segment_that_is_integrated_exactly(method):
    """Any control of an integrator is: on 7 segments T = 2.0068 with no error at all; the optimum is 2."""
    spec = load_text(MINIMUM_TIME, "time.yaml", [f"mesh.0.method={method}"])
    first = solve(build_all(spec), steps(spec.mesh))
    assert first.meshes[-1].relative_error < 1e-8
    solution = run(spec)
    assert not solution.unmet
    assert solution.objective == pytest.approx(2, abs=1e-6)


@pytest.mark.parametrize("method", ["hermite-simpson", "runge-kutta-4", "radau"])
@pytest.mark.parametrize("ends", [((-0.6, 1), (0, 0)), ((0, 0), (0.6, 1))])
def test_a_jump_on_the_first_or_the_last_segment(method, ends):
    """To rest at x = 0.6 from v = 1: faster for t = sqrt(1.1) - 1, then brake, T = 1 + 2 t; or the same backwards."""
    mesh = f"mesh=[{{method: {method}, segments: 6}}]"
    both = [
        f"states.{name}.{end}={value}"
        for end, values in zip(("initial", "final"), ends, strict=True)
        for name, value in zip("xv", values, strict=True)
    ]
    solution = run(load_text(MINIMUM_TIME, "time.yaml", [mesh, *both]))
    assert not solution.unmet
    assert solution.objective == pytest.approx(2 * 1.1**0.5 - 1, abs=1e-6)


@pytest.mark.parametrize("method", ["runge-kutta-2", "runge-kutta-4", "dormand-prince", "trapezoid"])
def test_the_integral_of_a_cost_that_no_state_feels(method):
    spec = load_text(COSTLY_END, "cost.yaml", [f"mesh.0.method={method}"])
    solution = run(spec)
    true = abs(solution.objective / COST - 1)
    assert true > 1e-4
    assert 2 * solution.meshes[-1].relative_error > true / 2  # of the larger of two segments
    assert run(load_text(COSTLY_END, "cost.yaml", [f"mesh.0.method={method}", "refine.tolerance=1e-5"])).objective == (
        pytest.approx(COST, rel=1e-3)
    )


@pytest.mark.parametrize(
    ("method", "segments", "substeps", "tolerance"),
    [("runge-kutta-2", 5, 20, 1e-6), ("runge-kutta-4", 5, 20, 1e-8), ("runge-kutta-4", 1, 40, 1e-8)],
)
def test_segments_of_many_substeps_are_split_as_their_method_needs(method, segments, substeps, tolerance):
    mesh = f"mesh=[{{method: {method}, segments: {segments}, substeps: {substeps}}}]"
    solution = run(load(shipped()["van_der_pol"], [mesh, f"refine={{tolerance: {tolerance}}}"]))
    assert not solution.unmet
    assert len(solution.meshes) <= 4
    assert solution.objective == pytest.approx(2.867261, abs=1e-5)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6])
def test_a_loose_tolerance_of_the_engine_is_not_taken_for_error_of_the_mesh(tolerance):
    """IPOPT stops at the barrier parameter that it starts from; refinement would chase the kinks that this leaves."""
    mesh = f"mesh=[{{method: radau, segments: 20, tolerance: {tolerance}}}]"
    solution = run(load(shipped()["brachistochrone"], [mesh, "refine={tolerance: 1e-8}"]))
    assert not solution.unmet
    assert solution.objective == pytest.approx(1.801603122, rel=1e-8)
    assert solution.meshes[-1].tolerance == 1e-8
    assert len(solution.meshes) <= 3


def test_bounds_are_not_relaxed_for_the_solver():
    """Bryson and Denham's J = 4 / (9 l) rises by 36 for each unit by which the bound l = 1/9 on x falls."""
    solution = run(load(shipped()["bryson_denham"], ["mesh.*.tolerance=1e-10"]))
    assert solution.objective == pytest.approx(4, abs=2e-8)
