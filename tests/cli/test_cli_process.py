"""The command line as a user's shell starts it: exit codes, the two streams, terminals, pipes."""

import json
import os
import re
import resource
import subprocess
import sys
from pathlib import Path

import broken
import h5py
import pytest
from command_line import OPTION_FILES, TRAJOPT, process, trajopt
from named import share

pytestmark = pytest.mark.usefixtures("folder")


def used() -> float:
    """Seconds of processor time of the processes that have ended: the machine may be busy with something else."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return children.ru_utime + children.ru_stime


def test_several_problems_in_one_process(folder):
    run = process("solve", "cartpole", "block_move_min_force", "--json")
    assert (run.returncode, run.stderr) == (0, "")
    summaries = [json.loads(line) for line in run.stdout.splitlines()]
    assert [summary["file"] for summary in summaries] == ["cartpole.h5", "block_move_min_force.h5"]
    assert summaries[0]["objective"] == pytest.approx(58.805425468, rel=1e-9)
    assert all(summary["solved"] and summary["reference"]["agrees"] for summary in summaries)
    assert sorted(path.name for path in folder.iterdir()) == ["block_move_min_force.h5", "cartpole.h5"]
    show = trajopt("show", "cartpole.h5", "block_move_min_force.h5", "--json")
    assert (show.exit_code, show.stdout, show.stderr) == (0, run.stdout, "")


def test_not_solved_is_told_and_written(folder):
    run = process("solve", "cartpole", "shot_put", "--set", "solver.max_iter=2", "--json")
    assert run.returncode == 1
    assert [json.loads(line)["status"] for line in run.stdout.splitlines()] == ["max_iterations"] * 2
    assert re.fullmatch(r"(not solved: .*: ran out of iterations; .*max_iter.*\n){2}", run.stderr)
    with h5py.File("cartpole.h5") as file:
        assert file.attrs["status"] == "max_iterations"
        assert file.attrs["remedy"] in run.stderr


def test_an_option_file_in_the_current_folder_changes_nothing(folder):
    def told():
        solved = trajopt("solve", "cartpole", "--json", "-o", "a.h5")
        check = trajopt("check", "cartpole", "--set", "solver.max_iter=5", "--set", "solver.linear_solver=ma57")
        assert (solved.exit_code, solved.stderr, check.exit_code, check.stdout) == (0, "", 2, "")
        summary = json.loads(solved.stdout)
        return summary["objective"], summary["iterations"], summary["error"], check.stderr

    plain = told()
    for said in OPTION_FILES.values():
        (folder / "ipopt.opt").write_text(said)
        assert told() == plain, said
        assert sorted(path.name for path in folder.iterdir()) == ["a.h5", "ipopt.opt"], said


def test_mistakes_and_files_have_their_exit_codes():
    mistake = process("solve", "cartpole", "--set", "solver.max_itr=3", "--set", "parameters.m1=-x")
    assert (mistake.returncode, mistake.stdout) == (2, "")  # IPOPT prints its own complaint on standard output
    assert mistake.stderr.count("error: ") == mistake.stderr.count("\n")
    file = process("solve", "no/such.yaml")
    assert (file.returncode, file.stdout) == (3, "")
    assert file.stderr == "error: no/such.yaml: there is no such file; look into no\n"


def test_every_mistake_of_many_files_in_one_run(folder):
    """The list of broken files as a user would check them: no traceback, a sentence each, not slow."""
    cases = share([case for case in broken.CASES if case.kind == "spec" and not case.overrides], 10)
    names = [f"{number}.yaml" for number in range(len(cases))]
    for name, case in zip(names, cases, strict=True):
        Path(name).write_bytes(case.content)
    before = used()
    run = process("check", *names)
    assert used() - before < 20  # some 60 files
    assert (run.returncode, run.stdout) == (2, "")
    lines = run.stderr.splitlines()
    assert all(line.startswith("error: ") for line in lines)
    for name, case in zip(names, cases, strict=True):
        assert any(line.startswith(f"error: {name}{case.place}") and case.says in line for line in lines), case.name


def test_output_that_cannot_be_written():
    with open("/dev/full", "w") as full:
        run = subprocess.run([*TRAJOPT, "list"], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert run.returncode == 3
    assert run.stderr == "error: standard output: it cannot be written (No space left on device); send it elsewhere\n"


def test_a_reader_that_goes_away_is_no_error():
    run = subprocess.run(f"{' '.join(map(repr, TRAJOPT))} schema | true", shell=True, capture_output=True, check=False)
    assert run.stderr == b""


def test_what_ipopt_prints_goes_to_standard_error():
    run = process("solve", "cartpole", "--set", "solver.print_level=5", "--json")
    assert json.loads(run.stdout)["solved"]
    assert "Number of Iterations" in run.stderr


def test_a_name_that_is_no_text(folder):
    path = os.fsencode(folder) + b"/\xff.yaml"
    Path(os.fsdecode(path)).write_text(broken.GOOD)
    run = subprocess.run([*TRAJOPT, "solve", path], capture_output=True, check=False)
    assert (run.returncode, run.stderr) == (0, b"")
    assert process("show", os.fsdecode(b"\xff.h5")).returncode == 0


@pytest.mark.parametrize("arguments", [("--help",), ("solve", "cartpole")])
def test_nothing_is_loaded_for_tables_that_are_not_drawn(arguments):
    script = "import sys; from trajopt.cli.app import app; app(sys.argv[1:], standalone_mode=False)"
    counted = f"{script}\nassert not [name for name in sys.modules if name.startswith('rich.')]"
    run = subprocess.run([sys.executable, "-c", counted, *arguments], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr


def test_help_is_quick():
    before = used()
    assert process("--help").returncode == 0
    assert used() - before < 1.5


def test_verbose_tells_of_iterations_and_of_nothing_else():
    run = process("solve", "cartpole", "--segments", "300", "-v")
    assert run.returncode == 0
    row = r"mesh \d+| iter  objective .*| +\d+ ( +[\d.e+-]+){4}"
    assert all(re.fullmatch(row, line) for line in run.stderr.splitlines()), run.stderr[:500]
    assert run.stderr.count("mesh") == 2  # a large mesh starts from a coarse one


def test_a_result_whose_folder_has_gone_is_kept_elsewhere(folder):
    (folder / "away").mkdir()
    arguments = ["solve", "cartpole", "-o", "away/a.h5", "-v", "--segments", "3000"]
    with subprocess.Popen([*TRAJOPT, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
        assert run.stderr.readline() == "mesh 1\n"
        (folder / "away").rmdir()
        errors = run.communicate(timeout=60)[1]
    assert run.returncode == 3
    rescued = re.search(r"error: away/a.h5: it cannot be written .*; the result is in (.*), move it from there", errors)
    kept = Path(rescued[1])
    with h5py.File(kept) as file:
        assert file.attrs["solved"]
    kept.unlink()
    kept.parent.rmdir()
