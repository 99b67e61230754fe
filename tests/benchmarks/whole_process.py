"""CPU seconds of whole processes, trajopt beside CasADi's mapped script: `python tests/benchmarks/whole_process.py`.

For each number of segments they are started in turn: trajopt, trajopt with `solver.library=casadi`, and the script, so
that what else the machine does falls on all, and ratios to the script are taken run by run: on a busy machine CPU
seconds grow, their ratios hardly do. `--repeats`, `--segments` and `--minutes` choose; a number of segments whose runs
would take longer than that has fewer of them, at least one. The biped, as it is shipped, is told last.

What is measured is what a user has: trajopt is installed by pip in a folder of its own, which compiles it to bytecode
as it installs, and all programs run where Python may keep the bytecode of what else they import. From a checkout
where it may not (PYTHONDONTWRITEBYTECODE) each run would compile trajopt again, a third of its CPU seconds.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from cartpole import ENVIRONMENT, HERE, SCRIPTS, timed

SEGMENTS = (25, 1000, 10_000, 100_000)
ROOT = Path(HERE).parents[1]


@dataclass(frozen=True)
class Pair:
    """CPU seconds of one run of each; fast: of trajopt with CasADi's IPOPT."""

    trajopt: float
    fast: float
    casadi: float

    @property
    def ratio(self) -> float:
        return self.trajopt / self.casadi

    @property
    def fast_ratio(self) -> float:
        return self.fast / self.casadi


def installed(folder: str) -> None:
    """Install trajopt in the folder, compiled, and let every program measured find it there first."""
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--compile", "--target", folder, str(ROOT)]
    subprocess.run(pip, check=True)
    ENVIRONMENT["PYTHONPATH"] = os.pathsep.join([folder, *filter(None, [os.environ.get("PYTHONPATH")])])


def solve(problem: str, *options: str) -> list[str]:
    """The command that solves a shipped problem."""
    trajopt = [sys.executable, "-c", "from trajopt.cli.main import main; main()", "solve"]
    return [*trajopt, str(ROOT / "problems" / f"{problem}.yaml"), "-q", "--force", "-o", "a.h5", *options]


def pair(segments: int, folder: str) -> Pair:
    """One run of each, the whole process: start-up, imports, solve; of trajopt the error estimate and the file, too."""
    trajopt = solve("cartpole", "--segments", str(segments))
    (script,) = SCRIPTS["CasADi mapped"]
    _, ours, _ = timed(trajopt, folder)
    _, fast, _ = timed([*trajopt, "--set", "solver.library=casadi"], folder)
    _, theirs, _ = timed([sys.executable, str(HERE / script), str(segments)], folder)
    return Pair(ours, fast, theirs)


def pairs(segments: int, repeats: int, minutes: float, folder: str) -> list[Pair]:
    """As many pairs as asked for, or as there is time for; the first one, which fills the system's cache, is not told
    where there are others."""
    began = time.monotonic()
    found = [pair(segments, folder)]
    while len(found) <= repeats and time.monotonic() - began < 60 * minutes:
        found.append(pair(segments, folder))
    return found[1:] or found


def row(segments: int, found: Sequence[Pair]) -> str:
    names = ("trajopt", "fast", "casadi", "ratio", "fast_ratio")
    middles = [f"{statistics.median(getattr(own, name) for own in found):.2f}" for name in names]
    spread = f"{min(own.ratio for own in found):.2f} to {max(own.ratio for own in found):.2f}"
    return " | ".join(["", str(segments), str(len(found)), *middles, spread, ""]).strip()


def kept_and_not(problem: str, repeats: int, folder: str) -> tuple[float, float]:
    """Median CPU seconds of solves that find what the one before has kept, and of those that find nothing."""
    command = solve(problem)
    timed(command, folder)
    kept = [timed(command, folder)[1] for _ in range(repeats)]
    first = [timed(["env", f"XDG_CACHE_HOME={folder}/{number}", *command], folder)[1] for number in range(repeats)]
    return statistics.median(kept), statistics.median(first)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--segments", type=int, nargs="+", default=list(SEGMENTS))
    parser.add_argument("--repeats", type=int, default=15, help="pairs for each number of segments")
    parser.add_argument("--minutes", type=float, default=5, help="for each number of segments")
    chosen = parser.parse_args()
    seconds = ("trajopt, CPU s", "with casadi's IPOPT", "CasADi mapped")
    heads = ("segments", "runs", *seconds, "ratio", "with casadi's", "runs from")
    print(f"| {' | '.join(heads)} |\n|{'--:|' * len(heads)}")
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as copy:
        installed(copy)
        for segments in chosen.segments:
            found = pairs(segments, chosen.repeats, chosen.minutes, folder)
            print(row(segments, found), flush=True)
        kept, first = kept_and_not("biped", min(chosen.repeats, 5), folder)
        print(f"\nbiped: {kept:.2f} CPU s; {first:.2f} where nothing is kept")


if __name__ == "__main__":
    main()
