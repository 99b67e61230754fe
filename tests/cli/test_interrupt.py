"""Ctrl-C, a scheduler's SIGTERM, and kill -9, sent to real processes in the middle of a real solve."""

import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np
import pytest
from command_line import solved_once, started, trajopt

pytestmark = pytest.mark.usefixtures("folder")


@pytest.fixture(autouse=True)
def anew(monkeypatch):
    """A solve that is known leaves little to interrupt."""
    monkeypatch.setenv("TRAJOPT_CACHE", "off")


LONG = ["solve", "cartpole", "--segments", "4000"]  # a second of building and another of solving
PATIENCE = 60


@contextmanager
def iterating(*arguments: str):
    """A verbose run that has told of its second iteration."""
    with started(*arguments, "-v") as run:
        for line in run.stderr:
            if line.startswith("    1  "):
                break
        else:
            pytest.fail("the solve ended before it could be interrupted")
        yield run


@contextmanager
def building(*arguments: str):
    """A run that has loaded what it builds the model with, and has not begun to iterate."""
    with started(*arguments) as run:
        deadline = time.monotonic() + PATIENCE
        while "symengine" not in Path(f"/proc/{run.pid}/maps").read_text():
            assert time.monotonic() < deadline and run.poll() is None
            time.sleep(0.01)
        time.sleep(0.5)  # the library is there some time before the model is begun
        yield run


def finish(run) -> tuple[int, str, str]:
    out, err = run.communicate(timeout=PATIENCE)
    return run.returncode, out, err


def check_interrupted(path: str) -> None:
    with h5py.File(path) as file:
        assert file.attrs["status"] == "interrupted" and not file.attrs["solved"]
        assert np.isfinite(file.attrs["objective"])
        for kind in ("state", "control"):
            for curve in file[f"phase/main/points/{kind}"].values():
                assert np.isfinite(curve[:]).all()
        assert len(file["solver/iterations/mu"]) >= 1


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
def test_in_the_middle_of_a_solve(folder, number):
    with iterating(*LONG, "-o", "a.h5") as run:
        run.send_signal(number)
        code, out, err = finish(run)
    assert code == 128 + number
    assert out.startswith("cart-pole swing-up: NOT SOLVED\nstatus      interrupted; this is the last iterate\n")
    assert "Traceback" not in err and "--guess" in err
    assert [path.name for path in folder.iterdir()] == ["a.h5"]
    check_interrupted("a.h5")


NUMBERS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]


LOADED = [  # each signal before and in a solve; the moments between with one of them
    *(("typer", number) for number in NUMBERS),
    ("trajopt.cli.solving.solve", signal.SIGTERM),
    ("inspect", signal.SIGHUP),
    *(("pyomo.core", number) for number in NUMBERS),
    ("h5py", signal.SIGINT),
]


@pytest.mark.parametrize(("module", "number"), LOADED)
def test_while_something_is_loaded(folder, module, number):
    """The signal comes as the module is imported."""
    script = (
        "import os, sys\n"
        "class Finder:\n"
        "    def find_spec(self, name, path, target=None):\n"
        f"        if name == {module!r}: os.kill(os.getpid(), {number.value})\n"
        "from trajopt.cli.main import main\n"
        "sys.modules.pop('inspect', None); sys.meta_path.insert(0, Finder()); main()"
    )
    run = subprocess.run([sys.executable, "-c", script, "schema" if module == "inspect" else "solve", "cartpole"],
                         capture_output=True, check=False)  # fmt: skip
    during_solve = module in ("pyomo.core", "h5py")
    if not during_solve:
        assert (run.returncode, run.stdout, run.stderr) == (128 + number, b"", b"interrupted\n")
    assert run.returncode == 128 + number and b"Traceback" not in run.stderr


@pytest.mark.parametrize("number", NUMBERS, ids=lambda number: number.name)
def test_on_the_way_out(number):
    """The signal comes after the command has ended, in the middle of what libraries do at the end."""
    script = "import atexit, os; from trajopt.cli.main import main; "
    script += f"atexit.register(lambda: os.kill(os.getpid(), {number.value})); main()"
    run = subprocess.run([sys.executable, "-c", script, "--version"], capture_output=True, check=False)
    assert (run.returncode, run.stderr) == (128 + number, b"interrupted\n") and run.stdout.startswith(b"trajopt ")


