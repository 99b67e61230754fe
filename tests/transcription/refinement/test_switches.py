"""Where controls switch: jumps and kinks are found on the segment that holds them, close to where they are."""

import numpy as np
import pytest
from exact import growth
from named import crossed, problem_named

from trajopt.problems.build import build_all
from trajopt.problems.load import load_text
from trajopt.transcription.refinement.refine import STANDS_OUT, refine
from trajopt.transcription.refinement.switches import Switches
from trajopt.transcription.settings import Step
from trajopt.transcription.solve import solve

CONSTANT = """
trajopt: 1
time: {initial: 0, final: 1}
states:
  x: {rate: "-x + u", initial: 0, final: 1}
  y: {rate: "-y + w + 0.1*x", initial: 0}
controls: {u: {}, w: {lower: -1, upper: 1}}
objective: {maximize: {terminal: "y[final]", integral: "-u**2"}}
"""  # w is 1 throughout


def solved(name: str, method: str, segments: int, *overrides: str):
    solution = solve(problem_named(name, *overrides), [Step(method, segments, 1e-8)])
    assert solution.solved
    return solution


def holding(trajectory, time: float) -> int:
    """The number of the segment that holds a time."""
    return int(np.searchsorted(trajectory.knots, time)) - 1


@pytest.mark.parametrize(("method", "segments"), [("hermite-simpson", 40), ("radau", 20), ("gauss", 20)])
def test_jumps_of_the_minimum_work_block(method, segments):
    """u_max = 20: from 20 to 0 at t* = (1 - sqrt(1 - 4/20))/2, from 0 to -20 at 1 - t*."""
    (trajectory,) = solved("block_move_min_work", method, segments).trajectories
    switches, exact = Switches(trajectory), (1 - np.sqrt(1 - 4 / 20)) / 2
    for time in (exact, 1 - exact):
        s = holding(trajectory, time)
        jump = switches.jump(s)
        assert jump and jump.name == "u"
        assert trajectory.knots[s] + jump.tau * trajectory.h[s] == pytest.approx(time, abs=0.1 * trajectory.h[s])
    assert not any(switches.jump(s) for s in range(segments // 4, 3 * segments // 4))


@pytest.mark.parametrize(("method", "segments"), crossed(["radau", "gauss", "lobatto"], [10, 20, 40]))
def test_kinks_where_a_path_constraint_becomes_active(method, segments):
    """l = 1/9: the displacement limit is reached at t = 3 l = 1/3 and left at 2/3."""
    (trajectory,) = solved("bryson_denham", method, segments).trajectories
    switches = Switches(trajectory)
    for time in (1 / 3, 2 / 3):
        s = holding(trajectory, time)
        kink = switches.kink(s)
        assert kink and kink.name == "u"
        assert trajectory.knots[s] + kink.tau * trajectory.h[s] == pytest.approx(time, abs=0.05 * trajectory.h[s])
    assert not any(switches.jump(s) for s in range(segments))


@pytest.mark.parametrize(
    ("method", "segments"), crossed(["trapezoid", "hermite-simpson", "radau", "gauss", "chebyshev"], [4, 10, 20])
)
def test_smooth_controls_have_none(method, segments):
    (trajectory,) = solve(growth(), [Step(method, segments, 1e-11)]).trajectories
    switches = Switches(trajectory)
    assert not any(switches.jump(s) or switches.kink(s) for s in range(segments))


@pytest.mark.parametrize("tolerance", [1e-5, 1e-6, 1e-8])
def test_what_the_barrier_leaves_of_a_constant_control_is_no_jump(tolerance):
    spec = load_text(CONSTANT, "constant.yaml")
    (trajectory,) = solve(build_all(spec), [Step("radau", 10, tolerance)]).trajectories
    w = trajectory.u[1, trajectory.mesh.collocated]
    assert 0 < np.ptp(w) < 0.02
    assert not Switches(trajectory).jumps


def test_a_kink_that_stands_out_becomes_a_knot():
    solution = solved("bryson_denham", "gauss", 10)
    (trajectory,), (error,) = solution.trajectories, solution.errors
    assert error.relative[3] > STANDS_OUT * max(error.relative[2], error.relative[4])
    knots = refine(trajectory, error, 1e-8).mesh.edges
    assert np.abs(knots - 1 / 3).min() < 1e-3
    assert np.abs(knots - 2 / 3).min() < 1e-3
    assert np.abs(trajectory.mesh.edges - 1 / 3).min() > 0.03


def test_a_force_that_reaches_its_bound_is_a_kink():
    """The swing-up with a weak motor: u leaves -12 N at about t = 0.92."""
    (trajectory,) = solved("cartpole", "gauss", 40, "parameters.u_max=12").trajectories
    s = holding(trajectory, 0.9215)
    kink = Switches(trajectory).kink(s)
    assert kink
    time = trajectory.knots[s] + kink.tau * trajectory.h[s]
    fine = solved("cartpole", "hermite-simpson", 800, "parameters.u_max=12").trajectories[0]
    free = fine.times[(fine.u[0] > -12 + 1e-3) & (fine.times > 0.85)][0]
    assert time == pytest.approx(free, abs=0.1 * trajectory.h[s])
