"""Controls that a mesh hardly determines: they are damped where they turn at every point, and only there."""

from functools import cache

import numpy as np
import pytest
from named import share

from trajopt.problems.build import build_all
from trajopt.transcription.engines.watch import Watch
from trajopt.transcription.loading import load_file, load_yaml
from trajopt.transcription.one_mesh import Origin, solve_mesh
from trajopt.transcription.refinement.chatter import Damping, Rough, chatter
from trajopt.transcription.settings import schedule_of, settings_of
from trajopt.transcription.solve import solve
from trajopt.transcription.transcribe import planned

BANG_BANG = """\
trajopt: 1
name: rest to rest
time: {initial: 0, final: {lower: 0, upper: 10, guess: 1}}
states: {x: {rate: v, initial: 0, final: 1}, v: {rate: u, initial: 0, final: 0}}
controls: {u: {lower: -1, upper: 1}}
objective: {minimize: {terminal: "t[final]"}}
"""
OF_NO_USE = """\
trajopt: 1
name: two controls for one rate, one of them against a wall
time: {initial: 0, final: 1}
states: {x: {rate: u1 - u2, initial: 0, final: 0.5}}
controls: {u1: {lower: 0, upper: 1}, u2: {lower: 0, upper: 1}}
objective: {minimize: {integral: (x - t/2)**2}}
"""


@cache
def solved(name, *overrides):
    spec = load_file(name, overrides)
    return solve(build_all(spec), schedule_of(spec), settings_of(spec))


def first_mesh(text):
    spec = load_yaml(text)
    (problem, meshes, tolerance), *_ = planned(build_all(spec), schedule_of(spec))
    return solve_mesh(problem, meshes, tolerance, settings_of(spec), Origin(None, None), Watch(None, None, 0))[1]


@pytest.fixture(scope="module")
def bang_bang():
    return first_mesh(BANG_BANG)


@pytest.fixture(scope="module")
def damped(bang_bang):
    damping = Damping((Rough("main", "u", 0.0, 1.0, 2.0),), strength=0.3, size=2.0)
    return damping.of(bang_bang.nlp, bang_bang.transcription)


def test_a_straight_control_costs_nothing_and_an_oscillation_what_the_formula_says(bang_bang, damped):
    (layout,) = bang_bang.transcription.phases
    program = damped
    known = layout.u[0] >= 0
    z, tau = np.zeros(bang_bang.nlp.n), layout.mesh.fractions[known]
    z[layout.u[0, known]] = 0.3 - 0.7 * tau
    assert program.term.objective(z) == pytest.approx(0, abs=1e-25)
    z[layout.u[0, known]] = (-1.0) ** np.arange(len(tau))  # d = 4, whatever the distances: 4 over the span of 2
    h = np.diff(tau)
    assert program.term.objective(z) == pytest.approx(0.3 * 2.0 * np.sum((h[:-1] + h[1:]) / 2 * (4 / 2) ** 2))


def test_derivatives_of_the_damped_program(bang_bang, damped):
    program, own, n = damped, bang_bang.nlp, bang_bang.nlp.n
    rng = np.random.default_rng(1)
    z, y = bang_bang.outcome.z + 0.1 * rng.random(n), rng.random(bang_bang.nlp.m)
    step = 1e-6 * np.eye(n)
    slopes = [(program.objective(z + e) - program.objective(z - e)) / 2e-6 for e in step]
    assert program.gradient(z) == pytest.approx(np.array(slopes), abs=1e-7)
    added = np.zeros((n, n))
    for sign, one in ((1, program), (-1, own)):
        rows, columns = one.hessianstructure()
        assert (rows >= columns).all()
        np.add.at(added, (rows, columns), sign * one.hessian(z, y, 0.7))

    def gradient(z):
        return program.gradient(z) - own.gradient(z)

    term = np.array([(gradient(z + e) - gradient(z)) / 1e-6 for e in step])
    assert added + np.tril(added, -1).T == pytest.approx(0.7 * term, abs=1e-6)


