"""Does the error bar of the objective hold, and is it tight? A table by method and by problem, and a picture.

    python tests/benchmarks/error_bar.py [-o error_bar.png] [--all]

Every problem of `known_optima` is solved by every method that has costates on three meshes. A case is covered if
|J - J*| <= bar; its ratio is bar / |J - J*|, where errors below 1e-11 (1 + |J|), which are rounding, count as that.
Only points that the engine calls optimal count. --all prints every case when it is solved.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from known_optima import KNOWN, Known

from trajopt.transcription.engines.outcome import Status
from trajopt.transcription.engines.watch import Watch
from trajopt.transcription.one_mesh import Origin, solve_mesh
from trajopt.transcription.settings import Settings, Step
from trajopt.transcription.solution.objective_error import ObjectiveError, objective_error

METHODS = {  # how many points of a second-order method a segment replaces
    "explicit-euler": 1, "implicit-euler": 1, "midpoint": 1, "trapezoid": 1, "hermite-simpson": 2,
    "hermite-simpson-compressed": 2, "gauss": 4, "radau": 4, "radau-left": 4, "lobatto": 4, "chebyshev": 4,
    "runge-kutta-2": 1, "runge-kutta-4": 2, "dormand-prince": 2,
}  # fmt: skip
FINER = (1, 2, 4)
TOLERANCE = 1e-8
SETTINGS = Settings({"max_iter": 400}, coarse_start=False)
ROUNDING = 1e-11
WANTED_COVERAGE, WANTED_RATIO = 0.95, 30.0


@dataclass(frozen=True)
class Case:
    problem: str
    method: str
    segments: int
    objective: float
    optimum: float
    estimate: ObjectiveError
    cost: float

    @property
    def error(self) -> float:
        return abs(self.objective - self.optimum)

    @property
    def corrected(self) -> float:
        return abs(self.objective + self.estimate.correction - self.optimum)

    @property
    def covered(self) -> bool:
        return self.error <= self.estimate.bar

    @property
    def ratio(self) -> float:
        return self.estimate.bar / max(self.error, ROUNDING * (1 + abs(self.objective)))

    def __str__(self) -> str:
        what = f"{self.problem:28}{self.method:28}{self.segments:5}"
        return f"{what}{self.error:10.1e}{self.estimate.bar:10.1e}{self.ratio:9.1f}  {'' if self.covered else 'missed'}"


def run(known: Known, method: str, segments: int) -> Case | str:
    """The case, or why there is none."""
    problem = known.problem()
    meshes = [Step(method, segments, TOLERANCE).mesh() for _ in problem.phases]
    began = time.perf_counter()
    solution, solved = solve_mesh(problem, meshes, TOLERANCE, SETTINGS, Origin(None, None), Watch(None, None, 0))
    ended = time.perf_counter()
    if solution.status is not Status.SOLVED:
        return solution.status.name.lower()
    estimate = objective_error(solved.transcription, solved.nlp, solved.outcome, solved.trajectories)
    cost = (time.perf_counter() - ended) / (ended - began)
    if not estimate.applies:
        return estimate.why_not
    return Case(known.name, method, segments, solution.objective, known.optimum, estimate, cost)


def runs() -> Iterator[Case | str]:
    for known in KNOWN:
        for method, points in METHODS.items():
            for finer in FINER:
                yield run(known, method, max(known.segments * finer // points, 2))


def table(cases: list[Case], key: str) -> None:
    print(f"\n{key:30}{'cases':>6}{'covered':>9}{'bar/error':>11}{'corrected/error':>17}{'cost':>7}")
    for name in dict.fromkeys(getattr(case, key) for case in cases):
        line([case for case in cases if getattr(case, key) == name], name)
    line(cases, "all")


def line(cases: list[Case], name: str) -> None:
    """Medians of the cases."""
    covered = np.mean([case.covered for case in cases])
    floor = [max(case.error, ROUNDING * (1 + abs(case.objective))) for case in cases]
    gain = np.median([case.corrected / error for case, error in zip(cases, floor, strict=True)])
    ratio, cost = np.median([case.ratio for case in cases]), np.median([case.cost for case in cases])
    print(f"{name:30}{len(cases):6}{100 * covered:8.1f}%{ratio:11.2f}{gain:17.3f}{100 * cost:6.0f}%")


def draw(cases: list[Case], path: str) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, ax = plt.subplots(figsize=(8, 6.5), constrained_layout=True)
    for i, method in enumerate(METHODS):
        own = [case for case in cases if case.method == method]
        scale = [1 + abs(case.optimum) for case in own]
        errors = [max(case.error / s, 1e-16) for case, s in zip(own, scale, strict=True)]
        bars = [max(case.estimate.bar / s, 1e-16) for case, s in zip(own, scale, strict=True)]
        ax.loglog(errors, bars, "osD^v<>"[i % 7], ms=4, color=f"C{i % 10}", alpha=0.7, label=method)
    ends = np.array([1e-16, 1e2])
    for factor, style in ((1, "-"), (10, "--"), (100, ":")):
        ax.plot(ends, factor * ends, "k" + style, lw=0.8, label=f"bar = {factor} x error" if factor > 1 else None)
    ax.set(xlabel="|J - J*| / (1 + |J*|)", ylabel="bar / (1 + |J*|)", xlim=ends, ylim=ends)
    ax.legend(fontsize=7, ncols=2, loc="lower right")
    ax.grid(True, which="major", alpha=0.3)
    figure.savefig(path, dpi=150)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", default="error_bar.png")
    parser.add_argument("--all", action="store_true")
    arguments = parser.parse_args()
    cases, left_out = [], []
    for result in runs():
        (cases if isinstance(result, Case) else left_out).append(result)
        if arguments.all:
            print(result, flush=True)
    table(cases, "problem")
    table(cases, "method")
    print(f"\nleft out: {', '.join(left_out) or 'none'}\nmissed:")
    print(*[case for case in cases if not case.covered], sep="\n")
    coverage, ratio = np.mean([case.covered for case in cases]), np.median([case.ratio for case in cases])
    good = coverage >= WANTED_COVERAGE and ratio <= WANTED_RATIO
    wanted = f"wanted: at least {100 * WANTED_COVERAGE:.0f}% and at most {WANTED_RATIO:.0f}"
    print(f"covered {100 * coverage:.1f}%, median ratio {ratio:.2f}; {wanted}: {'met' if good else 'not met'}")
    draw(cases, arguments.o)


if __name__ == "__main__":
    main()
