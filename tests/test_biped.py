"""The five-link biped: its mechanics against derivations by Lagrange, its optimal gait against independent values."""

from decimal import Decimal
from functools import cache

import numpy as np
import pytest
import sympy as sp
from scipy.integrate import solve_ivp

from trajopt.problems.errors import SpecError
from trajopt.problems.models import MODELS, find
from trajopt.problems.problem import Constraint, Guess, Phase, Problem, Range, State, Variable
from trajopt.transcription.implicit import consistent_inputs
from trajopt.transcription.settings import Step
from trajopt.transcription.solve import solve

HS = "hermite-simpson"
LINKS = range(1, 6)
TABLE_4 = {
    "m": (3.2, 6.8, 20.0, 6.8, 3.2),
    "I": (0.93, 1.08, 2.22, 1.08, 0.93),
    "l": (0.4, 0.4, 0.625, 0.4, 0.4),
    "d": (0.128, 0.163, 0.2, 0.163, 0.128),
}
LOPSIDED = {  # no two links alike: nothing may be right by symmetry
    "m": (3.2, 6.8, 20.0, 5.1, 2.3),
    "I": (0.93, 1.08, 2.22, 0.71, 0.55),
    "l": (0.41, 0.37, 0.625, 0.44, 0.39),
    "d": (0.128, 0.163, 0.2, 0.21, 0.19),
}
G, STEP, T = 9.81, 0.5, 0.7
Q0 = np.array([-0.3, 0.7, 0.0, -0.5, -0.6])  # (7.8)
SUPPLEMENT = {"d3": 0.425}
BOUNDS = {"q": Range(-np.pi / 2, np.pi / 2), "dq": Range(-10, 10), "ddq": Range(), "u": Range(-100, 100)}
KNEES = (
    Constraint("stance_knee", lambda v, m: v["q1"] - v["q2"], Range(upper=0)),
    Constraint("swing_knee", lambda v, m: v["q5"] - v["q4"], Range(upper=0)),
)


# -- the problem, built without a problem file ---


def parameters(table=TABLE_4, **changes) -> dict[str, float]:
    rows = {f"{symbol}{i}": value for symbol, row in table.items() for i, value in zip(LINKS, row, strict=True)}
    return {**rows, "g": G, "step_length": STEP, **changes}


def biped(path=(), table=TABLE_4, **changes) -> Problem:
    """The walking problem of the paper's section 7, for Table 4 with some parameters changed."""
    model = find("five_link_biped")
    equations = model.build(parameters(table, **changes))
    ranges = {name: BOUNDS[name[:-1]] for name in (*model.states, *model.controls, *model.algebraic)}
    ranges["u1"] = Range(0, 0)  # the ankle has no motor
    keyframes = np.array([Q0, Q0[::-1]])  # (7.8), (7.9)
    guess = dict.fromkeys((*model.controls, *model.algebraic), np.zeros(2))  # (7.11)
    guess |= {f"q{i}": keyframes[:, i - 1] for i in LINKS}
    guess |= {f"dq{i}": np.full(2, (keyframes[1] - keyframes[0])[i - 1] / T) for i in LINKS}  # (7.10)
    phase = Phase(
        name="main",
        initial_time=Range(0, 0),
        final_time=Range(T, T),
        states=tuple(
            State(name, bounds=ranges[name], rate=rate, initial=ranges[name], final=ranges[name])
            for name, rate in equations.rates.items()
        ),
        controls=tuple(Variable(name, bounds=ranges[name]) for name in model.controls),
        guess=Guess(0, T, np.array([0.0, 1.0]), guess),
        algebraic=tuple(map(Variable, model.algebraic)),
        residuals=tuple(Constraint(name, f, Range(0, 0)) for name, f in equations.residuals.items()),
        path=tuple(path),
        boundary=tuple(Constraint(name, f, bounds) for name, (f, bounds) in equations.boundary.items()),
        lagrange=lambda v, m: sum(v[f"u{i}"] ** 2 for i in LINKS),  # (7.1)
    )
    return Problem("biped", 1, (phase,))