def test_what_turns_at_every_point_chatters_and_what_jumps_does_not(bang_bang):
    (trajectory,), transcription = bang_bang.trajectories, bang_bang.transcription
    assert chatter([trajectory], transcription) == []
    known = transcription.phases[0].u[0] >= 0
    count = int(known.sum())
    for values, chatters in (
        ((-1.0) ** np.arange(count), True),
        (np.sin(np.linspace(0, 12, count)), False),
        (np.sign(np.sin(np.linspace(0, 12, count))), False),  # four jumps
        (1e-9 * (-1.0) ** np.arange(count), False),  # rounding
    ):
        trajectory.u[0, known] = values
        assert bool(chatter([trajectory], transcription)) == chatters


def test_what_turns_once_in_each_segment_chatters_where_it_does_so_often(bang_bang):
    """Three points on a level and a fourth above it; a bang-bang control has its switches farther apart."""
    spec = load_yaml(BANG_BANG + "mesh: [{method: radau, degree: 4, segments: 40}]\n")
    (problem, meshes, tolerance), *_ = planned(build_all(spec), schedule_of(spec))
    found = solve_mesh(problem, meshes, tolerance, settings_of(spec), Origin(None, None), Watch(None, None, 0))[1]
    (trajectory,), known = found.trajectories, found.transcription.phases[0].u[0] >= 0
    k = np.arange(int(known.sum()))
    for values, chatters in (
        (0.1 * (k % 4 == 3), True),
        (k / len(k) + 0.1 * (k % 4 == 3), True),
        (k / len(k) + 0.1 * (k % 4 == 3) * (k < 40), False),  # ten times
        (1.0 * (k % 8 < 4), False),  # a switch at each knot
    ):
        trajectory.u[0, known] = values
        assert bool(chatter([trajectory], found.transcription)) == chatters


@pytest.mark.parametrize(("count", "chatters"), [(12, True), (6, False)])
def test_single_points_that_stand_out_by_half_of_the_range_chatter_wherever_they_are(bang_bang, count, chatters):
    """A feed that is on at one point of some segments: the scheme's equations gain by it, the problem does not."""
    (trajectory,), transcription = bang_bang.trajectories, bang_bang.transcription
    known = np.flatnonzero(transcription.phases[0].u[0] >= 0)
    values = np.zeros(len(known))
    values[np.cumsum(np.resize([2, 4, 3], count)) + 1] = 1.0  # never twice as near as NEAR in a row
    trajectory.u[0, known] = values
    assert bool(chatter([trajectory], transcription)) is chatters


ELBOW = """\
trajopt: 1
name: an elbow with two muscles
parameters: {I: 0.1, g: 2.2, r1: 24, r2: 20, tau: 0.05}
time: {initial: 0, final: 0.8}
states:
  q: {rate: w, initial: 0.2, final: 2.0}
  w: {rate: (r1*a1 - r2*a2 - g*sin(q))/I, initial: 0, final: 0}
  a1: {rate: (e1 - a1)/tau, initial: 0.05, lower: 0, upper: 1}
  a2: {rate: (e2 - a2)/tau, initial: 0.05, lower: 0, upper: 1}
controls: {e1: {lower: 0, upper: 1}, e2: {lower: 0, upper: 1}}
objective: {minimize: {integral: a1**2 + a2**2}}
"""


@pytest.mark.parametrize("names", share(["e1 e2", "biceps triceps"], 1))
def test_muscles_that_chatter_in_each_segment_are_damped_and_named(names):
    first, second = names.split()
    spec = load_yaml(ELBOW.replace("e1", first).replace("e2", second))
    solution = solve(build_all(spec), schedule_of(spec), settings_of(spec))
    assert not solution.unmet and solution.meshes[-1].segments < 200
    assert any(f"{first} is hardly determined" in note and "chattered" in note for note in solution.notes)


