"""The result file: its layout, its scales and units, other tools."""

import json
import re
import warnings
from dataclasses import replace
from itertools import takewhile
from textwrap import dedent

import h5py
import numpy as np
import pytest
from exact import fixed, growth
from lazily import lazily
from repository import ROOT
from stored import save, solved

from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load
from trajopt.problems.problem import Guess, Phase, Problem
from trajopt.problems.quantities import Constraint, State, Variable
from trajopt.results.file import write as store
from trajopt.results.file.guess import guess_from
from trajopt.results.file.summary import summarize
from trajopt.results.file.write import write
from trajopt.transcription.engines.outcome import COLUMNS
from trajopt.transcription.settings import Step, settings_of, steps
from trajopt.transcription.solve import solve

xarray = lazily("xarray")

PARTS = ["build", "differentiate", "compile", "assemble", "evaluate", "linear_algebra", "error", "elsewhere"]


def members(file: h5py.File) -> list[str]:
    names = []
    file.visit(names.append)
    return sorted(names)


def curves(where: str, *kinds: str) -> list[str]:
    states, controls = ["x", "y", "vx", "vy"], []
    own = {"state": states, "costate": states, "epsilon": states, "control": controls}
    own |= {"algebraic": [], "output": [], "path": []}
    return [where, *(f"{where}/{kind}" for kind in kinds), *(f"{where}/{k}/{n}" for k in kinds for n in own[k])]


LAYOUT = [
    "spec", "spec/text", "spec/full", "spec/parameter", *(f"spec/parameter/{name}" for name in ("g", "h", "s")),
    "phase", "phase/main", "phase/main/knot", "phase/main/knots",
    *curves("phase/main/points", "state", "control", "algebraic", "output", "path", "costate"),
    "phase/main/points/time",
    *curves("phase/main/dense", "state", "control", "algebraic", "output", "path", "costate", "epsilon"),
    "phase/main/dense/time",
    "phase/main/error", "phase/main/error/eta", "phase/main/error/segment", "phase/main/error/state",
    "phase/main/error/relative", "phase/main/error/excess",
    "phase/main/complementarity", "phase/main/parameter", "phase/main/parameter/angle",
    "mesh", "mesh/0", "mesh/0/edges",
    "solver", "solver/z", "solver/z_lower", "solver/z_upper", "solver/y", "solver/unknown", "solver/constraint",
    "sensitivity", *(f"sensitivity/{name}" for name in ("number", "value", "derivative", "unit", "note")),
    "solver/iterations", "solver/iterations/number", *(f"solver/iterations/{column}" for column in COLUMNS),
]  # fmt: skip


RUNS = {"solved": {}, "two": {"max_iter": 2}, "one": {"max_wall_time": 1e-6}, "none": {"linear_solver": "ma27"}}
"""Options that end a run after so many iterations."""


@pytest.mark.parametrize("options", RUNS.values(), ids=RUNS)
def test_layout_of_a_solved_and_of_a_failed_run(tmp_path, options):
    with h5py.File(save(tmp_path / "a.h5", **options)) as file:
        named = ("throw forwards", "throw upwards", "bounds of angle")
        priced = ["phase/main/price", *(f"phase/main/price/{name}" for name in named)]
        only_solved = ["phase/main/error/objective", *priced] * (not options)
        assert members(file) == sorted(LAYOUT + only_solved)
        assert bool(file.attrs["solved"]) is not bool(options)
        assert np.isfinite(file["phase/main/points/state/x"][:]).all()


def drawn(text: str) -> list[str]:
    """The lines that draw the layout, in the docstring or in docs/result_file.md."""
    lines = dedent(text).split("\n")
    first = next(k for k, line in enumerate(lines) if re.match(r" *//? +attributes", line))
    return dedent("\n".join(takewhile(lambda line: line.strip(" `"), lines[first:]))).split("\n")


def test_the_docstring_names_every_group():
    groups = {name.rsplit("/", 1)[-1] for name in LAYOUT if not name.endswith(("angle", "/x", "/y", "/vx", "/vy"))}
    columns = {*COLUMNS, "unknown", "constraint", "main", "0", "g", "h", "s"}  # named by what they stand for
    for name in groups - columns:
        assert re.search(rf"\b{name}\b", store.__doc__), name


def test_the_documentation_draws_the_same():
    document = ROOT / "docs" / "result_file.md"
    assert drawn(document.read_text()) == drawn(store.__doc__)


def documented_attributes() -> dict[str, list[str]]:
    """Group -> the attributes that the docstring names; what stands for many of them is replaced by examples."""
    text = re.sub(r"\([^)]*\)", "", "\n".join(drawn(store.__doc__)))
    found = re.findall(r"^(/\S*) (?:.|\n )*?attributes?: ((?:[^;\n]|\n )*)", text, flags=re.MULTILINE)
    spelt = {"seconds_<part>": [f"seconds_{part}" for part in PARTS[:-1]], "every option": ["tol"]}
    split = {group: re.split(r"\s*,\s+|\s+and\s+", names.strip()) for group, names in found}
    return {group: [name for entry in names for name in spelt.get(entry, [entry])] for group, names in split.items()}