def run(problem: Problem, *schedule: tuple):
    solution = solve(problem, [Step(*entry) for entry in schedule])
    assert solution.solved, solution.status
    return solution


@cache
def table_4_gait():
    return run(biped(), (HS, 25, 1e-8))


@cache
def supplement_gait():
    return run(biped(KNEES, **SUPPLEMENT), (HS, 25, 1e-8))


# -- mechanics, derived a second time: a chain that floats freely, by Lagrange ---


class Floating:
    """M, h, T + V and the Jacobian of the swing foot of the walker with seven coordinates (x0, y0, q1, ..., q5).

    (x0, y0) is the stance foot. Without other forces than gravity and the motors, M a = h(q, v) + (0, 0, torques of q).
    """

    def __init__(self, table):
        z, v = sp.symbols("z:7"), sp.symbols("v:7")
        links, energy, potential = self.chain(table, z), 0, 0
        for x, y, angle, mass, inertia in links[:-1]:
            dx, dy = (sum(sp.diff(f, a) * b for a, b in zip(z, v, strict=True)) for f in (x, y))
            rotation = sum(sp.diff(angle, a) * b for a, b in zip(z, v, strict=True))
            energy += mass * (dx**2 + dy**2) / 2 + inertia * rotation**2 / 2
            potential += mass * G * y
        momentum = sp.Matrix([energy.diff(a) for a in v])
        M = momentum.jacobian(v)
        h = sp.Matrix([(energy - potential).diff(a) for a in z]) - momentum.jacobian(z) * sp.Matrix(v)
        foot = sp.Matrix(links[-1]).jacobian(z)
        self.functions = [sp.lambdify((z, v), f, cse=True) for f in (M, h, energy + potential, foot)]

    @staticmethod
    def chain(table, z) -> list:
        """(x, y, angle, m, I) of the centre of mass of each link, then (x, y) of the swing foot."""
        length, d = ([sp.Float(value) for value in table[name]] for name in "ld")
        x0, y0, *q = z

        def move(p, i, distance):
            return p[0] - distance * sp.sin(q[i]), p[1] + distance * sp.cos(q[i])

        knee = move((x0, y0), 0, length[0])
        hip = move(knee, 1, length[1])
        swing_knee = move(hip, 3, -length[3])
        foot = move(swing_knee, 4, -length[4])
        starts, distances = (knee, hip, hip, hip, swing_knee), (-d[0], -d[1], d[2], -d[3], -d[4])
        centres = [move(p, i, distance) for i, (p, distance) in enumerate(zip(starts, distances, strict=True))]
        return [(*c, *rest) for c, *rest in zip(centres, q, table["m"], table["I"], strict=True)] + [foot]

    def at(self, q, dq, base=(0.0, 0.0)):
        M, h, energy, foot = (f((0.0, 0.0, *q), (*base, *dq)) for f in self.functions)
        return M, np.ravel(h), energy, foot

    def accelerations(self, q, dq, u):
        """ddq with the stance foot pinned. Each motor turns its link and, the other way, the link before it."""
        M, h, *_ = self.at(q, dq)
        return np.linalg.solve(M[2:, 2:], h[2:] + u - np.append(u[1:], 0.0))

    def after_impact(self, q, dq):
        """dq just after the swing foot has stuck to the ground and the stance foot has come off it.

        M (v+ - v-) = J' impulse and J v+ = 0.
        """
        M, _, _, J = self.at(q, dq)
        system = np.block([[M, -J.T], [J, np.zeros((2, 2))]])
        return np.linalg.solve(system, np.concatenate([M @ [0.0, 0.0, *dq], [0.0, 0.0]]))[2:7]


@cache
def floating(which: str) -> Floating:
    return Floating({"table 4": TABLE_4, "lopsided": LOPSIDED}[which])


def random_states(count: int):
    rng = np.random.default_rng(1)
    return rng.uniform(-1.2, 1.2, (count, 5)), rng.uniform(-6, 6, (count, 5)), rng.uniform(-80, 80, (count, 5))