def test_goddard_in_feet_is_solved_in_one_phase():
    """18550.8718638 with the structure of the optimum in the file (`goddard_three_phases`)."""
    solution = solved("goddard_feet")
    assert solution.status.usable and not solution.unmet
    assert abs(solution.objective - 18550.8718638) <= solution.objective_error.bar < 0.1
    assert solution.meshes[-1].segments < 80
    assert any("T is hardly determined" in note for note in solution.notes)
    trajectory = solution.trajectories[0]
    assert np.nansum(np.abs(np.diff(trajectory.u[0]))) < 4 * np.ptp(trajectory.u[0])


@pytest.mark.parametrize(("name", "exact"), [("goddard", 1.01283692), ("schwartz_two_phase", 0.0)])
def test_singular_arcs_take_few_segments(name, exact):
    solution = solved(name)
    assert not solution.unmet
    assert abs(solution.objective - exact) <= solution.objective_error.bar + 1e-8
    assert solution.meshes[-1].segments < 60


def test_controls_of_which_only_the_difference_counts():
    spec = load_yaml(OF_NO_USE)
    solution = solve(build_all(spec), schedule_of(spec), settings_of(spec))
    assert not solution.unmet and abs(solution.objective) < 1e-8
    assert solution.meshes[-1].segments < 30


@pytest.mark.parametrize("name", ["double_integrator_min_time", "fuller", "catalyst_mixing"])
def test_bang_bang_and_resolved_arcs_are_left_alone(name):
    assert not any("damped" in note for note in solved(name).notes)


def test_a_mesh_whose_equations_follow_no_dynamics_is_not_believed():
    """On the third mesh negative glucose feeds the bacteria: an objective of 65, with errors of 1."""
    solution = solved("fed_batch_inducer", "refine.tolerance=1e-7", "refine.max_meshes=2")
    assert solution.objective == pytest.approx(0.8165, abs=1e-3)


def fixed(text, mesh):
    spec = load_yaml(f"{text}mesh: [{mesh}]\n")
    found = solve(build_all(spec), schedule_of(spec), settings_of(spec))
    assert found.solved
    return [own for own in found.notes if "chatters" in own]


DRAG = """\
trajopt: 1
name: a singular arc between two bounds
time: {initial: 0, final: 4}
states: {x: {rate: u, initial: 1, final: 0.5}, w: {rate: -w + v, initial: 0}}
controls: {u: {lower: -1, upper: 1}, v: {lower: 0, upper: 1}}
objective: {minimize: {integral: x**2 + (w - 0.3)**2}}
"""


@pytest.mark.parametrize("mesh", ["{method: trapezoid, segments: 40}", "{method: hermite-simpson, segments: 25}"])
@pytest.mark.parametrize("text", [OF_NO_USE, DRAG])
def test_a_mesh_that_is_not_refined_tells_of_chatter(text, mesh):
    told = fixed(text, mesh)
    rough = {own.split()[0] for own in told}
    assert told and rough <= {"u", "u1", "u2", "v"}
    assert all(own.endswith(", and chatters; refine: {} in the file damps its oscillations") for own in told)


DISCRETE = """\
trajopt: 1
name: back and forth in steps
time: {initial: 0, final: 20}
states: {x: {next: -x + u, initial: 1}}
controls: {u: {lower: -1, upper: 1}}
objective: {minimize: {sum: "(x - 0.5*cos(pi*t))**2 + (u - 0.5*cos(pi*t))**2"}}
"""


def test_controls_that_turn_at_each_step_of_discrete_time_do_not_chatter():
    spec = load_yaml(DISCRETE)
    found = solve(build_all(spec), schedule_of(spec), settings_of(spec))
    u = found.trajectories[0].u[0]
    assert found.solved and (np.diff(np.sign(np.diff(u[np.isfinite(u)]))) != 0).sum() > 8
    assert not any("chatters" in own for own in found.notes)


def test_a_control_that_switches_once_does_not_chatter():
    assert fixed(BANG_BANG, "{method: trapezoid, segments: 40}") == []
