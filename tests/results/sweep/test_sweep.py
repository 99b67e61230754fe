"""`trajopt sweep` as a shell starts it: real workers, killed at will; what it prints, and how it ends."""

import csv
import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import pytest
from command_line import process, started, strict_json, trajopt

from trajopt.results.sweep.engines import ClusterEngine, LocalEngine

from .sweeping import TEXT

pytestmark = pytest.mark.usefixtures("folder")

GRID = ["sweep", "push.yaml", "--over", "parameters.l=1:2:5", "--over", "parameters.T=1,2", "-j", "2"]
SLOW = ["sweep", "cartpole", "--over", "parameters.u_max=15:19:6", "--set", "mesh.0.segments=80", "-j", "2"]
PATIENCE = 60


@pytest.fixture
def push(folder):
    Path("push.yaml").write_text(TEXT)
    return folder


def table(folder):
    """index.csv without the seconds."""
    with open(Path(folder) / "index.csv", newline="") as file:
        return [{key: value for key, value in row.items() if key != "seconds"} for row in csv.DictReader(file)]


def index(folder) -> list[dict]:
    path = Path(folder) / "index.jsonl"
    return [json.loads(line) for line in path.read_bytes().splitlines()] if path.exists() else []


def children(pid: int) -> dict[int, str]:
    """All processes below one -> their command lines."""
    found = {}
    for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
        found[int(child)] = Path(f"/proc/{child}/cmdline").read_text()
        found |= children(int(child))
    return found


def workers(pid: int) -> list[int]:
    """The processes that the fork server has made."""
    servers = [child for child, line in children(pid).items() if "forkserver" in line]
    return [worker for server in servers for worker in children(server)]


def wait_until(true, run=None):
    deadline = time.monotonic() + PATIENCE
    while not true():
        assert time.monotonic() < deadline and (run is None or run.poll() is None)
        time.sleep(0.01)


def told(errors: str) -> list[str]:
    """The lines of standard error that do not tell of progress, which slow machines print."""
    return [line for line in errors.splitlines() if not re.search(r": \d+ of \d+ cases, ", line)]


def ended(pids) -> bool:
    """Whether none of the processes runs any more."""
    states = [Path(f"/proc/{pid}/stat") for pid in pids]
    return all(not path.exists() or path.read_text().rpartition(")")[2].split()[0] == "Z" for path in states)


def test_a_grid(push):
    run = process(*GRID)
    assert run.returncode == 0 and told(run.stderr) == []
    title, *lines = run.stdout.splitlines()
    assert title == "push: 10 of 10 cases solved"
    fields = dict(line.split(maxsplit=1) for line in lines)
    assert list(fields) == ["cases", "best", "worst", "seconds", "files"]
    assert fields["cases"] == "10, 10 solved, 0 failed"
    assert fields["best"] == "1.5  (parameters.l=1.0, parameters.T=2)"
    assert fields["worst"] == "48  (parameters.l=2.0, parameters.T=1)"
    assert fields["files"] == "push-sweep/index.csv, push-sweep/sweep.h5"
    with h5py.File("push-sweep/sweep.h5") as file:
        assert file["objective"].shape == (5, 2) and file["l"][:].tolist() == [1, 1.25, 1.5, 1.75, 2]
        assert file.attrs["problem"] == "push" and file.attrs["command"].endswith("-j 2")
    again = process(*GRID, "--resume")
    assert again.returncode == 0 and "seconds" not in again.stdout and again.stdout.startswith(title)
    assert len(index("push-sweep")) == 10


def test_one_json_line_a_case(push):
    run = process(*GRID, "--json", "--keep", "full", "-o", "a", "--set", "solver.print_level=5")
    rows = [strict_json(line) for line in run.stdout.splitlines()]
    assert run.returncode == 0 and sorted(row["case"] for row in rows) == list(range(10))
    assert "Number of Iterations" in run.stderr  # IPOPT's own output
    for row in rows[:2]:
        shown = trajopt("show", f"a/results/{row['key']}.h5", "--json")
        assert json.loads(shown.stdout)["objective"] == row["objective"]


