"""Standard streams that are closed, and solutions that are not to be lost."""

import subprocess
from pathlib import Path

import h5py
import pytest
from command_line import TRAJOPT, process

pytestmark = pytest.mark.usefixtures("folder")


def shell(arguments: str, redirections: str) -> subprocess.CompletedProcess:
    command = " ".join(f"'{word}'" for word in TRAJOPT)
    return subprocess.run(["sh", "-c", f"{command} {arguments} {redirections}"], capture_output=True, check=False)


@pytest.mark.parametrize("redirections", [">&-", "2>&-", ">&- 2>&-", "<&- >&- 2>&-"])
@pytest.mark.parametrize(
    ("arguments", "code"),
    [("solve cartpole", 0), ("solve cartpole --set solver.max_iter=2", 1), ("solve cartpole --json -v", 0),
     ("list", 0), ("check nothing.yaml", 3), ("nothing", 2)],
)  # fmt: skip
def test_a_closed_stream_is_dev_null(arguments, code, redirections):
    run = shell(arguments, redirections)
    assert run.returncode == code and b"Traceback" not in run.stderr
    if arguments.startswith("solve"):
        with h5py.File("cartpole.h5") as file:
            assert file.attrs["solved"] == (code == 0)


def solved(path: str) -> bool:
    with h5py.File(path) as file:
        return bool(file.attrs["solved"])


FAILING = ("solve", "cartpole", "--set", "solver.max_iter=2", "-o", "a.h5")


def test_a_solution_is_not_replaced_by_what_is_none():
    assert process("solve", "cartpole", "-q", "-o", "a.h5").returncode == 0
    run = process(*FAILING, "--plot")
    assert run.returncode == 1 and run.stderr.startswith(
        "note: a.h5 holds a solution and is kept (--force replaces it)"
    )
    assert "file        a-unsolved.h5" in run.stdout and Path("a-unsolved.png").exists()
    assert solved("a.h5") and not solved("a-unsolved.h5")


def test_what_stands_beside_a_solution_is_not_lost_either():
    for name in ("a.h5", "a-unsolved.h5"):
        assert process("solve", "cartpole", "-q", "-o", name).returncode == 0
    Path("a-unsolved-2.h5").write_text("a letter")
    run = process(*FAILING, "--json")
    assert run.returncode == 1 and '"file": "a-unsolved-3.h5"' in run.stdout
    assert solved("a.h5") and solved("a-unsolved.h5") and Path("a-unsolved-2.h5").read_text() == "a letter"


def test_force_replaces_a_solution():
    assert process("solve", "cartpole", "-q", "-o", "a.h5").returncode == 0
    assert process(*FAILING, "--force").returncode == 1
    assert not solved("a.h5") and not Path("a-unsolved.h5").exists()


def test_a_solution_replaces_what_is_none():
    assert process(*FAILING).returncode == 1
    assert process("solve", "cartpole", "-q", "-o", "a.h5").returncode == 0
    assert solved("a.h5") and not Path("a-unsolved.h5").exists()