def test_in_the_middle_of_writing(folder):
    """The signal comes between the two halves of a file: no part of it stays, and the older one is whole."""
    script = (
        "import os, pathlib, signal\n"
        "from trajopt.cli import signals; from trajopt.problems.files import replacing\n"
        "signals.end_on_signals()\n"
        "with replacing(pathlib.Path('a.h5')) as temporary:\n"
        "    temporary.write_bytes(b'half'); os.kill(os.getpid(), signal.SIGTERM)\n"
    )
    Path("a.h5").write_bytes(b"older")
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, check=False)
    assert (run.returncode, run.stderr) == (143, b"interrupted\n")
    assert [path.name for path in folder.iterdir()] == ["a.h5"] and Path("a.h5").read_bytes() == b"older"


def test_an_ignored_signal_stays_ignored(folder):
    script = "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN); from trajopt.cli.main import main; "
    script += "import atexit; atexit.register(lambda: print(signal.getsignal(signal.SIGINT) == signal.SIG_IGN)); main()"
    run = subprocess.run([sys.executable, "-c", script, "--version"], capture_output=True, text=True, check=False)
    assert run.stdout.endswith("\nTrue\n")


def test_while_building():
    with building(*LONG) as run:
        run.send_signal(signal.SIGINT)
        code, _, err = finish(run)
    assert code == 130 and "Traceback" not in err
    check_interrupted("cartpole.h5")


@pytest.mark.parametrize("number", NUMBERS, ids=lambda number: number.name)
def test_twice_ends_at_once(folder, number):
    """The second signal comes in a callback of the engine, where an exception could not be raised."""
    script = (
        "import os\n"
        "from trajopt.cli.main import main\n"
        "from trajopt.cli.output import progress\n"
        f"progress.print_iteration = lambda mesh, record: [os.kill(os.getpid(), {number.value}) for _ in range(2)]\n"
        "main()"
    )
    run = subprocess.run([sys.executable, "-c", script, "solve", "cartpole", "-v"], capture_output=True, check=False)
    assert (run.returncode, run.stdout) == (128 + number, b"")
    assert run.stderr.endswith(b"interrupted\n") and b"Traceback" not in run.stderr
    assert not list(folder.iterdir())


def test_what_comes_after_is_not_solved(folder):
    with iterating("solve", "cartpole", "shot_put", "--segments", "4000") as run:
        run.send_signal(signal.SIGINT)
        assert finish(run)[0] == 130
    assert [path.name for path in folder.iterdir()] == ["cartpole.h5"]


def test_an_interrupted_result_is_a_guess():
    with iterating(*LONG) as run:
        run.send_signal(signal.SIGINT)
        finish(run)
    assert trajopt("solve", "cartpole", "--guess", "cartpole.h5", "-q").exit_code == 0


def test_kill_leaves_the_older_result_and_nothing_else(folder):
    before = solved_once(Path("a.h5"), "cartpole").read_bytes()
    with iterating(*LONG, "-o", "a.h5") as run:
        os.kill(run.pid, signal.SIGKILL)
        run.wait(PATIENCE)
    assert Path("a.h5").read_bytes() == before
    assert [path.name for path in folder.iterdir()] == ["a.h5"]


def test_a_solution_is_kept_when_the_same_problem_is_interrupted(folder):
    before = solved_once(Path("a.h5"), "cartpole").read_bytes()
    for _ in range(2):  # the second one takes the place of the first
        with iterating(*LONG, "-o", "a.h5") as run:
            run.send_signal(signal.SIGTERM)
            code, out, err = finish(run)
        assert code == 143 and "a.h5 holds a solution and is kept" in err
        assert out.rstrip().endswith("file        a-unsolved.h5")
    assert Path("a.h5").read_bytes() == before
    check_interrupted("a-unsolved.h5")
    assert sorted(path.name for path in folder.iterdir()) == ["a-unsolved.h5", "a.h5"]