def test_a_section_of_the_file_and_standard_input(push):
    text = TEXT + "sweep: {over: {parameters.l: '1:2:3', parameters.T: [1, 2, 3]}, zip: true}\n"
    run = trajopt("sweep", "-", "-q", "-j", "1", given=text)
    assert (run.exit_code, run.stdout) == (0, "")
    rows = table("stdin-sweep")
    assert [(row["parameters.l"], row["parameters.T"]) for row in rows] == [("1.0", "1"), ("1.5", "2"), ("2.0", "3")]


@pytest.mark.parametrize(
    ("section", "says"),
    [
        ("{over: {parameters.l: '1:2'}}", '<f>: sweep.over.parameters.l: "1:2" is neither a range nor a list'),
        ("{over: {}}", "<f>:12: sweep.over: "),
        ("{over: {a: 1}, sample: x}", "<f>:12: sweep.sample: this is no number of cases"),
        ("{over: {a: 1}, zip: 3}", "<f>:12: sweep.zip: "),
        ("{over: {a: 1}, seed: x}", "<f>:12: sweep.seed: "),
        ("{ovr: {a: 1}}", "<f>:12: sweep"),
    ],
)
def test_mistakes_in_the_section(folder, section, says):
    Path("f.yaml").write_text(f"{TEXT}sweep: {section}\n")
    result = trajopt("sweep", "f.yaml")
    assert result.exit_code == 2 and f"error: {says.replace('<f>', 'f.yaml')}" in result.stderr, result.stderr
    assert "pydantic" not in result.stderr and "; " in result.stderr


def test_cases_that_fail_are_told_by_their_reason(push):
    run = trajopt("sweep", "push.yaml", "--over", "parameters.l=1,8,9", "-j", "2")
    assert run.exit_code == 1 and told(run.stderr) == []
    title, cases, failed, *_ = run.stdout.splitlines()
    assert (title, cases) == ("push: 1 of 3 cases solved", "cases       3, 1 solved, 2 failed")
    assert failed.startswith("failed      2 cases ")
    assert [row["solved"] for row in table("push-sweep")] == ["true", "false", "false"]


def test_a_mistake_that_only_a_worker_finds(push):
    """Every value is right with the first values of the other axes, but not every combination."""
    arguments = ["--over", "states.x.lower=-1,1.5", "--over", "parameters.l=2,1", "--set", "states.x.initial="]
    run = trajopt("sweep", "push.yaml", *arguments)
    assert run.exit_code == 2
    assert told(run.stderr)[0].startswith("error: --over states.x.lower=1.5, parameters.l=1: push.yaml:")
    assert run.stdout.startswith("push: 3 of 4 cases solved\n") and len(table("push-sweep")) == 4


def test_a_killed_parent_loses_nothing(folder):
    """kill -9 in the middle; its workers end as well, and the same command goes on."""
    assert trajopt(*SLOW, "-q", "-o", "whole").exit_code == 0
    with started(*SLOW, "-q", "-o", "a") as run:
        wait_until(lambda: len(index("a")) >= 2, run)
        below = children(run.pid)
        os.kill(run.pid, signal.SIGKILL)
    wait_until(lambda: ended(below))
    before = index("a")
    assert 2 <= len(before) < 6 and not Path("a/index.csv").exists()
    with open("a/index.jsonl", "ab") as file:
        file.write(b'{"case": 5, "key": "abc')
    assert trajopt(*SLOW, "-q", "-o", "a").exit_code == 0
    lines = Path("a/index.jsonl").read_text().splitlines()
    assert len(lines) == 7  # one is torn
    assert table("a") == table("whole")