@pytest.mark.parametrize("engine", ["ipopt", "newton"])
def test_every_attribute_of_the_docstring_is_there(tmp_path, engine):
    spec = load(shipped()["pendulum"], [f"solver.engine={engine}"])
    solution = solve(build(spec), steps(spec.mesh), settings_of(spec))
    write(tmp_path / "a.h5", solution, spec.text, spec.model_dump_json(), "")
    with h5py.File(tmp_path / "a.h5") as file:
        assert file["solver"].attrs["engine"] == engine
        assert documented_attributes().keys() == {"/", "/spec/", "/mesh/<k>/", "/solver/", "/sensitivity/"}
        for group, names in documented_attributes().items():
            assert not set(names) - set(file[group.replace("<k>", "0")].attrs), group


def test_lists_of_texts_are_texts_also_when_empty(tmp_path):
    empty, full = save(tmp_path / "a.h5"), tmp_path / "b.h5"
    spec, solution = solved("shot_put")
    told = replace(solution, violations=("x",), unmet=("segment 1",))
    write(full, told, spec.text, spec.model_dump_json(), "", {"time.final": 2.5})
    for path, count in ((empty, 0), (full, 1)):
        with h5py.File(path) as file:
            for group, name in (("solver", "violations"), ("solver", "unmet"), ("spec", "overrides")):
                assert h5py.check_string_dtype(file[group].attrs.get_id(name).dtype), name
                assert len(file[group].attrs[name]) == count


def test_the_degrees_of_a_method_with_a_choice_are_kept_over_its_segments(tmp_path):
    spec = load(shipped()["shot_put"], ["mesh=[{method: gauss, segments: 3, degree: 2}]"])
    solution = solve(build(spec), steps(spec.mesh))
    write(tmp_path / "a.h5", solution, spec.text, spec.model_dump_json(), "")
    with h5py.File(tmp_path / "a.h5") as file:
        mesh = file["mesh/0"]
        assert set(mesh) == {"edges", "segment", "degree", "differential"}
        assert mesh["degree"].dims[0][0] == mesh["segment"]
        assert mesh["degree"][:].tolist() == [2, 2, 2]


def test_every_array_has_a_scale_for_each_dimension_and_says_what_it_is(tmp_path):
    def look(name, item):
        if not isinstance(item, h5py.Dataset) or name.startswith("spec/"):
            return
        assert item.attrs["long_name"], name
        if not item.is_scale:
            assert [len(dimension) for dimension in item.dims] == [1] * item.ndim, name
            assert [dimension[0].size for dimension in item.dims] == list(item.shape), name

    with h5py.File(save(tmp_path / "a.h5")) as file:
        file.visititems(look)


def test_units(tmp_path):
    with h5py.File(save(tmp_path / "a.h5")) as file:
        main = file["phase/main"]
        names = ("points/time", "dense/time", "knots", "points/state/x", "dense/state/vy", "dense/epsilon/vy")
        assert [main[name].attrs["units"] for name in names] == ["s", "s", "s", "m", "m/s", "m/s/s"]
        assert main["parameter/angle"].attrs["units"] == "rad"
        assert "units" not in main["points/costate/x"].attrs  # the objective has none
    with h5py.File(save(tmp_path / "b.h5", "cartpole")) as file:
        assert file["phase/main/points/control/u"].attrs["units"] == "N"


def test_values(tmp_path):
    spec, solution = solved("cartpole")
    (trajectory,), (error,) = solution.trajectories, solution.errors
    with h5py.File(save(tmp_path / "a.h5", "cartpole")) as file:
        main = file["phase/main"]
        np.testing.assert_array_equal(main["points/time"], trajectory.times)
        np.testing.assert_array_equal([main[f"points/state/{s}"][:] for s in spec.states], trajectory.x)
        np.testing.assert_array_equal(main["points/control/u"], trajectory.u[0])
        np.testing.assert_array_equal(main["dense/costate/q2"], trajectory.dense.costate[1])
        np.testing.assert_array_equal(main["dense/epsilon/v2"], error.epsilon[3])
        np.testing.assert_array_equal(main["error/eta"], error.eta.T)
        np.testing.assert_array_equal(file["solver/y"], solution.outcome.y)
        assert file.attrs["objective"] == solution.objective
        assert file["mesh/0"].attrs["max_eta"] == solution.max_eta


def test_segments_are_indices_in_the_file_and_count_from_one_in_the_summary(tmp_path):
    with h5py.File(save(tmp_path / "a.h5", "cartpole")) as file:
        error = file["phase/main/error"]
        worst, state = np.unravel_index(np.argmax(error["eta"]), error["eta"].shape)
        assert error["segment"][:].tolist() == list(range(25))
        start = file["phase/main/knots"][worst]
    told = summarize(tmp_path / "a.h5")["error"]
    assert (told["segment"], told["start"], told["state"]) == (worst + 1, start, ["q1", "q2", "v1", "v2"][state])


