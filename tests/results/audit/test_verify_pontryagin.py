"""`verify` sees extremals that are no optima, and lets pass what only looks like a mistake: jumps, zero multipliers."""

import h5py
import numpy as np
import pytest
from exact import RIVER

from trajopt.problems.build import build_all
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load, load_text
from trajopt.results.audit.pontryagin import NAME as PONTRYAGIN
from trajopt.results.audit.starts import NAME as STARTS
from trajopt.results.file.write import write
from trajopt.results.verify import verify
from trajopt.transcription.pontryagin.candidates import box, candidates, feasible
from trajopt.transcription.settings import settings_of, steps
from trajopt.transcription.solution.hamiltonian import Constrained
from trajopt.transcription.solve import solve

HEAD = "trajopt: 1\nname: case\n"


def stored(path, spec):
    """Solved from the problem's own guess, which is not replaced by a better one."""
    problems = build_all(spec)
    solution = solve(problems, steps(spec.mesh), settings_of(spec), guess=[p.guess for p in problems[0].phases])
    assert solution.solved
    write(path, solution, spec.text, spec.model_dump_json(), "test", spec.overrides)
    return solution


def checked(path, anew: bool = True):
    """anew: whether other starts are looked at, too."""
    return {check.name: check for check in verify(path, anew=anew)}


def failed(checks) -> set[str]:
    return {name for name, check in checks.items() if not check.passed}


def test_the_lesser_of_two_optima_fails_by_a_better_one(tmp_path):
    """With v < 0 at the end it has the least H over all controls at every time: only another solve can tell."""
    solution = stored(tmp_path / "a.h5", load_text(RIVER, "a.yaml"))
    assert solution.objective == pytest.approx(0.2523054, abs=1e-6)
    checks = checked(tmp_path / "a.h5")
    assert failed(checks) == {STARTS}
    assert checks[STARTS].where.startswith("1.712315 from controls")
    assert checks[STARTS].value == pytest.approx((1.712315 - 0.252305) / 1.252305, rel=1e-5)
    u, x, p = _points(solution)
    angles = np.linspace(0, 2 * np.pi, 2001)
    around = [_hamiltonian(np.cos(a), np.sin(a), x, p) for a in angles]
    assert _hamiltonian(*u, x, p) == pytest.approx(np.min(around, axis=0), abs=1e-5)


def _points(solution):
    """Controls, states and costates of the minimised objective at the collocation points."""
    (own,) = solution.trajectories
    k = own.mesh.collocated
    return own.u[:, k], own.x[:, k], -own.point_costate[:, k]


def _hamiltonian(a, b, x, p):
    return p[0] * x[2] * a + p[1] * x[2] * b + p[2] * (0.5 - b)


def test_the_better_optimum_passes(tmp_path):
    spec = load_text(RIVER + "guess: {constants: {u1: 1, u2: 0.3}}\n", "a.yaml")
    assert stored(tmp_path / "a.h5", spec).objective == pytest.approx(1.712315, abs=1e-6)
    checks = checked(tmp_path / "a.h5")
    assert not failed(checks) and {PONTRYAGIN, STARTS} <= set(checks)


WELLS = """
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: 0}}
controls: {u: {BOUNDS}}
objective: {minimize: {integral: "(u**2 - 1)**2 + 0.2*u"}}
guess: {constants: {u: START}}
mesh: [{method: radau, segments: 5}]
"""
ON_A_CIRCLE = """
time: {initial: 0, final: 1}
states: {x: {rate: b, initial: 0}}
controls: {a: {}, b: {}}
objective: {minimize: {integral: "-a**2 + 0.2*a"}}
constraints: {path: [{name: circle, expression: a**2 + b**2, equals: 1}]}
guess: {constants: {a: START, b: 0.01}}
mesh: [{method: hermite-simpson, segments: 5}]
"""
ALGEBRAIC = """
time: {initial: 0, final: 1}
states: {x: {rate: z, initial: 0}}
controls: {u: {lower: -3, upper: 3}}
algebraic: {z: {}}
residuals: [z + z**3 - 2*u]
objective: {minimize: {integral: "(u**2 - 1)**2 + 0.2*z"}}
guess: {constants: {u: START, z: START}}
mesh: [{method: gauss, segments: 5}]
"""
HIGHER = {
    "between bounds": WELLS.replace("BOUNDS", "lower: -2, upper: 2"),
    "without bounds": WELLS.replace("BOUNDS", ""),
    "on the manifold of a path constraint": ON_A_CIRCLE,
    "through an algebraic variable": ALGEBRAIC,
}


