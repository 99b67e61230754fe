"""What a notebook shows of a spec, a problem, and all that a solve gives: a few lines, whatever they hold."""

from dataclasses import fields, is_dataclass

import pytest
from named import share

import trajopt
from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load, load_text
from trajopt.results.file.read import read
from trajopt.results.file.reload import reload
from trajopt.transcription.refinement.refine import refine
from trajopt.transcription.settings import settings_of, steps
from trajopt.transcription.solve import solve

FILES = shipped()


@pytest.mark.parametrize("name", share([*FILES], 3))
def test_a_few_lines_with_the_names_of_the_problem(name):
    spec = load(FILES[name])
    problem = build(spec)
    for shown in (repr(spec), str(spec), repr(problem), str(problem), *map(repr, problem.phases)):
        assert len(shown.splitlines()) <= 5
        assert max(map(len, shown.splitlines())) < 400
    assert spec.name in repr(spec) and spec.mesh[0].method in repr(spec)
    first = (problem.phases[0].states or problem.parameters)[0]
    assert problem.name in repr(problem) and first.name in repr(problem)


def test_a_thousand_names_and_a_long_name_are_shortened():
    states = "\n".join(f"  state_{i}: {{rate: u, initial: 0}}" for i in range(500))
    name = "a long name " * 500
    spec = load_text(
        f"trajopt: 1\nname: {name}\ntime: {{initial: 0, final: 1}}\ncontrols: {{u: {{}}}}\nstates:\n{states}\n"
        "objective: {minimize: {integral: u**2}}\nmesh: [{method: radau, segments: [1, 2, 3]}]\n",
        "many.yaml",
    )
    for shown in (repr(spec), repr(build(spec))):
        assert len(shown) < 1000
    assert "radau 3" in repr(spec)


def within(value, seen, depth=0):
    """Every object of trajopt that a value holds, once."""
    if is_dataclass(value) or isinstance(value, tuple):
        inner = [getattr(value, f.name) for f in fields(value)] if is_dataclass(value) else value[:5]
    else:
        inner = list(value.values())[:5] if isinstance(value, dict) else value[:5] if isinstance(value, list) else []
    if "trajopt" in type(value).__module__ and not type(value).__module__.endswith(".tree"):
        seen[id(value)] = value
    for part in inner if depth < 8 else ():
        within(part, seen, depth + 1)
    return seen


@pytest.mark.parametrize("mesh", [
    {"method": "hermite-simpson", "segments": 200}, {"method": "radau", "degree": 40, "segments": 2},
    {"method": "runge-kutta-4", "segments": 40},
])  # fmt: skip
def test_everything_that_a_solve_gives_is_a_few_lines(mesh, folder):
    loaded = trajopt.load("cartpole", {"mesh": [mesh]})
    schedule, settings = steps(loaded.spec.mesh), settings_of(loaded.spec)
    solution = solve(list(loaded.stages), schedule, settings)
    trajopt.solve(loaded).save("a.h5")
    (trajectory,), (error,) = solution.trajectories, solution.errors
    finer = refine(trajectory, error, tolerance=1e-12, merge=True)
    path = folder / "a.h5"
    roots = (solution, schedule, settings, reload(path), read(path), trajectory.dense, trajectory.mesh.groups, finer)
    seen = within(roots, {}).values()
    kinds = {type(value).__name__ for value in seen}
    assert kinds >= {"Solution", "Trajectory", "Mesh", "MeshRecord", "Outcome", "ErrorProfile", "Layout", "Result"}
    long = {type(value).__name__ for value in seen if len(repr(value)) > 600 or len(repr(value).splitlines()) > 6}
    assert not long
    count = mesh["segments"]
    assert repr(trajectory.mesh) == f"<Mesh schemes={count} of {mesh['method']}, widths=array({count})>"
