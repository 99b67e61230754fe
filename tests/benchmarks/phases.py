"""Two phases against one: the cart-pole swing-up cut at its middle, time and states linked, N segments in all.

    python tests/benchmarks/phases.py --segments 25 100 1000 --repeats 5

Each run is a process of its own, `trajopt solve`, from start to end, and the two take turns. The ratio is of CPU
seconds, two phases over one, pair by pair; its median is what counts.
"""

from __future__ import annotations

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

import yaml

from trajopt.problems.catalog import shipped

ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


def in_two_phases(text: str) -> str:
    """The swing-up whose first phase ends at T/2 and whose second begins there; the guess is one line through both."""
    data = yaml.safe_load(text)
    data["parameters"]["half"] = "T/2"
    data["phases"] = {"first": {"time": {"final": "half"}}, "second": {}}
    data["guess"] = {"keyframes": {"time": [0, "T"], **{name: [0, end] for name, end in (("q1", "d"), ("q2", "pi"))}}}
    return yaml.safe_dump(data, sort_keys=False)


def cpu_seconds(file: Path, segments: int) -> float:
    """Of one `trajopt solve`, user and system."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-m", "trajopt.cli.main", "solve", str(file), "--set", f"mesh.0.segments={segments}"]
    command += ["--set", "solver.coarse_start=false", "-o", str(file.with_suffix(".h5")), "--force"]
    subprocess.run(command, check=True, capture_output=True, env={**os.environ, **ONE_THREAD}, cwd=file.parent)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--segments", type=int, nargs="+", default=[25, 100, 1000])
    parser.add_argument("--repeats", type=int, default=5)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        one, two = Path(folder) / "one.yaml", Path(folder) / "two.yaml"
        text = shipped()["cartpole"].read_text()
        one.write_text(text)
        two.write_text(in_two_phases(text))
        for n in given.segments:
            pairs = [(cpu_seconds(one, n), cpu_seconds(two, n // 2)) for _ in range(given.repeats)]
            first, second = (statistics.median(column) for column in zip(*pairs, strict=True))
            ratio = statistics.median(b / a for a, b in pairs)
            print(f"N = {n:5d}: one phase {first:.3f} s, two {second:.3f} s of CPU, ratio {ratio:.3f}", flush=True)


if __name__ == "__main__":
    main()
