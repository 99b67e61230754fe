"""Refinement by the local error, which is the default, against refinement by the error bar of the objective.

    python tests/benchmarks/default_refinement.py [NAME ...] [--limit SECONDS] [-o table.md]

Every shipped problem with a reference optimum and a mesh to refine is solved twice from its own file, each in a process
of its own: with
`--refine 1e-6` and with `--accuracy 1e-6`. The table has unknowns of the last mesh, CPU seconds of the whole process,
the true error |J - reference| / (1 + |J|) and the error bar relative to 1 + |J|. A true error cannot be seen below the
digits of the reference.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.transcription.loading import load_file

WAYS = {"local error": "--refine", "error bar": "--accuracy"}
ASKED = "1e-6"
HEAD = ("problem", *(f"{what}, {way}" for way in WAYS for what in ("unknowns", "CPU s", "true error", "bar")))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--limit", type=float, default=60.0, help="seconds that a solve may take")
    parser.add_argument("-o", "--output", type=Path)
    arguments = parser.parse_args()
    lines = ["| " + " | ".join(HEAD) + " |", "|" + " --- |" * len(HEAD)]
    print("\n".join(lines))
    both = []
    for name in arguments.names or sorted(shipped()):
        spec = load_file(name)
        reference = spec.reference
        if reference is None or reference.objective is None or all(phase.exact for phase in build(spec).phases):
            continue
        found = [measured(name, option, float(reference.objective), arguments.limit) for option in WAYS.values()]
        lines.append(f"| {name} | " + " | ".join(cell for own in found for cell in told(own)) + " |")
        print(lines[-1], flush=True)
        if all(own is not None for own in found):
            both.append(found)
    lines += ["", *summary(both)]
    print("\n".join(lines[-len(summary(both)) - 1 :]))
    if arguments.output:
        arguments.output.write_text("\n".join(lines) + "\n")


def measured(name: str, option: str, reference: float, limit: float) -> dict[str, float] | None:
    """One solve; None if it is not solved within the limit."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-c", "from trajopt.cli.main import main; main()", "solve", name, option, ASKED]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        run = subprocess.run(
            [*command, "--json", "--time-limit", str(limit), "-o", f"{folder}/result.h5"],
            capture_output=True, text=True, check=False,
        )  # fmt: skip
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    told = json.loads(run.stdout)
    if not told["solved"]:
        return None
    size = 1 + abs(told["objective"])
    return {
        "unknowns": told["meshes"][-1]["unknowns"],
        "seconds": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime,
        "error": abs(told["objective"] - reference) / size,
        "bar": (told["objective_error"] or np.nan) / size,
    }


def told(found: dict[str, float] | None) -> list[str]:
    if found is None:
        return ["not solved", "", "", ""]
    return [f"{found['unknowns']}", f"{found['seconds']:.2f}", f"{found['error']:.1e}", f"{found['bar']:.1e}"]


def summary(both: list) -> list[str]:
    """Medians of the ratios of the second way to the first."""
    if not both:
        return ["nothing was solved by both"]
    lines = []
    for key in ("unknowns", "seconds", "bar"):
        ratios = [bar[key] / local[key] for local, bar in both if local[key] > 0]
        lines.append(
            f"{key}: the error bar takes {np.nanmedian(ratios):.2f} of the local error (median of {len(ratios)})"
        )
    worst = [[own["error"] for own in pair] for pair in both]
    lines.append(
        "largest true error: " + ", ".join(f"{e:.1e} ({w})" for e, w in zip(np.max(worst, axis=0), WAYS, strict=True))
    )
    return lines


if __name__ == "__main__":
    main()
