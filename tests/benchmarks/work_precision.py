"""Accuracy against time of several methods on cart-pole and biped: a table, and a work-precision picture.

    python tests/benchmarks/work_precision.py [-o work_precision.png] [--repeats 3]

Error is the distance of the objective from its converged value; time is one solve from the problem file's own guess,
start-up and compilation of the first run not counted (each method is run once before it is timed).
"""

from __future__ import annotations

import argparse
import json
import statistics
import time

from trajopt.problems.build import build_all
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load
from trajopt.transcription.settings import Settings, Step
from trajopt.transcription.solve import solve

CONVERGED = {"cartpole": 58.80766746, "biped": 390.79053817}
LADDERS = {
    "trapezoid": [Step("trapezoid", n, 1e-9) for n in (25, 50, 100, 200, 400, 800)],
    "hermite-simpson": [Step("hermite-simpson", n, 1e-9) for n in (10, 20, 40, 80, 160, 320)],
    "hp radau, degree 5": [Step("radau", n, 1e-9, 5) for n in (3, 5, 10, 20, 40)],
    "global chebyshev": [Step("chebyshev", 1, 1e-9, n) for n in (10, 15, 20, 30, 40, 60)],
    "runge-kutta-4 shooting": [Step("runge-kutta-4", n, 1e-9) for n in (25, 50, 100, 200, 400)],
}


def measure(name: str, step: Step, repeats: int) -> dict | None:
    """Error, median seconds and points of one solve; None if it fails."""
    spec = load(shipped()[name])
    problem = build_all(spec)[-1]
    seconds = []
    for _ in range(repeats + 1):
        began = time.perf_counter()
        solution = solve(problem, [step], Settings())
        seconds.append(time.perf_counter() - began)
    if not solution.solved:
        return None
    return {
        "error": abs(solution.objective - CONVERGED[name]),
        "seconds": statistics.median(seconds[1:]),
        "points": len(solution.trajectories[0].times),
        "iterations": solution.meshes[-1].iterations,
    }


def draw(rows: list[dict], path: str) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, len(CONVERGED), figsize=(11, 4.5), constrained_layout=True)
    for ax, name in zip(axes, CONVERGED, strict=True):
        for method, marker in zip(LADDERS, "osD^v", strict=True):
            own = [row for row in rows if (row["problem"], row["method"]) == (name, method)]
            ax.loglog([r["seconds"] for r in own], [max(r["error"], 1e-9) for r in own], marker=marker, label=method)
        ax.set(title=name, xlabel="seconds of one solve", ylabel="error of the objective")
        ax.grid(True, which="major", alpha=0.3)
    axes[0].legend()
    figure.savefig(path, dpi=150)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("-o", default="work_precision.png")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    rows = []
    print(f"{'problem':10}{'method':24}{'segments':>9}{'degree':>7}{'points':>8}{'error':>10}{'seconds':>9}{'iter':>6}")
    for name in CONVERGED:
        for method, ladder in LADDERS.items():
            for step in ladder:
                row = measure(name, step, arguments.repeats)
                shown = f"{name:10}{method:24}{step.segments:9}{step.degree or '':>7}"
                if row is None:
                    print(f"{shown}{'not solved':>16}")
                    continue
                print(f"{shown}{row['points']:8}{row['error']:10.1e}{row['seconds']:9.3f}{row['iterations']:6}")
                rows.append({"problem": name, "method": method, "segments": step.segments, **row})
    if arguments.json:
        print(json.dumps(rows))
    draw(rows, arguments.o)


if __name__ == "__main__":
    main()
