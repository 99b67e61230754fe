"""The long campaigns: `python -m tests.hostile KIND` prints how runs ended, and each that ended badly."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Iterator
from itertools import chain, islice
from pathlib import Path

from . import problem_files
from .campaign import COMMANDS, campaign
from .disks import CASES
from .disks import runs as of_disks
from .files import OLD, RESULTS, always, bad_files, good_results
from .full_disk import COMMANDS as COMMANDS_THAT_WRITE
from .full_disk import LEFT
from .full_disk import runs as of_full_disks
from .life import grows, life
from .moments import runs as of_moments
from .processes import Count, Run, preload
from .sweeps import runs as of_sweeps


def results(told: argparse.Namespace, folder: Path, count: Count) -> Iterator[Iterator[Run]]:
    sources = good_results(folder, told.sources)
    preload()
    bad = chain(always(sources[0]), bad_files(sources, told.files, told.seed))
    yield from (runs for _, runs in campaign(bad, sources[0], folder, told.commands, count.unmade))


def problems(told: argparse.Namespace, folder: Path, count: Count) -> Iterator[Iterator[Run]]:
    preload()
    for text in islice(problem_files.texts(told.files, told.seed), told.skip, None):
        yield problem_files.runs(text, folder)


def written(told: argparse.Namespace, folder: Path, count: Count) -> Iterator[Iterator[Run]]:
    preload()
    for text in islice(problem_files.written(told.files, told.seed), told.skip, None):
        yield problem_files.runs(text, folder)


def moments(told: argparse.Namespace, folder: Path, count: Count) -> Iterator[Iterator[Run]]:
    yield from (iter([run]) for run in of_moments(told.files, told.seed, folder))


def disks(told: argparse.Namespace, folder: Path, count: Count) -> Iterator[Iterator[Run]]:
    yield from (iter([run]) for run in of_disks(CASES[: told.files], folder))


def full(told: argparse.Namespace, folder: Path, count: Count) -> Iterator[Iterator[Run]]:
    yield from (iter([run]) for run in islice(of_full_disks(folder), told.files))


def sweeps(told: argparse.Namespace, folder: Path, count: Count) -> Iterator[Iterator[Run]]:
    more = ["--scheduler", told.scheduler] if told.scheduler else []
    yield from (iter([run]) for run in of_sweeps(told.files, told.seed, folder, more))


def long_life(count: int) -> int:
    """Print what many solves in one process leave; 1 if that grows."""
    marks = {}
    with tempfile.TemporaryDirectory() as name:
        for solves, own in life(count, Path(name)):
            marks[solves] = own
            print(f"{solves} solves: " + ", ".join(f"{what} {value}" for what, value in own.items()), flush=True)
    grown = grows(marks)
    print("grows: " + (", ".join(grown) or "nothing"))
    return int(bool(grown))


KINDS = {
    "results": (results, 1570),
    "problems": (problems, 2000),
    "written": (written, 1000),
    "moments": (moments, 300),
    "disks": (disks, len(CASES)),
    "sweeps": (sweeps, 100),
    "full": (full, len(COMMANDS_THAT_WRITE) * len(LEFT)),
}
"""Name -> the runs of each file, moment or case, and how many of them."""
ALL = "all"
"""Each of them in turn."""


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=[*KINDS, ALL, "life"])
    parser.add_argument("--files", type=int, default=0, help="how many, of all that there are")
    parser.add_argument("--seed", type=int, default=0, help="of the choice among them")
    parser.add_argument("--skip", type=int, default=0, help="problem files to leave out at the start")
    parser.add_argument("--seconds", type=float, default=float("inf"), help="stop after so many")
    parser.add_argument("--commands", nargs="*", default=list(COMMANDS), help=", ".join(COMMANDS))
    parser.add_argument("--sources", nargs="*", default=[*RESULTS, OLD], help="results that are made bad")
    parser.add_argument("--scheduler", default="", help="of a Dask cluster, for the sweeps")
    told = parser.parse_args()
    if told.kind == "life":
        return long_life(told.files or 1000)
    counts = [campaign_of(kind, told) for kind in (KINDS if told.kind == ALL else [told.kind])]
    return int(any(count.faults for count in counts))


def campaign_of(kind: str, told: argparse.Namespace) -> Count:
    """Run a campaign, print each run that ends badly, and the counts at the end."""
    make, usual = KINDS[kind]
    own = argparse.Namespace(**{**vars(told), "files": told.files or usual})
    start, count = time.monotonic(), Count()
    with tempfile.TemporaryDirectory() as name:
        for runs in make(own, Path(name), count):
            count.files += 1
            for run in runs:
                count.add(run)
                if run.fault:
                    last = (run.err.strip().splitlines() or [""])[-1]
                    print(f"{run.fault}: {run.bad}: {run.command}: {run.seconds:.1f} s: {last[:200]}", flush=True)
            if count.files % 100 == 0:
                print(f"{count.files} files, {time.monotonic() - start:.0f} s", file=sys.stderr, flush=True)
            if time.monotonic() - start > told.seconds:
                break
    print(f"\n{kind}: {count.files} files, {count.runs} runs, {time.monotonic() - start:.0f} s")
    print("exit codes:", ", ".join(f"{code}: {n}" for code, n in sorted(count.codes.items())))
    if count.unmade:
        print(f"could not be made: {len(count.unmade)}: {', '.join(count.unmade)}"[:2000])
    print(f"ended badly: {len(count.faults)}", flush=True)
    return count


if __name__ == "__main__":
    raise SystemExit(main())
