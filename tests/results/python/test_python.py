"""What Python users get of a solve: functions of time, failures as data, files that are read back."""

import subprocess
import sys
import textwrap

import numpy as np
import pytest

import trajopt

from .python_problems import ALGEBRAIC, BLOCK


@pytest.fixture(scope="module")
def block():
    return trajopt.solve(trajopt.load(BLOCK))


@pytest.fixture(scope="module")
def failed():
    return trajopt.solve(trajopt.load("cartpole", {"solver.max_iter": 3}))


# -- functions of time -----------------------------------------------------------------------------------------------


def test_at_a_scalar_and_at_arrays(block):
    x = block["x"]
    assert type(x(0.25)) is float and type(x(np.float64(0.25))) is float and type(x(1)) is float
    t = np.linspace(0, 1, 6)
    assert x(t).shape == (6,) and x(t.reshape(2, 3)).shape == (2, 3) and x([]).shape == (0,)
    assert x(t.reshape(2, 3)).ravel().tolist() == x(t.tolist()).tolist() == [x(time) for time in t]
    assert x(t) == pytest.approx(3 * t**2 - 2 * t**3, abs=1e-9)  # the exact solution
    assert block["v"](t) == pytest.approx(6 * t - 6 * t**2, abs=1e-9)
    assert block["u"](t) == pytest.approx(12 - 24 * t, abs=1e-7)
    assert block.costate["x"](t) == pytest.approx(-96 + 0 * t, abs=1e-4)


def test_outputs_are_functions_of_time(block):
    t = np.linspace(0, 1, 7)
    assert block["power"](t) == pytest.approx(block["u"](t) * block["v"](t))
    assert block["size"](t) == pytest.approx(abs(block["u"](t)))
    assert "twice" not in block  # it is constant
    assert block["power"].kind == "output" and block["power"].values.shape == block.time.shape


def test_an_output_that_a_model_gives():
    solution = trajopt.solve(trajopt.load("biped", {"mesh": [{"method": "trapezoid", "segments": 6}]}))
    outputs = [f.name for f in solution.phases["main"].functions.values() if f.kind == "output"]
    assert outputs and all(np.isfinite(solution[name](solution.time)).all() for name in outputs)


def test_algebraic_variables_and_static_parameters(block):
    solution = trajopt.solve(trajopt.load(ALGEBRAIC))
    assert solution["z"](0.3) == pytest.approx(1.0, abs=1e-7) and solution["z"].kind == "algebraic"
    assert type(block["k"]) is float and block["k"] == pytest.approx(3.0, abs=1e-6)


def test_values_at_the_points_of_the_mesh(block):
    assert block.time.shape == block["x"].values.shape == (17,)
    for name in ("x", "v", "u", "power", "size"):
        assert block[name](block.time) == pytest.approx(block[name].values, abs=1e-12)
    assert block.costate["v"].values.shape == (17,)
    assert block["x"].unit == "m" and block["u"].unit == "N" and block["u"].kind == "control"


@pytest.mark.parametrize("t", [-0.1, 1.1, [0.5, 2.0], np.nan, np.inf])
def test_a_time_outside_is_refused(block, t):
    with pytest.raises(ValueError, match=r"t = \S+ is outside phase main, which goes from 0 to 1 s"):
        block["x"](t)


def test_an_end_that_rounding_missed_is_the_end(block):
    assert block["x"](1 + 1e-15) == block["x"](1.0) and block["x"](-1e-16) == block["x"](0.0)


def test_an_unknown_name_is_told_with_the_nearest(block):
    with pytest.raises(KeyError, match="there is no 'powr': did you mean power"):
        block["powr"]
    with pytest.raises(KeyError, match="there is no 'y': there are x, v"):
        block.costate["y"]
    assert "x" in block and "y" not in block and list(block)[:2] == ["x", "v"]
    assert block._ipython_key_completions_() == list(block)


def test_the_phase_has_the_same(block):
    phase = block.phases["main"]
    assert phase["x"](0.3) == block["x"](0.3) and phase.costate["x"](0.3) == block.costate["x"](0.3)
    assert (phase.time == block.time).all() and phase.time_unit == "s"


def test_a_method_without_costates():
    text = ALGEBRAIC.partition("algebraic:")[0].replace("x: {rate: z,", "x: {accel: u, velocity: {name: v},")
    text += "objective: {minimize: {integral: u**2}}\nmesh: [{method: finite-difference, segments: 6}]\n"
    solution = trajopt.solve(trajopt.load(text))
    assert solution.solved and not solution.costate and repr(solution.costate) == "<no costates with this method>"
    with pytest.raises(KeyError, match="there is no 'x': there are none"):
        solution.costate["x"]


