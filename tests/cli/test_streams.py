"""Standard streams that are closed, and solutions that are not to be lost."""

import subprocess
from pathlib import Path

import h5py
import pytest
from command_line import TRAJOPT, trajopt

pytestmark = pytest.mark.usefixtures("folder")


def shell(arguments: str, redirections: str) -> subprocess.CompletedProcess:
    command = " ".join(f"'{word}'" for word in TRAJOPT)
    return subprocess.run(["sh", "-c", f"{command} {arguments} {redirections}"], capture_output=True, check=False)


CLOSED = OUT, ERR, BOTH, ALL = (">&-", "2>&-", ">&- 2>&-", "<&- >&- 2>&-")
USES = [  # a solve takes longer to start than all else that it does: all closings with the one that writes everything
    *(("solve cartpole --set solver.max_iter=2", 1, closed) for closed in CLOSED),
    *(("list", 0, closed) for closed in CLOSED),
    *(("check nothing.yaml", 3, closed) for closed in (ERR, ALL)),
    *(("nothing", 2, closed) for closed in (ERR, BOTH)),
    ("solve cartpole", 0, ALL),
    ("solve cartpole --json -v", 0, OUT),
    ("solve cartpole --json -v", 0, BOTH),
]


@pytest.mark.parametrize(("arguments", "code", "redirections"), USES)
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
    assert trajopt("solve", "cartpole", "-q", "-o", "a.h5").exit_code == 0
    run = trajopt(*FAILING, "--plot")
    assert run.exit_code == 1 and run.stderr.startswith("note: a.h5 holds a solution and is kept (--force replaces it)")
    assert "file        a-unsolved.h5" in run.stdout and Path("a-unsolved.png").exists()
    assert solved("a.h5") and not solved("a-unsolved.h5")


def test_what_stands_beside_a_solution_is_not_lost_either():
    for name in ("a.h5", "a-unsolved.h5"):
        assert trajopt("solve", "cartpole", "-q", "-o", name).exit_code == 0
    Path("a-unsolved-2.h5").write_text("a letter")
    run = trajopt(*FAILING, "--json")
    assert run.exit_code == 1 and '"file": "a-unsolved-3.h5"' in run.stdout
    assert solved("a.h5") and solved("a-unsolved.h5") and Path("a-unsolved-2.h5").read_text() == "a letter"


def test_force_replaces_a_solution():
    assert trajopt("solve", "cartpole", "-q", "-o", "a.h5").exit_code == 0
    assert trajopt(*FAILING, "--force").exit_code == 1
    assert not solved("a.h5") and not Path("a-unsolved.h5").exists()


def test_a_solution_replaces_what_is_none():
    assert trajopt(*FAILING).exit_code == 1
    assert trajopt("solve", "cartpole", "-q", "-o", "a.h5").exit_code == 0
    assert solved("a.h5") and not Path("a-unsolved.h5").exists()
