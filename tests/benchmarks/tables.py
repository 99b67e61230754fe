"""What a table of data costs in compiled code, against exp of the same arguments.

    python tests/benchmarks/tables.py

A block that moves with drag, dv/dt = u - f, by Hermite-Simpson: f is exp of minus the sum of its arguments, or a
table of that.
At a new point z the Jacobian and the Hessian are evaluated, with all lookups that they need: CPU seconds, the least of
some repeats of the two in turn, so that other work on the machine meets both. Beside other work set
OPENBLAS_NUM_THREADS=1: threads of BLAS that wait for a core count, and are most of 2500 segments then.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from time import process_time
from timeit import timeit

import numpy as np

from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.transcription.program.contract import NonlinearProgram
from trajopt.transcription.settings import steps
from trajopt.transcription.transcribe import compiled, transcribe

PROBLEM = """
trajopt: 1
tables: {{f: {{points: {points}, values: {values}, outside: extrapolate}}}}
time: {{initial: 0, final: 1}}
states:
  x: {{rate: v, initial: 0, final: 1}}
  v: {{rate: "{rate}", initial: 0, final: 0}}
controls: {{u: {{}}}}
objective: {{minimize: {{integral: u**2}}}}
mesh: [{{method: hermite-simpson, segments: {segments}}}]
"""
NAMES = ("x", "v", "u")
CASES = ((1, 6), (1, 1000), (2, 6), (2, 60), (3, 6), (3, 25))
"""Arguments, and points of each."""
SEGMENTS = (25, 250, 2500)
REPEATS = 15


def program(rate: str, arguments: int, size: int, segments: int) -> NonlinearProgram:
    grid = np.linspace(0.0, 1.5, size)
    points = {name: grid.tolist() for name in NAMES[:arguments]}
    total = sum(np.meshgrid(*[grid] * arguments, indexing="ij"))
    text = PROBLEM.format(points=points, values=np.exp(-total).tolist(), rate=rate, segments=segments)
    spec = load_text(text, "table.yaml")
    return compiled(transcribe(build(spec), [steps(spec.mesh)[0].mesh()]))


def evaluation(nlp: NonlinearProgram) -> Callable[[], None]:
    """What evaluates the Jacobian and the Hessian at points of a smooth trajectory that are new each time."""
    z, y = 0.1 + np.linspace(0.0, 1.2, nlp.n), np.ones(nlp.m)
    points = [z, z + 1e-9]

    def evaluate() -> None:
        points.reverse()
        nlp.jacobian(points[0])
        nlp.hessian(points[0], y, 1.0)

    return evaluate


def paired(one: Callable[[], None], other: Callable[[], None]) -> tuple[float, float]:
    """CPU seconds of one call of each."""
    once = [timeit(own, timer=process_time, number=2) for own in (one, other, one, other)]  # the first two are cold
    number = max(1, int(0.1 / max(once[2:])))
    found = [[timeit(own, timer=process_time, number=number) for own in (one, other)] for _ in range(REPEATS)]
    least = np.min(found, axis=0) / number
    return float(least[0]), float(least[1])


def main() -> None:
    print("arguments  points  segments   exp, us  table, us  ratio")
    for (arguments, size), segments in product(CASES, SEGMENTS):
        names = NAMES[:arguments]
        of_exp = evaluation(program(f"u - exp(-{' - '.join(names)})", 1, 2, segments))
        of_table = evaluation(program(f"u - f({', '.join(names)})", arguments, size, segments))
        by_exp, by_table = paired(of_exp, of_table)
        shown = f"{by_exp * 1e6:10.1f} {by_table * 1e6:10.1f} {by_table / by_exp:6.2f}"
        print(f"{arguments:9} {size:7} {segments:9}{shown}")


if __name__ == "__main__":
    main()
