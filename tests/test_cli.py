"""The command line as its users meet it: exit codes, what is printed where, which files are written."""

import json
import os
import pty
import re
import subprocess
import sys
import time
from importlib.metadata import version
from pathlib import Path

import broken
import h5py
import pytest
from typer.testing import CliRunner

from trajopt.cli.main import app
from trajopt.problems.catalog import shipped

TRAJOPT = [sys.executable, "-c", "from trajopt.cli.main import main; main()"]  # the console script, in any environment

COMMANDS = ("solve", "check", "show", "schema", "list", "methods", "export", "init")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def trajopt(*arguments: str):
    """A run inside this process: no start-up to pay. Anything but an exit with a code is a bug."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exception is None or isinstance(result.exception, SystemExit), repr(result.exception)
    return result


def process(*arguments: str, **options):
    """A run as a user's shell starts it."""
    return subprocess.run([*TRAJOPT, *map(str, arguments)], capture_output=True, text=True, check=False, **options)


# -- as processes --------------------------------------------------------------------------------------------------


def test_several_problems_in_one_process(folder):
    run = process("solve", "cartpole", "block_move_min_force", "--json")
    assert (run.returncode, run.stderr) == (0, "")
    summaries = [json.loads(line) for line in run.stdout.splitlines()]
    assert [summary["file"] for summary in summaries] == ["cartpole.h5", "block_move_min_force.h5"]
    assert summaries[0]["objective"] == pytest.approx(58.805425468, rel=1e-9)
    assert all(summary["solved"] and summary["reference"]["agrees"] for summary in summaries)
    assert sorted(path.name for path in folder.iterdir()) == ["block_move_min_force.h5", "cartpole.h5"]
    show = process("show", "cartpole.h5", "block_move_min_force.h5", "--json")
    assert (show.returncode, show.stdout, show.stderr) == (0, run.stdout, "")


def test_not_solved_is_told_and_written(folder):
    run = process("solve", "cartpole", "shot_put", "--set", "solver.max_iter=2", "--json")
    assert run.returncode == 1
    assert [json.loads(line)["status"] for line in run.stdout.splitlines()] == ["max_iterations"] * 2
    assert re.fullmatch(r"(not solved: .*: ran out of iterations; .*max_iter.*\n){2}", run.stderr)
    with h5py.File("cartpole.h5") as file:
        assert file.attrs["status"] == "max_iterations"
        assert file.attrs["remedy"] in run.stderr


def test_mistakes_and_files_have_their_exit_codes():
    mistake = process("solve", "cartpole", "--set", "solver.max_itr=3", "--set", "parameters.m1=-x")
    assert (mistake.returncode, mistake.stdout) == (2, "")  # IPOPT prints its own complaint on standard output
    assert mistake.stderr.count("error: ") == mistake.stderr.count("\n")
    file = process("solve", "no/such.yaml")
    assert (file.returncode, file.stdout) == (3, "")
    assert file.stderr == "error: no/such.yaml: there is no such file; look into no\n"


def test_every_mistake_of_many_files_in_one_run(folder):
    """The list of broken files as a user would check them: no traceback, a sentence each, not slow."""
    cases = [case for case in broken.CASES if case.kind == "spec" and not case.overrides]
    names = [f"{number}.yaml" for number in range(len(cases))]
    for name, case in zip(names, cases, strict=True):
        Path(name).write_bytes(case.content)
    began = time.perf_counter()
    run = process("check", *names)
    assert time.perf_counter() - began < 20  # some 120 files
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


def on_a_terminal(*arguments: str, columns: int = 80) -> str:
    """What a terminal of that width receives; standard output and error together."""
    primary, secondary = pty.openpty()
    environment = {**os.environ, "COLUMNS": str(columns), "TERM": "xterm"}
    started = subprocess.Popen([*TRAJOPT, *arguments], stdout=secondary, stderr=secondary, env=environment)
    os.close(secondary)
    received = b""
    try:
        while block := os.read(primary, 4096):
            received += block
    except OSError:  # Linux's way to say that the other side has closed
        pass
    os.close(primary)
    assert started.wait() == 0
    return received.decode()