def accelerations(phase: Phase, q, dq, u) -> np.ndarray:
    """ddq from the residuals, for q, dq, u of shape (5, ...)."""
    inputs = np.concatenate([u, np.zeros_like(u)])
    return consistent_inputs(phase, np.zeros(np.shape(q)[1:]), np.concatenate([q, dq]), inputs, {})[5:]


def test_single_stance_is_that_of_lagrange():
    """(F.4)-(F.8), as corrected, against a chain derived from its energies, no two links alike."""
    q, dq, u = random_states(40)
    expected = [floating("lopsided").accelerations(*state) for state in zip(q, dq, u, strict=True)]
    (phase,) = biped(table=LOPSIDED).phases
    found = accelerations(phase, q.T, dq.T, u.T).T
    assert found == pytest.approx(np.array(expected), rel=1e-9, abs=1e-9)


def test_residuals_are_moments_about_the_joints():
    """At rest and upright only the torques are left: residual k is u_k; in newton-metres, one to one."""
    model = find("five_link_biped")
    equations = model.build(parameters())
    values = dict.fromkeys((*model.states, *model.algebraic), 0.0) | {f"u{i}": 10.0 * i for i in LINKS}
    assert [f(values, np) for f in equations.residuals.values()] == pytest.approx([10, 20, 30, 40, 50])


def test_heel_strike_is_a_plastic_impact():
    """(F.9)-(F.15) against M(q) (v+ - v-) = J' impulse of the unpinned walker with seven coordinates."""
    equations = find("five_link_biped").build(parameters())
    strikes = [f for name, (f, _) in equations.boundary.items() if name.startswith("heel_strike")]

    def left_side(q, dq, dq_new):
        values = {f"q{i + 1}[final]": a for i, a in enumerate(q)} | {f"dq{i + 1}[final]": a for i, a in enumerate(dq)}
        values |= {f"q{i + 1}[initial]": a for i, a in enumerate(q[::-1])}
        values |= {f"dq{i + 1}[initial]": a for i, a in enumerate(dq_new)}
        return np.array([f(values, np) for f in strikes])

    for q, dq, _ in zip(*random_states(40), strict=True):
        constant = left_side(q, dq, np.zeros(5))
        matrix = np.array([left_side(q, dq, row) - constant for row in np.eye(5)]).T
        found = np.linalg.solve(matrix, -constant)
        expected = floating("table 4").after_impact(q, dq)[::-1]
        assert found == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_heel_strike_swaps_the_legs():
    equations = find("five_link_biped").build(parameters())
    values = {f"q{i}[final]": float(i) for i in LINKS} | {f"q{i}[initial]": 10.0 * (6 - i) for i in LINKS}
    swaps = [f(values, np) for name, (f, _) in equations.boundary.items() if name.startswith("swap")]
    assert swaps == pytest.approx([9.0 * i for i in (5, 4, 3, 2, 1)])


def test_passive_swing_keeps_its_energy():
    (phase,) = biped().phases

    def rate(t, x):
        return np.append(x[5:], accelerations(phase, x[:5], x[5:], np.zeros(5)))

    start = np.append(Q0, (Q0[::-1] - Q0) / T)
    swing = solve_ivp(rate, (0, 0.25), start, method="DOP853", rtol=1e-10, atol=1e-12)
    assert swing.success
    energy = np.array([floating("table 4").at(x[:5], x[5:])[2] for x in swing.y.T])
    assert np.abs(swing.y[:5, -1] - Q0).max() > 0.2
    assert energy == pytest.approx(energy[0], rel=1e-8)


# -- the gait ---

