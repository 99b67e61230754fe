"""`trajopt reproduce`: the checks, the page, and what is refused; tests/reproduction/paper.py does all of the paper."""

import json
from dataclasses import replace

import numpy as np
import pytest
from command_line import trajopt

from trajopt.results.reproduction.figures.example import Run, peak
from trajopt.results.reproduction.paper_values import (
    SWITCH,
    U_MAX,
    VALUES,
    WORK,
    at_least,
    at_most,
    near_value,
    printed,
)
from trajopt.results.reproduction.reproduce import EXAMPLES

pytestmark = pytest.mark.usefixtures("folder")

NAMES = ("block", "splines", "refinement", "cartpole", "biped", "min_work", "points", "pendulum")
PAPER_FIGURES = ("02", "03", "04", "05", "06", "07", "09", "10", "11", "13", "14", "15", "16", "17", "19", "20")


# -- the whole ------------------------------------------------------------------------------------------------------


def test_every_figure_of_the_paper_is_there():
    files = [picture.file for example in EXAMPLES.values() for picture in example.pictures]
    assert len(set(files)) == len(files)
    assert {file[3:5] for file in files if file.startswith("fig")} == set(PAPER_FIGURES)
    assert tuple(EXAMPLES) == tuple(VALUES) == NAMES


# -- numbers --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "right", "wrong"),
    [
        (printed("J", "58.805425"), (58.8054246, 58.80542547, 58.8054254), (58.8054256, 58.805424, np.nan, np.inf)),
        (printed("eta", "3.8e-6"), (3.76e-6, 3.849e-6), (3.74e-6, 3.86e-6, 0.0)),
        (printed("u", "-0.0120"), (-0.01204, -0.01196), (-0.0121, 0.0120)),
        (near_value("J", 12, 1e-7), (12, 12 + 9e-8), (12 + 2e-7, np.nan)),
        (near_value("segment", 11, 0), (11,), (10, 12)),
        (at_most("difference", 1e-8), (0, 1e-8, -1), (2e-8, np.nan)),
        (at_least("order", 1.5), (1.5, 2), (1.49, np.nan)),
    ],
)
def test_a_number_agrees_in_all_its_digits_or_fails(value, right, wrong):
    assert all(map(value.holds, right))
    assert not any(map(value.holds, wrong))


def test_the_exact_least_work():
    distance = U_MAX * SWITCH * (1 - SWITCH)
    assert [SWITCH, WORK, distance] == pytest.approx([0.0527864, 1.1145618, 1], abs=5e-8)


@pytest.mark.parametrize("example", NAMES)
def test_every_value_has_a_name_of_its_own_and_a_source(example):
    names = [value.name for value in VALUES[example]]
    assert len(set(names)) == len(names)
    assert all(value.source and value.low <= value.high for value in VALUES[example])


def test_the_peak_between_the_samples():
    t = np.linspace(0, 1, 61)
    assert peak(np.sin(2 * np.pi * (t - 0.0033))) == pytest.approx(1, abs=1e-6)
    assert peak(-(np.sin(np.pi * (t - 0.009)) ** 3)) == pytest.approx(1, abs=1e-6)


def test_a_wrong_expectation_fails(folder, monkeypatch):
    wrong = near_value("least number of subsegments", 3, 0)
    monkeypatch.setitem(VALUES, "refinement", (*VALUES["refinement"][1:], wrong))
    run = trajopt("reproduce", "refinement", "--no-figures")
    assert run.exit_code == 1
    assert [line.split()[:2] for line in run.stdout.splitlines() if "FAIL" in line] == [["FAIL", "refinement"]]
    assert "3 checks: 1 failure" in run.stdout
    index = (folder / "reproduction" / "index.html").read_text()
    assert '<span class="fail">FAIL</span>' in index and "1 are wrong" in index


def test_a_problem_that_is_not_solved_fails(folder, monkeypatch):
    example = EXAMPLES["pendulum"]
    stopped = Run("pendulum", ("solver.engine=ipopt", "solver.max_iter=1"), shown=True)
    runs = {"pendulum": example.runs["pendulum"], "pendulum_ipopt": stopped}
    monkeypatch.setitem(EXAMPLES, "pendulum", replace(example, runs=runs))
    run = trajopt("reproduce", "pendulum", "--json")
    assert (run.exit_code, json.loads(run.stdout)["unsolved"]) == (1, {"pendulum_ipopt": "ran out of iterations"})
    assert (
        "pendulum_ipopt was not solved: ran out of iterations" in (folder / "reproduction" / "index.html").read_text()
    )


def test_without_check_only_what_the_figures_show_is_solved(folder):
    run = trajopt("reproduce", "pendulum", "-o", "some")
    assert run.exit_code == 0, run.output
    shown = {name for name, run in EXAMPLES["pendulum"].runs.items() if run.shown}
    assert {path.stem for path in (folder / "some" / "results").iterdir()} == shown
    assert "4 checks: all pass" in run.stdout
    assert run.stdout.endswith("some/index.html\n")


# -- the folder -----------------------------------------------------------------------------------------------------


def test_an_own_folder_is_renewed_and_what_else_is_in_it_stays(folder):
    assert trajopt("reproduce", "points").exit_code == 0
    (folder / "reproduction" / "notes.txt").write_text("mine")
    assert trajopt("reproduce", "splines", "--no-figures").exit_code == 0
    assert (folder / "reproduction" / "notes.txt").read_text() == "mine"
    assert (folder / "reproduction" / "figures" / "fig19_collocation_points.png").exists()
    assert "Splines" in (folder / "reproduction" / "index.html").read_text()


def test_a_foreign_folder_is_refused(folder):
    (folder / "mine").mkdir()
    (folder / "mine" / "index.html").write_text("<p>my own page</p>")
    run = trajopt("reproduce", "points", "-o", "mine")
    assert (run.exit_code, run.stdout) == (3, "")
    assert "was not made by 'trajopt reproduce'" in run.stderr
    assert [path.name for path in (folder / "mine").iterdir()] == ["index.html"]
    assert (folder / "mine" / "index.html").read_text() == "<p>my own page</p>"
    (folder / "file").write_text("x")
    assert trajopt("reproduce", "points", "-o", "file").exit_code == 3


def test_a_foreign_picture_in_an_own_folder_is_not_replaced(folder):
    assert trajopt("reproduce", "points").exit_code == 0
    picture = folder / "reproduction" / "figures" / "fig19_collocation_points.png"
    picture.write_bytes(b"mine")
    assert trajopt("reproduce", "points").exit_code == 3
    assert picture.read_bytes() == b"mine"


def test_an_unknown_example_is_a_mistake(folder):
    run = trajopt("reproduce", "cartpol", "points")
    assert run.exit_code == 2
    assert "did you mean cartpole?" in run.stderr
    assert list(folder.iterdir()) == []
