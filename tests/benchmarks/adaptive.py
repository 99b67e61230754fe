"""The cart-pole swing-up to a relative error of 1e-8: adaptive meshes against the equal ones that reach the same error.

    python tests/benchmarks/adaptive.py [--repeats 5]

Each schedule is solved once before it is timed, so that machine code is there for both. An equal mesh is solved from
the guess, as the file gives it, and from the solution on a coarse mesh, which is a refinement of its own.
"""

from __future__ import annotations

import argparse
import statistics
import time

from trajopt.problems.build import build_all
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load
from trajopt.transcription.settings import Refine, Settings, Step
from trajopt.transcription.solve import solve

TOLERANCE = 1e-8
PAIRS = [  # a first mesh to refine, and the method and degree of the equal mesh
    (Step("hermite-simpson", 20, 1e-9), Step("hermite-simpson", 0, 1e-9)),
    (Step("radau", 20, 1e-9, 6), Step("radau", 0, 1e-9, 4)),
    (Step("radau", 20, 1e-9, 6), Step("radau", 0, 1e-9, 6)),
    (Step("radau", 20, 1e-9, 6), Step("hermite-simpson", 0, 1e-9)),
]
STEP = 1.05  # between the numbers of segments that are tried


def timed(problem, step: Step, settings: Settings, repeats: int):
    solution, seconds = solve(problem, [step], settings), []
    for _ in range(repeats):
        began = time.perf_counter()
        solution = solve(problem, [step], settings)
        seconds.append(time.perf_counter() - began)
    return solution, statistics.median(seconds)


def coarsest(problem, step: Step) -> Step:
    """The coarsest equal mesh, within 5 %, that meets the tolerance."""
    segments = 20
    while True:
        attempt = Step(step.method, segments, step.tolerance, step.degree)
        if solve(problem, [attempt]).meshes[-1].relative_error <= TOLERANCE:
            return attempt
        segments = int(segments * STEP) + 1


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=5)
    repeats = parser.parse_args().repeats
    problem = build_all(load(shipped()["cartpole"]))[0]
    print(f"{'mesh':42}{'meshes':>7}{'segments':>9}{'points':>8}{'error':>10}{'seconds':>9}")
    for first, equal in PAIRS:
        for kind, step, settings in (
            ("adaptive", first, Settings(refine=Refine(TOLERANCE, 12))),
            ("equal", coarsest(problem, equal), Settings(coarse_start=False)),
            ("equal, coarse start", coarsest(problem, equal), Settings()),
        ):
            solution, seconds = timed(problem, step, settings, repeats)
            mesh = solution.meshes[-1]
            name = f"{kind} {step.method}" + (f", degree {step.degree}" if step.degree else "")
            points = len(solution.trajectories[0].times)
            shown = f"{name:42}{len(solution.meshes):7}{mesh.mesh.segments:9}{points:8}"
            print(f"{shown}{mesh.relative_error:10.1e}{seconds:9.3f}")


if __name__ == "__main__":
    main()
