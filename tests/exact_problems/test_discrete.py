"""Discrete time: exact optima, costates, several phases, and what verify can tell."""

import h5py
import numpy as np
import pytest
from command_line import trajopt

from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.results.verify import verify
from trajopt.transcription.continuation import solve_spec

REGULATOR = """\
trajopt: 1
parameters: {N: 6, a: 1}
time: {initial: 0, final: N}
states: {x: {next: a*x + u, initial: 1}}
controls: {u: {}}
objective: {minimize: {sum: x**2 + u**2}}
"""


def solved(text, *overrides):
    spec = load_text(text, "discrete.yaml", overrides)
    return solve_spec(spec, [build(spec)])


def riccati(N, a):
    """P[0..N] of min sum x^2 + u^2, x[k + 1] = a x[k] + u[k], and no cost at the end."""
    P = [0.0]
    for _ in range(N):
        P.append(1 + a**2 * P[-1] / (1 + P[-1]))
    return P[::-1]


@pytest.mark.parametrize(("N", "a"), [(6, 1.0), (9, 1.3), (1, 0.5)])
def test_the_regulator_is_that_of_riccati(N, a):
    solution = solved(REGULATOR, f"parameters.N={N}", f"parameters.a={a}")
    P, (trajectory,) = riccati(N, a), solution.trajectories
    assert solution.objective == pytest.approx(P[0], abs=1e-9)
    assert abs(solution.objective - P[0]) <= solution.objective_error.bar
    x = trajectory.x[0]
    assert trajectory.point_costate[0] == pytest.approx(2 * np.array(P) * x, abs=1e-7)  # dJ/dx = 2 P x
    assert trajectory.u[0, :-1] == pytest.approx(-np.array(P[1:]) / (1 + np.array(P[1:])) * a * x[:-1], abs=1e-8)
    assert solution.program == "convex quadratic program: the optimum is global"


def test_states_and_controls_are_held_between_the_steps():
    (trajectory,) = solved(REGULATOR).trajectories
    s = np.array([0.0, 0.1, 1 / 6 - 1e-9, 1 / 6, 1.0])
    assert trajectory.at(s).x[0] == pytest.approx(trajectory.x[0, [0, 0, 0, 1, 6]])


NONLINEAR = """\
trajopt: 1
time: {initial: 0, final: 12}
states:
  n: {next: n*exp(0.8*(1 - n) - q), initial: 0.4, lower: 0.3, final: {lower: 0.6}, note: a fish stock by Ricker}
controls:
  q: {lower: 0, upper: 0.9, note: fishing}
objective: {maximize: {sum: n*(1 - exp(-q))}}
"""


@pytest.fixture(scope="module")
def fishery(tmp_path_factory):
    folder = tmp_path_factory.mktemp("discrete")
    (folder / "fish.yaml").write_text(NONLINEAR)
    assert trajopt("solve", folder / "fish.yaml", "-q", "-o", folder / "fish.h5").exit_code == 0
    return folder / "fish.h5"


def test_a_nonlinear_problem_is_solved_as_scipy_does(fishery):
    from scipy.optimize import minimize

    def stock(q):
        n = [0.4]
        for own in q:
            n.append(n[-1] * np.exp(0.8 * (1 - n[-1]) - own))
        return np.array(n)

    found = minimize(
        lambda q: -np.sum(stock(q)[:-1] * (1 - np.exp(-q))), np.full(12, 0.3), bounds=[(0, 0.9)] * 12, method="SLSQP",
        constraints={"type": "ineq", "fun": lambda q: np.append(stock(q)[1:] - 0.3, stock(q)[-1] - 0.6)},
        options={"ftol": 1e-12, "maxiter": 500},
    )  # fmt: skip
    with h5py.File(fishery) as file:
        assert file.attrs["objective"] == pytest.approx(-found.fun, abs=1e-6)


