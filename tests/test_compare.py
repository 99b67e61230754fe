"""Results side by side."""

import json

import pytest
from command_line import solved_once, trajopt

from trajopt.problems.errors import SpecError
from trajopt.results.compare import compare, differences


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


def test_another_problem_is_told(results):
    paths = [results / name for name in ("fine.h5", "coarse.h5", "heavy.h5")]
    run = trajopt("compare", *paths)
    assert run.exit_code == 0
    assert run.stderr == (
        f"note: {paths[0]} and {paths[2]} are results of different problems: parameters.m1 is 1 and 2\n"
    )
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
