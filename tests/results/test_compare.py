"""Results side by side."""

import json
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import solved_once, strict_json, trajopt
from stored import save_not_finite

from trajopt.problems.errors import SpecError
from trajopt.results.compare import _distance, compare, differences
from trajopt.results.file.read import Curve, PhaseCurves


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("compare")
    runs = {
        "fine.h5": ["cartpole", "--segments", "100"],
        "same.h5": ["cartpole", "--segments", "100", "--method", "hermite-simpson-compressed"],
        "coarse.h5": ["cartpole", "--segments", "20", "--method", "trapezoid"],
        "block.h5": ["block_move_min_force"],
        "heavy.h5": ["cartpole", "--set", "parameters.m1=2", "--set", "solver.max_iter=500"],
    }
    for name, arguments in runs.items():
        solved_once(folder / name, *arguments)
    return folder


def test_the_first_is_the_measure(results):
    fine, same, coarse = compare([results / name for name in ("fine.h5", "same.h5", "coarse.h5")])
    assert fine["difference"] == 0
    assert fine["state_difference"] == 0
    assert same["difference"] == pytest.approx(0, abs=1e-7)
    assert same["state_difference"] < 1e-6
    assert coarse["difference"] == pytest.approx(coarse["objective"] - fine["objective"])
    assert 1e-3 < coarse["state_difference"] < 0.2
    assert coarse["max_eta"] > 100 * fine["max_eta"]
    assert (coarse["method"], coarse["segments"]) == ("trapezoid", 20)


def test_good_results_on_different_meshes_agree(tmp_path):
    """To what both are good for: straight lines between dense points would differ by 1e-5."""
    for segments in (30, 60):
        mesh = f"mesh=[{{method: radau, segments: {segments}, degree: 10, tolerance: 1e-10}}]"
        solved_once(tmp_path / f"{segments}.h5", "cartpole", "--set", mesh)
    _, other = compare([tmp_path / "30.h5", tmp_path / "60.h5"])
    assert other["max_eta"] < 1e-9
    assert 0 < other["state_difference"] < 1e-8


def test_results_without_a_common_state_are_refused(results):
    with pytest.raises(SpecError, match="no state in common"):
        compare([results / "fine.h5", results / "block.h5"])


def test_command_line(results):
    paths = [results / name for name in ("fine.h5", "coarse.h5")]
    table = trajopt("compare", *paths)
    assert table.exit_code == 0
    assert len(table.stdout.splitlines()) == 3
    rows = [json.loads(line) for line in trajopt("compare", *paths, "--json").stdout.splitlines()]
    assert [row["segments"] for row in rows] == [100, 20]
    missing = trajopt("compare", paths[0], "missing.h5")
    assert missing.exit_code == 3


def test_what_is_not_finite_is_empty_in_the_table_and_null_in_json(tmp_path):
    path = save_not_finite(tmp_path / "a.h5")
    head, *lines = trajopt("compare", path, path).stdout.splitlines()
    assert "nan" not in "".join(lines)
    assert [line.split()[:4] for line in lines] == [[str(path), "hermite-simpson", "5", "33"]] * 2
    start, end = head.index("objective") - 1, head.index("max eta") + len("max eta")
    assert [line[start:end].strip() for line in lines] == ["", ""]
    for row in map(strict_json, trajopt("compare", path, path, "--json").stdout.splitlines()):
        names = ("objective", "difference", "state_difference", "max_eta")
        assert [row[name] for name in names] == [None] * 4


def test_a_state_that_is_not_finite_differs_most():
    curves = {name: Curve("", np.empty(0), np.array([0.0, value])) for name, value in (("a", 1.0), ("b", 2.0))}
    t = np.array([0.0, 1.0])
    first = PhaseCurves("main", "s", t, t, t, {"state": curves}, {}, {}, {})
    for name in curves:
        broken = {**curves, name: Curve("", np.empty(0), np.array([0.0, np.nan]))}
        state, distance = _distance(Path("a.h5"), [first], [replace(first, curves={"state": broken})])
        assert state == name and np.isnan(distance)


