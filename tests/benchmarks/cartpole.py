"""Measure trajopt against CasADi on the cart-pole swing-up: `python tests/benchmarks/cartpole.py`.

Every run is a process of its own, so that nothing is warm and the peak memory is that run's. The tools take turns, so
that what else the machine does falls on all of them. README.md says what the columns mean.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from datetime import date
from importlib.metadata import version
from pathlib import Path

HERE = Path(__file__).resolve().parent
OPTI_LIMIT = 1000  # segments: beyond, Opti takes minutes
SCRIPTS = {
    "trajopt": ["cartpole_trajopt.py"],
    "trajopt direct": ["cartpole_trajopt.py", "solver.coarse_start=false"],
    "CasADi mapped": ["cartpole_casadi_mapped.py"],
    "CasADi Opti": ["cartpole_casadi_opti.py"],
}
PARTS = ("import", "build", "compile", "solve", "evaluate", "total", "CPU", "process")
# BLAS on one thread for every tool: more threads slow MUMPS down, and CPU seconds would count their idling.
ENVIRONMENT = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
# Where Python may not keep what it has compiled, each run compiles trajopt again: a third of its CPU seconds.
ENVIRONMENT.pop("PYTHONDONTWRITEBYTECODE", None)


def timed(command: Sequence[str], folder: str) -> tuple[float, float, str]:
    """Run a command to its end: seconds by the clock, CPU seconds, what it printed. Raises RuntimeError if it fails."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.perf_counter()
    run = subprocess.run(command, capture_output=True, text=True, env=ENVIRONMENT, cwd=folder, check=False)
    seconds = time.perf_counter() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if run.returncode:
        raise RuntimeError(f"{' '.join(command)} ended with code {run.returncode}:\n{run.stderr}")
    return seconds, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, run.stdout


def measure(tool: str, segments: int, folder: str) -> dict:
    """One cold run of one tool: its own record, with the seconds of the whole process."""
    script, *arguments = SCRIPTS[tool]
    seconds, _, output = timed([sys.executable, str(HERE / script), str(segments), *arguments], folder)
    record = json.loads(output)
    if not record["solved"]:
        raise RuntimeError(f"{tool} did not solve {segments} segments")
    return {**record, "process": seconds}


def solves(segments: Sequence[int], repeats: int, opti_always: bool, folder: str) -> list[dict]:
    """A record for each number of segments and tool: the median and the minimum of each part over the repeats."""
    table = []
    for n in segments:
        tools = [tool for tool in SCRIPTS if tool != "CasADi Opti" or n <= OPTI_LIMIT or opti_always]
        runs = {tool: [] for tool in tools}
        for _ in range(repeats):
            for tool in tools:
                runs[tool].append(measure(tool, n, folder))
                print(".", end="", file=sys.stderr, flush=True)
        for tool in tools:
            table.append(summary(tool, n, runs))
    print(file=sys.stderr)
    return table


def summary(tool: str, segments: int, every: dict[str, list[dict]]) -> dict:
    runs = every[tool]

    def ratio(ours: str, choose: Callable, part: str = "total") -> float:
        return choose(run[part] for run in every[ours]) / choose(run[part] for run in runs)

    return {
        "segments": segments,
        "tool": tool,
        "median": {part: statistics.median(run[part] for run in runs) for part in PARTS},
        "min": {part: min(run[part] for run in runs) for part in PARTS},
        "share": statistics.median(run["evaluate"] / run["solve"] for run in runs),
        "memory": max(run["memory"] for run in runs),
        "iterations": runs[0]["iterations"],
        "objective": runs[0]["objective"],
        "ratio of medians": ratio("trajopt", statistics.median),
        "ratio of minima": ratio("trajopt", min),
        "direct ratio of medians": ratio("trajopt direct", statistics.median),
        "direct ratio of minima": ratio("trajopt direct", min),
    }


