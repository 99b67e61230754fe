"""The five-link biped, section 7 and appendix F: Figures 13, 14, 15 and 20.

The paper's Table 4 and its electronic supplement disagree on where the centre of mass of the torso is, so the figures
are drawn for both.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...pictures.animate import stop_action
from ...pictures.error_plots import draw_error
from ...pictures.style import BLACK, BLUE, GREY, VERMILION
from .example import Example, Picture, Run, Solutions, SolvedRun, draw, largest, name_time, objectives, panel_grid, peak

TABLE, SUPPLEMENT = "biped", "biped_supplement"
LINKS = range(1, 6)
TIPS = ("stance_tibia", "stance_femur", "torso", "swing_femur", "swing_tibia")
"""The links whose tips are P1 to P5."""

JOINTS = (0, 1, 2, 2, 4)
"""The numbers of the points that the links begin at."""

POSES = 10
SPREAD = 0.3
"""Metres by which each pose of Figure 13 stands to the right of the one before, so that legs do not hide legs."""

POSE_TIME = 0.85  # part of the step at which Figure 20 shows the walker

_ONE_MESH = "mesh=[{{method: {}, segments: {}, tolerance: 1.0e-8}}]"
_MESHES = {f"{short}_{n}": (method, n) for short, method, n in (
    ("hs", "hermite-simpson", 5), ("hs", "hermite-simpson", 15), ("hs", "hermite-simpson", 25),
    ("hs", "hermite-simpson", 60), ("trapezoid", "trapezoid", 24), ("trapezoid", "trapezoid", 100),
)}  # fmt: skip
NO_KNEES = "biped_supplement_without_knees"

RUNS = {
    TABLE: Run(TABLE, shown=True),
    SUPPLEMENT: Run(SUPPLEMENT, shown=True),
    **{
        f"{walker}_{mesh}": Run(walker, (_ONE_MESH.format(*how),))
        for walker in (TABLE, SUPPLEMENT)
        for mesh, how in _MESHES.items()
    },
    NO_KNEES: Run(SUPPLEMENT, ("constraints.path=[]",)),
}

_NAMES = {"hermite-simpson": "Hermite-Simpson"}


def _texts(walker: str) -> dict[str, str]:
    texts = {f"{walker}_{mesh}": f"{_NAMES.get(m, m)}, {n} segments" for mesh, (m, n) in _MESHES.items()}
    return {**texts, walker: "Hermite-Simpson, 5 then 25 segments"}


def measure(solved: Solutions) -> dict[str, float]:
    supplement = {**objectives(solved, _texts(SUPPLEMENT)), **_measure(solved[SUPPLEMENT])}
    numbers = {
        **objectives(solved, _texts(TABLE)),
        **_measure(solved[TABLE]),
        **{f"supplement: {name}": number for name, number in supplement.items()},
    }
    if f"{TABLE}_hs_25" in solved:
        difference = solved[f"{TABLE}_hs_25"].objective - solved[TABLE].objective
        numbers["J, directly on 25 segments - J on two meshes"] = difference
        numbers["supplement: J, without the knee constraint, 25 segments"] = solved[NO_KNEES].objective
    return numbers


def _measure(step: SolvedRun) -> dict[str, float]:
    height = _foot_height(step)
    return {
        **{f"largest eta of q{i}": step.phase.eta[f"q{i}"].max() for i in LINKS},
        **{f"largest |epsilon| of q{i}": peak(step.phase.epsilon[f"q{i}"].dense) for i in LINKS},
        **{f"q{i}(0)": step.curve(f"q{i}").points[0] for i in LINKS},
        **{f"u{i}(0)": step.curve(f"u{i}").points[0] for i in LINKS},
        **{f"u{i}(T)": step.curve(f"u{i}").points[-1] for i in LINKS},
        "largest height of the swing foot": largest(height),
        "least height of the swing foot between the ends": height[1:-1].min(),
    }


def _foot_height(step: SolvedRun) -> np.ndarray:
    """The height of P5 on the dense grid, m."""
    return step.curve("swing_tibia_y").dense


def poses(walker: str, solved: Solutions) -> Figure:
    figure, ((ax,),) = panel_grid([2.7], 1, 6.6)
    stop_action(ax, solved[walker].result, POSES, by_part=True, spread=SPREAD)
    ax.set_xlabel(f"x [m], each pose {SPREAD:g} m to the right of the one before")
    return figure


def trajectory(walker: str, solved: Solutions) -> Figure:
    figure, axes = panel_grid([1.05] * 5, 2, 2.9, down=0.2)
    for i, (left, right) in zip(LINKS, axes, strict=True):
        draw(left, solved[walker], f"q{i}", f"$q_{i}$")
        if i == 1:  # zero by definition
            right.set_axis_off()
            right.text(0.5, 0.5, "$u_1 = 0$: the stance ankle has no motor", ha="center", va="center", color=GREY)
        else:
            draw(right, solved[walker], f"u{i}", f"$u_{i}$")
    name_time(axes)
    axes[0][0].set_title("angles", loc="left")
    axes[0][1].set_title("torques", loc="left")
    return figure


def error(walker: str, solved: Solutions) -> Figure:
    figure, axes = panel_grid([1.0] * 5, 2, 2.9, down=0.65)
    for i, pair in zip(LINKS, axes, strict=True):
        draw_error((pair[0], pair[1]), solved[walker].result, f"q{i}")
    return figure


def kinematics(solved: Solutions) -> Figure:
    """The walker of Table 4 at one time of its step, with P_i and G_i."""
    step = solved[TABLE]
    _, parameters = step.result.build()
    start, end = step.phase.knots[[0, -1]]
    places = step.phase.values("output", np.array([start + POSE_TIME * (end - start)]))
    P = np.array([[0.0, 0.0], *([float(places[f"{tip}_{axis}"][0]) for axis in "xy"] for tip in TIPS)])
    length, d = (np.array([parameters[f"{name}{i}"] for i in LINKS]) for name in "ld")
    part = np.where(np.arange(5) < 2, 1 - d / length, d / length)  # d of the stance leg is from the upper end
    G = P[list(JOINTS)] + part[:, None] * (P[1:] - P[list(JOINTS)])
    figure, ((ax,),) = panel_grid([5.0], 1, 3.4)
    for chain in ([0, 1, 2, 3], [2, 4, 5]):
        ax.plot(*P[chain].T, color=GREY, linewidth=5, alpha=0.6, solid_capstyle="round", zorder=1)
    ax.axhline(0, color=BLACK, linewidth=1)
    _draw_points(ax, P, "P", 0, "joints", marker="o", color=BLUE)
    _draw_points(ax, G, "G", 1, "centres of mass", marker="D", color=VERMILION)
    ax.set_aspect("equal")
    ax.set_xlim(-0.25, 0.75)
    ax.set_ylim(-0.08, 1.48)
    ax.set_xlabel("x [m]")
    ax.set_ylabel("y [m]")
    ax.legend(loc="upper left")
    return figure


def _draw_points(ax: Axes, points: np.ndarray, letter: str, first: int, what: str, *, marker: str, color: str) -> None:
    """Points with their names; those of the swing leg, which is in front, at its right."""
    ax.plot(*points.T, marker, color=color, markersize=8, label=f"{what} ${letter}_i$", zorder=3)
    for i, point in enumerate(points, start=first):
        side, align = (1, "left") if i > 3 else (-1, "right")
        place: dict[str, Any] = {"xytext": (10 * side, 8 if point[1] == 0 else 0), "textcoords": "offset points"}
        ax.annotate(f"${letter}_{i}$", point, ha=align, va="center", fontsize=12, color=color, **place)


_PAPER = "The paper: 29 iterations in 0.96 s, then 56 iterations in 21.3 s"


def _pictures(walker: str, suffix: str, which: str) -> tuple[Picture, ...]:
    return (
        Picture(
            f"fig13{suffix}_{walker}_stop_action",
            f"Figure 13{suffix}. One step as a stop-action picture, {which}",
            f"{POSES} poses at equal steps of time, from left to right; earlier ones are paler, and each stands "
            f"{SPREAD:g} m further to the right than it would, so that legs do not hide legs. The stance leg is "
            f"dashed and orange, the swing leg blue, the torso purple. Hermite-Simpson collocation, first 5 segments "
            f"with tolerance 1e-3, then 25 with 1e-6: {{{walker}}}. {_PAPER}.",
            partial(poses, walker),
        ),
        Picture(
            f"fig14{suffix}_{walker}_trajectory",
            f"Figure 14{suffix}. Angles and torques of the step, {which}",
            "Absolute angles of the links and torques of the joints over time; circles mark the knots of the 25 "
            "segments. Forward leaning angles are negative. The torque of the stance ankle is zero by definition and "
            "is not drawn.",
            partial(trajectory, walker),
        ),
        Picture(
            f"fig15{suffix}_{walker}_error",
            f"Figure 15{suffix}. How well the step meets the dynamics, {which}",
            "Left: epsilon, the error of the differential equations of the five angles. Right: eta, its integral "
            "over each of the 25 segments.",
            partial(error, walker),
        ),
    )


EXAMPLE = Example(
    name="biped",
    title="Five-link biped (section 7)",
    runs=RUNS,
    measure=measure,
    pictures=(
        *_pictures(TABLE, "", "torso of Table 4"),
        *_pictures(SUPPLEMENT, "s", "torso and knees of the electronic supplement"),
        Picture(
            "fig20_biped_kinematics",
            "Figure 20. Kinematics of the biped",
            f"The joints and the centres of mass of the links, with the lengths of Table 4, in the pose of our "
            f"solution after {POSE_TIME:.0%} of the step. P0 is the stance foot, P2 the hip, P3 the top of the "
            f"torso, P5 the swing foot.",
            kinematics,
        ),
    ),
)
