"""IPOPT through cyipopt: statuses, options, the record of iterations, starts."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from command_line import OPTION_FILES

from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load, load_text
from trajopt.transcription.engines import ipopt
from trajopt.transcription.engines.ipopt import check_options
from trajopt.transcription.engines.ipopt_library import load_library
from trajopt.transcription.engines.outcome import COLUMNS, Start, Status
from trajopt.transcription.layout import bounded_start
from trajopt.transcription.program.compiler import compile_model
from trajopt.transcription.settings import Settings, Step
from trajopt.transcription.solve import solve
from trajopt.transcription.transcribe import transcribe

STEP = Step("hermite-simpson", 10, 1e-8)

ACCEPTABLE = {"tol": 1e-20, "acceptable_iter": 1}

REACHED = {  # real runs of cart-pole that end otherwise than solved
    Status.ACCEPTABLE: ACCEPTABLE,
    Status.MAX_ITERATIONS: {"max_iter": 1},
    Status.MAX_CPU_TIME: {"max_cpu_time": 1e-6},
    Status.MAX_WALL_TIME: {"max_wall_time": 1e-6},
    Status.DIVERGING: {"diverging_iterates_tol": 1.0},
    Status.INVALID_OPTION: {"linear_solver": "ma27"},  # known to IPOPT, but the wheel has no HSL library
}


@cache
def cartpole():
    return build(load(shipped()["cartpole"]))


@cache
def program():
    transcription = transcribe(cartpole(), [STEP.mesh()])
    return compile_model(transcription.model, transcription.variables), *bounded_start(transcription)


def run(options=None, start=None, progress=None, stop=None):
    nlp, z, lower, upper = program()
    return ipopt.solve_program(nlp, z, lower, upper, options, start=start, progress=progress, stop=stop)


def test_every_status_of_cyipopt_is_told_in_words():
    load_library()
    import ipopt_wrapper

    codes = {status.code for status in Status}
    internal = {-100, -101}  # uncaught exceptions inside IPOPT: no more to say than "it failed"
    assert set(ipopt_wrapper.STATUS_MESSAGES) - internal <= codes
    assert all(Status.from_code(code) is Status.FAILED for code in (*internal, -199, 12345))
    assert len(codes) == len(Status)


@pytest.mark.parametrize("status", Status, ids=lambda status: status.name)
def test_status_has_a_message_and_a_remedy(status):
    assert Status.from_code(status.code) is status
    assert status.message
    assert status.remedy or status in (Status.SOLVED, Status.FEASIBLE)
    assert status.usable == (status.name in ("SOLVED", "ACCEPTABLE", "FEASIBLE"))


@pytest.mark.parametrize("status", REACHED, ids=lambda status: status.name)
def test_status_is_reached(status):
    outcome = run(REACHED[status])
    assert outcome.status is status
    assert outcome.z.shape == (program()[0].n,) and np.isfinite(outcome.z).all()
    solution = solve(cartpole(), [STEP], Settings(REACHED[status]))
    assert solution.status is status and not solution.solved
    assert np.isfinite(solution.trajectories[0].x).all()


@pytest.mark.parametrize(("accept", "solved"), [(Status.SOLVED, False), (Status.ACCEPTABLE, True)])
def test_an_acceptable_point_is_solved_only_if_accepted(accept, solved):
    solution = solve(cartpole(), [STEP], Settings(ACCEPTABLE, accept=accept))
    assert solution.status is Status.ACCEPTABLE and solution.solved is solved


def test_a_problem_without_freedom_is_feasible():
    text = """
trajopt: 1
time: {initial: 0, final: 1}
states: {x: {rate: -x, initial: 1}}
objective: {minimize: {terminal: "x[final]"}}
mesh: [{method: hermite-simpson, segments: 10}]
"""
    solution = solve(build(load_text(text, "decay.yaml")), [STEP])
    assert solution.solved
    assert solution.objective == pytest.approx(np.exp(-1), abs=1e-6)


def test_record_of_each_iteration():
    told = []
    outcome = run(progress=told.append)
    assert outcome.status is Status.SOLVED and set(outcome.iterations) == set(COLUMNS)
    assert {len(values) for values in outcome.iterations.values()} == {len(told)}
    assert outcome.iterations["iteration"].tolist() == list(range(len(told)))
    assert [record["objective"] for record in told] == outcome.iterations["objective"].tolist()
    assert outcome.iterations["objective"][-1] == pytest.approx(outcome.objective, rel=1e-12)
    assert outcome.iterations["primal_infeasibility"][-1] < 1e-8
    assert outcome.iterations["mu"][-1] < outcome.iterations["mu"][0]
    assert outcome.solver == {
        "engine": "ipopt", "ipopt": outcome.solver["ipopt"], "library": "bundled", "scaling": "null", **ipopt.DEFAULTS
    }  # fmt: skip


def test_stop_keeps_the_last_iterate():
    asked = []

    def stop():
        asked.append(True)
        return len(asked) == 4

    outcome = run(stop=stop)
    assert outcome.status is Status.INTERRUPTED and len(asked) == 4
    assert outcome.iterations["iteration"].tolist() == [0, 1, 2, 3]
    other = run({"max_iter": 3})
    np.testing.assert_array_equal(outcome.z, other.z)


def test_multipliers_satisfy_the_first_order_conditions():
    """grad f + J'y - z_lower + z_upper = 0: the signs that costates and warm starts rely on."""
    nlp, *_ = program()
    outcome = run()
    rows, cols = nlp.jacobianstructure()
    gradient = nlp.gradient(outcome.z) - outcome.z_lower + outcome.z_upper
    np.add.at(gradient, cols, nlp.jacobian(outcome.z) * outcome.y[rows])
    assert np.abs(gradient).max() < 1e-6
    assert (outcome.z_lower >= 0).all() and (outcome.z_upper >= 0).all()


