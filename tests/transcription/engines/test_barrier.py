"""What the engine's barrier leaves of the objective: digits of optima that are known exactly, on the default meshes."""

import numpy as np
import pytest
from command_line import trajopt

from trajopt.problems.build import build
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load_text
from trajopt.transcription.settings import settings_of, steps
from trajopt.transcription.solve import solve

HEAD = "trajopt: 1\nname: barrier\n"
POINT_MASS = (
    HEAD
    + """\
time: {initial: 0, final: {lower: 0, upper: 10, guess: 1}}
states: {x: {rate: v, initial: 0, final: d}, v: {rate: u, initial: 0, final: 0}}
controls: {u: {lower: -a, upper: a}}
objective: {minimize: {terminal: "t[final]"}}
parameters: {d: 1, a: 1}
"""
)
SINGULAR = (
    HEAD
    + """\
time: {initial: 0, final: pi/2}
states: {x: {rate: y, initial: 0}, y: {rate: u, initial: 1}}
controls: {u: {lower: -1, upper: 1}}
objective: {minimize: {integral: (y**2 - x**2)/2}}
"""
)
RAMP = (
    HEAD
    + """\
time: {initial: 0, final: 2}
states: {x: {rate: u, initial: 0}}
controls: {u: {lower: 0, upper: 1}}
objective: {minimize: {integral: (x - 0.25)**2 + u**2}}
constraints: {path: [{name: low, expression: x + u, upper: 0.3}]}
"""
)

EXACT = {  # the time to go a distance d with |u| <= a is 2 sqrt(d/a)
    "a unit mass": (POINT_MASS, 2.0),
    "a strong mass": (POINT_MASS.replace("a: 1}", "a: 20}"), 2 / np.sqrt(20)),
    "a long way": (POINT_MASS.replace("d: 1,", "d: 16,"), 8.0),
    "a totally singular control": (SINGULAR, 0.0),
}


def solved(text: str, **options):
    spec = load_text(text, "x.yaml")
    settings = settings_of(spec)
    settings = type(settings)(**{**vars(settings), "options": {**settings.options, **options}})
    return solve(build(spec), steps(spec.mesh), settings)


@pytest.mark.parametrize("case", EXACT)
def test_the_barrier_takes_no_digits(case):
    text, exact = EXACT[case]
    solution = solved(text)
    assert solution.status.name == "SOLVED"
    assert solution.objective == pytest.approx(exact, rel=5e-9, abs=5e-9)
    assert abs(solution.objective - exact) <= solution.objective_error.bar


def test_what_a_smaller_barrier_gains():
    """With the engine's own end, which an option of the user's asks for, the same mesh is worse by the gap."""
    text, exact = EXACT["a strong mass"]
    own, tight = solved(text, compl_inf_tol=1e-4), solved(text)
    assert abs(tight.objective - exact) < 0.1 * abs(own.objective - exact)
    assert own.objective_error.gap > 10 * tight.objective_error.gap
    assert len(own.meshes) == len(tight.meshes)
    assert own.meshes[-1].iterations < tight.meshes[-1].iterations <= own.meshes[-1].iterations + 10


def test_a_path_constraint_that_acts_over_time():
    own, tight = solved(RAMP, compl_inf_tol=1e-4), solved(RAMP)
    finest = solved(RAMP, compl_inf_tol=1e-11)
    assert abs(tight.objective - finest.objective) < abs(own.objective - finest.objective)


TOLERANCE = (
    HEAD
    + """\
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: 0, final: 1}}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
solver: {tol: 1.0e-10}
"""
)


def test_the_solvers_tolerance_of_a_file_without_a_mesh():
    assert [entry.tolerance for entry in load_text(TOLERANCE, "x.yaml").mesh] == [1e-10]
    given = load_text(TOLERANCE, "x.yaml", ["solver.tol=1e-9"])
    assert [entry.tolerance for entry in given.mesh] == [1e-9]
    assert "tol" not in given.solver.options


@pytest.mark.parametrize("wrong", ["soon", "0", "-1.0e-8", "true", "2"])
def test_a_wrong_tolerance_is_told_at_its_place(wrong):
    with pytest.raises(SpecError, match=r"x\.yaml:7: solver\.tol: the tolerance of the solver is .*; write a number"):
        load_text(TOLERANCE.replace("1.0e-10", wrong), "x.yaml")


def test_a_file_with_a_mesh_has_its_tolerance_there(tmp_path):
    (tmp_path / "x.yaml").write_text(TOLERANCE + "mesh: [{method: trapezoid, segments: 5}]\n")
    run = trajopt("check", tmp_path / "x.yaml")
    assert run.exit_code == 2 and "write it as tolerance: in each entry of mesh:" in run.stderr