@pytest.mark.parametrize("value", [np.inf, -np.inf, np.nan, 1e308])
@pytest.mark.parametrize("first", [True, False])
def test_values_that_are_not_finite_bring_no_warning_of_numpy(value, first):
    curve = Curve("", np.empty(0), np.array([0.0, value, 1.0]))
    t = np.array([0.0, 0.5, 1.0])
    broken = PhaseCurves("main", "s", t, t, t[::2], {"state": {"a": curve}}, {}, {}, {})
    whole = replace(broken, curves={"state": {"a": replace(curve, dense=t)}})
    pair = (broken, whole) if first else (whole, broken)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        _, distance = _distance(Path("a.h5"), pair[:1], pair[1:])
    assert not distance < 1e300 or (first and value == 1e308)


def test_a_phase_that_has_shrunk_to_nothing():
    curve, t = Curve("", np.empty(0), np.array([0.0, 2.0, 4.0])), np.full(3, 7.0)
    shrunk = PhaseCurves("main", "s", t, t, t[:2], {"state": {"a": curve}}, {}, {}, {})
    moved = replace(curve, dense=np.array([0.0, 2.0, 5.0]))
    other = replace(shrunk, dense_time=np.array([0.0, 0.5, 1.0]), knots=np.array([0.0, 1.0]))
    other = replace(other, curves={"state": {"a": moved}})
    assert _distance(Path("a.h5"), [shrunk], [shrunk]) == ("a", 0.0)
    assert _distance(Path("a.h5"), [shrunk], [other]) == ("a", pytest.approx(0.25))


def test_another_problem_is_told(results):
    paths = [results / name for name in ("fine.h5", "coarse.h5", "heavy.h5")]
    run = trajopt("compare", *paths)
    assert run.exit_code == 0
    assert run.stderr == "note: these are results of different problems, which differ in parameters.m1\n"
    assert [row.split()[1] for row in run.stdout.splitlines()] == ["parameters.m1", "1", "1", "2"]
    assert [row["other_problem"] for row in compare(paths)] == [{}, {}, {"parameters.m1": (1.0, 2.0)}]
    rows = [json.loads(line) for line in trajopt("compare", *paths, "--json").stdout.splitlines()]
    assert rows[2]["other_problem"] == {"parameters.m1": [1.0, 2.0]}


BASE = {
    "name": "a", "parameters": {"note": {"value": 1.0, "note": "mass"}}, "expressions": {"guess": "x"},
    "constraints": {"path": [{"name": "c", "expression": "x", "upper": 1.0}]}, "mesh": [{"segments": 3}],
    "time": {"final": {"lower": 0.0, "guess": 2.0}},
}  # fmt: skip


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"name": "b", "mesh": [{"segments": 4}], "note": "other words", "guess": {"constants": {"x": 1.0}}}, {}),
        ({"parameters": {"note": {"value": 1.0, "note": "load"}}, "time": {"final": {"lower": 0.0}}}, {}),
        ({"parameters": {"note": {"value": 2.0}}}, {"parameters.note": (1.0, 2.0)}),
        ({"expressions": {"guess": "y"}}, {"expressions.guess": ("x", "y")}),
        (
            {"constraints": {"path": []}},
            {"constraints.path.0.expression": ("x", None), "constraints.path.0.upper": (1.0, None)},
        ),
    ],
)  # fmt: skip
def test_what_makes_another_problem(change, told):
    assert differences(BASE, {**BASE, **change}) == told


@pytest.mark.parametrize(("start", "end"), [(0.90753, 5.80332), (0.1, 0.7), (0.0, 1.0)])
def test_trajectories_that_are_cut_in_two_ways_agree_to_the_end(start, end):
    """By rounding, t0 + 1.0*(tF - t0) may be beyond tF: for the first of these ends."""
    t = np.linspace(start, end, 9)

    def phase(name, times):
        curves = {"state": {"a": Curve("", np.empty(0), times**2)}}
        return PhaseCurves(name, "s", times, times, times[[0, -1]], curves, {}, {}, {})

    halves = [phase("first", t[:5]), phase("second", t[4:])]
    for first, other in (([phase("main", t)], halves), (halves, [phase("main", t)])):
        assert _distance(Path("a.h5"), first, other) == ("a", pytest.approx(0, abs=1e-12))