def test_the_live_line_appears_and_vanishes():
    shown = on_a_terminal("solve", "cartpole", "--segments", "800")
    lines = shown.split("\r\x1b[K")[0].split("\r")
    assert "cart-pole swing-up: building" in lines[1]
    *live, rest = re.split(r"\r(?=[^\n])", shown)
    assert any(re.search(r"mesh 1/1, iteration \d+, J = .*, infeasibility \d", line) for line in live)
    assert all(len(line.removesuffix("\x1b[K")) < 80 for line in live)
    assert rest.startswith("\x1b[K")  # written over with nothing before the table
    table = rest.removeprefix("\x1b[K").replace("\r", "")
    assert re.match(r"(\x1b\[\d+m)+cart-pole swing-up: solved\x1b\[0m\n", table)
    assert max(map(len, table.splitlines()[1:])) <= 80
    assert "\n            0.0" in table or "seconds" in table


def test_tables_on_a_terminal_keep_to_its_width():
    lines = on_a_terminal("list", columns=70).replace("\r", "").splitlines()
    assert len(lines) == 1 + len(shipped())
    assert all(len(re.sub(r"\x1b\[\d+m", "", line)) <= 70 for line in lines)
    assert any(line.endswith("...") for line in lines)


def test_help_is_quick():
    began = time.perf_counter()
    assert process("--help").returncode == 0
    assert time.perf_counter() - began < 2


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


def test_methods():
    lines = trajopt("methods").stdout.splitlines()
    assert {"trapezoid", "hermite-simpson"} <= {line.split()[0] for line in lines[1:]}


def test_schema_is_json_schema():
    schema = json.loads(trajopt("schema").stdout)
    assert {"states", "controls", "mesh"} <= schema["properties"].keys()


# -- solve ---------------------------------------------------------------------------------------------------------


def attributes(path: str) -> dict:
    with h5py.File(path) as file:
        return {**file.attrs, **{f"mesh_{k}": v for k, v in file["mesh/0"].attrs.items()}}


def test_the_table(folder):
    result = trajopt("solve", "cartpole")
    assert (result.exit_code, result.stderr) == (0, "")
    title, *lines = result.stdout.splitlines()
    assert title == "cart-pole swing-up: solved"
    fields = dict(line.split(maxsplit=1) for line in lines)
    assert list(fields) == ["objective", "error", "mesh", "iterations", "seconds", "file"]
    assert fields["objective"] == "58.80542547  (minimize); agrees with the reference 58.805425"
    assert fields["error"].startswith("relative 1.38e-03; max eta 1.27e-02, in v2 on segment 11, t = 0.8 to 0.88")
    parts = re.fullmatch(r"[\d.]+  \((.*)\)", fields["seconds"])[1]
    names = [part.rsplit(" ", 1)[0] for part in parts.split(", ")]
    assert names == ["build", "differentiate", "compile", "assemble", "evaluate", "linear algebra", "error"]
    assert fields["file"] == "cartpole.h5"
    shown = trajopt("show", "cartpole.h5").stdout
    assert shown.startswith(result.stdout)
    assert "phase main: t = 0 to 2 s" in shown


def test_overrides():
    for arguments, key, value in (
        (["--segments", "12"], "mesh_segments", 12),
        (["--method", "trapezoid"], "mesh_method", "trapezoid"),
        (["--tol", "1e-5"], "mesh_tolerance", 1e-5),
        (["--set", "mesh.0.segments=7"], "mesh_segments", 7),
        (["--set", "name=other"], "problem", "other"),
    ):
        assert trajopt("solve", "shot_put", *arguments, "-q", "--force").exit_code == 0
        assert attributes("shot_put.h5")[key] == value
    trajopt("solve", "block_move_min_force", "--set", "time.final=2", "-q")
    assert attributes("block_move_min_force.h5")["objective"] == pytest.approx(12 / 2**3)


