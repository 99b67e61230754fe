"""`import trajopt` and `trajopt.load`: names, files, texts, overrides, and every mistake at its place."""

import subprocess
import sys

import numpy as np
import pytest

import trajopt
from trajopt.problems.catalog import shipped

from .python_problems import ALGEBRAIC, BLOCK

# -- importing -------------------------------------------------------------------------------------------------------


def modules_after(code):
    """What a fresh Python has imported after running the code."""
    told = subprocess.run(
        [sys.executable, "-c", f"{code}\nimport sys; print(*sys.modules)"], capture_output=True, text=True, check=True
    )
    return set(told.stdout.split())


def test_import_alone_loads_nothing_heavy():
    assert not modules_after("import trajopt; dir(trajopt)") & {"numpy", "pyomo", "cyipopt", "pydantic", "h5py"}
    assert not modules_after("import trajopt.cli.main") & {"numpy", "pyomo", "cyipopt", "pydantic", "typer"}


def test_every_name_is_there_and_no_other():
    assert dir(trajopt) == sorted(trajopt.__all__)
    assert all(getattr(trajopt, name).__doc__ for name in trajopt.__all__)
    with pytest.raises(AttributeError, match=r"no attribute 'sovle'; it has .*solve"):
        trajopt.sovle  # noqa: B018
    assert modules_after("from trajopt import SpecError, load") >= {"trajopt.results.python.problem"}


# -- loading ---------------------------------------------------------------------------------------------------------


def test_by_name_by_file_by_text(folder):
    (folder / "mine.yaml").write_text(BLOCK)
    loaded = [trajopt.load(source) for source in ("mine.yaml", folder / "mine.yaml", BLOCK)]
    assert {problem.name for problem in loaded} == {"block"}
    assert len({problem.spec.model_dump_json() for problem in loaded}) == 1
    assert trajopt.load("cartpole").name == trajopt.load(shipped()["cartpole"]).name == "cart-pole swing-up"
    assert trajopt.load(ALGEBRAIC).name == "text"


@pytest.mark.parametrize("overrides", [
    {"parameters.far": 0.5, "mesh.0.segments": 4},
    ["parameters.far=0.5", "mesh.*.segments=4"],
    {"parameters": {"m": 2, "far": np.float64(0.5)}, "mesh": ({"method": "hermite-simpson", "segments": np.int64(4)},)},
    {"states.x.final": np.array(0.5), "mesh.0.segments": np.array([1, 1.0, 1, 1])},
])  # fmt: skip
def test_overrides_are_values_or_texts(overrides):
    solution = trajopt.solve(trajopt.load(BLOCK, overrides))
    assert solution["x"](1.0) == pytest.approx(0.5, abs=1e-9)
    assert solution.meshes[-1].mesh.segments == 4


def test_one_override_may_be_one_text():
    assert trajopt.load(BLOCK, "parameters.far=0.5").spec.parameters["far"].value.constant() == 0.5


@pytest.mark.parametrize(
    "value", ["12", "1e5", "yes", "null", "", "a: b", "*x", "-", "quote \" and '", "two\nlines", "é"]
)
def test_a_text_stays_the_text_it_is(value):
    problem = trajopt.load(BLOCK, {"note": value, "states.x.note": value})
    assert problem.spec.note == problem.spec.states["x"].note == value


def test_none_takes_a_key_away():
    assert trajopt.load("cartpole", {"reference": None}).spec.reference is None
    assert trajopt.load("cartpole").spec.reference is not None


@pytest.mark.parametrize("value", [object(), {1, 2}, 1j, lambda t: t])
def test_a_value_that_no_file_can_hold(value):
    with pytest.raises(trajopt.SpecError, match=r"^override parameters.m: ") as caught:
        trajopt.load(BLOCK, {"parameters.m": value})
    assert len(caught.value.mistakes) == 1


def test_all_mistakes_at_once_and_at_their_places(folder):
    (folder / "mine.yaml").write_text(BLOCK.replace("rate: v", "rate: w").replace("lower: -100", "lower: no"))
    overrides = {"parameters.m": "2*", "mesh.0.segments": -1, "solver.max_itr": 3}
    with pytest.raises(trajopt.SpecError) as caught:
        trajopt.load("mine.yaml", overrides)
    told = str(caught.value).splitlines()
    assert [mistake.where for mistake in caught.value.mistakes] == [
        "mine.yaml:8: states.x.rate",
        "mine.yaml:10: controls.u.lower",
        "override parameters.m",
        "override mesh.0.segments",
        "override solver.max_itr",
    ]
    assert told == [str(mistake) for mistake in caught.value.mistakes]


@pytest.mark.parametrize("overrides, where", [
    ({"parameters.m": "2*"}, "override parameters.m"),  # over {value: ...}
    ({"parameters.m.unit": ["kg"]}, "override parameters.m.unit"),
    ({"time": {"initial": 0, "final": "1 +"}}, "override time"),  # over a section
    ({"mesh": [{"method": "no-such", "segments": 4}]}, "override mesh"),
    ({"mesh.0.method": "gauss", "mesh.0.degree": 0}, "override mesh.0.degree"),
    ({"parameters.n": 3}, "override parameters.n"),
    ({"a=b": 3}, "override a=b"),
    (["parameters.m"], "override parameters.m"),
])  # fmt: skip
def test_a_mistake_in_an_override_names_the_override(overrides, where):
    with pytest.raises(trajopt.SpecError) as caught:
        trajopt.load(BLOCK, overrides)
    assert [mistake.where for mistake in caught.value.mistakes] == [where]


def test_what_an_override_leaves_is_told_with_its_line():
    with pytest.raises(trajopt.SpecError, match=r"^text:5: parameters.m.unit: "):
        trajopt.load(BLOCK.replace("unit: kg", "unit: [kg]"), {"parameters.m": 3})


def test_what_only_the_methods_know_is_told_when_loading():
    with pytest.raises(trajopt.SpecError, match=r"finite-difference|second"):
        trajopt.load(BLOCK, {"mesh.0.method": "finite-difference"})


def test_files_that_are_none(folder):
    with pytest.raises(trajopt.FileError, match="did you mean cartpole"):
        trajopt.load("cartpol")
    with pytest.raises(trajopt.FileError, match="folder"):
        trajopt.load(folder)
    (folder / "text.h5").write_text("no")
    for name in ("text.h5", "none.h5"):
        with pytest.raises(trajopt.FileError, match=f"^{name}: .*a file that a solution was saved to$") as caught:
            trajopt.read(name)
    assert issubclass(trajopt.FileError, trajopt.TrajoptError) and caught.value.mistakes


@pytest.mark.parametrize("line", ["x" * 300, "name: " + "x" * 5000])
def test_a_line_that_no_file_can_be_called(line):
    with pytest.raises(trajopt.FileError, match=r"cannot be the name of a file .* has a line break in it$"):
        trajopt.load(line)


def test_no_message_speaks_of_the_command_line(folder):
    for overrides in ({"solver.linear_solver": "ma57"}, {"solver.option_file_name": "x"}):
        with pytest.raises(trajopt.SpecError) as caught:
            trajopt.load(BLOCK, overrides)
        assert "--" not in str(caught.value) and "override" in str(caught.value)
    with pytest.raises(trajopt.SpecError, match=r'override: \{"solver.hsllib": ...\}'):
        trajopt.load(BLOCK + "solver: {hsllib: x.so}\n")
