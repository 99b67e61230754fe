"""The cart-pole swing-up to a relative error of 1e-8: adaptive meshes against the equal ones that reach the same error.

    python tests/benchmarks/adaptive.py [--repeats 9]

The runs of a group take turns, after each was solved once, so that machine code is there for all. Ratios are those to
the adaptive run. An equal mesh is solved from the guess, as the file gives it, and from the solution on a coarse mesh,
which is a refinement of its own.
"""

from __future__ import annotations

import argparse
import statistics
import time
from collections.abc import Iterator
from dataclasses import replace

from trajopt.problems.build import build_all
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load
from trajopt.transcription.settings import Refine, Settings, Step
from trajopt.transcription.solution.solution import Solution
from trajopt.transcription.solve import solve

TOLERANCE = 1e-8
GROUPS = [  # a first mesh to refine, and the methods and degrees of the equal meshes
    (Step("hermite-simpson", 20, 1e-9), [Step("hermite-simpson", 0, 1e-9)]),
    (
        Step("radau", 20, 1e-9, 6),
        [Step("hermite-simpson", 0, 1e-9), Step("radau", 0, 1e-9, 4), Step("radau", 0, 1e-9, 6)],
    ),
]
STEP = 1.05  # between the numbers of segments that are tried
COLUMNS = ("mesh", "meshes", "segments", "points", "ratio", "error", "seconds", "ratio")


def coarsest(problem, step: Step) -> Step:
    """The coarsest equal mesh, within 5 %, that meets the tolerance."""
    segments = 20
    while True:
        attempt = replace(step, segments=segments)
        if solve(problem, [attempt]).meshes[-1].relative_error <= TOLERANCE:
            return attempt
        segments = int(segments * STEP) + 1


def runs(problem, first: Step, equals: list[Step]) -> Iterator[tuple[str, Step, Settings]]:
    yield "adaptive", first, Settings(refine=Refine(TOLERANCE, 12))
    for equal in equals:
        step = coarsest(problem, equal)
        yield "equal", step, Settings(coarse_start=False)
        yield "equal, coarse start", step, Settings()


def timed(problem, step: Step, settings: Settings) -> tuple[float, Solution]:
    began = time.perf_counter()
    solution = solve(problem, [step], settings)
    return time.perf_counter() - began, solution


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeats", type=int, default=9)
    repeats = parser.parse_args().repeats
    problem = build_all(load(shipped()["cartpole"]))[0]
    print("| " + " | ".join(COLUMNS) + " |\n|:--|" + "--:|" * (len(COLUMNS) - 1))
    for first, equals in GROUPS:
        group = list(runs(problem, first, equals))
        for _, step, settings in group:  # so that machine code is there
            solve(problem, [step], settings)
        rounds = [[timed(problem, step, settings) for _, step, settings in group] for _ in range(repeats)]
        seconds = [statistics.median(own[0] for own in run) for run in zip(*rounds, strict=True)]
        points = [len(solution.trajectories[0].times) for _, solution in rounds[0]]
        for i, ((kind, step, _), (_, solution)) in enumerate(zip(group, rounds[0], strict=True)):
            name = f"{kind} {step.method}" + (f", degree {step.degree}" if step.degree else "")
            mesh = solution.meshes[-1]
            cells = [name, len(solution.meshes), mesh.mesh.segments, points[i], f"{points[i] / points[0]:.1f}"]
            cells += [f"{mesh.relative_error:.1e}", f"{seconds[i]:.3f}", f"{seconds[i] / seconds[0]:.1f}"]
            print("| " + " | ".join(map(str, cells)) + " |", flush=True)


if __name__ == "__main__":
    main()