def test_short_forms_go_to_the_last_or_to_every_mesh():
    trajopt("solve", "van_der_pol", "--segments", "70", "--method", "trapezoid", "--tol", "1e-6", "-q")
    with h5py.File("van_der_pol.h5") as file:
        meshes = [dict(file[f"mesh/{k}"].attrs) for k in range(len(file["mesh"]))]
    assert len(meshes) > 1
    assert {mesh["method"] for mesh in meshes} == {"trapezoid"}
    assert (meshes[-1]["segments"], meshes[-1]["tolerance"]) == (70, 1e-6)
    assert meshes[0]["segments"] != 70


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--method", "trap"], 'error: --method: there is no method "trap"; did you mean trapezoid?\n'),
        (["--segments", "1000000"], "error: --segments: "),
        (["--tol", "nan"], "error: --tol: "),
        (["--set", "parameters.dd=1"], "error: --set parameters.dd: parameters has no dd"),
        (["--set", "solver.max_itr=1"], "error: --set solver.max_itr: IPOPT does not take max_itr = 1; did you mean"),
    ],
)
def test_wrong_options_are_named_as_they_were_given(folder, arguments, sentence):
    result = trajopt("solve", "cartpole", "block_move_min_force", *arguments)
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith(sentence)
    assert result.stderr.count("\n") == 1 or "parameters" in sentence
    assert not list(folder.iterdir())


@pytest.mark.parametrize("arguments", [["--segments", "0"], ["--segments", "x"], ["--tol", "x"], ["--nonsense"], []])
def test_a_wrong_command_line(arguments):
    result = trajopt("solve", *(["cartpole"] if arguments else []), *arguments)
    assert result.exit_code == 2
    assert "Error: " in result.stderr and "trajopt solve -h" in result.stderr.replace("root", "trajopt")


def test_quiet_and_verbose():
    assert trajopt("solve", "cartpole", "-q").output == ""
    quiet = trajopt("solve", "cartpole", "-q", "--set", "solver.max_iter=1")
    assert (quiet.exit_code, quiet.stdout) == (1, "") and quiet.stderr.startswith("not solved: ")
    verbose = trajopt("solve", "van_der_pol", "-v")
    assert verbose.exit_code == 0 and verbose.stdout.startswith("Van der Pol oscillator: solved")
    assert re.match(r"mesh 1\n iter  objective +infeasibility  dual +mu\n    0  ", verbose.stderr)
    assert "\nmesh 2\n" in verbose.stderr
    rows = [line for line in verbose.stderr.splitlines() if re.match(r" +\d", line)]
    assert len({len(row) for row in rows}) == 1


def test_names_work_from_any_folder_and_a_file_here_comes_first(folder):
    assert trajopt("solve", "shot_put.yaml", "-q").exit_code == 0
    Path("cartpole").write_text(broken.GOOD)
    assert trajopt("check", "cartpole").stdout == "cartpole: no mistakes; 2 states, 1 control, 1 mesh\n"
    missing = trajopt("solve", "cartpol")
    assert missing.exit_code == 3 and "did you mean cartpole?" in missing.stderr


