"""Single and multiple shooting: tables, exact derivatives, order, costates, and the shipped problems."""

from functools import cache

import numpy as np
import pytest
from exact import GROWTH_OBJECTIVE, growth, growth_costate, growth_state, integration, integration_state

from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load, load_text
from trajopt.problems.problem import Constraint, Problem, Range
from trajopt.results.reload import reload
from trajopt.results.store import write
from trajopt.transcription.export import export
from trajopt.transcription.family import NotFinite
from trajopt.transcription.mesh import Mesh
from trajopt.transcription.runge_kutta import CLASSICAL, CONTROLS, TABLES, Shooting, Table, order_conditions
from trajopt.transcription.schemes import find
from trajopt.transcription.solve import Refine, Settings, Step, bounded_start, solve, steps
from trajopt.transcription.transcribe import compiled, transcribe

TABLE = pytest.mark.parametrize("table", TABLES, ids=lambda table: table.name)
SCHEMES = [(table.name, control) for table in TABLES for control in table.controls]
SCHEME = pytest.mark.parametrize(("method", "control"), SCHEMES)


def named(name: str) -> Problem:
    return build(load(shipped()[name]))


@cache
def solved(name: str, method: str, segments: int, substeps: int, control: str | None = None):
    solution = solve(named(name), [Step(method, segments, 1e-9, substeps=substeps, control=control)])
    assert solution.solved, solution.status
    return solution


# -- the tables and the interpolants ----------------------------------------------------------------


@TABLE
def test_order_conditions(table):
    rows, sides = order_conditions(table.A, table.order)
    assert np.abs(rows @ table.b - sides).max() < 1e-15
    rows, sides = order_conditions(table.A, max(table.order - 1, 2), theta=0.5)
    assert np.abs(rows @ table.middle - sides).max() < 1e-15


@TABLE
def test_the_order_is_no_higher(table):
    quadrature = [abs(table.b @ table.c**k - 1 / (k + 1)) for k in range(8)]
    trees, sides = order_conditions(table.A, min(table.order + 1, 5))
    assert max(quadrature[table.order], np.abs(trees @ table.b - sides).max()) > 1e-4


def test_row_sums_and_weights_as_published():
    heun, classical, dormand_prince = TABLES
    assert heun.c.tolist() == [0, 1]
    assert classical.c.tolist() == [0, 1 / 2, 1 / 2, 1]
    assert dormand_prince.c == pytest.approx([0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1], abs=1e-14)
    assert classical.middle == pytest.approx([5 / 24, 1 / 6, 1 / 6, -1 / 24], abs=1e-15)


def test_an_implicit_table_is_refused():
    with pytest.raises(ValueError, match="strictly lower"):
        Table("midpoint", 2, np.array([[0.5]]), np.ones(1), "")


@pytest.mark.parametrize("control", CONTROLS)
@pytest.mark.parametrize("substeps", [1, 2, 5])
def test_interpolants_are_exact_for_polynomials(control, substeps):
    scheme, tau, h = Shooting(CLASSICAL, substeps, control), np.linspace(0, 1, 23), 3.0
    at = scheme.interpolant(tau)
    for k in range(int(scheme.state_interpolant) + 1):
        slope = k * (h * scheme.c) ** max(k - 1, 0)
        x = (h * scheme.sigma) ** k
        assert at.X @ x + h * at.F @ slope == pytest.approx((h * tau) ** k, abs=1e-12 * h**k)
        assert at.dX @ x / h + at.dF @ slope == pytest.approx(k * (h * tau) ** max(k - 1, 0), abs=1e-11 * h**k)
    u = scheme.c ** int(scheme.control_interpolant)
    assert at.U @ u == pytest.approx(tau ** int(scheme.control_interpolant), abs=1e-13)
    for k in range(min(substeps, 3) + 1):
        assert scheme.costate_basis(tau) @ scheme.sigma**k == pytest.approx(tau**k, abs=1e-13)


# -- the nonlinear program --------------------------------------------------------------------------


