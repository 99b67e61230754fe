"""Solutions solved again in phases by their arcs: exact where they are known, and kept only where they are better."""

from dataclasses import replace

import numpy as np
import pytest
from command_line import trajopt
from named import ALL

from trajopt.problems.phases.split import PhasePart, why_not
from trajopt.problems.phases.split_each import split
from trajopt.problems.quantities import Range
from trajopt.results.file.write import write
from trajopt.results.polish.polish import MOST_ITERATIONS, REFINED, TOLERANCE, Polished, _in_phases, polish
from trajopt.results.polish.signs import worth_of_leaving
from trajopt.results.verify import verify
from trajopt.transcription.arcs import LOWER, UPPER
from trajopt.transcription.loading import load_file, load_yaml

from .harvest import STOCK
from .polished import first, limited_energy

REST = """\
trajopt: 1
name: rest to rest
time: {initial: 0, final: {lower: 0.1, upper: 20, guess: 3}}
states: {x: {rate: v, initial: 0, final: 1}, v: {rate: u, initial: 0, final: 0}}
controls: {u: {lower: -1, upper: 2}}
objective: {minimize: {terminal: "t[final]"}}
"""
ONE = REST.replace("upper: 2}", "upper: 1}")
POWER = ONE + 'constraints: {path: [{name: power, expression: "u*v", upper: 0.5}]}\n'
ENERGY = ONE + 'constraints: {integral: [{name: energy, expression: "u**2", upper: 1.8}]}\n'
JERK = """\
trajopt: 1
name: minimum-time move with bounded jerk
parameters: {d: 4}
time: {initial: 0, final: {lower: 0.1, upper: 10, guess: 4}}
states:
  x: {rate: v, initial: 0, final: d}
  v: {rate: a, lower: -2, upper: 2, initial: 0, final: 0}
  a: {rate: j, lower: -4, upper: 4, initial: 0, final: 0}
controls: {j: {lower: -40, upper: 40}}
objective: {minimize: {terminal: "t[final]"}}
mesh: [{method: radau, segments: 60, degree: 4}]
"""
RUN_DOWN = 2 / 3**0.5 * np.arctan(0.6 / 3**0.5)  # the time of the greatest harvest, from n = 1/2 to 0.2


def limited_power():
    """u = 1 until v = 1/2, u v = 1/2 until v = w, then u = -1."""
    (w,) = [root.real for root in np.roots([2 / 3, 1 / 2, 0, 1 / 24 - 1]) if abs(root.imag) < 1e-12 and root.real > 0]
    return 0.25 + w**2 + w


@pytest.fixture(scope="module")
def one():
    """The double integrator with |u| <= 1."""
    return first(ONE)


EXACT = [
    ("double_integrator_min_time", 2, 2, 1e-10),
    (REST, 3**0.5, 2, 1e-10),
    (JERK, 2.6, 7, 1e-10),
    (STOCK, 0.25 * (10 - RUN_DOWN - np.log(4)) + RUN_DOWN, 3, 1e-9),
    (POWER, limited_power(), 3, 2e-7),
    ("bryson_denham", 4, 3, 1e-9),
]
if ALL:  # else within phases, in test_polish_phases.py
    EXACT.append((ENERGY, limited_energy(), 3, 1e-8))


@pytest.mark.parametrize(("text", "exact", "phases", "within"), EXACT)
def test_problems_with_arcs_become_exact(text, exact, phases, within, tmp_path):
    own = first(text)
    new = polish(own.spec, own.solution)
    solution = new.solution
    assert f"polished in {phases} phases" in solution.notes[-1] and len(solution.trajectories) == phases
    assert solution.objective == pytest.approx(exact, abs=within)
    assert abs(solution.objective - exact) <= solution.objective_error.bar < own.solution.objective_error.bar
    assert len(solution.arcs) == phases and not solution.inaccurate
    path = tmp_path / "polished.h5"
    write(path, solution, new.spec.text, new.spec.model_dump_json(), "", new.spec.overrides)
    assert all(check.passed for check in verify(path, anew=False))


WHY_NOT = [
    ("enzyme_progress_curves", "measurements"),
    ("goddard_three_phases", ""),
    ("overhead_crane", ""),
    (
        ONE.replace("objective", "integrals: {work: u**2}\nobjective").replace("rate: u,", "rate: u - 0.1*work,"),
        "an integral so far",
    ),
    ("hyperbola", "no continuous time"),
    ("discrete_move", "no continuous time"),
    ("biped", ""),
    (ONE + "complementarity: [{a: x, b: 1 - u}]\n", "complementarity"),
    ("block_move_min_work", ""),
    ("delayed_system", "states at earlier times"),
    ("gas_oil_cracking", "measurements"),
    ("warming_motor", r"t[initial], t[final] or t[duration]"),
    ("goddard", ""),
]


@pytest.mark.parametrize(("name", "why"), WHY_NOT)
def test_what_cannot_be_split_is_told_in_one_sentence(name, why):
    told = why_not(load_yaml(name) if "\n" in name else load_file(name))
    assert why in told and bool(told) == bool(why)


def test_without_a_switch_the_solution_stays_as_it_is():
    own = first("block_move_min_force")
    kept = polish(own.spec, own.solution)
    assert kept.solution.notes == ("not polished: it has no switch",)
    assert kept.solution.objective == own.solution.objective and kept.spec is own.spec


def test_a_failed_solve_is_not_polished(one):
    failed = replace(one.solution, status=type(one.solution.status).MAX_ITERATIONS)
    assert polish(one.spec, failed).solution is failed


def test_an_interrupted_polish_keeps_the_first_solution(one):
    kept = polish(one.spec, one.solution, stop=lambda: True).solution
    assert "not polished: in 2 phases it is not solved" in kept.notes[-1]
    assert kept.trajectories is one.solution.trajectories


