"""Sweeps that are killed at random moments: after they have gone on, the folder is that of a sweep nobody disturbed."""

from __future__ import annotations

import csv
import random
import shutil
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path

import h5py

from .disks import TRAJOPT
from .processes import Run

SWEEP = [
    *("sweep", "cartpole", "--over", "parameters.u_max=12:24:4", "--over", "parameters.d=0.8:1.2:5"),
    *("--chain", "-q", "-j", "2"),
]
DEATHS = 3
"""The most processes that are killed in one sweep."""
UNLIKE = {"seconds"}
"""What two runs of the same case may differ in."""
AT_WORK = "is at work in this folder"
"""What is told while workers of a parent that was killed still end."""


def runs(count: int, seed: int, folder: Path, more: list[str]) -> Iterator[Run]:
    """So many sweeps, in each of which processes are killed: itself, a worker of it, or what makes its workers.

    more: more arguments of each sweep, such as the address of a cluster.
    """
    start = time.monotonic()
    subprocess.run([*TRAJOPT, *SWEEP, "-o", "whole"], cwd=folder, check=True)
    usual, whole = time.monotonic() - start, told(folder / "whole")
    for k in range(count):
        rng = random.Random(f"{seed} {k}")
        shutil.rmtree(folder / "killed", ignore_errors=True)
        kills = [_killed([*SWEEP, *more], rng, usual, folder) for _ in range(rng.randint(1, DEATHS))]
        run = _resumed([*SWEEP, *more], f"{k} {' '.join(kills)}", folder)
        if not run.err and told(folder / "killed") != whole:
            run.err = f"Traceback: {_difference(folder / 'killed', whole)}"
        yield run


def told(folder: Path) -> dict[str, object]:
    """All that the folder of a sweep tells, less what is never the same twice: file -> what is in it."""
    names = sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.suffix != ".lock")
    with (folder / "index.csv").open(newline="") as stream:
        rows = [{key: row[key] for key in row.keys() - UNLIKE} for row in csv.DictReader(stream)]
    with h5py.File(folder / "sweep.h5") as file:
        arrays = {name: _plain(file[name]) for name in file.keys() - UNLIKE}
    return {"files": names, "index.csv": rows, "sweep.h5": arrays}


def _plain(array: h5py.Dataset) -> bytes | list[str]:
    """The bits of numbers, or the texts."""
    return array.asstr()[()].ravel().tolist() if h5py.check_string_dtype(array.dtype) else array[()].tobytes()


def _difference(folder: Path, whole: dict[str, object]) -> str:
    return ", ".join(f"{name} differs" for name, value in told(folder).items() if value != whole[name])


def _killed(arguments: list[str], rng: random.Random, usual: float, folder: Path) -> str:
    """Whose end it was: one process of a sweep is killed at a moment of its usual time."""
    with subprocess.Popen([*TRAJOPT, *arguments, "-o", "killed"], cwd=folder, stdout=-1, stderr=-1) as own:
        time.sleep(rng.uniform(0, 1.1) * usual)
        below = _below(own.pid)
        victim, whose = (own.pid, "the sweep") if not below or rng.random() < 0.5 else (rng.choice(below), "a worker")
        try:
            subprocess.run(["kill", "-9", str(victim)], check=True, capture_output=True)
        except subprocess.CalledProcessError:
            whose = "nobody"  # it had ended
        own.communicate(timeout=600)
    return whose


def _below(pid: int) -> list[int]:
    """The processes that a process has started, and those that these have."""
    found = subprocess.run(["ps", "-o", "pid=", "--ppid", str(pid)], capture_output=True, text=True, check=False)
    own = [int(word) for word in found.stdout.split()]
    return [*own, *(more for child in own for more in _below(child))]


def _resumed(arguments: list[str], bad: str, folder: Path) -> Run:
    """How the sweep ends that goes on, once the workers of those that were killed have ended."""
    start = time.monotonic()
    while True:
        typed = [*TRAJOPT, *arguments, "-o", "killed"]
        own = subprocess.run(typed, cwd=folder, capture_output=True, text=True, check=False)
        if AT_WORK not in own.stderr or time.monotonic() - start > 60:
            break
        time.sleep(0.2)
    run = Run(bad, "sweep", own.returncode, own.stdout, own.stderr, time.monotonic() - start)
    run.codes = frozenset({0})
    return run