def test_output_file_and_folder(folder):
    Path("out").mkdir()
    assert trajopt("solve", "shot_put", "-o", "a name.h5", "-q").exit_code == 0
    assert trajopt("solve", "shot_put", "-o", "out", "-q").exit_code == 0
    assert trajopt("solve", "shot_put", "block_move_min_force", "-o", folder / "out", "-q").exit_code == 0
    names = sorted(str(path.relative_to(folder)) for path in folder.rglob("*.h5"))
    assert names == ["a name.h5", "out/block_move_min_force.h5", "out/shot_put.h5"]


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["shot_put", "-o", "no/a.h5"], 3, "its folder does not exist; create no"),
        (["shot_put", "-o", "no/"], 2, "this is no folder"),
        (["shot_put", "block_move_min_force", "-o", "a.h5"], 2, "there are 2 problems; create the folder first"),
        (["shot_put", "./shot_put.yaml"], 2, "two of the problems would go to this file"),
        (["shot_put", "-o", "/dev/full", "--force"], 3, "it is no ordinary file"),
        (["shot_put", "-o", "/proc/a.h5"], 3, "its folder cannot be written"),
        (["shot_put", "--guess", "no.h5"], 3, "no.h5: there is no such file"),
        (["shot_put", "--guess", "shot_put.yaml"], 3, "it cannot be read as HDF5"),
    ],
)
def test_outputs_that_are_refused_before_any_work(folder, arguments, code, words):
    Path("shot_put.yaml").write_bytes(shipped()["shot_put"].read_bytes())
    result = trajopt("solve", *arguments)
    assert result.exit_code == code and words in result.stderr
    assert [path.name for path in folder.iterdir()] == ["shot_put.yaml"]


def test_an_existing_file_is_replaced_only_by_the_same_problem():
    assert trajopt("solve", "shot_put", "-o", "a.h5", "-q").exit_code == 0
    assert trajopt("solve", "shot_put", "-o", "a.h5", "-q", "--segments", "9").exit_code == 0
    before = Path("a.h5").read_bytes()
    refused = trajopt("solve", "block_move_min_force", "-o", "a.h5")
    assert refused.exit_code == 3
    assert "a result of another problem, 'shot put'" in refused.stderr and "--force" in refused.stderr
    assert Path("a.h5").read_bytes() == before
    Path("b.h5").write_text("precious")
    refused = trajopt("solve", "shot_put", "-o", "b.h5")
    assert refused.exit_code == 3 and "no trajopt result" in refused.stderr
    assert Path("b.h5").read_text() == "precious"
    assert trajopt("solve", "block_move_min_force", "-o", "a.h5", "-q", "--force").exit_code == 0
    assert attributes("a.h5")["problem"] == "block move, minimum force"


def test_one_refused_output_stops_all_before_the_first(folder):
    Path("shot_put.h5").write_text("precious")
    assert trajopt("solve", "block_move_min_force", "shot_put").exit_code == 3
    assert [path.name for path in folder.iterdir()] == ["shot_put.h5"]


def test_guess():
    trajopt("solve", "cartpole", "-q")
    cold = json.loads(trajopt("show", "cartpole.h5", "--json").stdout)["iterations"]
    warm = json.loads(trajopt("solve", "cartpole", "--guess", "cartpole.h5", "--json").stdout)["iterations"]
    assert warm < cold
    other = trajopt("solve", "block_move_min_force", "--guess", "cartpole.h5")
    assert other.exit_code == 3 and "none of the states" in other.stderr


def test_the_result_remembers_its_command(monkeypatch):
    monkeypatch.setattr(sys, "argv", ["/usr/bin/trajopt", "solve", "shot_put", "-o", "my file.h5"])
    trajopt("solve", "shot_put", "-o", "my file.h5", "-q")
    assert attributes("my file.h5")["command"] == "trajopt solve shot_put -o 'my file.h5'"


def test_names_with_line_breaks_and_escapes_stay_on_one_line():
    text = broken.GOOD.replace("name: a good file", 'name: "two\\nlines \\e[31mred"')
    Path("odd.yaml").write_text(text)
    first = trajopt("solve", "odd.yaml").stdout.splitlines()[0]
    assert first == "two lines ?[31mred: solved"


# -- show, check, init, export --------------------------------------------------------------------------------------


