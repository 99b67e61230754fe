"""The command line as its users meet it: help and listings, broken files, show, check, init."""

import json
import re
import time
from importlib.metadata import version
from pathlib import Path

import broken
import pytest
from command_line import trajopt

from trajopt.cli.app import COMMANDS
from trajopt.problems.catalog import Listed, listed, shipped
from trajopt.problems.load import load
from trajopt.transcription.schemes.table import METHODS

pytestmark = pytest.mark.usefixtures("folder")


# -- help and listings ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", COMMANDS)
def test_help_has_an_example(command):
    result = trajopt(command, "-h")
    assert result.exit_code == 0
    assert re.search(rf"Example: trajopt {command}\b", result.stdout)
    assert "..." not in result.stdout.split("\n\n")[1]


def test_help_names_every_command_and_the_exit_codes():
    text = trajopt("--help").stdout
    for command in COMMANDS:
        (line,) = re.findall(rf"^  {command} +(.*)$", text, re.MULTILINE)
        assert line.endswith(".") and not line.endswith("...")
    assert "130" in text
    assert trajopt("--version").stdout == f"trajopt {version('trajopt')}\n"
    assert trajopt().exit_code == 2


def test_list():
    lines = trajopt("list").stdout.splitlines()
    assert len(lines) == 1 + len(shipped())
    assert [line.split()[0] for line in lines[1:]] == list(shipped())
    assert all(line == line.rstrip() for line in lines)


def test_list_by_tags():
    """Those with all of the tags; what is listed is what the files, read in full, say."""
    specs = {name: load(path) for name, path in shipped().items()}
    assert listed() == {
        name: Listed(own.name, tuple(own.tags), own.source, own.reference and own.reference.objective)
        for name, own in specs.items()
    }
    rows = trajopt("list", "--tag", "minimum-time", "--tag", "robotics").stdout.splitlines()[1:]
    fast = {name for name, own in specs.items() if {"minimum-time", "robotics"} <= {*own.tags}}
    assert {row.split()[0] for row in rows} == fast and "robot_arm" in fast
    assert any("9.14091 " in row and " minimum-time, bang-bang," in row for row in rows)


def test_an_unknown_tag_names_the_nearest():
    result = trajopt("list", "--tag", "robotic")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr == 'error: --tag: no shipped problem has the tag "robotic"; did you mean robotics?\n'
    assert "the tags are aerospace, " in trajopt("list", "--tag", "zzz").stderr


def test_methods():
    table, notes = trajopt("methods").stdout.split("\n\n")
    assert [line.split()[0] for line in table.splitlines()[1:]] == list(METHODS)
    noted = [line.split(":")[0] for line in notes.splitlines()[1:]]
    assert noted == [name for name, method in METHODS.items() if method.note]


def test_schema_is_json_schema():
    schema = json.loads(trajopt("schema").stdout)
    assert {"states", "controls", "mesh"} <= schema["properties"].keys()


# -- show, check, init ----------------------------------------------------------------------------------------------


def test_show_refuses_what_is_no_result():
    Path("a.yaml").write_text(broken.GOOD)
    Path("a.h5").write_text("no HDF5")
    told = {"no.h5": "no such file", "a.h5": "cannot be read as HDF5", ".": "it is a folder", "a.yaml": "a problem"}
    for name, words in told.items():
        result = trajopt("show", name)
        assert (result.exit_code, result.stdout) == (2 if name == "a.yaml" else 3, "") and words in result.stderr


def test_show_of_an_unsolved_result():
    trajopt("solve", "shot_put", "--set", "solver.max_iter=1", "-q")
    result = trajopt("show", "shot_put.h5")
    assert result.exit_code == 1
    assert result.stdout.startswith("shot put: NOT SOLVED\nstatus      ran out of iterations\n")


@pytest.mark.parametrize("case", broken.CASES, ids=lambda case: case.name)
def test_broken_file(case, tmp_path):
    (tmp_path / "in").mkdir()
    path = broken.write(case, tmp_path / "in")
    sets = [argument for override in case.overrides for argument in ("--set", override)]
    began = time.process_time()  # the machine may be busy with something else
    result = trajopt("solve", path, *sets)
    assert time.process_time() - began < 3
    assert result.exit_code == {"spec": 2, "file": 3}[case.kind]
    assert result.stdout == ""
    lines = result.stderr.splitlines()
    assert lines and all(line.startswith("error: ") and "; " in line and len(line) < 700 for line in lines)
    place = case.place if case.place.startswith("--set") else f"{path}{case.place}"
    assert any(line.startswith(f"error: {place}") and case.says in line for line in lines), result.stderr
    assert [found.name for found in tmp_path.iterdir()] == ["in"]


def test_warnings_do_not_stop():
    Path("warned.yaml").write_text(broken.GOOD.replace("x: [0, 0.5, 1]", "x: [0, 9, 1]"))  # outside the bounds of x
    for command in ("check", "solve"):
        result = trajopt(command, "warned.yaml")
        assert result.exit_code == 0
        assert result.stderr.startswith("warning: warned.yaml:28: guess.keyframes.x: ")
        assert result.stderr.count("\n") == 1


def test_init_check_solve():
    result = trajopt("init", "my_problem")
    assert result.stdout == "my_problem.yaml: edit it, then run: trajopt solve my_problem.yaml\n"
    assert trajopt("check", "my_problem.yaml").stdout == "my_problem.yaml: no mistakes; 2 states, 1 control, 1 mesh\n"
    assert trajopt("check", "-q", "my_problem.yaml").output == ""
    solved = trajopt("solve", "my_problem.yaml")
    assert (solved.exit_code, solved.stderr) == (0, "") and "my_problem.h5" in solved.stdout
    again = trajopt("init", "my_problem")
    assert again.exit_code == 3 and "--force" in again.stderr
    assert trajopt("init", "my_problem", "--force").exit_code == 0
    assert trajopt("init", "other", "--from", "cartpole").exit_code == 0
    assert trajopt("check", "other.yaml").exit_code == 0
    assert trajopt("init", "third", "--from", "cartpol").exit_code == 3
    assert trajopt("init", "no/such/folder").exit_code == 3


def test_options_of_the_engine_are_told_with_the_other_mistakes(folder):
    text = shipped()["block_move_min_force"].read_text().replace("rate: v,", "rate: v, lowr: 0,")
    Path("o.yaml").write_text(text + "solver: {max_itr: 5, hsllib: a.so, tol: 1.0e-6, print_level: high}\n")
    told = trajopt("check", "o.yaml").stderr
    for place in ("states.x.lowr", "solver.max_itr", "solver.hsllib", "solver.tol", "solver.print_level"):
        assert f"{place}:" in told


def test_init_takes_the_whole_name_away():
    Path("long.yaml").write_text("trajopt: 1\nname: a long name\n  that goes on\n\n  and on\ntime: {initial: 0}\n")
    assert trajopt("init", "short", "--from", "long.yaml").exit_code == 0
    assert Path("short.yaml").read_text() == "trajopt: 1\nname: short\ntime: {initial: 0}\n"


def test_init_from_what_is_no_text():
    Path("bytes.yaml").write_bytes(b"name: \xff\xfe")
    result = trajopt("init", "new", "--from", "bytes.yaml")
    assert result.exit_code == 2
    assert result.stderr == "error: bytes.yaml:1: this is not UTF-8 text; save the file as UTF-8\n"
