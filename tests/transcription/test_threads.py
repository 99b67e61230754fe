"""Solving in several threads at once gives, bit for bit, what solving in one gives."""

import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from named import ALL, share

import trajopt
from trajopt.problems.build import build_all
from trajopt.problems.catalog import find_problem
from trajopt.problems.load import load
from trajopt.transcription.settings import settings_of, steps
from trajopt.transcription.solve import solve

JOBS = [
    ("cartpole", ()),
    ("cartpole", ("mesh=[{method: radau, degree: 5, segments: 8}]",)),
    ("pendulum", ()),  # finite differences
    ("cartpole", ("mesh=[{method: runge-kutta-4, segments: 20}]",)),
    ("biped", ()),
    ("block_move_min_work", ("mesh=[{method: trapezoid, segments: 20}]",)),
    ("pendulum", ("solver.engine=newton",)),
]
THREADS, ROUNDS = 4, 4 if ALL else 2


def solution_of(job: tuple[str, tuple[str, ...]]) -> np.ndarray:
    name, overrides = job
    spec = load(find_problem(name), overrides)
    solution = solve(build_all(spec), steps(spec.mesh), settings_of(spec))
    assert solution.solved
    return np.concatenate([solution.outcome.z, solution.outcome.y])


def test_threads_give_what_one_thread_gives():
    """Before there was a lock, one run in five of four threads died (TemplateError)."""
    alone = [solution_of(job) for job in JOBS]
    with ThreadPoolExecutor(THREADS) as pool:
        together = list(pool.map(solution_of, JOBS * ROUNDS))
    for number, z in enumerate(together):
        np.testing.assert_array_equal(z, alone[number % len(JOBS)])


@pytest.mark.parametrize("_", share(range(3), 2))
def test_a_model_that_fails_leaves_the_others_alone(_):
    """An error in the middle of building in one thread changes nothing for the others."""
    failed = threading.Event()

    def failing(values, functions):
        failed.set()
        raise ZeroDivisionError

    spec = load(find_problem("cartpole"))
    (problem,) = build_all(spec)
    phase = problem.phases[0]
    broken = type(problem)(problem.name, 1, (type(phase)(**{**vars(phase), "lagrange": failing}),))
    alone = solution_of(JOBS[0])

    def break_it(_number):
        with pytest.raises(ZeroDivisionError):
            solve(broken, steps(spec.mesh), settings_of(spec))

    with ThreadPoolExecutor(THREADS) as pool:
        runs = [pool.submit(break_it, n) if n % 2 else pool.submit(solution_of, JOBS[0]) for n in range(8)]
        results = [run.result() for run in runs]
    assert failed.is_set()
    for z in results[::2]:
        np.testing.assert_array_equal(z, alone)


GIVEN = """
trajopt: 1
name: thrown against a drag
parameters: {n: 2, c: 0}
time: {initial: 0, final: 1}
states: {x: {rate: v, initial: 0, final: 1}, v: {rate: u - c*v**n, initial: 0}}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
mesh: [{method: radau, segments: 4}]
"""


@pytest.mark.parametrize("change", [{}, {"parameters.n": 1}, {"mesh.0.method": "trapezoid", "parameters.c": 1}])
def test_sensitivities_wait_for_a_model_that_another_thread_builds(change):
    """While Pyomo makes a template in one thread, Sets have placeholders for members in all. A zero and an exponent are
    numbers in the program of a solve, and data in one that is built when sensitivities are asked for."""
    solution, inside, done = trajopt.solve(trajopt.load(GIVEN, change)), threading.Event(), threading.Event()

    def slow(values, functions):
        if hasattr(values["u"], "is_expression_type") and not inside.is_set():  # Pyomo asks, for the template
            inside.set()
            done.wait(3)
        return values["u"] ** 2

    spec = load(find_problem("cartpole"))
    (problem,) = build_all(spec)
    phase = problem.phases[0]
    own = type(problem)(problem.name, 1, (type(phase)(**{**vars(phase), "lagrange": slow}),))
    with ThreadPoolExecutor(2) as pool:
        first = pool.submit(solve, own, steps(spec.mesh), settings_of(spec))
        assert inside.wait(60)
        second = pool.submit(lambda: dict(solution.sensitivities))
        second.add_done_callback(lambda _: done.set())
        assert first.result().solved and second.result() == dict(
            trajopt.solve(trajopt.load(GIVEN, change)).sensitivities
        )