def two_phases() -> Problem:
    """Two phases with different times, a parameter, and every kind of constraint; maximised."""
    (first,), (second,) = named("brachistochrone").phases, growth().phases
    integral = Constraint("effort", lambda v, m: v["u"] ** 2 * m.exp(v["t"]), Range(upper=3.0))
    path = Constraint("speed", lambda v, m: v["u"] * v["x"] + v["t"] ** 2, Range(-9.0, 9.0))
    ends = Constraint("ends", lambda v, m: v["x[final]"] * v["u[initial]"] + v["u[final]"] ** 2, Range(-5.0, 5.0))
    second = type(second)(**{**vars(second), "name": "second", "integral": (integral,), "path": (path,),
                             "boundary": (ends,), "mayer": lambda v, m: v["x[final]"] ** 3})  # fmt: skip
    return Problem("two", -1, (first, second))


DERIVATIVES = {
    name: (lambda name=name: named(name))
    for name in ("cartpole", "cartpole_min_time", "bryson_denham", "shot_put", "brachistochrone", "block_move_min_work")
} | {"two phases": two_phases, "integration": integration}


def difference(f, z: np.ndarray) -> np.ndarray:
    """df/dz by central differences of order 4, the derivatives last."""
    columns = []
    for k in range(len(z)):
        e = np.zeros(len(z))
        e[k] = 1e-4 * max(1, abs(z[k]))
        columns.append((8 * (f(z + e) - f(z - e)) - f(z + 2 * e) + f(z - 2 * e)) / (12 * e[k]))
    return np.stack(columns, axis=-1)


def dense(structure, values, shape) -> np.ndarray:
    out = np.zeros(shape)
    np.add.at(out, structure, values)
    return out


@pytest.mark.parametrize("name", DERIVATIVES)
@pytest.mark.parametrize(
    ("method", "substeps", "control"),
    [("runge-kutta-2", 3, "constant"), ("runge-kutta-4", 2, "quadratic"), ("dormand-prince", 2, "linear")],
)
def test_derivatives_are_exact(name, method, substeps, control):
    problem = DERIVATIVES[name]()
    scheme, other = find(method, substeps=substeps, control=control), find("runge-kutta-4", substeps=1, control=control)
    mesh = Mesh((scheme, other, scheme), np.array([1.0, 2.0, 1.5]))
    transcription = transcribe(problem, [mesh] * len(problem.phases))
    nlp, generator = compiled(transcription), np.random.default_rng(1)
    z, _, _ = bounded_start(transcription)
    z = z + 0.05 * generator.standard_normal(nlp.n) * (1 + np.abs(z))
    y = generator.standard_normal(nlp.m)

    def jacobian(z):
        return dense(nlp.jacobianstructure(), nlp.jacobian(z), (nlp.m, nlp.n))

    def slope(z):
        return 0.7 * nlp.gradient(z) + jacobian(z).T @ y

    rows, columns = nlp.hessianstructure()
    assert (rows >= columns).all()
    lower = dense((rows, columns), nlp.hessian(z, y, 0.7), (nlp.n, nlp.n))
    for exact, numeric in (
        (nlp.gradient(z), difference(nlp.objective, z)),
        (jacobian(z), difference(nlp.constraints, z)),
        (lower + np.tril(lower, -1).T, difference(slope, z)),
    ):
        assert np.abs(exact - numeric).max() < 1e-8 * (1 + np.abs(numeric).max())


def test_a_segment_does_not_depend_on_controls_to_come():
    transcription = transcribe(named("bryson_denham"), [Mesh.of(find("runge-kutta-4", substeps=3), 2)])
    nlp, (layout,) = compiled(transcription), transcription.phases
    limit = next(f for f in transcription.families if f.kind in ("path", "bound"))
    rows, columns = nlp.jacobianstructure()
    for row, time in zip(nlp.rows(limit.component), limit.span[:, 0], strict=True):
        later = layout.u[:, layout.mesh.fractions > time + 0.1].ravel()  # a middle sees the end of its substep
        assert not np.isin(columns[rows == row], later).any()


@pytest.mark.parametrize(("control", "nodes"), [("constant", 1), ("linear", 1), ("quadratic", 2)])
def test_number_of_unknowns(control, nodes):
    step = Step("runge-kutta-4", 10, 1e-8, substeps=5, control=control)
    (mesh,) = transcribe(named("cartpole"), [step.mesh()]).phases
    unknowns = len(transcribe(named("cartpole"), [step.mesh()]).variables)
    assert (mesh.x >= 0).sum() == 4 * 11  # states at the ends of the segments only
    assert unknowns == 4 * 11 + nodes * 50 + (control != "constant")
    assert (
        len(transcribe(named("brachistochrone"), [step.mesh()]).variables)
        == 3 * 11 + nodes * 50 + (control != "constant") + 1
    )