# -- solving ---------------------------------------------------------------------------------------------------------


def test_what_a_solution_tells(block):
    assert block.solved and block.status == "solved" and not block.remedy and not block.causes
    assert block.objective == pytest.approx(48.0, abs=1e-6)
    assert block.error.max_eta < 1e-8 and block.error.relative < 1e-8
    assert abs(block.objective - 48.0) <= block.error.objective < 1e-3
    assert len(block.meshes) == 1 and block.meshes[0].iterations > 0


def test_a_failed_solve_is_data(failed):
    assert not failed.solved and failed.status == "max_iterations"
    assert failed.message == "ran out of iterations" and "max_iter" in failed.remedy
    assert failed.causes and "missed by" in failed.causes[0]
    assert np.isfinite(failed["q1"](1.0)) and "NOT SOLVED" in repr(failed) and failed.message in repr(failed)


def test_a_contradiction_is_data():
    solution = trajopt.solve(trajopt.load(BLOCK, {"states.v.upper": 0.1}))
    assert not solution.solved and solution.status == "infeasible"
    assert any("upper bound of v" in cause for cause in solution.causes)


def test_an_engine_that_cannot_take_the_problem():
    with pytest.raises(trajopt.SpecError, match=r"override solver.engine|controls"):
        trajopt.solve(trajopt.load(BLOCK, {"solver.engine": "newton"}))


def test_progress_and_stop():
    seen = []
    problem = trajopt.load("cartpole")
    solution = trajopt.solve(
        problem, progress=lambda mesh, record: seen.append((mesh, record["iteration"])), stop=lambda: len(seen) > 4
    )
    assert solution.status == "interrupted" and seen == [(0, i) for i in range(5)]
    assert "guess=" in solution.remedy and "--" not in solution.remedy


def test_an_error_in_progress_is_raised():
    def fail(mesh, record):
        raise RuntimeError("mine")

    with pytest.raises(RuntimeError, match="mine"):
        trajopt.solve(trajopt.load(BLOCK), progress=fail)


def test_a_guess_is_a_solution_or_its_file(block, folder):
    block.save("block.h5")
    problem = trajopt.load(BLOCK, {"parameters.far": 1.1})
    cold, warm, file = (trajopt.solve(problem, guess=guess) for guess in (None, block, "block.h5"))
    first = [solution.meshes[0].iterations for solution in (cold, warm, file)]
    assert first[1] == first[2] <= first[0]
    assert warm.objective == file.objective == pytest.approx(cold.objective, abs=1e-6)
    with pytest.raises(trajopt.SpecError, match=r"^the solution: it has none of the states q1"):
        trajopt.solve(trajopt.load("cartpole"), guess=block)
    with pytest.raises(trajopt.FileError, match=r"none.h5: there is no such file"):
        trajopt.solve(problem, guess="none.h5")


def test_only_a_loaded_problem_is_solved():
    with pytest.raises(TypeError, match=r"trajopt\.load"):
        trajopt.solve("cartpole")


def test_nothing_is_printed(folder, capfd):
    for source, overrides in (
        ("cartpole", {}), ("cartpole", {"solver.max_iter": 3}), (BLOCK, {"states.v.upper": 0.1}),
        ("block_move_min_work", {"mesh": [{"method": "trapezoid", "segments": 10}]}),
        ("brachistochrone", {}), ("cartpole", {"states.v2.rate": "sqrt(q1 - 5)"}),
    ):  # fmt: skip
        solution = trajopt.solve(trajopt.load(source, overrides))
        solution.save("a.h5", force=True)
        trajopt.read("a.h5")
    for wrong in ({"solver.max_iter": "many"}, {"solver.mu_strategy": "x"}, {"solver.linear_solver": "ma57"}):
        with pytest.raises(trajopt.SpecError):
            trajopt.load("cartpole", wrong)
    assert capfd.readouterr() == ("", "")


