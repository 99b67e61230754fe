"""All shipped problems by the command that a user types: each as its file and the kept baseline say, none worse."""

import json

import pytest
from command_line import process

from trajopt.problems.catalog import shipped
from trajopt.results.library.baseline import baseline, regressions
from trajopt.results.library.rows import row_from

BASELINE = baseline()
HOW = "trajopt reproduce library writes library.md and baseline.json anew"


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return process("reproduce", "library", "--check", "--json", "-o", tmp_path_factory.mktemp("made") / "library")


@pytest.fixture(scope="module")
def rows(run):
    return {told["name"]: row_from(told) for told in json.loads(run.stdout)["problems"]}


def test_nothing_is_worse_than_in_the_baseline(run):
    told = json.loads(run.stdout)
    assert told["regressions"] == []
    assert (run.returncode, len(told["problems"])) == (0, len(shipped())), run.stderr


@pytest.mark.parametrize("name", shipped())
def test_a_shipped_problem_ends_as_its_file_and_the_baseline_say(rows, name):
    """What is better than the baseline fails as well: the page tells what is."""
    row = rows[name]
    assert row.solved, row.message
    assert row.checks
    assert row.difference <= row.tolerance, (row.objective, row.reference)
    assert regressions({name: row}, [BASELINE[name]], finer=False) == [], f"better than in the baseline: {HOW}"
