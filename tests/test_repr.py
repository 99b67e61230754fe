"""What a notebook shows of a spec and of a problem: a few lines, whatever the file holds."""

import pytest

from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load, load_text

FILES = shipped()


@pytest.mark.parametrize("name", FILES)
def test_a_few_lines_with_the_names_of_the_problem(name):
    spec = load(FILES[name])
    problem = build(spec)
    for shown in (repr(spec), str(spec), repr(problem), str(problem), repr(problem.phases)):
        assert len(shown.splitlines()) <= 5
        assert max(map(len, shown.splitlines())) < 400
    assert spec.name in repr(spec) and spec.mesh[0].method in repr(spec)
    assert problem.name in repr(problem) and problem.phases[0].states[0].name in repr(problem)


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
