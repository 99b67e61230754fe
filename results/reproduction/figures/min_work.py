"""Moving a block with the least work, section 8: Figures 16 and 17, and the table over meshes and smoothing."""

from __future__ import annotations

from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ....problems.expressions.smooth import SQRT, TANH, smooth_abs
from ...pictures.style import BLACK, BLUE, GREEN, PURPLE, VERMILION
from ..paper_values import SWITCH, U_MAX, WORK
from .example import Example, Picture, Run, Solutions, SolvedRun, largest, name_time, objectives, panel_grid

ALPHAS = (0.01, 1.0, 5.0)
METHODS = {"slack": "slack", **{f"tanh {alpha:g}": f"{{tanh: {alpha:g}}}" for alpha in ALPHAS}}
DRAWN = (19, 39, 99)
"""Segments of the meshes of Figure 17."""
MESHES = {"slack": (9, 19, 29, 39, 49, 99, 199, 399, 799), "tanh 0.01": (9, 19, 39, 99), **{
    method: (9, 19, 39, 99, 199, 399, 799) for method in ("tanh 1", "tanh 5")}}  # fmt: skip
SCHEDULE = "min_work_schedule"


def name_of(method: str, n: int) -> str:
    return f"min_work_{method.replace(' ', '_')}_{n}"


RUNS = {
    **{
        name_of(method, n): Run(
            "block_move_min_work", (f"nonsmooth={nonsmooth}", f"mesh.-1.segments={n}"), shown=n in DRAWN
        )
        for method, nonsmooth in METHODS.items()
        for n in MESHES[method]
    },
    SCHEDULE: Run("block_move_min_work_smooth"),
}


def exact(t: np.ndarray) -> dict[str, np.ndarray]:
    """The analytic solution (8.5)."""
    u = np.where(t < SWITCH, U_MAX, np.where(t > 1 - SWITCH, -U_MAX, 0.0))
    v = U_MAX * np.minimum(np.minimum(t, SWITCH), 1 - t)
    return {"u": u, "v": v}


def measure(solved: Solutions) -> dict[str, float]:
    texts = {name_of(method, n): f"{method}, {n} segments" for method in METHODS for n in MESHES[method]}
    numbers = {
        **objectives(solved, {**texts, SCHEDULE: "schedule tanh 5, 1, 0.01, 99 segments"}),
        **{f"work done, {method}": work_done(solved[name_of(method, 99)]) for method in METHODS},
        **_smoothing(),
    }
    for method in list(METHODS)[1:]:
        common = [n for n in MESHES[method] if name_of(method, n) in solved]
        losses = [numbers[f"J, slack, {n} segments"] - numbers[f"J, {method}, {n} segments"] for n in common]
        numbers[f"J, slack - J, {method}, largest over meshes"] = max(losses)
        numbers[f"J, slack - J, {method}, least over meshes"] = min(losses)
    if SCHEDULE in solved:
        numbers["order of convergence of J to the exact value"] = _order(numbers)
    return numbers


def work_done(run: SolvedRun) -> float:
    """The integral of |u v| by the trapezoidal rule on the mesh: what the smoothed solutions really cost."""
    power = np.abs(run.curve("u").points * run.curve("v").points)
    return float(np.trapezoid(power, run.phase.time))


def _order(numbers: dict[str, float]) -> float:
    """The slope of log |J - J*| over log h, from 39 segments on: there h is below t*."""
    n = np.array([n for n in MESHES["slack"] if n >= 39])
    errors = [WORK - numbers[f"J, slack, {k} segments"] for k in n]
    return float(-np.polyfit(np.log(n), np.log(errors), 1)[0])


def _smoothing() -> dict[str, float]:
    x = np.linspace(-20, 20, 40_001)
    tanh, root = (smooth_abs(kind, np, x, 1.0) - np.abs(x) for kind in (TANH, SQRT))
    return {
        "largest of x tanh(x) - |x|": tanh.max(),
        "least of sqrt(x^2 + 1) - |x|": root.min(),
        "largest error of tanh smoothing / alpha": largest(tanh),
        "largest error of square-root smoothing / beta": largest(root),
    }


# -- Figure 16 ------------------------------------------------------------------------------------------------------

WIDTHS = ((0.1, BLUE, "-"), (0.5, VERMILION, (0, (5, 1))), (1.0, GREEN, (0, (3, 1, 1, 1))))


def smoothing(solved: Solutions) -> Figure:
    figure, axes = panel_grid([1.9, 1.5], 2, 2.9, down=0.25)
    x = np.linspace(-2, 2, 801)
    kinds = ((TANH, r"\alpha", r"$x\,\tanh(x/\alpha)$"), (SQRT, r"\beta", r"$\sqrt{x^2 + \beta^2}$"))
    for (above, below), (kind, letter, formula) in zip(zip(*axes, strict=True), kinds, strict=True):
        above.plot(x, np.abs(x), color=BLACK, linewidth=2.4, alpha=0.35, label="$|x|$")
        for width, colour, style in WIDTHS:
            y = smooth_abs(kind, np, x, width)
            above.plot(x, y, color=colour, linestyle=style, label=f"${letter} = {width:g}$")
            below.plot(x, y - np.abs(x), color=colour, linestyle=style)
        above.set_title(formula, loc="left")
        above.legend(loc="upper center", fontsize=7.5)
        above.set_ylim(-0.1, 2.3)
        below.set_xlabel("$x$")
        below.axhline(0, color=BLACK, linewidth=0.6, zorder=1)
    axes[0][0].set_ylabel("smooth $|x|$")
    axes[1][0].set_ylabel("smooth $|x|$ − $|x|$")
    for ax in axes[0]:
        ax.tick_params(labelbottom=False)
    return figure


