"""What is said is so: odd files are told, work is counted, values are data; slips on the command line."""

import json
import re
import subprocess
import time

import h5py
import pytest
from command_line import TRAJOPT, process, solved_once, trajopt

from trajopt.cli.output import progress
from trajopt.problems.errors import SpecError
from trajopt.transcription.loading import load_yaml

pytestmark = pytest.mark.usefixtures("folder")

FILE = """trajopt: 1
name: said
parameters: {u_max: 5, twice: 2*u_max}
time: {initial: 0, final: {lower: 0.1, upper: 10, guess: 1}}
states:
  x: {rate: v, initial: 0, final: 1}
  v: {rate: u, initial: 0, final: 0}
controls:
  u: {lower: -u_max, upper: twice}
objective: {minimize: {terminal: "t[final]"}}
mesh: [{method: hermite-simpson, segments: 6}]
"""
WITHOUT = FILE.replace("u: {lower: -u_max, upper: twice}", "u: {}").replace(
    "parameters: {u_max: 5, twice: 2*u_max}", "note: no parameters"
)


def warnings(text: str) -> list[str]:
    return [str(warning) for warning in load_yaml(text, (), "s.yaml").warnings]


def test_a_usual_file_is_not_odd():
    assert not warnings(FILE)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (FILE.replace("\nobjective", "\n  w: {lower: 0, upper: 1}\nobjective").replace(
            'terminal: "t[final]"', 'terminal: "t[final]", integral: w**2'),
         "10: controls.w: the control w stands in no rate"),
        (FILE.replace("rate: v, initial: 0", "rate: -2, initial: 0"), "x cannot get from 0 to 1: its rate is -2"),
        (FILE.replace("upper: twice}", "upper: }"), "controls.u.upper: upper: is empty, and counts as left out"),
        (WITHOUT, "controls.u: the control u has no bounds, and the time is to be short"),
        (FILE.replace("rate: u,", "rate: u - sin(x),").replace("x: {rate", "x: {unit: deg, rate"),
         "states.x.unit: x has the unit deg, but sin(x) takes it as radians"),
    ],
    ids=["no rate", "wrong way", "empty", "no bounds", "degrees"],
)  # fmt: skip
def test_what_is_odd_is_told(text, words):
    assert any(words in own for own in warnings(text)), warnings(text)


def test_an_end_that_the_dynamics_keep_away_is_a_mistake():
    with pytest.raises(SpecError, match="final values cannot be reached: the dynamics keep x, which is 0"):
        load_yaml(FILE.replace("rate: v, initial: 0", "rate: 0, initial: 0"), file="s.yaml")


def test_what_is_limited_otherwise_is_not_odd():
    assert not warnings(WITHOUT.replace("mesh:", "constraints: {path: [{expression: u**2, upper: 9}]}\nmesh:"))
    angle = WITHOUT.replace("rate: u,", "rate: sin(u),")
    assert not warnings(angle)


def test_parameters_and_overrides_are_data(folder):
    (folder / "said.yaml").write_text(FILE)
    solved = solved_once(folder / "a.h5", "said.yaml", "--set", "parameters.u_max=4", "--set", "mesh.0.segments=8")
    told = json.loads(trajopt("show", solved, "--json").stdout)
    assert told["parameters"] == {"u_max": 4.0, "twice": 8.0}
    assert told["overrides"] == {"parameters.u_max": 4, "mesh.0.segments": 8}
    with h5py.File(solved) as file:
        assert file["spec/parameter/twice"][()] == 8.0
        assert [json.loads(value) for value in file["spec"].attrs["override_values"]] == [4, 8]
    assert told["seconds"]["total"] >= sum(v for k, v in told["seconds"].items() if k not in ("total", "elsewhere"))


def test_a_time_that_runs_away_is_told(folder):
    """x' = -x reaches zero never: the longer, the better."""
    text = """trajopt: 1
name: forever
time: {initial: 0, final: {lower: 1, guess: 2}}
states: {x: {rate: -1e-7*x + 0*u, initial: 1}}
controls: {u: {lower: -1, upper: 1}}
objective: {minimize: {terminal: "x[final]"}}
mesh: [{method: radau, segments: 2, degree: 3}]
"""
    (folder / "forever.yaml").write_text(text)
    run = trajopt("solve", "forever.yaml", "--json")
    told = json.loads(run.stdout)
    ended = told["phases"]["main"]["time"]["final"]
    assert ended < 1e5 or any("the final time has run away to" in note for note in told["notes"])
    assert ended > 1e5


def test_compare_is_one_table_in_the_order_of_what_differs(folder):
    (folder / "said.yaml").write_text(FILE)
    values = (10, 9, 2)
    files = [solved_once(folder / f"r{v}.h5", "said.yaml", "--set", f"parameters.u_max={v}") for v in values]
    run = trajopt("compare", *files)
    assert run.stderr.count("note:") == 1 and "parameters.u_max" in run.stderr
    head, *rows = run.stdout.splitlines()
    assert head.split()[:2] == ["file", "parameters.u_max"]
    assert [row.split()[1] for row in rows] == ["2", "9", "10"]


