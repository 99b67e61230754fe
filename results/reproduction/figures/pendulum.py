"""The driven pendulum of the introduction to direct collocation, section 6: finite differences and Newton's method."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from ...pictures.animate import stop_action
from ...pictures.style import BLACK, BLUE, GREY, VERMILION, Numbers
from .example import Example, Picture, Run, Solutions, name_time, objectives, panel_grid, with_unit

FRAMES = 11

RUNS = {
    "pendulum": Run("pendulum", shown=True),
    "pendulum_ipopt": Run("pendulum", ("solver.engine=ipopt",), shown=True),
    "pendulum_100": Run("pendulum", ("mesh.-1.segments=100",)),
    "pendulum_hermite-simpson": Run(
        "pendulum", ("mesh=[{method: hermite-simpson, segments: 400, tolerance: 1.0e-8}]", "solver.engine=ipopt")
    ),
}

_OBJECTIVES = {
    "pendulum": "finite differences, 1001 points",
    "pendulum_100": "finite differences, 101 points",
    "pendulum_hermite-simpson": "converged: Hermite-Simpson, 400 segments",
}


def measure(solved: Solutions) -> dict[str, float]:
    newton, ipopt = solved["pendulum"], solved["pendulum_ipopt"]
    return {
        **objectives(solved, _OBJECTIVES),
        "|J of IPOPT - J of Newton|": abs(ipopt.objective - newton.objective),
        **{f"largest |{name} of IPOPT - {name} of Newton|": _difference(solved, name).max() for name in ("q", "u")},
    }


def _difference(solved: Solutions, name: str) -> np.ndarray:
    return np.abs(solved["pendulum_ipopt"].curve(name).points - solved["pendulum"].curve(name).points)


def trajectory(solved: Solutions) -> Figure:
    figure, axes = panel_grid([1.4, 1.1, 1.1, 1.1], 1, 5.2, down=0.2)
    newton = solved["pendulum"]
    t = newton.phase.time
    for (ax,), (name, label) in zip(axes, (("q", "angle $q$"), ("w", "rate $w$"), ("u", "torque $u$")), strict=False):
        curve = newton.curve(name)
        ax.plot(t, curve.points, color=VERMILION if name == "u" else BLUE)
        ax.set_ylabel(with_unit(label, curve.unit))
        ax.yaxis.set_major_formatter(Numbers())
    axes[0][0].axhline(np.pi / 2, color=GREY, linestyle="--", linewidth=0.9)
    last = axes[-1][0]
    for name, colour, style in (("q", BLUE, "-"), ("u", VERMILION, "--")):
        last.semilogy(t, np.maximum(_difference(solved, name), 1e-17), color=colour, linestyle=style, label=name)
    last.axhline(1e-8, color=BLACK, linestyle=":", linewidth=0.9)
    last.set_ylabel("|IPOPT − Newton|")
    last.legend(loc="center", ncols=2, bbox_to_anchor=(0.5, 0.28))
    name_time(axes)
    return figure


def poses(solved: Solutions) -> Figure:
    figure, ((ax,),) = panel_grid([3.2], 1, 3.8)
    stop_action(ax, solved["pendulum"].result, FRAMES)
    return figure


EXAMPLE = Example(
    name="pendulum",
    title="Driven pendulum (the introduction, section 6)",
    runs=RUNS,
    measure=measure,
    pictures=(
        Picture(
            "pendulum_trajectory",
            "The driven pendulum",
            "From hanging at rest to level at rest in 1 s with the least torque squared: angle, rate and torque at "
            "1001 points, one millisecond apart, by second-order finite differences. Newton's method on the KKT "
            "system: {pendulum}; IPOPT on the same equations: {pendulum_ipopt}. The last panel shows how far the two "
            "solutions are apart; they must agree to 1e-8 (dotted). The torque jumps at its ends because the "
            "introduction's listing has other equations there.",
            trajectory,
        ),
        Picture(
            "pendulum_stop_action",
            "The driven pendulum as a stop-action picture",
            f"{FRAMES} frames at equal steps of time, from dark to light.",
            poses,
        ),
    ),
)