@pytest.mark.parametrize("name", HIGHER)
def test_a_local_minimum_of_the_hamiltonian_fails(tmp_path, name):
    """At 1 all derivatives are those of a minimum; the least value is that at -1."""
    stored(tmp_path / "high.h5", load_text(HEAD + HIGHER[name].replace("START", "1"), "a.yaml"))
    checks = checked(tmp_path / "high.h5", anew=False)
    assert failed(checks) == {PONTRYAGIN}
    where = checks[PONTRYAGIN].where
    assert where.startswith("t = ") and " by " in where and (" = -0.9" in where or " = -1" in where)
    stored(tmp_path / "low.h5", load_text(HEAD + HIGHER[name].replace("START", "-1"), "a.yaml"))
    assert not failed(checked(tmp_path / "low.h5", anew=name == "between bounds"))


def circle(v, k):
    return (v**2).sum(axis=0)[None]


def test_candidates_are_moved_onto_constraints():
    u = np.array([[0.5, 0.6], [0.1, 0.2]])
    within = box(u, np.array([[-np.inf, 0.0], [np.inf, 1.0]]))
    assert within == pytest.approx(np.array([[-1.3, 0.0], [2.4, 1.0]]))
    tried = candidates(u, within)
    assert (tried == candidates(u, within)).all()  # seeded
    v = np.broadcast_to(tried[:, :, None], (*tried.shape, 2))
    every = np.arange(2)
    equal = feasible(v, within, Constrained(circle, np.ones(1), np.ones(1), np.zeros((1, 2))), every)
    met = np.isfinite(equal).all(axis=0)
    assert met.mean() > 0.9 and circle(equal, every)[0][met] == pytest.approx(1, abs=1e-9)
    below = feasible(v, within, Constrained(circle, np.array([-np.inf]), np.full(1, 0.5), np.zeros((1, 2))), every)
    inside = circle(v, every)[0] <= 0.5
    assert (below[:, inside] == v[:, inside]).all()
    none = feasible(v, within, Constrained(circle, np.full(1, 9.0), np.full(1, 9.0), np.zeros((1, 2))), every)
    assert np.isnan(none).all()


def test_a_better_optimum_than_the_reference_means_does_not_count(tmp_path):
    """The swing-up of the paper costs 58.81; one that starts the other way costs 57.94."""
    spec = load(shipped()["cartpole"], ["mesh=[{method: radau, segments: 10}]", "refine={}"])
    stored(tmp_path / "a.h5", spec)
    checks = checked(tmp_path / "a.h5")
    assert not failed(checks) and "57.94" in checks[STARTS].where


@pytest.mark.parametrize("name", ["block_move_min_work", "block_move_min_work_smooth"])
def test_a_jump_of_the_control_or_of_a_multiplier_is_no_failure(tmp_path, name):
    """The control jumps twice, and the multiplier of the slack variables at both ends, where v = 0."""
    stored(tmp_path / "a.h5", load(shipped()[name]))
    checks = checked(tmp_path / "a.h5", anew=False)
    assert not failed(checks)
    assert "in a jump" in checks["Hamiltonian along the trajectory, relative"].where


def test_the_overshoot_of_a_jump_over_two_segments_is_no_failure(tmp_path):
    overrides = ["mesh=[{method: runge-kutta-4, segments: 12}]", "refine={}"]
    stored(tmp_path / "a.h5", load(shipped()["block_move_min_work"], overrides))
    assert not failed(checked(tmp_path / "a.h5", anew=False))