REFERENCES = [  # walker, method, segments, objective as printed: half a unit of the last digit is the tolerance
    ("table 4", HS, 5, "390.73094"),
    ("table 4", HS, 15, "390.78984"),
    ("table 4", HS, 25, "390.79044"),
    ("table 4", HS, 60, "390.79053"),
    ("table 4", "trapezoid", 24, "393.497"),
    ("table 4", "trapezoid", 24, "393.49732"),
    ("table 4", "trapezoid", 100, "390.96116"),
    ("table 4, knees", HS, 25, "390.79044"),
    ("supplement", HS, 25, "469.50107"),
    ("supplement, knees", HS, 5, "469.46885"),
    ("supplement, knees", HS, 15, "469.64333"),
    ("supplement, knees", HS, 25, "469.64678"),
    ("supplement, knees", HS, 60, "469.6500"),
    ("supplement, knees", "trapezoid", 24, "473.865"),
    ("supplement, knees", "trapezoid", 24, "473.86487"),
    ("supplement, knees", "trapezoid", 100, "469.91994"),
]


@pytest.mark.parametrize(("walker", "method", "segments", "printed"), REFERENCES)
def test_reference_value(walker, method, segments, printed):
    """Computed independently of trajopt with CasADi and IPOPT, tol 1e-8."""
    problem = biped(KNEES if "knees" in walker else (), **SUPPLEMENT if "supplement" in walker else {})
    solution = run(problem, (method, segments, 1e-8))
    half_a_unit = 0.5 * 10.0 ** Decimal(printed).as_tuple().exponent
    assert solution.objective == pytest.approx(float(printed), rel=0, abs=half_a_unit * 1.001)


PRINTED = {  # x(0), dq(T), u(0), u(T), greatest height of the swing foot, greatest eta of q1 to q5; 25 segments
    table_4_gait: {
        "x0": [0.07129, 0.50165, -0.22793, -0.35099, -0.36192, -1.20789, -1.07960, 0.23077, -0.58534, -1.91620],
        "dq_final": [-2.05706, -1.52743, 1.07607, -1.96205, 3.57032],
        "u0": [0, -22.955, 41.965, 8.670, 12.613],
        "u_final": [0, 13.452, 8.722, -22.109, 9.460],
        "height": 0.0704,
        "eta": [3.8e-6, 3.9e-6, 1.2e-6, 1.7e-6, 1.8e-6],
    },
    supplement_gait: {
        "x0": [0.08645, 0.49319, -0.12735, -0.34672, -0.35800, -1.50587, -0.60570, 0.01500, -0.54394, -2.01556],
        "dq_final": [-2.17582, -1.62054, 1.02672, -1.37964, 2.99184],
        "u0": [0, -25.118, 53.669, 1.696, 16.103],
        "u_final": [0, 14.362, 8.233, -22.671, 7.585],
        "height": 0.0712,
        "eta": [9.4e-6, 1.02e-5, 1.8e-6, 2.3e-6, 1.7e-6],
    },
}


@pytest.mark.parametrize("gait", PRINTED)
def test_gait(gait):
    (trajectory,), printed = gait().trajectories, PRINTED[gait]
    x, u = trajectory.x, trajectory.u
    assert x[:, 0] == pytest.approx(printed["x0"], abs=5.1e-6)
    assert x[:5, -1] == pytest.approx(x[4::-1, 0], abs=1e-9)
    assert x[5:, -1] == pytest.approx(printed["dq_final"], abs=5.1e-6)
    assert u[:5, 0] == pytest.approx(printed["u0"], abs=5.1e-4)
    assert u[:5, -1] == pytest.approx(printed["u_final"], abs=5.1e-4)


@pytest.mark.parametrize("gait", PRINTED)
def test_foot_stays_above_the_ground(gait):
    """(7.5) holds without being asked for."""
    (trajectory,) = gait().trajectories
    dense = trajectory.dense
    foot_y = find("five_link_biped").build(parameters()).outputs["foot_y"]
    y = foot_y(trajectory.phase.values(dense.t, dense.x, dense.u, {}), np)
    assert y.max() == pytest.approx(PRINTED[gait]["height"], abs=5.1e-5)
    assert y[1:-1].min() > 0
    assert (y[0], y[-1]) == pytest.approx((0, 0), abs=1e-8)


