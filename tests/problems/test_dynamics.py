"""Dynamics in every form: accelerations, implicit rates, algebraic variables, models; solved, and compared."""

import numpy as np
import pytest

from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load, load_text
from trajopt.problems.quantities import Range
from trajopt.transcription.settings import Settings, steps
from trajopt.transcription.solve import solve

CARTPOLE = shipped()["cartpole"].read_text()
BEFORE, REST = CARTPOLE.split("states:\n")
TAIL = "controls:\n" + REST.split("controls:\n")[1]

FORMS = {
    "accel": """\
  q1:
    {unit: m, lower: -d_max, upper: d_max, initial: 0, final: d, velocity: {name: v1, initial: 0, final: 0},
     accel: (l*m2*sin(q2)*v2**2 + u + m2*g*cos(q2)*sin(q2)) / (m1 + m2*sin(q2)**2)}
  q2:
    {unit: rad, lower: -2*pi, upper: 2*pi, initial: 0, final: pi, velocity: {name: v2, initial: 0, final: 0},
     accel: -(l*m2*cos(q2)*sin(q2)*v2**2 + u*cos(q2) + (m1 + m2)*g*sin(q2)) / (l*m1 + l*m2*sin(q2)**2)}
""",
    # the equations of motion as Lagrange gives them, without solving for the accelerations
    "implicit": """\
  q1: {unit: m, rate: v1, lower: -d_max, upper: d_max, initial: 0, final: d}
  q2: {unit: rad, rate: v2, lower: -2*pi, upper: 2*pi, initial: 0, final: pi}
  v1: {unit: m/s, initial: 0, final: 0}
  v2: {unit: rad/s, initial: 0, final: 0}
residuals:
  - (m1 + m2)*v1[rate] + m2*l*cos(q2)*v2[rate] - m2*l*sin(q2)*v2**2 - u
  - {name: pole, expression: "cos(q2)*v1[rate] + l*v2[rate] + g*sin(q2)"}
""",
    "implicit velocities": """\
  q1: {unit: m, lower: -d_max, upper: d_max, initial: 0, final: d, velocity: {name: v1, initial: 0, final: 0}}
  q2: {unit: rad, lower: -2*pi, upper: 2*pi, initial: 0, final: pi, velocity: {name: v2, initial: 0, final: 0}}
residuals:
  - (m1 + m2)*v1[rate] + m2*l*cos(q2)*v2[rate] - m2*l*sin(q2)*v2**2 - u
  - cos(q2)*v1[rate] + l*v2[rate] + g*sin(q2)
""",
    # the force in the rod as an algebraic variable
    "algebraic": """\
  q1: {unit: m, rate: v1, lower: -d_max, upper: d_max, initial: 0, final: d}
  q2: {unit: rad, rate: v2, lower: -2*pi, upper: 2*pi, initial: 0, final: pi}
  v1: {unit: m/s, rate: (u + F*sin(q2))/m1, initial: 0, final: 0}
  v2: {unit: rad/s, rate: -(cos(q2)*(u + F*sin(q2))/m1 + g*sin(q2))/l, initial: 0, final: 0}
algebraic:
  F: {unit: N, note: force in the rod}
residuals:
  - sin(q2)*(u + F*sin(q2))/m1 - l*v2**2 - g*cos(q2) + F/m2
""",
}


def run(spec, engine=None):
    solution = solve(build(spec), steps(spec.mesh), Settings(spec.solver.options, engine=engine or spec.solver.engine))
    assert solution.solved, solution.status
    return solution


def cartpole(form: str, *overrides: str):
    return load_text(BEFORE + "states:\n" + FORMS[form] + TAIL, "cartpole.yaml", overrides)


@pytest.mark.parametrize("form", FORMS)
def test_every_form_of_the_cart_pole_has_one_solution(form):
    spec = cartpole(form)
    solution = run(spec)
    assert not spec.warnings
    assert f"{solution.objective:.6f}" == "58.805425"
    names = [state.name for state in solution.trajectories[0].phase.states]
    assert names == ["q1", "q2", "v1", "v2"]


def test_second_order_dynamics_are_two_states():
    (phase,) = build(cartpole("accel")).phases
    assert [state.velocity_of for state in phase.states] == ["", "", "q1", "q2"]
    assert [state.unit for state in phase.states] == ["m", "rad", "m/s", "rad/s"]
    assert phase.states[0].rate({"v1": 3.0}, np) == 3.0
    assert phase.states[2].initial == Range(0, 0) and phase.states[0].bounds == Range(-2, 2)


def test_a_velocity_has_a_name_and_bounds_of_its_own():
    spec = load_text(
        """{trajopt: 1, time: {initial: 0, final: 1}, controls: {u: {}}, objective: {minimize: {integral: u**2}},
        states: {q: {accel: u - q_dot, unit: m, initial: 0, final: 1}, p: {accel: u, velocity: {lower: -1, unit: m/h}}},
        mesh: [{method: any, segments: 1}]}""",
        "f",
    )
    (phase,) = build(spec).phases
    assert [(s.name, s.unit, s.velocity_of) for s in phase.states] == [
        ("q", "m", ""), ("p", "", ""), ("q_dot", "m/s", "q"), ("p_dot", "m/h", "p"),
    ]  # fmt: skip
    assert phase.states[3].bounds == Range(lower=-1)


def test_implicit_rates_are_algebraic_variables():
    spec = cartpole("implicit", "guess={constants: {'v1[rate]': 2}}")
    (phase,) = build(spec).phases
    assert [(z.name, z.unit) for z in phase.algebraic] == [("v1[rate]", "m/s/s"), ("v2[rate]", "rad/s/s")]
    assert [r.name for r in phase.residuals][1] == "pole" and all(r.bounds == Range(0, 0) for r in phase.residuals)
    assert phase.states[2].rate({"v1[rate]": 7.0}, np) == 7.0
    assert phase.guess.values["v1[rate]"].tolist() == [2, 2] and phase.guess.values["v2[rate]"].tolist() == [0, 0]


