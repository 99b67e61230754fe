"""`trajopt doctor`: whether this installation solves problems, and what it is made of."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import typer

from ...transcription.cache.folder import OFF, SWITCH
from ..errors import NOT_SOLVED, command
from ..options import Json
from ..output.installation import print_installation

PATIENCE = 300  # seconds that a problem may take which usually takes one
PROBLEM = "block_move_min_force"
AGAIN = "install again the versions that trajopt is tested with: pip install --force-reinstall -c requirements.lock ."


@command
def doctor(json_: Json = False) -> None:
    """Tell whether it can solve, versions, and what is missing.

    Example: trajopt doctor
    """
    from ...results.installation import installation

    trial = solve_tiny()
    found = {"solves": trial["solves"], "trial": trial, **installation(load=not trial["crashed"])}
    if json_:
        print(json.dumps(found, allow_nan=False))
    else:
        print_installation(found)
    raise typer.Exit(0 if trial["solves"] else NOT_SOLVED)


def solve_tiny() -> dict[str, Any]:
    """Solve a shipped problem as a user does, in a process of its own: a library that is broken may end that.

    The keys: "solves", whether the result is right; "crashed", whether a library ended the process; "problem",
    "objective", "seconds" of the solve; "trouble" and "remedy", "" where there is none.
    """
    trial: dict[str, Any] = {"solves": False, "crashed": False, "problem": PROBLEM, "objective": None, "seconds": None}
    try:
        with tempfile.TemporaryDirectory() as folder:
            done = _started(Path(folder) / "tiny.h5")
    except subprocess.TimeoutExpired:
        return {**trial, "trouble": f"it did not end in {PATIENCE} s", "remedy": AGAIN}
    except OSError as error:
        remedy = "set TMPDIR to a folder that can be written"
        return {**trial, "trouble": f"no temporary file can be written ({error.strerror})", "remedy": remedy}
    if done.returncode < 0:
        name = signal.Signals(-done.returncode).name
        trouble = f"the process was ended by {name}: a library does not fit this machine"
        return {**trial, "crashed": True, "trouble": trouble, "remedy": AGAIN}
    return {**trial, **_judged(done)}


def _started(path: Path) -> subprocess.CompletedProcess[str]:
    typed = ["solve", PROBLEM, "--json", "-q", "-o", str(path)]
    program = "from trajopt.cli.main import main; main()"
    return subprocess.run(
        [sys.executable, "-P", "-c", program, *typed],
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
        env={**os.environ, SWITCH: OFF},  # what was compiled at another time tells nothing
    )


def _judged(done: subprocess.CompletedProcess[str]) -> dict[str, Any]:
    """What a solve that has ended by itself came to."""
    try:
        result = json.loads(done.stdout)
    except json.JSONDecodeError:
        told = done.stderr.strip().splitlines()
        return {"trouble": told[-1] if told else f"it ended with exit code {done.returncode}", "remedy": AGAIN}
    right = done.returncode == 0 and result["reference"]["agrees"]
    wrong = f"the objective is {result['objective']}, not {result['reference']['objective']}"
    trouble = "" if right else wrong if result["solved"] else result["message"]
    seconds = result["seconds"]["total"]
    remedy = "" if right else AGAIN
    return {"solves": right, "objective": result["objective"], "seconds": seconds, "trouble": trouble, "remedy": remedy}
