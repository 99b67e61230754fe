"""Broken files of phases, links, tables and measurements through the command line: exit code 2, and a sentence each.

The files are those of `broken`, 124 of them, whose other tests look at the words; and some with CSV files beside them.
"""

import re

import broken
import pytest
from broken.measurements import MEASUREMENTS
from broken.phases import PHASES
from broken.tables import TABLES
from command_line import trajopt

FILES = [*PHASES, *TABLES, *MEASUREMENTS]
TWO_MISTAKES = {
    # What has lost its name is used under the old one, which is the second mistake.
    "a phase of no name",
    "a phase of a reserved name",
    "a table called sin",
    "a table called delay",
    "a table called like a state",
    "a table called like a parameter",
    "an end outside",  # of the table, and of a path constraint
}
THREE_MISTAKES = {"tables as a list"}  # with a misspelt key, and a table that is none

SENTENCE = re.compile(r"error: \S+broken\.yaml:\d+: [\w.() -]+: .{5,}; .{5,}")
"""The file, the line, the path, what is wrong, and the remedy."""


@pytest.mark.parametrize("case", FILES, ids=lambda case: case.name)
def test_a_broken_file_ends_with_2_and_a_sentence(case, tmp_path):
    path = broken.write(case, tmp_path)
    run = trajopt("check", path, *(part for own in case.overrides for part in ("--set", own)))
    told = run.stderr.splitlines()
    assert run.exit_code == 2 and not run.stdout
    assert len(told) == 1 + (case.name in TWO_MISTAKES) + 2 * (case.name in THREE_MISTAKES), run.stderr
    assert all(SENTENCE.fullmatch(own) for own in told), run.stderr
    assert any(f"{path}{case.place}" in own and case.says in own for own in told)


def test_there_are_forty_of_them():
    assert len({case.content for case in FILES}) == len(FILES) >= 40
    assert min(map(len, (PHASES, TABLES, MEASUREMENTS))) >= 10


@pytest.mark.parametrize("case", [PHASES[7], PHASES[12], TABLES[0], MEASUREMENTS[1]], ids=lambda case: case.name)
def test_solve_refuses_it_as_check_does(case, tmp_path):
    path = broken.write(case, tmp_path)
    solved, checked = (trajopt(command, path) for command in ("solve", "check"))
    assert solved.exit_code == checked.exit_code == 2
    assert solved.stderr == checked.stderr and not solved.stdout
    assert [own.name for own in tmp_path.iterdir()] == [path.name]
