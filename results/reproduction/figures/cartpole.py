"""The cart-pole swing-up, section 6: Figures 9, 10 and 11."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from ...pictures.animate import stop_action
from ...pictures.error_plots import draw_error
from .example import Example, Picture, Run, Solutions, draw, largest, name_time, objectives, panel_grid, peak

HS, TRAPEZOID = "Hermite-Simpson", "trapezoid"
FRAMES = 9

_SEGMENTS = {"trapezoid": (9, 19, 29, 49, 200), "hermite-simpson": (100, 2000)}

RUNS = {
    "cartpole": Run("cartpole", shown=True),
    **{
        f"cartpole_{method}_{n}": Run("cartpole", (f"mesh.*.method={method}", f"mesh.-1.segments={n}"))
        for method, numbers in _SEGMENTS.items()
        for n in numbers
    },
}

_OBJECTIVES = {
    "cartpole": f"{HS}, 25 segments",
    "cartpole_hermite-simpson_100": f"{HS}, 100 segments",
    "cartpole_hermite-simpson_2000": f"converged: {HS}, 2000 segments",
    **{f"cartpole_trapezoid_{n}": f"{TRAPEZOID}, {n} segments" for n in _SEGMENTS["trapezoid"]},
}


def measure(solved: Solutions) -> dict[str, float]:
    swing = solved["cartpole"]
    u, q1, q2, v2 = (swing.curve(name).points for name in ("u", "q1", "q2", "v2"))
    eta, epsilon = swing.phase.eta, swing.phase.epsilon
    return {
        **objectives(solved, _OBJECTIVES),
        "u(0)": u[0],
        "u(T)": u[-1],
        "largest |u|": largest(u),
        "largest q1": q1.max(),
        "least q2": q2.min(),
        "largest |dq2/dt|": largest(v2),
        **{f"largest |epsilon| of {q}": peak(epsilon[q].dense) for q in ("q1", "q2")},
        **{f"largest eta of {q}": eta[q].max() for q in ("q1", "q2")},
        **{f"largest eta of d{q}/dt": eta[v].max() for q, v in (("q1", "v1"), ("q2", "v2"))},
        **{f"segment of the largest eta of {q}": float(np.argmax(eta[q]) + 1) for q in ("q1", "q2")},
    }


def poses(solved: Solutions) -> Figure:
    figure, ((ax,),) = panel_grid([3.6], 1, 5.6)
    stop_action(ax, solved["cartpole"].result, FRAMES)
    return figure


def trajectory(solved: Solutions) -> Figure:
    figure, axes = panel_grid([1.4] * 3, 1, 5.6, down=0.2)
    labels = (("q1", "position $q_1$"), ("q2", "angle $q_2$"), ("u", "force $u$"))
    for (ax,), (name, label) in zip(axes, labels, strict=True):
        draw(ax, solved["cartpole"], name, label)
    name_time(axes)
    return figure


def error(solved: Solutions) -> Figure:
    figure, axes = panel_grid([1.5] * 2, 2, 3.4, down=0.6)
    for pair, state in zip(axes, ("q1", "q2"), strict=True):
        draw_error((pair[0], pair[1]), solved["cartpole"].result, state)
    return figure


_SETTINGS = "Hermite-Simpson collocation with 25 segments, parameters of Table 3"

EXAMPLE = Example(
    name="cartpole",
    title="Cart-pole swing-up (section 6)",
    runs=RUNS,
    measure=measure,
    pictures=(
        Picture(
            "fig09_cartpole_stop_action",
            "Figure 9. The swing-up as a stop-action picture",
            f"{FRAMES} frames at equal steps of time, from dark and blue to light and yellow, and the path of the "
            f"tip of the pole. {_SETTINGS}: {{cartpole}}; the paper: 71 iterations in 5.91 s.",
            poses,
        ),
        Picture(
            "fig10_cartpole_trajectory",
            "Figure 10. State and control of the swing-up",
            "Position of the cart, angle of the pole and force on the cart over time. The curves are the cubic and "
            "quadratic splines of the method; circles mark the knots.",
            trajectory,
        ),
        Picture(
            "fig11_cartpole_error",
            "Figure 11. How well the swing-up meets the dynamics",
            "Left: epsilon, the error of the differential equations of q1 and q2 between the collocation points. "
            "Right: eta, its integral over each segment. Both peak on segment 11, where the pole swings up fastest "
            "and a uniform mesh is too coarse.",
            error,
        ),
    ),
)