# -- saving and reading ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("source, overrides", [
    ("cartpole", {}),
    ("cartpole", {"solver.max_iter": 3}),
    ("biped", {"mesh": [{"method": "hermite-simpson", "segments": 5}]}),
    ("brachistochrone", {}),
    (BLOCK, {"mesh": [{"method": "radau", "degree": 3, "segments": 5}]}),
    (BLOCK, {"mesh": [{"method": "runge-kutta-4", "segments": 6, "substeps": 2}]}),
    (ALGEBRAIC, {}),
    (ALGEBRAIC, {"mesh": None, "refine": {"tolerance": 1e-6}}),
])  # fmt: skip
def test_read_gives_what_was_saved(folder, source, overrides):
    before = trajopt.solve(trajopt.load(source, overrides))
    assert before.save("a.h5") == folder.joinpath("a.h5").relative_to(folder)
    after = trajopt.read("a.h5")
    for name in ("solved", "status", "message", "remedy", "causes", "objective", "error"):
        assert repr(getattr(before, name)) == repr(getattr(after, name))  # nan is nan
    assert list(before) == list(after) and list(before.costate) == list(after.costate)
    first, last = before.time[[0, -1]]
    t = np.linspace(first, last, 101)
    for name, function in before.phases["main"].functions.items():
        assert after[name](t) == pytest.approx(function(t), abs=1e-10, rel=1e-10)
        assert after[name].unit == function.unit and after[name].kind == function.kind
    for name, function in before.costate.items():
        assert after.costate[name](t) == pytest.approx(function(t), abs=1e-8, rel=1e-8)
    for one, other in zip(before.meshes, after.meshes, strict=True):
        assert other.mesh.edges == pytest.approx(one.mesh.edges, abs=1e-14)
        assert other.mesh.schemes[0] is one.mesh.schemes[0]
        for name in vars(one).keys() - {"grids"}:
            own, stored = getattr(one, name), getattr(other, name)
            assert own == stored or str(own) == str(stored) == "nan", name
    assert repr(before) == repr(after)


def test_what_was_read_can_be_saved_and_solved_again(block, folder):
    block.save("a.h5")
    trajopt.read("a.h5").save("b.h5")
    assert (folder / "a.h5").read_bytes() == (folder / "b.h5").read_bytes()
    again = trajopt.solve(trajopt.read("a.h5").problem, guess=trajopt.read("b.h5"))
    assert again.objective == pytest.approx(block.objective, abs=1e-9)


def test_saving_loses_nothing(block, failed, folder):
    solved = trajopt.solve(trajopt.load("cartpole"))
    solved.save("cart.h5")
    kept = (folder / "cart.h5").read_bytes()
    with pytest.raises(trajopt.FileError, match=r"it holds a solution, and this result is none.*force=True"):
        failed.save("cart.h5")
    with pytest.raises(trajopt.FileError, match=r"another problem, 'cart-pole swing-up'; .* with force=True"):
        block.save("cart.h5")
    with pytest.raises(trajopt.FileError, match="its folder does not exist"):
        block.save("no/folder.h5")
    (folder / "notes.txt").write_text("mine")
    with pytest.raises(trajopt.FileError, match="no trajopt result"):
        block.save("notes.txt")
    assert (folder / "cart.h5").read_bytes() == kept and (folder / "notes.txt").read_text() == "mine"
    failed.save("cart.h5", force=True)
    solved.save("cart.h5")
    assert trajopt.read("cart.h5").solved


def test_the_command_line_reads_it(block, folder):
    block.save("a.h5")
    shown = subprocess.run(
        [sys.executable, "-m", "trajopt.cli.main", "show", "a.h5"], capture_output=True, text=True, check=True
    )
    assert "block: solved" in shown.stdout


# -- repr ------------------------------------------------------------------------------------------------------------


def test_repr_is_a_few_lines(block, failed):
    shown = [block, failed, block.problem, block.phases["main"], block["x"], block.costate, block.costate["x"]]
    for value in (*shown, *block.meshes, block.error, block.phases):
        assert len(repr(value)) < 1000 and len(repr(value).splitlines()) <= 6
    assert "block" in repr(block) and "solved" in repr(block) and "hermite-simpson" in repr(block)
    assert repr(block["x"]) == "<state x(t) in m, t = 0 to 1 s>"


def test_many_names_are_shortened():
    states = "\n".join(f"  state_{i}: {{rate: u, initial: 0}}" for i in range(300))
    text = (
        "trajopt: 1\nname: many\ntime: {initial: 0, final: 1}\ncontrols: {u: {}}\nstates:\n" + states + "\n"
        "objective: {minimize: {integral: (u - 1)**2}}\nmesh: [{method: trapezoid, segments: 2}]\n"
    )
    solution = trajopt.solve(trajopt.load(text))
    assert len(repr(solution)) < 1000
    with pytest.raises(KeyError) as caught:
        solution["control"]
    assert len(str(caught.value)) < 600


def test_the_example_of_help_runs():
    example = textwrap.dedent(trajopt.__doc__.split("\n\n")[1])
    scope = {}
    exec(example, scope)
    assert scope["solution"].solved
