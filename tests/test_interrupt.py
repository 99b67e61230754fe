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
from command_line import TRAJOPT

pytestmark = pytest.mark.usefixtures("folder")

LONG = ["solve", "cartpole", "--segments", "4000"]  # a second of building and another of solving
PATIENCE = 60


@contextmanager
def started(*arguments: str):
    run = subprocess.Popen([*TRAJOPT, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        yield run
    finally:
        run.kill()
        run.communicate()


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
    assert code == 130
    assert out.startswith("cart-pole swing-up: NOT SOLVED\nstatus      interrupted; this is the last iterate\n")
    assert "Traceback" not in err and "--guess" in err
    assert [path.name for path in folder.iterdir()] == ["a.h5"]
    check_interrupted("a.h5")


@pytest.mark.parametrize("module", ["typer", "trajopt.cli.solving.solve", "inspect"])
def test_while_the_command_line_is_loaded(folder, module):
    """The signal comes as the module is imported."""
    script = (
        "import os, signal, sys\n"
        "class Finder:\n"
        "    def find_spec(self, name, path, target=None):\n"
        f"        if name == {module!r}: os.kill(os.getpid(), signal.SIGINT)\n"
        "from trajopt.cli.main import main\n"
        "sys.modules.pop('inspect', None); sys.meta_path.insert(0, Finder()); main()"
    )
    run = subprocess.run([sys.executable, "-c", script, "solve", "cartpole"], capture_output=True, check=False)
    assert (run.returncode, run.stdout, run.stderr) == (130, b"", b"")


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


def test_twice_ends_at_once(folder):
    with building("solve", "cartpole", "--segments", "20000") as run:  # many seconds of building
        for _ in range(2):
            run.send_signal(signal.SIGINT)
            time.sleep(0.2)
        began = time.monotonic()
        code, out, err = finish(run)
    assert (code, out, err) == (130, "", "interrupted; nothing was written\n")
    assert time.monotonic() - began < 10
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
    again = subprocess.run([*TRAJOPT, "solve", "cartpole", "--guess", "cartpole.h5", "-q"], check=False)
    assert again.returncode == 0


def test_kill_leaves_the_older_result_and_nothing_else(folder):
    subprocess.run([*TRAJOPT, "solve", "cartpole", "-q", "-o", "a.h5"], check=True)
    before = Path("a.h5").read_bytes()
    with iterating(*LONG, "-o", "a.h5") as run:
        os.kill(run.pid, signal.SIGKILL)
        run.wait(PATIENCE)
    assert Path("a.h5").read_bytes() == before
    assert [path.name for path in folder.iterdir()] == ["a.h5"]