def test_show_refuses_what_is_no_result():
    Path("a.yaml").write_text(broken.GOOD)
    for name, words in (("no.h5", "no such file"), ("a.yaml", "cannot be read as HDF5"), (".", "it is a folder")):
        result = trajopt("show", name)
        assert (result.exit_code, result.stdout) == (3, "") and words in result.stderr


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
    began = time.perf_counter()
    result = trajopt("solve", path, *sets)
    assert time.perf_counter() - began < 3
    assert result.exit_code == {"spec": 2, "file": 3}[case.kind]
    assert result.stdout == ""
    lines = result.stderr.splitlines()
    assert lines and all(line.startswith("error: ") and "; " in line for line in lines)
    assert case.says in result.stderr
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
    solved = trajopt("solve", "my_problem.yaml")
    assert (solved.exit_code, solved.stderr) == (0, "") and "my_problem.h5" in solved.stdout
    again = trajopt("init", "my_problem")
    assert again.exit_code == 3 and "--force" in again.stderr
    assert trajopt("init", "my_problem", "--force").exit_code == 0
    assert trajopt("init", "other", "--from", "cartpole").exit_code == 0
    assert trajopt("check", "other.yaml").exit_code == 0
    assert trajopt("init", "third", "--from", "cartpol").exit_code == 3
    assert trajopt("init", "no/such/folder").exit_code == 3


@pytest.mark.parametrize(
    ("name", "method", "variables", "constraints"),
    [
        ("cartpole", "hermite-simpson", 5 * 21, 8 * 10),  # states and control at 21 points, two defects a state
        ("cartpole", "trapezoid", 5 * 11, 4 * 10),
        ("cartpole", "hermite-simpson-compressed", 5 * 21 - 4 * 10, 4 * 10 + 2 * 10),  # bounds of q1, q2 at midpoints
        ("shot_put", "trapezoid", 4 * 11 + 2, 4 * 10 + 2),  # the final time and the angle; two boundary constraints
        ("bryson_denham", "trapezoid", 3 * 11, 2 * 10 + 11),  # a path constraint
    ],
)
def test_export_nl(name, method, variables, constraints):
    result = trajopt("export", name, "a.nl", "--segments", "10", "--method", method)
    assert result.stdout.split() == ["a.nl", "a.row", "a.col"]
    counts = [int(n) for n in Path("a.nl").read_text().splitlines()[1].split("#")[0].split()]
    assert counts[:3] == [variables, constraints, 1]
    assert len(Path("a.col").read_text().split()) == variables
    assert len(Path("a.row").read_text().split()) == constraints + 1


@pytest.mark.parametrize("name", shipped())
def test_every_problem_is_exported(name):
    for suffix in ("nl", "gms", "tex"):
        assert trajopt("export", name, f"a.{suffix}", "--segments", "3").exit_code == 0
        assert Path(f"a.{suffix}").stat().st_size > 1000


def test_export_for_other_readers():
    assert trajopt("export", "shot_put", "a.gms").exit_code == 0
    assert "solve" in Path("a.gms").read_text().lower()
    assert trajopt("export", "shot_put", "a.tex", "--segments", "2").exit_code == 0
    assert "\\begin{document}" in Path("a.tex").read_text()
    refused = trajopt("export", "shot_put", "a.tex")
    assert refused.exit_code == 3 and "--force" in refused.stderr
    assert trajopt("export", "shot_put", "a.tex", "--segments", "2", "--force").exit_code == 0
    other = trajopt("export", "shot_put", "a.mod")
    assert other.exit_code == 2 and ".nl, .gms, .tex" in other.stderr


def test_options_of_the_engine_are_told_with_the_other_mistakes(folder):
    text = shipped()["block_move_min_force"].read_text().replace("rate: v,", "rate: v, lowr: 0,")
    Path("o.yaml").write_text(text + "solver: {max_itr: 5, hsllib: a.so, tol: 1.0e-6, print_level: high}\n")
    told = trajopt("check", "o.yaml").stderr
    for place in ("states.x.lowr", "solver.max_itr", "solver.hsllib", "solver.tol", "solver.print_level"):
        assert f"{place}:" in told


def test_a_solve_may_draw_its_result(folder):
    result = trajopt("solve", "shot_put", "--plot", "-o", "a.h5")
    assert result.exit_code == 0
    assert "picture: a.png" in result.stderr
    assert (folder / "a.png").read_bytes().startswith(b"\x89PNG")
