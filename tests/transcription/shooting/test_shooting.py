"""Shipped problems by single and multiple shooting: optima, costates, meshes, and what a file may ask for."""

import numpy as np
import pytest
from exact import growth
from named import crossed, problem_named
from shooting import SCHEMES, solved

from trajopt.problems.build import build
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load_text
from trajopt.results.file.reload import reload
from trajopt.results.file.write import write
from trajopt.transcription.export.export import export
from trajopt.transcription.schemes.mesh import Mesh
from trajopt.transcription.schemes.runge_kutta import CONTROLS
from trajopt.transcription.schemes.table import find
from trajopt.transcription.settings import Refine, Settings, Step, steps
from trajopt.transcription.solve import solve
from trajopt.transcription.transcribe import transcribe

# -- problems ---------------------------------------------------------------------------------------


def same(one, other, tolerance: float) -> None:
    s = np.linspace(0, 1, 41)
    a, b = (solution.trajectories[0].at(s) for solution in (one, other))
    assert one.objective == pytest.approx(other.objective, rel=tolerance)
    assert a.x == pytest.approx(b.x, abs=tolerance * np.abs(a.x).max())
    assert a.u == pytest.approx(b.u, abs=10 * tolerance * np.abs(a.u).max())


@pytest.mark.parametrize(("method", "control"), [s for s in SCHEMES if s[0] != "runge-kutta-2" and s[1] != "constant"])
def test_minimum_force_block(method, control):
    """u = 6 - 12 t, J = 12; H = u^2 + lambda_x v + lambda_v u gives lambda_x = -24, lambda_v = 24 t - 12."""
    single, multiple = (solved("block_move_min_force", method, n, 12 // n, control) for n in (1, 4))
    same(single, multiple, 1e-8)
    (trajectory,) = multiple.trajectories
    t = trajectory.times
    assert multiple.objective == pytest.approx(12, abs=1e-7)
    assert trajectory.u[0] == pytest.approx(6 - 12 * t, abs=1e-5)
    assert trajectory.x[0] == pytest.approx(3 * t**2 - 2 * t**3, abs=1e-7)
    for solution in (single, multiple):
        dense = solution.trajectories[0].dense
        assert dense.costate[0] == pytest.approx(-24, abs=1e-4)
        assert dense.costate[1] == pytest.approx(24 * dense.t - 12, abs=1e-4)


def test_piecewise_constant_controls_are_those_of_the_block():
    """The best steps of force over 12 intervals: J = 12 / (1 - 1/12^2), by least norm with the moments of the block."""
    multiple = solved("block_move_min_force", "runge-kutta-4", 3, 4, "constant")
    assert multiple.objective == pytest.approx(12 / (1 - 1 / 144), rel=1e-8)
    u = multiple.trajectories[0].dense.u[0]
    assert len(np.unique(u.round(6))) == 12


def test_cart_pole_by_single_and_multiple_shooting():
    multiple = solved("cartpole", "runge-kutta-4", 10, 5)
    # From the straight line single shooting finds another, better, local optimum (J = 57.945): start it from this one.
    single = solve(
        problem_named("cartpole"), [Step("runge-kutta-4", 1, 1e-9, substeps=50)], guess=multiple.trajectories
    )
    assert single.solved
    same(single, multiple, 1e-6)


def test_cart_pole_converges_to_what_collocation_finds():
    errors = [abs(solved("cartpole", "runge-kutta-4", n, 10).objective - 58.807667) for n in (5, 10, 40)]
    assert errors[0] > 4 * errors[1] > 100 * errors[2]
    assert errors[2] < 5e-6
    start = solved("cartpole", "runge-kutta-4", 40, 10).trajectories
    other = solve(problem_named("cartpole"), [Step("dormand-prince", 40, 1e-9, substeps=5)], guess=start)
    assert other.objective == pytest.approx(58.807667, abs=2e-6)


FREE = ["brachistochrone", "shot_put", "bryson_denham", "van_der_pol", "pendulum", "cartpole_min_time"]


@pytest.mark.parametrize(("name", "method"), crossed(FREE, ["runge-kutta-4", "dormand-prince"]))
def test_shipped_problems_as_by_collocation(name, method):
    """Free final times, static parameters, bounds on simulated states."""
    other = solve(problem_named(name), [Step("hermite-simpson", 40, 1e-9)])
    assert solved(name, method, 10, 4).objective == pytest.approx(other.objective, rel=3e-4)


def test_bounds_hold_at_every_point():
    (trajectory,) = solved("bryson_denham", "runge-kutta-4", 4, 6).trajectories
    names = [state.name for state in trajectory.phase.states]
    for state, x in zip(trajectory.phase.states, trajectory.x, strict=True):
        assert x.max() <= state.bounds.upper + 1e-7
    assert len(names) == len(trajectory.x)
    assert solved("bryson_denham", "runge-kutta-4", 4, 6).objective == pytest.approx(4, abs=5e-3)


def test_equations_of_the_controls_hold_where_the_control_has_nodes():
    """Slack variables of abs: with an equation at the ends of the substeps only, the middles would be free."""
    multiple = solved("block_move_min_work", "runge-kutta-4", 10, 4)
    (trajectory,) = multiple.trajectories
    names = [control.name for control in trajectory.phase.controls]
    plus, minus = (trajectory.u[names.index(f"abs1_{side}")] for side in ("plus", "minus"))
    assert plus - minus == pytest.approx(trajectory.u[names.index("u")] * trajectory.x[1], abs=1e-7)
    assert multiple.objective == pytest.approx(1.10884, abs=1e-4)


def test_implicit_dynamics_of_the_biped():
    solution = solved("biped", "runge-kutta-4", 10, 2)
    assert solution.objective == pytest.approx(390.7905, abs=0.02)


def test_states_between_the_knots_are_the_simulated_ones():
    solution = solved("cartpole", "runge-kutta-4", 10, 5)
    (trajectory,), mesh = solution.trajectories, solution.trajectories[0].mesh
    sample = trajectory.at(mesh.fractions)
    assert sample.x == pytest.approx(trajectory.x, abs=1e-8)
    assert sample.u == pytest.approx(trajectory.u, abs=1e-8)
    ends = mesh.first + mesh.degrees
    assert trajectory.f[:, ends] == pytest.approx(trajectory.at(mesh.fractions[ends]).dx, abs=1e-7)


def test_both_sides_of_a_knot_give_the_same_costate():
    (trajectory,) = solved("cartpole", "runge-kutta-4", 10, 5).trajectories
    start = trajectory.mesh.offset[1:]
    assert trajectory.costate[:, start - 1] == pytest.approx(trajectory.costate[:, start], abs=1e-6)


def test_costates_agree_with_those_of_collocation():
    (one,) = solved("cartpole", "dormand-prince", 20, 5).trajectories
    (other,) = solve(problem_named("cartpole"), [Step("hermite-simpson", 100, 1e-9)]).trajectories
    s = np.linspace(0, 1, 50)
    size = np.abs(other.at(s).costate).max(axis=1, keepdims=True)
    assert np.abs(one.at(s).costate - other.at(s).costate).max() < 2e-3 * size.max()


def test_meshes_follow_each_other_and_are_refined():
    schedule = [Step("runge-kutta-4", 5, 1e-8, substeps=4), Step("hermite-simpson", 20, 1e-8),
                Step("runge-kutta-4", 10, 1e-8, substeps=4)]  # fmt: skip
    solution = solve(problem_named("pendulum"), schedule, Settings(refine=Refine(1e-7, 4)))
    assert solution.solved and not solution.unmet
    assert len(solution.meshes) > 3
    assert solution.meshes[-1].mesh.segments > 10


STEPS = [
    (("runge-kutta-4", 10, 4), ("runge-kutta-4", 20, 4)),
    (("hermite-simpson", 20, None), ("runge-kutta-4", 10, 4)),
    (("dormand-prince", 10, 4), ("hermite-simpson", 40, None)),
]


@pytest.mark.parametrize(
    ("name", "steps"), crossed(["cartpole", "van_der_pol", "bryson_denham", "brachistochrone", "shot_put"], STEPS)
)
def test_warm_start_takes_fewer_iterations_than_cold(name, steps):
    before, after = steps
    coarse, fine = (Step(method, segments, 1e-8, substeps=substeps) for method, segments, substeps in (before, after))
    warm = solve(problem_named(name), [coarse, fine])
    cold = solve(problem_named(name), [fine], guess=solve(problem_named(name), [coarse]).trajectories)
    assert warm.solved and cold.solved
    assert warm.objective == pytest.approx(cold.objective, rel=1e-6)
    assert warm.meshes[1].iterations < cold.meshes[0].iterations


def test_newtons_method_solves_it_too():
    problem, step = growth(), Step("runge-kutta-4", 3, 1e-9, substeps=2)
    one, other = (solve(problem, [step], Settings(engine=engine)) for engine in ("newton", "ipopt"))
    assert one.solved
    assert one.objective == pytest.approx(other.objective, rel=1e-9)


# -- files ------------------------------------------------------------------------------------------

FILE = """
trajopt: 1
name: block
time: {initial: 0, final: 1}
states: {x: {rate: v, initial: 0, final: 1}, v: {rate: u, initial: 0, final: 0}}
controls: {u: }
objective: {minimize: {integral: u**2}}
mesh:
  - {method: runge-kutta-4, segments: 3, substeps: 4, control: linear}
"""


def test_mesh_of_a_problem_file():
    spec = load_text(FILE, "block.yaml")
    (step,) = steps(spec.mesh)
    assert step == Step("runge-kutta-4", 3, 1e-8, substeps=4, control="linear")
    assert solve(build(spec), [step]).objective == pytest.approx(12, abs=1e-6)


@pytest.mark.parametrize(
    ("entry", "says"),
    [
        ("substeps: 0", "write a whole number from 1 to 1000"),
        ("substeps: 2.5", "this is no number of substeps"),
        ("control: cubic", "write 'constant', 'linear' or 'quadratic'"),
    ],
)
def test_mistakes_of_a_mesh(entry, says):
    with pytest.raises(SpecError, match=says):
        load_text(FILE.replace("substeps: 4, control: linear", entry), "block.yaml")


@pytest.mark.parametrize(
    ("method", "how", "says"),
    [
        ("trapezoid", {"substeps": 2}, "no shooting method"),
        ("radau", {"control": "linear"}, "leave control: out"),
        ("runge-kutta-2", {"control": "quadratic"}, "write constant or linear"),
        ("runge-kutta-4", {"degree": 3}, "leave out degree"),
        ("runge-kutta-4", {"substeps": 100_000}, "out of range"),
    ],
)
def test_what_a_method_does_not_have(method, how, says):
    with pytest.raises(SpecError, match=says):
        Step(method, 5, 1e-8, **how).mesh()


def test_what_cannot_be_transcribed(tmp_path):
    with pytest.raises(SpecError, match="use more segments"):
        transcribe(problem_named("cartpole"), [Mesh.of(find("dormand-prince", substeps=1000), 50)])
    with pytest.raises(SpecError, match="cannot follow algebraic variables"):
        transcribe(problem_named("biped"), [Mesh.of(find("runge-kutta-4", control="constant"), 5)])
    with pytest.raises(SpecError, match="export with another method"):
        export(problem_named("cartpole"), [Mesh.of(find("runge-kutta-4"), 5)], tmp_path / "model.nl")


@pytest.mark.parametrize("control", CONTROLS)
def test_results_are_reloaded_as_they_were(tmp_path, control):
    spec = load_text(FILE.replace("linear", control), "block.yaml")
    solution = solve(build(spec), steps(spec.mesh))
    write(tmp_path / "block.h5", solution, spec.text, spec.model_dump_json(), "test")
    (before,), (after,) = solution.trajectories, reload(tmp_path / "block.h5").trajectories
    s = np.linspace(0, 1, 31)
    for a, b in zip(before.at(s), after.at(s), strict=True):
        assert a == pytest.approx(b, abs=1e-12)
