"""The five-link biped: its mechanics against derivations by Lagrange, and what its name stands for."""

from functools import cache

import numpy as np
import pytest
from lazily import lazily
from scipy.integrate import solve_ivp

from trajopt.problems.chains.robots import ROBOTS
from trajopt.problems.problem import Phase
from trajopt.problems.schema.model import CHAIN as CHAIN_KIND
from trajopt.problems.schema.model import NAMES_OF_MODELS
from trajopt.transcription.solution.implicit import consistent_inputs

from .walker import CHAIN, LINKS, LOPSIDED, Q0, STRIDE, TABLE_4, G, T, biped

sp = lazily("sympy")

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
    (phase,) = biped(table=LOPSIDED, model=f"{{{CHAIN}}}").phases
    found = accelerations(phase, q.T, dq.T, u.T).T
    assert found == pytest.approx(np.array(expected), rel=1e-9, abs=1e-9)


def test_heel_strike_is_a_plastic_impact():
    """(F.9)-(F.15) against M(q) (v+ - v-) = J' impulse of the unpinned walker with seven coordinates."""
    (phase,) = biped().phases
    strikes = [row.function for row in phase.boundary if row.name.startswith("strike")]

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
    (phase,) = biped().phases
    values = {f"q{i}[final]": float(i) for i in LINKS} | {f"q{i}[initial]": 10.0 * (6 - i) for i in LINKS}
    swaps = [row.function(values, np) for row in phase.boundary if row.name.startswith("step q")]
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


# -- a robot's name ---


def test_the_name_stands_for_the_chain():
    """The same residuals and constraints between the ends as with the links written out."""
    (named,), (written,) = biped().phases, biped(model=f"{{{CHAIN}, {STRIDE}}}").phases
    rng = np.random.default_rng(3)
    names = [v.name for v in (*named.states, *named.inputs)]
    assert names == [v.name for v in (*written.states, *written.inputs)]
    values = dict(zip(names, rng.uniform(-2, 2, len(names)), strict=True))
    ends = {f"{name}[{end}]": own for name, own in values.items() for end in ("initial", "final")}
    for a, b in zip(named.residuals, written.residuals, strict=True):
        assert a.function(values, np) == b.function(values, np)
    own = {row.name: row.function(ends, np) for row in named.boundary}
    assert {row.name: row.function(ends, np) for row in written.boundary}.items() <= own.items()
    assert own.keys() - {row.name for row in written.boundary} == {
        "step_length", "foot_lands", "foot_leaves_upwards", "foot_lands_downwards"
    }  # fmt: skip


def test_every_robot_that_is_known_has_a_name():
    assert (CHAIN_KIND, *ROBOTS) == NAMES_OF_MODELS
    for robot in ROBOTS.values():
        assert all(unit and note for unit, note in robot.parameters.values())


def test_the_foot_is_where_the_links_put_it():
    (phase,) = biped().phases
    values = {f"q{i}": a for i, a in zip(LINKS, Q0, strict=True)}
    length = TABLE_4["l"]
    reach = (length[0], length[1], 0.0, -length[3], -length[4])
    assert phase.outputs["foot_x"].function(values, np) == pytest.approx(-sum(np.sin(Q0) * reach))
    assert phase.outputs["foot_y"].function(values, np) == pytest.approx(sum(np.cos(Q0) * reach))