def test_compare_of_other_problems_names_them(folder):
    """Their values are not laid side by side, and a unit alone makes no other problem."""
    (folder / "said.yaml").write_text(FILE)
    (folder / "told.yaml").write_text(
        FILE.replace("name: said", "name: told").replace("u_max: 5", "v_max: 5, u_max: 4")
    )
    (folder / "unit.yaml").write_text(FILE.replace("u_max: 5", "u_max: {value: 5, unit: N}"))
    files = [solved_once(folder / f"{name}.h5", f"{name}.yaml") for name in ("said", "told", "unit")]
    run = trajopt("compare", *files[:2])
    head, *rows = run.stdout.splitlines()
    assert head.split()[:3] == ["file", "problem", "method"]
    assert sorted(row.split()[1] for row in rows) == ["said", "told"]
    assert "these are results of different problems, which differ in parameters." in run.stderr
    alike = trajopt("compare", files[0], files[2])
    assert (alike.stderr, alike.stdout.split()[:2]) == ("", ["file", "method"])


def test_compare_is_in_the_order_of_segments_if_nothing_else_differs(folder):
    (folder / "said.yaml").write_text(FILE)
    files = [
        solved_once(folder / f"s{n}.h5", "said.yaml", "--segments", str(n), "--set", "mesh.0.method=trapezoid")
        for n in (12, 9, 4)
    ]
    rows = trajopt("compare", *files).stdout.splitlines()[1:]
    assert [row.split()[2] for row in rows] == ["4", "9", "12"]
    assert rows[-1].split()[6] == "0.00e+00"  # the difference is from the first that is named
    other = solved_once(folder / "other.h5", "said.yaml", "--segments", "4")
    rows = trajopt("compare", files[0], other).stdout.splitlines()[1:]
    assert [row.split()[2] for row in rows] == ["12", "4"], "of two methods, as they were given"


@pytest.fixture
def often(monkeypatch):
    monkeypatch.setattr(progress, "INTERVAL", 0.02)


SHOWN = re.compile(r" +\d+ s  said: (building|mesh \d+, iteration \d+, J = \S+, infeasibility \S+)")


def test_a_long_solve_tells_where_it_is(folder, often):
    """Where standard error is no terminal; the seconds that it tells are those that it took."""
    (folder / "said.yaml").write_text(FILE)
    told = trajopt("solve", "said.yaml", "--segments", "150")
    lines = told.stderr.splitlines()
    assert len(lines) > 3 and all(map(SHOWN.fullmatch, lines)), told.stderr
    assert len({line.partition("  ")[2] for line in lines}) > 1, "it goes on"
    assert trajopt("solve", "said.yaml", "--segments", "150", "-q").stderr == ""


@pytest.mark.parametrize("command", ["verify", "report", "explain"])
def test_other_long_work_tells_it_too(folder, monkeypatch, command):
    monkeypatch.setattr(progress, "INTERVAL", 0.001)
    (folder / "said.yaml").write_text(FILE)
    solved_once(folder / "said.h5", "said.yaml")
    told = trajopt(command, "said.h5")
    assert re.match(r" +\d+ s  (verify|report|explain)ing said", told.stderr)
    assert told.stdout
    quiet = trajopt(command, "said.h5", "-q")
    assert (quiet.exit_code, quiet.stdout, quiet.stderr) == (told.exit_code, "", "")


def test_nobody_reads_the_progress_any_more():
    """The work goes on, and nothing is told of it."""
    tried = []

    def closed():
        tried.append(0)
        raise BrokenPipeError

    with progress._again_and_again(closed, 0.01):
        time.sleep(0.2)
    assert len(tried) == 1


@pytest.mark.parametrize(
    "arguments",
    [
        ("--refine", "1e-7"),
        ("--refine", "1e-10", "--set", "solver.max_iter=14"),  # finer meshes fail
        ("--starts", "3", "--segments", "100"),  # long enough that what is no solve counts little
        ("--polish",),
        ("--set", "states.x.final=200"),  # cannot be, and why
    ],
)
def test_the_seconds_are_those_of_all_work(folder, arguments):
    (folder / "said.yaml").write_text(FILE)
    began = time.perf_counter()
    told = json.loads(trajopt("solve", "said.yaml", *arguments, "--json").stdout)
    passed = time.perf_counter() - began
    told_of_meshes = sum(sum(mesh["seconds"].values()) for mesh in told["meshes"])
    assert 0.6 * passed < told["seconds"]["total"] <= passed
    assert told_of_meshes <= told["seconds"]["total"] * (1 + 1e-9)
    assert told["iterations"] >= sum(mesh["iterations"] for mesh in told["meshes"])


