"""Spectral convergence of global collocation: error against degree on one segment, a table and a semi-log picture.

    python tests/benchmarks/spectral.py [-o spectral.png]

The problem is dx/dt = x cos(3 t), x(0) = 1 on [0, 2], x = exp(sin(3 t) / 3); the error is that of x at the end.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from trajopt.transcription.settings import Step
from trajopt.transcription.solve import solve

sys.path.insert(0, str(Path(__file__).parents[1] / "helpers"))
from exact import integration, integration_state

METHODS = ("gauss", "radau", "radau-left", "lobatto", "chebyshev")
DEGREES = range(2, 33, 2)


def error(method: str, degree: int) -> float:
    (trajectory,) = solve(integration(), [Step(method, 1, 1e-13, degree)]).trajectories
    return abs(float(trajectory.x[0, -1]) - float(integration_state(2.0)))


def draw(errors: dict[str, list[float]], path: str) -> None:
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, ax = plt.subplots(figsize=(6.5, 4.5), constrained_layout=True)
    for (method, values), marker in zip(errors.items(), "osD^v", strict=True):
        ax.semilogy(DEGREES, [max(value, 1e-16) for value in values], marker=marker, label=method)
    ax.set(xlabel="degree, on one segment", ylabel="error of x at the end")
    ax.grid(True, alpha=0.3)
    ax.legend()
    figure.savefig(path, dpi=150)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("-o", default="spectral.png")
    arguments = parser.parse_args()
    errors = {method: [error(method, degree) for degree in DEGREES] for method in METHODS}
    print("degree" + "".join(f"{method:>12}" for method in METHODS))
    for row, degree in enumerate(DEGREES):
        print(f"{degree:6}" + "".join(f"{errors[method][row]:12.1e}" for method in METHODS))
    draw(errors, arguments.o)


if __name__ == "__main__":
    main()