@pytest.mark.parametrize("gait", PRINTED)
def test_error_estimate(gait):
    """The right side of Figure 15, computed independently; all digits given."""
    (error,) = gait().errors
    printed = np.array(PRINTED[gait]["eta"])
    assert np.all(np.abs(error.eta.max(axis=1)[:5] - printed) <= 0.51e-7)


def test_both_meshes_of_the_paper():
    """5 segments to 1e-3, then 25 to 1e-6; the paper's solver needs 29 and 56 iterations, 0.96 s and 21.3 s."""
    solution = run(biped(), (HS, 5, 1e-3), (HS, 25, 1e-6))
    assert solution.objective == pytest.approx(390.79044, abs=5e-6)
    assert [mesh.iterations < 30 for mesh in solution.meshes] == [True, True]
    for mesh in solution.meshes:
        parts = ", ".join(f"{name} {seconds:.3f}" for name, seconds in mesh.seconds.items())
        total = sum(mesh.seconds.values())
        print(f"{mesh.mesh.segments} segments: {mesh.iterations} iterations, {total:.3f} s: {parts}")


def test_compressed_form_finds_the_same_gait():
    """The midpoint states are eliminated; the accelerations at the midpoints stay unknown."""
    assert run(biped(), (f"{HS}-compressed", 25, 1e-8)).objective == pytest.approx(390.79044, abs=5e-6)


def test_foot_clearance_over_a_bump():
    """(7.7): the swing foot stays above h (1 - (x / step length)^2), written with the outputs of the model."""
    outputs = find("five_link_biped").build(parameters()).outputs

    def clearance(values, functions):
        x, y = (outputs[name](values, functions) for name in ("foot_x", "foot_y"))
        return y - 0.08 * (1 - (x / STEP) ** 2)

    solution = run(biped([Constraint("clearance", clearance, Range(lower=0))]), (HS, 15, 1e-8))
    (trajectory,) = solution.trajectories
    values = trajectory.phase.values(trajectory.times, trajectory.x, trajectory.u, {})
    margin = clearance(values, np)
    assert margin.min() > -1e-7
    assert np.sum(margin < 1e-6) > 2
    assert solution.objective > 391


# -- the contract of a model ---


@pytest.mark.parametrize("name", MODELS)
def test_a_model_says_all_that_its_equations_hold(name):
    model = find(name)
    equations = model.build(dict.fromkeys(model.parameters, 0.3))
    assert model.name == name
    assert set(equations.rates) == set(model.states)
    assert len(equations.residuals) == len(model.algebraic)
    names = [*model.parameters, *model.states, *model.controls, *model.algebraic, *equations.outputs]
    assert len(names) == len(set(names))
    quantities = {**model.parameters, **model.states, **model.controls, **model.algebraic}
    assert all(quantity.unit and quantity.note for quantity in quantities.values())


def test_an_unknown_model_is_told_with_the_nearest_name():
    with pytest.raises(SpecError, match=r"did you mean five_link_biped\? the models are five_link_biped"):
        find("five_link_bipde")
    with pytest.raises(SpecError, match=r'no model "segway"; the models are five_link_biped'):
        find("segway")


def test_pose_draws_the_links_where_the_equations_have_them():
    model = find("five_link_biped")
    values = {f"q{i}": a for i, a in zip(LINKS, Q0, strict=True)}
    pose = model.pose(values, parameters())
    outputs = model.build(parameters()).outputs
    assert pose["stance leg"][0] == pytest.approx([0, 0])
    assert pose["swing leg"][-1] == pytest.approx([outputs[name](values, np) for name in ("foot_x", "foot_y")])
    lengths = {part: np.linalg.norm(np.diff(joints, axis=0), axis=1).tolist() for part, joints in pose.items()}
    leg = pytest.approx(TABLE_4["l"][:2])
    assert lengths == {"stance leg": leg, "torso": [TABLE_4["l"][2]], "swing leg": leg}
    assert pose["torso"][1] - pose["torso"][0] == pytest.approx([0, 0.625])
