"""`python -m tests.hostile --files 1500`: the long campaign; prints how the runs ended, and each that ended badly."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from itertools import chain
from pathlib import Path

from .campaign import COMMANDS, Count, campaign, preload
from .files import OLD, RESULTS, always, bad_files, good_results


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--files", type=int, default=1500, help="bad files; all kinds of damage are some 20 000")
    parser.add_argument("--seed", type=int, default=0, help="of the choice among them")
    parser.add_argument("--seconds", type=float, default=float("inf"), help="stop after so many")
    parser.add_argument("--commands", nargs="*", default=list(COMMANDS), help=", ".join(COMMANDS))
    parser.add_argument("--sources", nargs="*", default=[*RESULTS, OLD], help="results that are made bad")
    told = parser.parse_args()
    start, count = time.monotonic(), Count()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        sources = good_results(folder, told.sources)
        preload()
        bad = chain(always(sources[0]), bad_files(sources, told.files, told.seed))
        for own, runs in campaign(bad, sources[0], folder, told.commands):
            count.files += 1
            for run in runs:
                count.add(run)
                if run.fault:
                    last = (run.err.strip().splitlines() or [""])[-1]
                    print(f"{run.fault}: {own.source.stem}: {own.name}: {run.command}: {last[:200]}", flush=True)
            if count.files % 100 == 0:
                print(f"{count.files} files, {time.monotonic() - start:.0f} s", file=sys.stderr, flush=True)
            if time.monotonic() - start > told.seconds:
                break
    print(f"\n{count.files} files, {count.runs} runs, {time.monotonic() - start:.0f} s")
    print("exit codes:", ", ".join(f"{code}: {n}" for code, n in sorted(count.codes.items())))
    print(f"ended badly: {len(count.faults)}")
    return int(bool(count.faults))


if __name__ == "__main__":
    raise SystemExit(main())
