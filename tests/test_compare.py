"""Results side by side."""

import json

import pytest
from command_line import solved_once, trajopt

from trajopt.problems.errors import FileError
from trajopt.results.compare import compare


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("compare")
    runs = {
        "fine.h5": ["cartpole", "--segments", "100"],
        "same.h5": ["cartpole", "--segments", "100", "--method", "hermite-simpson-compressed"],
        "coarse.h5": ["cartpole", "--segments", "20", "--method", "trapezoid"],
        "block.h5": ["block_move_min_force"],
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
    with pytest.raises(FileError, match="no state in common"):
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
