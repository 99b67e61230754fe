"""Moving a block with the least force, section 2 and appendix B: Figure 2."""

from __future__ import annotations

from matplotlib.figure import Figure

from ...pictures.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, VERMILION, labelled
from .example import Example, Picture, Run, Solutions, SolvedRun, largest, name_time, objectives, panel_grid

BLOCK = "block_move_min_force"
FEASIBLE = {  # name -> a force w(t); the feasible trajectory whose force is nearest to it
    "early": "20*cos(3*pi*t)",
    "late": "-14*cos(4*pi*t) - 4",
    "hasty": "30*exp(-3*t)*cos(2*pi*t)",
    "halting": "25*sin(6*pi*t)",
}
COLOURS = (VERMILION, GREEN, ORANGE, PURPLE)
STYLES = ("--", "-.", ":", (0, (6, 1)))
ROWS = {"x": "position", "v": "velocity", "u": "force"}

_MESHES = {
    **{f"block_trapezoid_{n}": ("trapezoid", n, f"trapezoid, {n} segments") for n in (9, 29, 59)},
    "block_hs_1": ("hermite-simpson", 1, "Hermite-Simpson, 1 segment"),
    "block_hs_100": ("hermite-simpson", 100, "Hermite-Simpson, 100 segments"),
}

RUNS = {
    "block": Run(BLOCK, shown=True),
    **{
        f"block_feasible_{name}": Run(
            BLOCK,
            (f'objective.minimize.integral="(u - ({force}))**2"', "mesh.-1.segments=40", f'name="block move, {name}"'),
            shown=True,
        )
        for name, force in FEASIBLE.items()
    },
    **{
        name: Run(BLOCK, (f"mesh.*.method={method}", f"mesh.-1.segments={n}"))
        for name, (method, n, _) in _MESHES.items()
    },
}


def measure(solved: Solutions) -> dict[str, float]:
    block, phase = solved["block"], solved["block"].phase
    t, costates = phase.dense_time, phase.curves["costate"]
    feasible = [run for name, run in solved.items() if name.startswith("block_feasible")]
    texts = {name: text for name, (_, _, text) in _MESHES.items()}
    return {
        **objectives(solved, {"block": "Hermite-Simpson, 10 segments", **texts}),
        **{
            f"u(0), trapezoid, {n} segments": solved[f"block_trapezoid_{n}"].curve("u").points[0]
            for n in (9, 29)
            if f"block_trapezoid_{n}" in solved
        },
        "largest |x - (3 t^2 - 2 t^3)|": largest(block.curve("x").dense - (3 * t**2 - 2 * t**3)),
        "largest |v - (6 t - 6 t^2)|": largest(block.curve("v").dense - (6 * t - 6 * t**2)),
        "largest |u - (6 - 12 t)|": largest(block.curve("u").dense - (6 - 12 * t)),
        "largest |costate of x - c0|, c0 = -24": largest(costates["x"].dense + 24),
        "largest |costate of v - (c1 - c0 t)|, c1 = -12": largest(costates["v"].dense - (-12 + 24 * t)),
        "feasible trajectories: largest eta": max(max(map(largest, run.phase.eta.values())) for run in feasible),
        "feasible trajectories: least J": min(map(_effort, feasible)),
    }


def _effort(run: SolvedRun) -> float:
    """The integral of u^2 by Simpson's rule on the mesh; exact for no less than the method's own accuracy."""
    t, u = run.phase.time, run.curve("u").points
    w = u**2
    return float(((w[:-2:2] + 4 * w[1:-1:2] + w[2::2]) * (t[2::2] - t[:-2:2])).sum() / 6)


def comparison(solved: Solutions) -> Figure:
    figure, axes = panel_grid([1.5, 1.2, 1.2], 2, 3.0, down=0.2, across=0.35)
    for row, (name, meaning) in zip(axes, ROWS.items(), strict=True):
        for kind, colour, line in zip(FEASIBLE, COLOURS, STYLES, strict=True):
            run = solved[f"block_feasible_{kind}"]
            row[0].plot(run.phase.dense_time, run.curve(name).dense, color=colour, linestyle=line)
        best = solved["block"]
        row[1].plot(best.phase.dense_time, best.curve(name).dense, color=BLUE, linewidth=2)
        row[0].set_ylabel(labelled(meaning, {"u": "N"}.get(name, best.curve(name).unit)))
        limits = row[0].get_ylim()
        row[1].set_ylim(limits)
        row[1].tick_params(labelleft=False)
        for ax in row:
            ax.axhline(0, color=BLACK, linewidth=0.6, zorder=1)
            ax.margins(x=0.015)
    axes[0][0].set_title("feasible", loc="left")
    axes[0][1].set_title("optimal", loc="left")
    name_time(axes)
    return figure


EXAMPLE = Example(
    name="block",
    title="Block move with the least force (sections 1.3 and 2)",
    runs=RUNS,
    measure=measure,
    pictures=(
        Picture(
            "fig02_block_trajectories",
            "Figure 2. Feasible and optimal trajectories of the block",
            "Left: four of the many ways to move the block by 1 m in 1 s from rest to rest; each is the feasible "
            "trajectory whose force is nearest to a force that we chose. Right: the one with the least integral of "
            "force squared, x = 3 t^2 - 2 t^3, u = 6 - 12 t. Hermite-Simpson collocation: {block}.",
            comparison,
        ),
    ),
)
