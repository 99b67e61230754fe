"""Cases a second of a sweep, from end to end: `python tests/benchmarks/sweep_rate.py`.

The cart-pole with other limits of the force and other distances, with its folder of results, started as a user starts
it: each case from the guess, and each from its neighbour (`--chain`). CPU seconds are those of all processes, start-up
included: on a busy machine they tell more than the rate. Memory is that of the largest worker at its peak, and of the
parent. `--cases`, `--jobs`, `--set` and `--repeats` choose.
"""

from __future__ import annotations

import argparse
import ctypes
import os
import subprocess
import sys
import tempfile
import time
from typing import NamedTuple

from cartpole import HERE

DISTANCES = 25

PR_SET_CHILD_SUBREAPER = 36
"""Of Linux's prctl: workers, whose parent ends before them, become children of this process, which sees their CPU."""


class Run(NamedTuple):
    """Wall seconds of a sweep, CPU seconds of all its processes; MB of the largest worker and of the parent."""

    wall: float
    cpu: float
    worker: float
    parent: float


def swept(problem: str, cases: int, jobs: int, more: list[str], folder: str) -> Run:
    """One sweep, whose cases are all solved."""
    axes = ["--over", f"parameters.u_max=12:24:{cases // DISTANCES}", "--over", f"parameters.d=0.8:1.2:{DISTANCES}"]
    command = [sys.executable, "-c", "from trajopt.cli.main import main; main()", "sweep", problem, *axes, *more]
    began, ended = time.perf_counter(), {}
    parent = subprocess.Popen([*command, "-q", "--force", "-j", str(jobs), "-o", folder])
    wall = 0.0
    while True:
        try:
            pid, status, used = os.wait4(-1, 0)
        except ChildProcessError:  # all have ended
            break
        ended[pid] = used
        if pid == parent.pid:
            wall = time.perf_counter() - began
            if status:
                raise RuntimeError(f"{' '.join(command)} ended with status {status}")
    cpu = sum(used.ru_utime + used.ru_stime for used in ended.values())
    memory = {pid: used.ru_maxrss / 1024 for pid, used in ended.items()}
    return Run(wall, cpu, max(own for pid, own in memory.items() if pid != parent.pid), memory[parent.pid])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, nargs="+", default=[1000], help="multiples of 25; several show the growth")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--repeats", type=int, default=1, help="the fastest is told")
    parser.add_argument("--set", action="append", default=[], metavar="PATH=VALUE", help="of all cases")
    chosen = parser.parse_args()
    ctypes.CDLL(None).prctl(PR_SET_CHILD_SUBREAPER, 1)
    problem, given = str(HERE.parents[1] / "problems" / "cartpole.yaml"), [f"--set={value}" for value in chosen.set]
    print("| cases | from | seconds | cases/s | CPU ms a case | worker, MB | parent, MB |")
    print("|--:|:--|--:|--:|--:|--:|--:|")
    for cases in chosen.cases:
        for start, more in (("the guess", []), ("a neighbour", ["--chain"])):
            with tempfile.TemporaryDirectory() as folder:
                runs = [swept(problem, cases, chosen.jobs, [*given, *more], folder) for _ in range(chosen.repeats)]
            wall, cpu, worker, parent = (min(values) for values in zip(*runs, strict=True))
            told = f"{wall:.1f} | {cases / wall:.1f} | {1e3 * cpu / cases:.1f} | {worker:.0f} | {parent:.0f}"
            print(f"| {cases} | {start} | {told} |", flush=True)


if __name__ == "__main__":
    main()