@pytest.mark.parametrize("server", [False, True], ids=["worker", "fork server too"])
def test_a_killed_worker_changes_nothing_but_time(folder, server, monkeypatch):
    """Its programs are new, so that it has loaded all that it ever loads."""
    monkeypatch.setenv("TRAJOPT_CACHE", str(folder / "cache"))
    arguments = [*SLOW, "--over", "parameters.d=1"]
    with started(*arguments) as run:
        wait_until(lambda: index("cartpole-sweep"), run)
        os.kill(workers(run.pid)[0], signal.SIGKILL)
        if server:
            os.kill(next(pid for pid, line in children(run.pid).items() if "forkserver" in line), signal.SIGKILL)
        out, err = run.communicate(timeout=PATIENCE)
    assert run.returncode == 0 and told(err) == []
    assert out.startswith("cart-pole swing-up: 6 of 6 cases solved\n")
    assert [row["case"] for row in table("cartpole-sweep")] == list("012345")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
def test_signals(folder, number):
    """The first one ends it after the iteration, with the table and the arrays of what is finished."""
    with started(*SLOW) as run:
        wait_until(lambda: index("cartpole-sweep"), run)
        below = children(run.pid)
        for pid in (run.pid, *workers(run.pid)) if number == signal.SIGINT else (run.pid,):  # as a terminal does
            os.kill(pid, number)
        out, err = run.communicate(timeout=PATIENCE)
    assert run.returncode == 128 + number and "Traceback" not in err
    wait_until(lambda: ended(below))
    assert " missing\n" in out
    rows = table("cartpole-sweep")
    assert 1 <= len(rows) < 6 and all(row["solved"] == "true" for row in rows)
    with h5py.File("cartpole-sweep/sweep.h5") as file:
        assert file["solved"][:].sum() == len(rows)


def test_what_workers_need_is_loaded_before_they_are_made():
    """A worker that imports cyipopt after it has a second thread would load all of SciPy's statistics."""
    script = "import sys, trajopt.results.sweep.preload; print('cyipopt' in sys.modules, 'scipy.stats' in sys.modules)"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert run.stdout == "True False\n"


def test_one_thread_in_each_worker(monkeypatch):
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    LocalEngine(1, print)
    assert os.environ["OMP_NUM_THREADS"] == "1"


def test_a_cluster_that_is_not_there(push, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    result = trajopt(*GRID, "--scheduler", "tcp://127.0.0.1:1")
    assert (result.exit_code, result.stderr) == (
        2,
        "error: --scheduler: a cluster needs the package distributed, which is not installed; "
        "install it: pip install distributed\n",
    )


def test_the_same_results_on_a_cluster(push):
    """Bit for bit, and without a word, though one of its workers is killed midway."""
    distributed = pytest.importorskip("distributed")
    assert trajopt(*GRID, "-q", "-o", "here").exit_code == 0
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        engine = ClusterEngine(cluster.scheduler_address)
        assert engine.capacity == 2
        pids = list(engine.client.run(os.getpid).values())
        engine.close()
        with started(*GRID, "-q", "-o", "there", "--scheduler", cluster.scheduler_address) as run:
            wait_until(lambda: index("there"), run)
            os.kill(pids[0], signal.SIGKILL)
            assert run.communicate(timeout=2 * PATIENCE) == ("", "") and run.returncode == 0
    assert table("here") == table("there")


def test_solving_what_is_piped_in(folder):
    run = trajopt("solve", "-", given=TEXT)
    assert run.exit_code == 0 and run.stdout.startswith("push: solved\n")
    assert [path.name for path in folder.iterdir()] == ["stdin.h5"]
    assert trajopt("show", "stdin.h5").exit_code == 0
    wrong = trajopt("solve", "-", given=TEXT.replace("rate: u", "rate: w"))
    assert wrong.exit_code == 2 and wrong.stderr.startswith("error: standard input:8: states.v.rate: ")
    twice = trajopt("solve", "-", "-", given=TEXT)
    assert twice.stderr == "error: standard input: it is given twice; write - once\n"
    empty = process("solve", "-", stdin=subprocess.DEVNULL)
    assert empty.returncode == 2 and empty.stderr.startswith("error: standard input: the file is empty; ")
    assert trajopt("check", "-", given=TEXT).stdout.startswith("standard input: no mistakes; ")