def test_rows_are_told_by_name():
    transcription = transcribe(named("bryson_denham"), [Mesh.of(find("runge-kutta-4", substeps=2), 3)])
    nlp = compiled(transcription)
    for family in transcription.families:
        rows = nlp.rows(family.component)
        assert len(rows.ravel()) == len(family.span)
        assert nlp.row_name(int(rows.ravel()[-1]))[0] == f"{family.kind} {family.name}"


def test_what_is_not_finite_is_told_by_segment():
    transcription = transcribe(named("hyper_sensitive"), [Mesh.of(find("runge-kutta-4", substeps=3), 3)])
    nlp = compiled(transcription)  # steps of 1000 s blow up
    z = np.full(nlp.n, 1.5)
    with pytest.raises(NotFinite, match="simulation of segment 1"):
        nlp.hessian(z, np.ones(nlp.m), 1.0)


# -- order of convergence ---------------------------------------------------------------------------


def slope(sizes, errors) -> float:
    return -np.polyfit(np.log(sizes), np.log(errors), 1)[0]


@SCHEME
@pytest.mark.parametrize("substeps", [1, 4])
def test_order_of_integration(method, control, substeps):
    """State at the knots and integral, for given dynamics: the order in the table of methods."""
    sizes, state, integral = (32, 64, 128), [], []
    for size in sizes:
        solution = solve(integration(), [Step(method, size // substeps, 1e-13, substeps=substeps, control=control)])
        (trajectory,) = solution.trajectories
        exact = integration_state(trajectory.times)
        state.append(np.abs(trajectory.x[0] - exact)[trajectory.mesh.knots].max())
        integral.append(abs(solution.objective - exact[-1] + 1))
    order = find(method).order
    assert slope(sizes, state) == pytest.approx(order, abs=0.3)
    assert integral[-1] <= 1.1 * state[-1]


OPTIMAL = {"constant": (2, 2), "linear": (4, 4), "quadratic": (5, 4)}
"""What the control's polynomial leaves of the table's order: objective; state and costate at the knots."""


@SCHEME
def test_order_of_the_optimal_solution(method, control):
    sizes, objective, state, costate, between = (16, 32, 64), [], [], [], []
    for size in sizes:
        solution = solve(
            growth(), [Step(method, size // 4, 1e-13, substeps=4, control=control)], Settings({"acceptable_iter": 0})
        )
        (trajectory,), times = solution.trajectories, solution.trajectories[0].knots
        knots = trajectory.mesh.knots
        objective.append(abs(solution.objective - GROWTH_OBJECTIVE))
        state.append(np.abs(trajectory.x[0, knots] - growth_state(times)).max())
        costate.append(np.abs(trajectory.point_costate[0, knots] - growth_costate(times)).max())
        dense = trajectory.dense
        between.append(
            max(
                np.abs(dense.x[0] - growth_state(dense.t)).max(),
                np.abs(dense.costate[0] - growth_costate(dense.t)).max(),
            )
        )
    expected, at_knots = (min(find(method).order, order) for order in OPTIMAL[control])
    assert slope(sizes, objective) == pytest.approx(expected, abs=0.3)
    assert slope(sizes[1:], state[1:]) > at_knots - 0.5
    assert slope(sizes[1:], costate[1:]) > at_knots - 0.3
    assert slope(sizes, between) > min(at_knots, 3) - 0.3


@SCHEME
def test_the_error_estimate_bounds_the_true_error(method, control):
    solution = solve(growth(), [Step(method, 3, 1e-12, substeps=3, control=control)])
    (trajectory,), (error,) = solution.trajectories, solution.errors
    nodes, weights = np.polynomial.legendre.leggauss(4)
    tau = (
        (np.arange(12)[:, None] + (nodes + 1) / 2) / 12
    ).ravel()  # four pieces of each substep: none has a jump in it
    u = trajectory.grid(np.arange(3), tau).u[0]
    end = np.exp(1 + (trajectory.h[:, None] * np.tile(weights / 24, 12) * u).sum())
    assert abs(end - trajectory.x[0, -1]) <= error.eta.sum() * np.exp(np.abs(trajectory.u).max()) + 1e-13
    assert error.max_eta < 0.02


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
    single = solve(named("cartpole"), [Step("runge-kutta-4", 1, 1e-9, substeps=50)], guess=multiple.trajectories)
    assert single.solved
    same(single, multiple, 1e-6)


def test_cart_pole_converges_to_what_collocation_finds():
    errors = [abs(solved("cartpole", "runge-kutta-4", n, 10).objective - 58.807667) for n in (5, 10, 40)]
    assert errors[0] > 4 * errors[1] > 100 * errors[2]
    assert errors[2] < 5e-6
    start = solved("cartpole", "runge-kutta-4", 40, 10).trajectories
    other = solve(named("cartpole"), [Step("dormand-prince", 40, 1e-9, substeps=5)], guess=start)
    assert other.objective == pytest.approx(58.807667, abs=2e-6)


@pytest.mark.parametrize(
    "name", ["brachistochrone", "shot_put", "bryson_denham", "van_der_pol", "pendulum", "cartpole_min_time"]
)
@pytest.mark.parametrize("method", ["runge-kutta-4", "dormand-prince"])
def test_shipped_problems_as_by_collocation(name, method):
    """Free final times, static parameters, bounds on simulated states."""
    other = solve(named(name), [Step("hermite-simpson", 40, 1e-9)])
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
    (other,) = solve(named("cartpole"), [Step("hermite-simpson", 100, 1e-9)]).trajectories
    s = np.linspace(0, 1, 50)
    size = np.abs(other.at(s).costate).max(axis=1, keepdims=True)
    assert np.abs(one.at(s).costate - other.at(s).costate).max() < 2e-3 * size.max()


def test_meshes_follow_each_other_and_are_refined():
    schedule = [Step("runge-kutta-4", 5, 1e-8, substeps=4), Step("hermite-simpson", 20, 1e-8),
                Step("runge-kutta-4", 10, 1e-8, substeps=4)]  # fmt: skip
    solution = solve(named("pendulum"), schedule, Settings(refine=Refine(1e-7, 4)))
    assert solution.solved and not solution.unmet
    assert len(solution.meshes) > 3
    assert solution.meshes[-1].mesh.segments > 10


@pytest.mark.parametrize("name", ["cartpole", "van_der_pol", "bryson_denham", "brachistochrone", "shot_put"])
@pytest.mark.parametrize(
    ("before", "after"),
    [
        (("runge-kutta-4", 10, 4), ("runge-kutta-4", 20, 4)),
        (("hermite-simpson", 20, None), ("runge-kutta-4", 10, 4)),
        (("dormand-prince", 10, 4), ("hermite-simpson", 40, None)),
    ],
)
def test_warm_start_takes_fewer_iterations_than_cold(name, before, after):
    coarse, fine = (Step(method, segments, 1e-8, substeps=substeps) for method, segments, substeps in (before, after))
    warm = solve(named(name), [coarse, fine])
    cold = solve(named(name), [fine], guess=solve(named(name), [coarse]).trajectories)
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
        transcribe(named("cartpole"), [Mesh.of(find("dormand-prince", substeps=1000), 50)])
    with pytest.raises(SpecError, match="cannot follow algebraic variables"):
        transcribe(named("biped"), [Mesh.of(find("runge-kutta-4", control="constant"), 5)])
    with pytest.raises(SpecError, match="export with another method"):
        export(named("cartpole"), [Mesh.of(find("runge-kutta-4"), 5)], tmp_path / "model.nl")


@pytest.mark.parametrize("control", CONTROLS)
def test_results_are_reloaded_as_they_were(tmp_path, control):
    spec = load_text(FILE.replace("linear", control), "block.yaml")
    solution = solve(build(spec), steps(spec.mesh))
    write(tmp_path / "block.h5", solution, spec.text, spec.model_dump_json(), "test")
    (before,), (after,) = solution.trajectories, reload(tmp_path / "block.h5").trajectories
    s = np.linspace(0, 1, 31)
    for a, b in zip(before.at(s), after.at(s), strict=True):
        assert a == pytest.approx(b, abs=1e-12)