# -- the command line ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("check", "cartpole", "--set", "parameters.l=1", "b=2"), 2, "write --set b=2"),
        (("check", "cartpole", "--set", "max_iter=3"), 2, "write --set solver.max_iter=3"),
        (("check", "cartpole", "--set", "tf=3"), 2, "--set tf: tf has its place in the file; write --set time.final=3"),
        (("check", "cartpole", "--set", "segments=9"), 2, "write --set mesh.0.segments=9"),
        (("check", "cartpole", "--set", "parameters.l==1"), 2, "write --set parameters.l=1"),
        (("check", "cartpole", "--set", "parameters.l: 1"), 2, "write --set parameters.l=1"),
        (("check", "cartpole", "--set", "parameters.l=1_0"), 2, "write --set parameters.l=10"),
        (("check", "cartpole", "--set", "states.q1.final=[0, 1]"), 2, "--set 'states.q1.final={lower: 0, upper: 1}'"),
        (("check", "cartpole", "--set", "states.q1.rate="), 2, "--set states.q1.rate: nothing determines how q1"),
        (("check", "said.yaml", "--set", "objective.minimize.terminal="), 2, "--set objective.minimize.terminal: "),
        (("solve", "cartpole", "--refine", "1d-6"), 2, "is written with e; write --refine 1e-6"),
        (("check", "cartpole", "--set", "l=1"), 2, "write --set parameters.l=1"),
        (("check", "cartpole", "--set", "l=1,5"), 2, "write --set parameters.l=1.5"),
        (("check", "cartpole", "--set", "u=5"), 2, "write --set controls.u.KEY=..., where KEY is lower or upper"),
        (("check", "cartpole", "--set", "states.q1", "1.5"), 2, "write --set PATH=1.5"),
        (("check", "cartpole", "--set", "parameters.u_max=abc"), 2, '--set parameters.u_max: unknown name "abc"'),
        (("check", "cartpole", "--set", "parameters.u_max=u*2"), 2, "--set parameters.u_max: "),
        (("check", "cartpole", "--set", "parameters.u_max.value=2*"), 2, "--set parameters.u_max.value: "),
        (("export", "old.h5", "q.csv"), 2, "write trajopt table old.h5 -o q.csv"),
        (("export", "old.h5", "q.parquet"), 2, "write trajopt table old.h5 -o q.parquet"),
        (("sweep", "cartpole", "--over", "parameters.l=1,2", "-o", "-"), 2, "-o -: a sweep is a folder"),
        (("plot", "old.h5", "-o", "-"), 2, "-o -: this command writes files"),
        (("report", "old.h5", "-o", "-"), 2, "-o -: this command writes files"),
        (("animate", "old.h5", "-o", "-"), 2, "-o -: this command writes files"),
        (("check", "cartpole", "--set", "parameters.u_max=1,5"), 2, "--set parameters.u_max: a number has a point"),
        (("export", "cartpole", "q.csv"), 2, "error: q.csv: '.csv' is no format"),
        (("solve", "cartpole", "-o", "-"), 2, "-o -: a result is an HDF5 file"),
        (
            ("show", "said.yaml"),
            2,
            "said.yaml: this is a problem, not a result; solve it first: trajopt solve said.yaml",
        ),
        (("verify", "said"), 2, "said: this is a problem, not a result; solve it first: trajopt solve said.yaml"),
        (("plot", "goddard"), 2, "goddard: this is a problem, not a result; solve it first: trajopt solve goddard"),
        (("table", "nowhere"), 3, "nowhere: there is no such file; give a result"),
        (("solve", "cartpole", "--guess", "said.yaml"), 2, "said.yaml: this is a problem, not a result"),
        (("show", "swept"), 2, "swept: it is the folder of a sweep, not one result; make a page of it: trajopt report"),
        (("solve", "old.h5"), 2, "old.h5: this is a result, not a problem file"),
        (("check", "cartpole", "said.yaml", "--set", "parameters.l=1"), 2, "--set parameters (in said.yaml)"),
    ],
)
def test_slips(folder, arguments, code, words):
    (folder / "said.yaml").write_text(FILE)
    (folder / "swept").mkdir()
    (folder / "swept/sweep.json").write_text("{}")
    with h5py.File(folder / "old.h5", "w"):
        pass
    run = trajopt(*arguments)
    assert (run.exit_code, run.stdout) == (code, "")
    if "in said" in words:
        assert "parameters has no l" in run.stderr and "(in said.yaml)" in run.stderr
    else:
        assert words in run.stderr


def test_a_file_without_its_suffix_and_a_folder_that_is_made(folder):
    (folder / "said.yaml").write_text(FILE)
    assert trajopt("check", "said").stdout.startswith("said.yaml: no mistakes")
    assert trajopt("solve", "said", "-q", "-o", "new/of/it/").exit_code in (0, 4)
    assert (folder / "new" / "of" / "it" / "said.h5").exists()


def test_a_whole_number_for_a_real_option_prints_nothing(folder):
    run = process("solve", "block_move_min_force", "--set", "solver.max_wall_time=50", "-q")
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")


def test_standard_input_by_its_other_names(folder):
    (folder / "said.yaml").write_text(FILE)
    run = subprocess.run(
        [*TRAJOPT, "check", "/dev/stdin"], input=FILE, capture_output=True, text=True, check=False
    )  # fmt: skip
    assert run.returncode == 0 and "no mistakes" in run.stdout, run.stderr
