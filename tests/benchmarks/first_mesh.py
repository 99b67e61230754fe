"""Which first mesh finds the best optimum known most often, and at what cost: a table.

    python tests/benchmarks/first_mesh.py [NAME|FILE ...] [--limit SECONDS] [-o table.md]

Each problem is solved from its own start on each of STARTS, and refined as a file without `mesh:` is, within a limit of
CPU seconds. The best objective that any of them found as an optimal point is the best known; a start has found it
if its own is as good by 1e-4 (1 + |J|), and "accurately" if no segment misses the tolerance, too. Problems in which no
mesh is chosen (without time, in discrete time), and those whose phases say meshes of their own, are left out.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from pathlib import Path
from typing import Any

import numpy as np

import trajopt
from trajopt.problems.catalog import shipped
from trajopt.problems.errors import SpecError

STARTS: dict[str, dict[str, Any]] = {
    "10 x radau 4": {"method": "radau", "segments": 10},
    "20 x radau 3": {"method": "radau", "segments": 20, "degree": 3},
    "hermite-simpson 20": {"method": "hermite-simpson", "segments": 20},
    "hermite-simpson 40": {"method": "hermite-simpson", "segments": 40},
}
FOUND = 1e-4
"""Relative to 1 + |J|: as good as the best."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--limit", type=float, default=20.0, help="CPU seconds that a solve may take")
    parser.add_argument("-o", "--output", type=Path)
    arguments = parser.parse_args()
    trajopt.solve(trajopt.load("cartpole"))  # loads what children share
    table = [f"| problem | {' | '.join(STARTS)} |", "|" + " --- |" * (len(STARTS) + 1)]
    print(*table, sep="\n", flush=True)
    rows = []
    for name in arguments.names or sorted(shipped()):
        row = [apart(name, mesh, arguments.limit) for mesh in STARTS.values()]
        if not all(row):
            continue
        rows.append(row)
        table.append(f"| {Path(name).stem} | {' | '.join(told(own, best(row)) for own in row)} |")
        print(table[-1], flush=True)
    table += ["", *summary(rows)]
    print(*table[-len(STARTS) - 1 :], sep="\n")
    if arguments.output:
        arguments.output.write_text("\n".join(table) + "\n")


def apart(name: str, mesh: dict[str, Any], limit: float) -> dict[str, Any] | None:
    """One solve in a process of its own; None if the file has no use for a mesh."""
    read, write = os.pipe()
    if child := os.fork():
        os.close(write)
        with os.fdopen(read) as answer:
            text = answer.read()
        os.waitpid(child, 0)
        found: dict[str, Any] | None = json.loads(text) if text else None
        return found
    with os.fdopen(write, "w") as answer:
        json.dump(measured(name, mesh, limit), answer)
    os._exit(0)


def measured(name: str, mesh: dict[str, Any], limit: float) -> dict[str, Any] | None:
    try:
        problem = trajopt.load(name, {"mesh": [mesh], "refine": {"tolerance": 1e-6, "max_meshes": 10}})
    except SpecError:
        return None
    began = time.process_time()
    solution = trajopt.solve(problem, stop=lambda: time.process_time() - began > limit)
    goal = problem.spec.objective
    return {
        "objective": solution.objective if solution.status in ("solved", "acceptable") else None,
        "accurate": bool(solution.solved and solution.meshes[-1].relative_error <= 1e-6),
        "maximize": bool(goal and goal.maximize is not None),
        "seconds": time.process_time() - began,
        "iterations": sum(own.iterations for own in solution.meshes),
    }


def best(row: list[dict[str, Any]]) -> float | None:
    objectives = [own["objective"] for own in row if own["objective"] is not None]
    if not objectives:
        return None
    return max(objectives) if row[0]["maximize"] else min(objectives)


def is_found(own: dict[str, Any], known: float | None) -> bool:
    if known is None or own["objective"] is None:
        return False
    return bool(abs(own["objective"] - known) <= FOUND * (1 + abs(known)))


def told(own: dict[str, Any], known: float | None) -> str:
    if own["objective"] is None:
        return f"no solution, {own['seconds']:.1f} s"
    mark = "" if is_found(own, known) else " (lesser)"
    return f"{own['objective']:.7g}{mark}{'' if own['accurate'] else ' inaccurate'}, {own['seconds']:.1f} s"


def summary(rows: list[list[dict[str, Any]]]) -> list[str]:
    lines = []
    first = np.array([row[0]["seconds"] for row in rows])
    for i, name in enumerate(STARTS):
        own = [row[i] for row in rows]
        found = [is_found(one, best(row)) for one, row in zip(own, rows, strict=True)]
        accurate = [one["accurate"] and good for one, good in zip(own, found, strict=True)]
        seconds = np.array([one["seconds"] for one in own])
        lines.append(
            f"{name}: the best in {sum(found)} of {len(rows)}, accurately in {sum(accurate)}; CPU seconds "
            f"{seconds.sum():.0f} in all, {np.median(seconds / first):.2f} of the first column in the median"
        )
    return lines


if __name__ == "__main__":
    main()