LIMITS = """\
expressions: {a: "v1[rate]"}
constraints:
  path: [{expression: "v1[rate]", upper: 8}]
  boundary: [{expression: "a[final]", upper: -3}]
guess: {constants: {"v1[rate]": 1}}
"""


def test_rates_stand_in_any_expression_over_time():
    free = cartpole("implicit")
    acceleration = run(free).trajectories[0].u[1]
    assert acceleration.max() > 8.1 and acceleration[-1] > -2
    limited = run(load_text(free.text.replace("guess: linear\n", LIMITS), "limited.yaml"))
    acceleration = limited.trajectories[0].u[1]
    assert acceleration.max() == pytest.approx(8, abs=1e-6) and acceleration[-1] == pytest.approx(-3, abs=1e-6)
    assert limited.objective == pytest.approx(58.829304, abs=1e-6)


# -- the pendulum of the introduction ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("engine", "method", "segments", "printed"),
    [
        ("newton", "finite-difference", 1000, "37.598137"),
        ("newton", "finite-difference", 100, "37.647360"),
        ("ipopt", "finite-difference", 100, "37.647360"),
        ("ipopt", "hermite-simpson", 400, "37.5926865"),
        ("newton", "hermite-simpson", 400, "37.5926865"),
    ],
)
def test_pendulum(engine, method, segments, printed):
    spec = load(shipped()["pendulum"], [f"mesh.0.method={method}", f"mesh.0.segments={segments}"])
    assert spec.solver.engine == "newton"
    objective = run(spec, engine).objective
    assert f"{objective:.{len(printed.split('.')[1])}f}" == printed


def test_newton_and_ipopt_agree_on_the_pendulum():
    spec = load(shipped()["pendulum"], ["mesh.0.segments=200"])
    newton, ipopt = run(spec), run(spec, "ipopt")
    assert newton.objective == pytest.approx(ipopt.objective, rel=0, abs=1e-8)
    for a, b in zip(newton.trajectories, ipopt.trajectories, strict=True):
        assert a.x[0] == pytest.approx(b.x[0], abs=1e-8) and a.u == pytest.approx(b.u, abs=1e-7)


def test_the_pendulum_has_the_signs_of_the_listing():
    (phase,) = build(load(shipped()["pendulum"])).phases
    assert phase.states[1].rate({"q": np.pi / 2, "u": 3.0, "w": 0.0}, np) == pytest.approx(3 - 9.81)


# -- models --------------------------------------------------------------------------------------------------------


def test_biped_of_the_supplement():
    spec = load(shipped()["biped_supplement"], ["mesh.0.tolerance=1e-8"])
    assert not spec.warnings
    solution = run(spec)
    for mesh, expected in zip(solution.meshes, ("469.46885", "469.64678"), strict=True):
        assert mesh.objective == pytest.approx(float(expected), abs=0.5001e-5)


def test_biped_has_the_meshes_of_the_paper():
    """Its objective on them is looked at in results/test_library and in chains/test_biped_gait."""
    spec = load(shipped()["biped"])
    assert [(mesh.segments, mesh.tolerance) for mesh in spec.mesh] == [(5, 1e-3), (25, 1e-6)]


def test_a_robot_gives_what_the_file_leaves_out():
    spec = load(shipped()["biped_supplement"], ["states.q3=", "states.dq1.unit=deg/s", "controls.u2.upper=5"])
    (phase,) = build(spec).phases
    assert [state.name for state in phase.states] == [f"{name}{i}" for name in ("q", "dq") for i in range(1, 6)]
    assert phase.states[2].bounds == Range() and phase.states[2].unit == "rad"
    assert phase.states[5].unit == "deg/s" and phase.controls[1].bounds == Range(-100, 5)
    assert [z.name for z in phase.algebraic] == [f"dq{i}[rate]" for i in range(1, 6)] and len(phase.residuals) == 5


CLEARANCE = """\
expressions: {height: 100*swing_tibia_y}
constraints:
  path: [{expression: height, lower: -1}]
  boundary:
    - {expression: "swing_tibia_x[final] - height[final]", lower: 0}
"""


def test_outputs_of_a_chain_are_names():
    """(7.5) as a path constraint of the file, and an output at the ends."""
    text = shipped()["biped"].read_text()
    text = text.replace("constraints:\n  boundary:\n", CLEARANCE)
    problem = build(load_text(text, "clear.yaml"))
    (phase,) = problem.phases
    path = next(constraint for constraint in phase.path if constraint.name == "height")
    values = {name: 0.1 * i for i, name in enumerate(("t", *(v.name for v in (*phase.states, *phase.inputs))))}
    q = [values[f"q{i}"] for i in range(1, 6)]
    reach = [0.4, 0.4, 0, -0.4, -0.4]
    assert path.function(values, np) == pytest.approx(100 * sum(c * np.cos(a) for c, a in zip(reach, q, strict=True)))
    ends = {f"{name}[final]": value for name, value in values.items()}
    expected = sum(c * (-np.sin(a) - 100 * np.cos(a)) for c, a in zip(reach, q, strict=True))
    assert phase.boundary[0].function(ends, np) == pytest.approx(expected)
    assert run(load_text(text, "clear.yaml")).objective == pytest.approx(390.79044, abs=1e-4)


def test_a_model_of_which_a_parameter_is_swept():
    light = run(load(shipped()["biped"], ["parameters.m3=18", "mesh.-1.segments=10"]))
    assert light.objective < 390