def test_starting_from_the_solution_takes_almost_no_iterations():
    nlp, _, lower, upper = program()
    outcome = run()
    start = Start(outcome.y, outcome.z_lower, outcome.z_upper)
    again = ipopt.solve_program(nlp, outcome.z, lower, upper, start=start)
    assert again.status is Status.SOLVED
    assert len(again.iterations["mu"]) <= 4 < len(outcome.iterations["mu"])
    assert again.objective == pytest.approx(outcome.objective, rel=1e-9)
    cold = ipopt.solve_program(nlp, outcome.z, lower, upper)
    assert len(again.iterations["mu"]) < len(cold.iterations["mu"])


def test_a_linear_solver_that_is_not_there_is_a_mistake():
    (mistake,) = check_options({"linear_solver": "ma57"})
    assert mistake.where == "solver.linear_solver"
    assert "cannot load the linear solver ma57" in mistake.what
    assert "hsllib" in mistake.remedy


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"max_itr": 3}, "did you mean max_iter?"),
        ({"linear_solvr": "mumps"}, "did you mean linear_solver?"),
        ({"max_iter": "many"}, "max_iter = 'many'"),
        ({"max_iter": 2.5}, "max_iter = 2.5"),
        ({"max_iter": -1}, "max_iter = -1"),
        ({"mu_strategy": "clever"}, "mu_strategy = 'clever'"),
        ({"tol": 0.0}, "tol = 0.0"),
        ({"no_such_thing_at_all": 1}, "IPOPT's documentation"),
    ],
)
def test_a_wrong_option_is_a_mistake(options, words):
    (mistake,) = check_options(options)
    assert mistake.where == f"solver.{next(iter(options))}"
    assert words in str(mistake)
    with pytest.raises(ValueError, match=next(iter(options))):
        run(options)


@pytest.mark.parametrize("said", OPTION_FILES.values(), ids=OPTION_FILES)
def test_an_option_file_in_the_current_folder_changes_nothing(said, folder, capfd):
    plain, unknown = run(), check_options({"linear_solver": "ma57"})
    capfd.readouterr()
    (folder / "ipopt.opt").write_text(said)
    outcome = run()
    assert outcome.status is Status.SOLVED and outcome.solver == plain.solver
    np.testing.assert_array_equal(outcome.z, plain.z)
    np.testing.assert_array_equal(outcome.y, plain.y)
    assert not check_options({"max_iter": 10}) and check_options({"linear_solver": "ma57"}) == unknown
    assert capfd.readouterr() == ("", "")
    assert [path.name for path in folder.iterdir()] == ["ipopt.opt"]


@pytest.mark.parametrize("name", ["option_file_name", "OPTION_FILE_NAME", "resto.option_file_name"])
def test_no_option_file_can_be_named(name, folder):
    (folder / "mine.opt").write_text("max_iter 2\n")
    (mistake,) = check_options({name: "mine.opt"})
    assert mistake.where == f"solver.{name}"
    with pytest.raises(ValueError, match=name):
        run({name: "mine.opt"})


def test_every_wrong_option_is_named():
    assert len(check_options({"a": 1, "max_iter": 10, "b": 2})) == 2


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"max_iter": 10, "tol": 1e-6, "mu_strategy": "adaptive", "linear_solver": "mumps"},
        {"acceptable_tol": 1},  # a whole number where IPOPT wants a real one
        {"hessian_approximation": "limited-memory"},
    ],
)
def test_right_options_are_taken(options):
    assert not check_options(options)
    outcome = run(options)
    assert outcome.solver.items() >= options.items()


def test_suggested_options_exist():
    """Each is known to IPOPT: a value of the wrong type is refused otherwise than the name."""
    values = {
        "acceptable_iter": 3, "derivative_test": "none", "fixed_variable_treatment": "relax_bounds",
        "hessian_approximation": "exact", "hsllib": "x.so", "linear_solver": "mumps", "max_iter": 10,
        "mu_strategy": "monotone", "mumps_permuting_scaling": 7, "mumps_pivot_order": 7, "mumps_scaling": 77,
        "nlp_scaling_method": "none", "output_file": "", "print_level": 0, "warm_start_init_point": "no",
    }  # fmt: skip
    assert not check_options({name: values.get(name, 1e-3) for name in ipopt.FREQUENT_OPTIONS})


def test_settings_reach_every_mesh():
    solution = solve(cartpole(), [STEP, replace(STEP, segments=20)], Settings({"mu_init": 0.02}))
    assert solution.solved and solution.outcome.solver["mu_init"] == 0.02


@pytest.mark.parametrize(
    ("segments", "options", "scaling"), [(20, {}, None), (40, {}, 0), (40, {"mumps_scaling": 77}, 77)]
)
def test_a_large_program_has_defaults_of_its_own_and_the_users_go_before(segments, options, scaling, monkeypatch):
    """As if 100 unknowns were many."""
    monkeypatch.setattr(ipopt, "LARGE", 100)
    problem = build(load(shipped()["block_move_min_force"]))
    settings = Settings(options, coarse_start=False)
    found = solve(problem, [Step("trapezoid", segments, 1e-8)], settings)
    assert (found.outcome.solver.get("mumps_scaling"), len(found.outcome.z) >= ipopt.LARGE) == (scaling, segments > 20)
    assert found.solved and found.objective == pytest.approx(12, rel=0.01)