# -- Figure 17 ------------------------------------------------------------------------------------------------------

_COLOURS = {"slack": BLUE, "tanh 0.01": VERMILION, "tanh 1": GREEN, "tanh 5": PURPLE}
_TITLES = {"slack": "slack variables", **{f"tanh {a:g}": rf"tanh, $\alpha$ = {a:g}" for a in ALPHAS}}


def solutions(name: str, solved: Solutions) -> Figure:
    """One of the curves, for each mesh (rows) and method (columns)."""
    figure, axes = panel_grid([1.35] * len(DRAWN), len(METHODS), 1.75, down=0.42, across=0.2, top=0.85, left=0.8)
    for row, n in zip(axes, DRAWN, strict=True):
        for ax, method in zip(row, METHODS, strict=True):
            run = solved[name_of(method, n)]
            _draw_solution(ax, run, name, _COLOURS[method])
            head = f"{_TITLES[method]}\n" if n == DRAWN[0] else ""
            ax.set_title(
                f"{head}$J$ = {run.objective:.3f}, {run.iterations[0]} it., {1000 * run.seconds[0]:.0f} ms",
                loc="left", fontsize=8,
            )  # fmt: skip
        for ax in row[1:]:
            ax.tick_params(labelleft=False)
        row[0].set_ylabel({"u": f"{n} segments\nforce $u$ [N]", "v": f"{n} segments\nvelocity $v$ [m/s]"}[name])
    name_time(axes)
    figure.suptitle(
        f"$u_{{max}}$ = {U_MAX:g} N, trapezoidal collocation; exact: $J^*$ = {WORK:.4f}, $t^*$ = {SWITCH:.4f} s",
        fontsize=9, y=1 - 0.1 / figure.get_figheight(), va="top",
    )  # fmt: skip
    return figure


def _draw_solution(ax: Axes, run: SolvedRun, name: str, colour: str) -> None:
    t = np.unique(np.concatenate([np.linspace(0, 1, 401), [SWITCH, SWITCH - 1e-9, 1 - SWITCH, 1 - SWITCH + 1e-9]]))
    ax.plot(run.phase.dense_time, run.curve(name).dense, color=colour, linewidth=1.7)
    ax.plot(t, exact(t)[name], color=BLACK, linestyle=(0, (4, 2)), linewidth=1.0, zorder=3)
    ax.margins(x=0.03)
    ax.set_xticks([0, 0.5, 1])
    ax.set_ylim(*{"u": (-1.12 * U_MAX, 1.12 * U_MAX), "v": (-0.08, 1.45)}[name])


# -- the table ------------------------------------------------------------------------------------------------------


def table(solved: Solutions) -> list[list[str]]:
    """J over meshes and smoothing, and how far slack variables are from the exact value."""
    rows = [["segments", *(f"J, {_plain(method)}" for method in METHODS), "exact J - J, slack"]]
    for n in MESHES["slack"]:
        runs = [solved.get(name_of(method, n)) for method in METHODS]
        values = [f"{run.objective:.6f}" if run else "" for run in runs]
        rows.append([str(n), *values, f"{WORK - solved[name_of('slack', n)].objective:.1e}"])
    rows.append(["exact", f"{WORK:.6f}", *[""] * len(METHODS)])
    return rows


def _plain(method: str) -> str:
    return method if method == "slack" else method.replace("tanh ", "tanh, alpha = ")


_SETTING = (
    f"Rows: {', '.join(map(str, DRAWN))} segments. Columns: slack variables, and tanh smoothing with alpha = 0.01, 1 "
    f"and 5. Solid: computed; dashed: the analytic solution (8.5). The paper does not tell its u_max and its meshes: "
    f"u_max = {U_MAX:g} N and the meshes were chosen by us. All solves start from the same guess (8.6)-(8.8)."
)

EXAMPLE = Example(
    name="min_work",
    title="Block move with the least work (section 8)",
    runs=RUNS,
    measure=measure,
    table=table,
    pictures=(
        Picture(
            "fig16_smoothing",
            "Figure 16. Two smooth approximations of |x|",
            "Left: x tanh(x/alpha), (8.12), always below |x|. Right: sqrt(x^2 + beta^2), (8.13), always above. "
            "Below: their errors. Drawn by the functions that the solver puts in the place of abs().",
            smoothing,
        ),
        Picture(
            "fig17_min_work_force",
            "Figure 17. Minimum work by slack variables and by smoothing: force",
            f"{_SETTING} Slack variables and light smoothing give nearly the same force; heavier smoothing is solved "
            f"faster and is less accurate. Other than FMINCON in the paper, IPOPT takes more time for light "
            f"smoothing than for slack variables.",
            partial(solutions, "u"),
        ),
        Picture(
            "fig17v_min_work_velocity",
            "Figure 17v. Minimum work by slack variables and by smoothing: velocity",
            _SETTING,
            partial(solutions, "v"),
        ),
    ),
)