def test_the_time_limit_is_that_of_both_solves(one):
    spent = sum(sum(record.seconds.values()) for record in one.solution.meshes)
    spec = load_yaml(ONE, [f"solver.seconds={spent}"])
    assert "not polished: in 2 phases it is not solved" in polish(spec, one.solution).solution.notes[-1]


def test_arcs_that_shrink_to_nothing_are_left_out(one):
    parts = [
        PhasePart(0.5, {"u": UPPER}),
        PhasePart(1.0, {"u": LOWER}),
        PhasePart(1.5, {"u": UPPER}),
        PhasePart(2.0, {"u": LOWER}),
    ]
    found = _in_phases(one, [parts], None, None)
    assert len(found.solution.trajectories) == 2 and found.solution.objective == pytest.approx(2, abs=1e-10)


WRONG = [
    ([PhasePart(0.5, {"u": UPPER}), PhasePart(2.0, {"u": UPPER})], "it is not solved"),
    ([PhasePart(1.2, {"u": UPPER}, {"x": UPPER}), PhasePart(2.0, {"u": LOWER})], "in 2 phases"),
]


@pytest.mark.parametrize(("parts", "why"), WRONG)
def test_a_structure_that_cannot_be_is_told(one, parts, why):
    bounded = Polished(one.solution, load_yaml(ONE.replace("x: {rate: v,", "x: {rate: v, upper: 3,")))
    assert why in _in_phases(bounded, [parts], None, None)


def test_a_control_that_should_not_be_on_its_bound_is_found():
    """With u <= 1/2 solved as if that were the bound of a control that may be 1: it is worth more than nothing."""
    tight = first(ONE.replace("upper: 1}", "upper: 0.5}"))
    trajectory = tight.solution.trajectories[0]
    assert worth_of_leaving(trajectory, {"u": UPPER}, {"u": Range(-1, 1)}, 1) > 0.1
    assert worth_of_leaving(replace(trajectory, costate=None), {"u": UPPER}, {"u": Range(-1, 1)}, 1) == np.inf


def test_polish_is_dropped_where_a_fixed_control_should_leave_its_bound():
    """Nothing and then all is worse than what is best; with a bar so wide, the sign alone tells."""
    own = first(STOCK)
    wide = replace(own.solution, objective_error=replace(own.solution.objective_error, bar=10.0))
    parts = [PhasePart(9.6, {"h": LOWER}), PhasePart(10.0, {"h": UPPER})]
    assert "h should not be on its bound" in _in_phases(Polished(wide, own.spec), [parts], None, None)


def test_phases_of_a_file_say_what_is_fixed_held_and_freed():
    spec = load_yaml(
        JERK.replace("mesh:", 'constraints: {path: [{expression: x, upper: 5}, {expression: "a*v", lower: -9}]}\nmesh:')
    )
    parts = [
        PhasePart(0.1, {"j": UPPER}, freed={"a": (LOWER, -9.0)}),
        PhasePart(0.5, held={"a": UPPER, "x": UPPER}),
        PhasePart(0.7, held={"a_v": LOWER}),
        PhasePart(2.6),
    ]
    again = load_yaml(split(spec, {"main": parts}, TOLERANCE, REFINED))
    one, two, three, _ = again.phases.values()
    assert one.controls["j"].lower.text == one.controls["j"].upper.text == "40"
    assert one.states["a"].lower.text == "-9.0" and len(one.constraints.path) == 2
    assert two.states["a"].upper.text == two.states["a"].lower.text == "4"
    assert two.states["x"].lower.text == "5" and [own.name for own in two.constraints.path] == ["a_v"]
    assert [own.expression.text for own in two.constraints.boundary] == ["v[initial]", "a[initial]"]
    assert three.constraints.path[1].equals.text == "-9" and three.constraints.path[1].lower is None


def test_the_command_writes_phases_and_tells_the_structure(folder):
    done = trajopt("solve", "double_integrator_min_time", "--polish", "-o", "a.h5")
    assert done.exit_code == 0 and "objective   2.000000000 +- " in done.stdout
    assert "arcs        u: max until 1, then min\n" in done.stdout and "polished in 2 phases; before, 2" in done.stdout
    shown = trajopt("show", "a.h5")
    assert "phase arc2: t = 1 to 2 s" in shown.stdout
    again = trajopt(
        "solve", "double_integrator_min_time", "--set", "parameters.d=9", "--polish", "-o", "a.h5", "--json"
    )
    assert (
        again.exit_code == 0
        and '"overrides": {"parameters.d": 9' in again.stdout
        and '"reference": null' in again.stdout
    )


def test_what_is_not_polished_is_written_all_the_same(folder):
    done = trajopt("solve", "block_move_min_force", "--polish", "-o", "b.h5")
    assert done.exit_code == 0 and "note        not polished: it has no switch" in done.stdout


@pytest.mark.parametrize(("solver", "most"), [("", MOST_ITERATIONS), ("solver: {max_iter: 60}\n", 60)])
def test_a_mesh_in_phases_has_a_limit_of_iterations(solver, most):
    """The file's own stands where it is less."""
    own = first(REST + solver)
    new = polish(own.spec, own.solution)
    assert len(new.solution.trajectories) == 2
    assert new.spec.solver.options["max_iter"] == most


def test_phases_that_would_take_more_iterations_are_told():
    own = first("bryson_denham", "solver.max_iter=30")
    assert own.solution.solved
    few = replace(own, spec=load_file("bryson_denham", ["solver.max_iter=2"]))
    new = polish(few.spec, few.solution)
    assert new.solution.notes[-1].startswith("not polished: in 3 phases it is not solved (ran out of iterations")
    assert new.solution.objective == own.solution.objective
