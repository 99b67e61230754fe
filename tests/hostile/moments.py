"""Signals at random moments of solves, sweeps, exports and pictures: what was there stays whole."""

from __future__ import annotations

import random
import shutil
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

from trajopt.problems.errors import FileError
from trajopt.results.file.summary import summarize

from .disks import TRAJOPT
from .processes import Run

SIGNALS = [signal.SIGKILL, signal.SIGINT, signal.SIGTERM, signal.SIGHUP]
COMMANDS = {
    "solve": ["solve", "cartpole", "-o", "a.h5"],
    "refine": ["solve", "cartpole", "--refine", "1e-9", "-o", "a.h5"],
    "export": ["export", "cartpole", "a.nl", "--force"],
    "plot": ["plot", "kept.h5", "-o", "a.png", "--force"],
    "sweep": ["sweep", "cartpole", "--over", "parameters.u_max=12,14,16", "--jobs", "1", "-o", "sweep"],
    "reproduce": ["reproduce", "block", "--no-figures", "-o", "page"],
}
"""Name -> what is typed, in a folder with the results kept.h5 and a.h5."""
TOLD = (" ", "stopping", "interrupted", "cart-pole swing-up: mesh")
"""How lines begin that are told of progress, and of a signal."""
WHOLE = ["kept.h5", "a.h5"]


def runs(count: int, seed: int, folder: Path) -> Iterator[Run]:
    """So many commands, each with a signal at a moment of its usual time, and one in four with a second signal."""
    work = folder / "work"
    work.mkdir()
    subprocess.run([*TRAJOPT, "solve", "cartpole", "-q", "-o", "kept.h5"], cwd=work, check=True)
    shutil.copy(work / "kept.h5", work / "a.h5")
    usual = {name: _timed(arguments, work) for name, arguments in COMMANDS.items()}
    for k in range(count):
        rng = random.Random(f"{seed} {k}")
        name = rng.choice(list(COMMANDS))
        sent = [rng.choice(SIGNALS), *([rng.choice(SIGNALS[1:])] if rng.random() < 0.25 else [])]
        yield _run(k, name, sent, rng.uniform(0.1, 1.1) * usual[name], work)


def _timed(arguments: list[str], folder: Path) -> float:
    start = time.monotonic()
    subprocess.run([*TRAJOPT, *arguments], cwd=folder, capture_output=True, check=False)
    return time.monotonic() - start


def _run(k: int, name: str, sent: list[signal.Signals], moment: float, folder: Path) -> Run:
    with subprocess.Popen([*TRAJOPT, *COMMANDS[name]], cwd=folder, stdout=-1, stderr=-1, text=True) as own:
        time.sleep(moment)
        for number in sent:
            own.send_signal(number)
        out, err = own.communicate(timeout=600)
    codes = {0, 4, *(128 + number for number in sent), *(-number for number in sent)}
    err = "\n".join(line for line in err.splitlines() if not line.startswith(TOLD))
    run = Run(
        f"{k} {[number.name for number in sent]}", name, own.returncode, out, err + _lost(name, sent, folder), moment
    )
    run.codes = frozenset(codes)
    if "Traceback" in run.err or own.returncode not in codes:
        run.err = f"Traceback: exit code {own.returncode}: {run.err}"
    run.code = 0  # what a signal ends is no fault: `err` tells what is one
    run.codes = frozenset({0})
    return run


def _lost(name: str, sent: list[signal.Signals], folder: Path) -> str:
    """A result that is no longer whole; a temporary file that a command that could clear it has left."""
    told = []
    for kept in WHOLE:
        try:
            summarize(folder / kept)
        except FileError as error:
            told.append(f"Traceback: {error}")
    left = list(folder.glob(".trajopt-*"))
    if left and signal.SIGKILL not in sent:
        told.append(f"Traceback: {left} was left")
    for own in left:  # as the next run would; of another command it may not come to a write
        own.unlink()
    return "\n".join(told)
