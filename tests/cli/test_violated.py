"""A bound is called violated only where `trajopt verify` would fail it; overlays have the axes of single pictures."""

import pytest
from command_line import solved_once, trajopt

from trajopt.results.audit.broken import broken_bounds
from trajopt.results.file.bounds import bounds_of
from trajopt.results.file.read import read
from trajopt.results.pictures.overlay import overlay_figure
from trajopt.results.pictures.plots import trajectory_figure
from trajopt.results.pictures.style import VIOLATED
from trajopt.results.verify import verify

WALL = """trajopt: 1
name: past a wall
time: {initial: 0, final: 1}
parameters: {w: 0.4}
states:
  x: {rate: 4, initial: 0}
  y: {rate: v, initial: 0, final: 0}
  v: {rate: a}
  T: {unit: K, rate: 1e-9*a, initial: 300}
controls:
  a: {lower: -200, upper: 200}
expressions:
  gap: {value: "(x - 2)**2 + y**2", unit: m^2}
constraints:
  path: [{name: disc, expression: gap, lower: w**2}]
objective: {minimize: {integral: a**2}}
mesh: [{method: trapezoid, segments: 3}]
"""


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """A disc that lies between the points, one that is so small that its check passes, a control that jumps."""
    folder = tmp_path_factory.mktemp("violated")
    file = folder / "wall.yaml"
    file.write_text(WALL)
    jump = ("double_integrator_min_time", "--method", "radau", "--segments", "7")
    return {
        "wall": solved_once(folder / "wall.h5", file),
        "grazed": solved_once(folder / "grazed.h5", file, "--set", "parameters.w=0.15"),
        "jump": solved_once(folder / "jump.h5", *jump),
    }


def drawn(result):
    """Titles of the panels with a violated bound."""
    bounds = bounds_of(result.build()[0])
    figure = trajectory_figure(result, bounds, (), broken_bounds(result, bounds))
    return [
        ax.get_title(loc="left").split(" [")[0]
        for ax in figure.axes
        if any(line.get_color() == VIOLATED for line in ax.get_lines())
    ]


@pytest.mark.parametrize(("name", "violated"), [("wall", ["gap", "disc"]), ("grazed", []), ("jump", [])])
def test_violated_is_what_verify_fails(results, name, violated):
    failed = [own.name for own in verify(results[name], anew=False) if "between the" in own.name and not own.passed]
    assert bool(failed) == bool(violated)
    assert drawn(read(results[name])) == violated


def test_what_hardly_varies_is_flat_in_an_overlay_too(results):
    figure = overlay_figure([read(results["wall"]), read(results["jump"])])
    panels = {ax.get_title(loc="left"): ax for ax in figure.axes}
    low, high = panels["T [K]"].get_ylim()
    assert high - low == pytest.approx(0.3, rel=1e-3)
    assert "gap [m²]" in panels, "an output with a unit is drawn"


def test_a_spike_does_not_set_the_axis_of_an_overlay(results):
    result = read(results["jump"])
    dense, points = result.phases[0].curves["control"]["u"].dense, result.phases[0].curves["control"]["u"].points
    dense[len(dense) // 2] = 50.0
    (ax,) = overlay_figure([result, result], (), ["u"]).axes[:1]
    assert ax.get_ylim()[1] <= points.max() + 0.6


@pytest.mark.parametrize(
    ("arguments", "target"), [(("--xy", "x,y"), "new/wall-xy.png"), (("--only", "a"), "of/it/wall.png")]
)
def test_a_folder_is_made(results, folder, arguments, target):
    run = trajopt("plot", results["wall"], *arguments, "-o", f"{target.rpartition('/')[0]}/")
    assert (run.exit_code, run.stdout) == (0, f"{target}\n") and (folder / target).exists()
    both = trajopt("plot", results["wall"], results["grazed"], "-o", "both/")
    assert (both.exit_code, both.stdout) == (0, "both/overlay.png\n")
    for names in ((results["wall"], *arguments), (results["wall"], results["grazed"])):
        refused = trajopt("plot", *names, "-o", "-")
        assert refused.exit_code == 2 and "which standard output cannot hold" in refused.stderr


def test_a_result_that_is_damaged_is_drawn_all_the_same(results, folder):
    import h5py

    copy = folder / "damaged.h5"
    copy.write_bytes(results["wall"].read_bytes())
    with h5py.File(copy, "a") as file:
        z = file["solver/z"][:]
        z[:] = float("nan")
        file["solver/z"][:] = z
    assert trajopt("plot", copy, "-o", "damaged.png").exit_code == 0


def test_the_command_tells_it(results, tmp_path):
    for names in (["wall"], ["wall", "grazed"]):
        target = tmp_path / f"{len(names)}.svg"
        assert trajopt("plot", *(results[name] for name in names), "-o", target).exit_code == 0
        assert VIOLATED.lower() in target.read_text().lower()
    target = tmp_path / "jump.svg"
    assert trajopt("plot", results["jump"], "-o", target).exit_code == 0
    assert VIOLATED.lower() not in target.read_text().lower()