NOTHING_ELSE = """
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: 0}}
controls: {u: {}}
objective: {minimize: {integral: (u - 1)**2}}
mesh: [{method: METHOD, segments: 10}]
"""


@pytest.mark.parametrize("method", ["radau", "trapezoid", "runge-kutta-4"])
def test_multipliers_that_are_zero_are_no_failure(tmp_path, method):
    """All terms of H and of dH/du are rounding: relative to each other they say nothing."""
    stored(tmp_path / "a.h5", load_text(HEAD + NOTHING_ELSE.replace("METHOD", method), "a.yaml"))
    assert not failed(checked(tmp_path / "a.h5", anew=method == "radau"))


UNEVEN = """
time: {initial: 0, final: 1}
states: {x: {rate: v, initial: 0, final: 1}, v: {rate: u, initial: 0, final: 0}}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
mesh: [{method: trapezoid, segments: [1, 1, 1, 1, 12, 1, 1, 1, 1]}]
"""


def test_the_control_between_a_short_and_a_long_segment_is_that_of_their_middle(tmp_path):
    """u = 6 - 12 t in the exact optimum; the trapezoid rule's is optimal for the costate of another time."""
    stored(tmp_path / "a.h5", load_text(HEAD + UNEVEN, "a.yaml"))
    name = "stationarity dH/du, relative"
    assert checked(tmp_path / "a.h5", anew=False)[name].passed
    with h5py.File(tmp_path / "a.h5", "r+") as file:
        file["solver/z"][2::3] *= 1.1  # x, v, u at each point
    assert not checked(tmp_path / "a.h5", anew=False)[name].passed


def test_costates_that_were_changed_fail(tmp_path):
    stored(tmp_path / "a.h5", load(shipped()["brachistochrone"]))
    with h5py.File(tmp_path / "a.h5", "r+") as file:
        file["phase/main/points/costate/v"][...] *= -1
    assert failed(checked(tmp_path / "a.h5", anew=False)) == {
        "stored arrays of main, from the solver's point, relative"
    }


def test_an_unknown_outside_its_bounds_fails(tmp_path):
    """All of x moved by the same keeps the dynamics, which know no place."""
    stored(tmp_path / "a.h5", load(shipped()["brachistochrone"]))
    with h5py.File(tmp_path / "a.h5", "r+") as file:
        file["solver/z"][0::4] += 1e-3  # x, y, v, theta at each point
    assert "constraints at the points, relative" in failed(checked(tmp_path / "a.h5", anew=False))


CRUISE = """
time: {initial: 0, final: {lower: 1, upper: 1000, guess: GUESS}}
states:
  d: {rate: v, initial: 0, final: FAR}
  v: {rate: (f - DRAG)/M, initial: 0, lower: 0, upper: FAST}
  M: {rate: -0.004*f**2, initial: 2}
controls: {f: {lower: -2, upper: 2}}
objective: {minimize: {terminal: "t[final]"}}
refine: {tolerance: 1.0e-6}
"""


@pytest.mark.parametrize(
    ("far", "guess", "drag", "fast"), [(100, 50, "0.1*v**2", 3), (400, 300, "0.4*v", 1.5), (60, 30, "0.1*v**2", 3)]
)
def test_the_slope_at_a_knot_of_an_arc_on_the_bound_of_a_state_is_none_of_its_multiplier(
    tmp_path, far, guess, drag, fast
):
    """On segments of all lengths: the costates of both sides of a knot differ by what the bound does there."""
    text = CRUISE.replace("FAR", str(far)).replace("GUESS", str(guess)).replace("DRAG", drag).replace("FAST", str(fast))
    stored(tmp_path / "a.h5", load_text(HEAD + text, "a.yaml"))
    assert not failed(checked(tmp_path / "a.h5", anew=False))