def test_verify_passes_it(fishery):
    checks = verify(fishery)
    assert [check.name for check in checks if not check.passed] == []
    names = {check.name for check in checks}
    assert {"each step, relative", "costate equation, relative", "stationarity dH/dq, relative"} <= names
    assert not any("Pontryagin" in name for name in names)  # no necessary condition in discrete time


@pytest.mark.parametrize(
    ("place", "change", "failing"),
    [("z", 1e-3, "each step"), ("y", 3e-2, "costate equation"), ("y", 0.5, "stationarity")],
)
def test_verify_sees_what_is_changed(fishery, tmp_path, place, change, failing):
    path = tmp_path / "fish.h5"
    path.write_bytes(fishery.read_bytes())
    with h5py.File(path, "r+") as file:
        values = file[f"solver/{place}"]
        values[:] = values[:] + change * np.arange(len(values)) / len(values)
    assert any(check.name.startswith(failing) for check in verify(path) if not check.passed)


def test_two_phases_in_discrete_time_go_on_from_each_other():
    text = """{trajopt: 1, states: {x: {next: x + u, initial: 1}}, controls: {u: {}},
      objective: {minimize: {sum: x**2 + u**2}}, time: {initial: 0, final: 6},
      phases: {early: {time: {final: 2}}, late: {}}}"""
    assert solved(text).objective == pytest.approx(riccati(6, 1.0)[0], abs=1e-9)


def test_a_sum_is_bounded_and_priced():
    text = """{trajopt: 1, time: {initial: 0, final: 4}, states: {x: {next: x + u, initial: 0}}, controls: {u: {}},
      objective: {maximize: {terminal: "x[final]"}},
      constraints: {sum: [{name: energy, expression: u**2, upper: 9}]}}"""
    solution = solved(text)
    assert solution.objective == pytest.approx(6, abs=1e-7)  # sqrt(4 c)
    assert solution.prices[0]["energy"] == pytest.approx(1 / 3, abs=1e-6)  # d sqrt(4 c)/dc


def test_time_is_the_number_of_the_step():
    text = """{trajopt: 1, time: {initial: 2, final: 5}, controls: {u: {}},
      states: {x: {next: x + t + 0*u, initial: 0}}, objective: {minimize: {sum: u**2, terminal: "x[final]"}}}"""
    assert solved(text).trajectories[0].x[0].tolist() == pytest.approx([0, 2, 5, 9])


def test_it_is_shown_drawn_and_exported(fishery, monkeypatch):
    monkeypatch.chdir(fishery.parent)
    told = trajopt("show", "fish.h5").stdout
    assert "12 steps" in told and "max eta" not in told.split("\n\n")[0]
    assert trajopt("plot", "fish.h5").exit_code == 0
    for name in ("fish.nl", "fish.tex"):
        assert trajopt("export", "fish.yaml", name).exit_code == 0


def test_a_mesh_of_many_steps_is_never_a_coarser_one():
    N = 700
    solution = solved(REGULATOR, f"parameters.N={N}", "parameters.a=0.999")
    assert [record.segments for record in solution.meshes] == [N]
    assert solution.objective == pytest.approx(riccati(N, 0.999)[0], abs=1e-8)


def test_bounds_hold_at_the_steps_and_a_phase_beside_is_refined(folder):
    """Between steps there is nothing that a path constraint could be exceeded by."""
    (folder / "mixed.yaml").write_text("""
trajopt: 1
name: mixed
phases:
  steps:
    time: {initial: 0, final: 4}
    states: {x: {next: x + u, initial: 0}}
    controls: {u: {lower: -1, upper: 1}}
    constraints: {path: [{name: p, expression: x + 0.5*t, upper: 3}]}
    objective: {minimize: {integral: -x}}
  flows:
    time: {initial: 4, final: 6}
    states: {x: {rate: u - x**3, final: 2}}
    controls: {u: {}}
    objective: {minimize: {integral: u**2}}
refine: {tolerance: 1.0e-8}
""")
    run = trajopt("solve", "mixed.yaml")
    assert run.exit_code == 0 and "exceeded" not in run.stdout
    assert trajopt("verify", "mixed.h5").exit_code == 0