def test_the_problem_file_is_kept_to_the_letter(tmp_path):
    with h5py.File(save(tmp_path / "a.h5", "cartpole")) as file:
        assert file["spec/text"].asstr()[()].encode() == shipped()["cartpole"].read_bytes()
        full = json.loads(file["spec/full"].asstr()[()])
        assert full["mesh"][0].items() >= {"method": "hermite-simpson", "segments": 25, "tolerance": 1e-8}.items()
        assert full["states"]["q1"]["unit"] == "m"


def test_order_is_that_of_the_problem_file_and_of_the_work(tmp_path):
    with h5py.File(save(tmp_path / "a.h5")) as file:
        assert list(file["phase/main/points/state"]) == ["x", "y", "vx", "vy"]
        attributes = [name for name in file["solver"].attrs if name.startswith("seconds_")]
        assert attributes == [f"seconds_{part}" for part in PARTS]
    summary = summarize(tmp_path / "a.h5")
    assert list(summary["seconds"]) == [*PARTS, "total"]
    assert list(summary["phases"]["main"]["states"]) == ["x", "y", "vx", "vy"]
    assert summary["seconds"]["total"] == pytest.approx(sum(summary["seconds"][part] for part in PARTS))


@pytest.mark.parametrize("name", ["cartpole", "shot_put", "brachistochrone"])
def test_xarray_sees_named_coordinates(tmp_path, name):
    path = save(tmp_path / "a.h5", name)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        tree = xarray.open_datatree(path)
    with tree:
        for where in ("points", "dense"):
            for kind in ("state", "costate", "control"):
                for curve in tree[f"phase/main/{where}/{kind}"].dataset.data_vars.values():
                    assert curve.dims == ("time",)
                    assert curve["time"].attrs["units"] == "s"
        eta = tree["phase/main/error"]["eta"]
        assert eta.dims == ("segment", "state")
        assert eta["state"].values.tolist() == list(load(shipped()[name]).states)
        state = tree["phase/main/dense/state"].to_dataset()
        assert float(state.interp(time=state.time[-1]).to_array()[0]) == pytest.approx(float(state.to_array()[0, -1]))
        assert tree["solver/iterations"]["objective"].dims == ("number",)
        assert tree.attrs["format"] == store.FORMAT


def test_a_single_group_opens_too(tmp_path):
    with xarray.open_dataset(save(tmp_path / "a.h5"), group="phase/main/points") as points:
        assert points.time.attrs["long_name"] == "time"


def algebraic_problem() -> Problem:
    """dx/dt = z with 0 = z - u: an acceleration, say, that an implicit equation gives."""
    guess = Guess(0.0, 1.0, np.array([0.0, 1.0]), {"x": np.arange(2.0), "u": np.zeros(2), "z": np.zeros(2)})
    phase = Phase(
        "main", fixed(0), fixed(1), (State("x", "m", rate=lambda v, m: v["z"], initial=fixed(0), final=fixed(1)),),
        (Variable("u", "N"),), guess, algebraic=(Variable("z", "m/s"),),
        residuals=(Constraint("balance", lambda v, m: v["z"] - v["u"], fixed(0)),),
        lagrange=lambda v, m: v["u"] ** 2,
    )  # fmt: skip
    return Problem("algebraic", 1, (phase,))


def test_algebraic_variables_have_their_own_place(tmp_path):
    solution = solve(algebraic_problem(), [Step("hermite-simpson", 5, 1e-8)])
    write(tmp_path / "a.h5", solution, "", json.dumps({}), "")
    with h5py.File(tmp_path / "a.h5") as file:
        assert list(file["phase/main/points/control"]) == ["u"]
        np.testing.assert_allclose(file["phase/main/dense/algebraic/z"], 1, atol=1e-6)
        assert file["phase/main/dense/algebraic/z"].attrs["units"] == "m/s"
    assert summarize(tmp_path / "a.h5")["phases"]["main"]["algebraic"]["z"]["final"] == pytest.approx(1)
    (guess,) = guess_from(tmp_path / "a.h5", algebraic_problem())
    np.testing.assert_allclose(guess.values["z"], 1, atol=1e-6)


def test_maximised_objective_and_costates_as_written(tmp_path):
    for sense, name in ((1, "minimize"), (-1, "maximize")):
        solution = solve(growth(sense), [Step("hermite-simpson", 20, 1e-8)])
        write(tmp_path / "a.h5", solution, "", json.dumps({}), "")
        with h5py.File(tmp_path / "a.h5") as file:
            assert file.attrs["sense"] == name
            assert np.sign(file.attrs["objective"]) == sense
            assert np.sign(file["phase/main/dense/costate/x"][0]) == sense


def test_numbers_without_a_value_are_null_in_json(tmp_path):
    _, solution = solved("shot_put")
    (trajectory,) = solution.trajectories
    broken = replace(solution, objective=np.nan, trajectories=(replace(trajectory, u=trajectory.u * np.inf),))
    write(tmp_path / "a.h5", broken, "", json.dumps({}), "")
    text = json.dumps(summarize(tmp_path / "a.h5"), allow_nan=False)
    assert json.loads(text)["objective"] is None