def cold(repeats: int, folder: str) -> list[dict]:
    """Whole processes as they are typed, 25 segments."""
    trajopt = str(Path(sys.executable).with_name("trajopt"))
    commands = {
        "trajopt solve problems/cartpole.yaml": [
            trajopt, "solve", str(HERE.parents[1] / "problems" / "cartpole.yaml"), "--force",
        ],
        "CasADi Opti script": [sys.executable, str(HERE / SCRIPTS["CasADi Opti"][0]), "25"],
        "CasADi mapped script": [sys.executable, str(HERE / SCRIPTS["CasADi mapped"][0]), "25"],
        "trajopt --help": [trajopt, "--help"],
        "python -c pass": [sys.executable, "-c", "pass"],
    }  # fmt: skip
    runs = {name: [] for name in commands}
    for number in range(repeats + 1):
        for name, command in commands.items():
            seconds, cpu, _ = timed(command, folder)
            if number:  # the first round brings the files into the system's cache
                runs[name].append((seconds, cpu))
    return [
        {
            "command": name,
            "median": statistics.median(s for s, _ in pairs),
            "min": min(s for s, _ in pairs),
            "CPU": statistics.median(c for _, c in pairs),
        }
        for name, pairs in runs.items()
    ]


def machine() -> str:
    versions = [f"{name} {version(name)}" for name in ("casadi", "pyomo", "cyipopt-wheels", "symengine", "numpy")]
    hardware = f"{os.cpu_count()} cores {platform.machine()}, Python {platform.python_version()}"
    return f"{date.today()}, {hardware}, {', '.join(versions)}"


def layout(rows: list[Sequence[str]], markdown: bool) -> str:
    """Rows, the first of them the header, as aligned columns."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    edge, gap = ("| ", " | ") if markdown else ("", "  ")
    lines = [edge + gap.join(cell.rjust(w) for cell, w in zip(row, widths, strict=True)) + edge[::-1] for row in rows]
    if markdown:
        lines.insert(1, "|" + "|".join("-" * (w + 1) + ":" for w in widths) + "|")
    return "\n".join(lines)


def solves_table(table: list[dict], statistic: str, markdown: bool) -> str:
    parts = ("import", "build", "compile", "solve", "total", "CPU", "process")
    header = ["N", "tool", *parts, "eval %", "peak MB", "iter", "objective", "ratio", "direct"]
    ratio = {"median": "ratio of medians", "min": "ratio of minima"}[statistic]
    rows = [
        [
            str(row["segments"]), row["tool"], *(f"{row[statistic][part]:.3f}" for part in parts),
            f"{100 * row['share']:.1f}", f"{row['memory'] / 1e6:.0f}", str(row["iterations"]),
            f"{row['objective']:.8f}", f"{row[ratio]:.2f}", f"{row['direct ' + ratio]:.2f}",
        ]
        for row in table
    ]  # fmt: skip
    return layout([header, *rows], markdown)


def cold_table(table: list[dict], markdown: bool) -> str:
    header = ["whole process, cold", "median s", "min s", "CPU s"]
    rows = [[row["command"], *(f"{row[part]:.3f}" for part in ("median", "min", "CPU"))] for row in table]
    return layout([header, *rows], markdown)


def report(result: dict, markdown: bool) -> str:
    parts = [result["machine"]]
    if result["solves"]:
        parts += [f"Seconds, median of {result['repeats']} runs:", solves_table(result["solves"], "median", markdown)]
        parts += ["Seconds, minimum:", solves_table(result["solves"], "min", markdown)]
    if result["cold"]:
        parts.append(cold_table(result["cold"], markdown))
    return "\n\n".join(parts) + "\n"


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--segments", type=int, nargs="*", default=[25, 100, 1000, 10000])
    parser.add_argument("--repeats", type=int, default=5, help="runs of each tool and number of segments")
    parser.add_argument("--cold-repeats", type=int, default=15, help="runs of each whole command; 0 for none")
    parser.add_argument("--opti-always", action="store_true", help=f"run Opti above {OPTI_LIMIT} segments too")
    parser.add_argument("--markdown", type=Path, help="write the tables to this file too")
    parser.add_argument("--json", type=Path, help="write the numbers to this file")
    return parser.parse_args()


def main() -> None:
    wanted = arguments()
    with tempfile.TemporaryDirectory() as folder:
        result = {
            "machine": machine(),
            "repeats": wanted.repeats,
            "solves": solves(wanted.segments, wanted.repeats, wanted.opti_always, folder),
            "cold": cold(wanted.cold_repeats, folder) if wanted.cold_repeats else [],
        }
    print(report(result, markdown=False), end="")
    if wanted.markdown:
        wanted.markdown.write_text(report(result, markdown=True))
    if wanted.json:
        wanted.json.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
