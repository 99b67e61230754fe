"""Pictures of results: what is in them, where they go, and what is refused."""

import json
import os
import subprocess
import sys
from dataclasses import replace

import h5py
import numpy as np
import pytest
from branches import BRANCHES
from command_line import process, trajopt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from trajopt.problems.build import build
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load_text
from trajopt.problems.quantities import Range
from trajopt.results.file.bounds import bounds_of
from trajopt.results.file.read import read
from trajopt.results.file.summary import summarize
from trajopt.results.file.write import write
from trajopt.results.pictures import plots
from trajopt.results.pictures.style import DPI, Numbers, drawn_by_us
from trajopt.transcription.settings import steps
from trajopt.transcription.solve import solve

from .pictured import titles

pytestmark = pytest.mark.usefixtures("folder")


def labels(ax):
    return ax.get_legend_handles_labels()[1]


def test_picture_is_drawn_at_150_dpi_and_is_not_blank(solved, folder):
    result = trajopt("plot", solved("cartpole"))
    assert (result.exit_code, result.stdout) == (0, "cartpole.png\n")
    picture = Image.open(folder / "cartpole.png")
    figure = plots.trajectory_figure(read(solved("cartpole")))
    assert picture.size == tuple(np.floor(figure.get_size_inches() * DPI + 1e-9).astype(int))
    dark = np.asarray(picture.convert("L")) < 128
    assert 0.002 < dark.mean() < 0.2
    assert picture.text["Title"] == "cart-pole swing-up"
    edges = (dark[:3], dark[-3:], dark[:, :3], dark[:, -3:])
    assert not any(edge.any() for edge in edges)  # nothing is cut off


def test_every_quantity_has_a_panel_with_its_unit(solved):
    figure = plots.trajectory_figure(read(solved("cartpole")))
    assert titles(figure) == [
        "q1 [m]", "q2 [rad]", "v1 [m/s]", "v2 [rad/s]", "u [N]", "costate of q1 [objective/m]",
        "costate of q2 [objective/rad]", "costate of v1 [objective/(m/s)]", "costate of v2 [objective/(rad/s)]",
    ]  # fmt: skip
    assert {ax.get_xlabel() for ax in figure.axes} == {"", "time [s]"}
    assert figure.get_suptitle().startswith("cart-pole swing-up: solved, tolerance missed\nobjective 58.")


@pytest.mark.parametrize(("name", "count"), [("pendulum", 2 + 1), ("biped", 10 + 5 + 5 + 10)])
def test_kinds_that_are_not_there_have_no_panel(solved, name, count):
    figure = plots.trajectory_figure(read(solved(name)))
    assert len(figure.axes) == count
    assert ("dq1[rate] [rad/s²]" in titles(figure)) == (name == "biped")


def test_result_without_algebraic_variables_and_costates(solved, folder):
    with h5py.File(solved("cartpole")) as source, h5py.File("old.h5", "w") as old:
        source.copy("/phase", old)
        for group in ("mesh", "spec", "solver"):
            source.copy(group, old)
        old.attrs.update(source.attrs)
        for grid in ("points", "dense"):
            del old[f"phase/main/{grid}/algebraic"], old[f"phase/main/{grid}/costate"]
    assert len(plots.trajectory_figure(read(folder / "old.h5")).axes) == 5


def test_curves_are_the_dense_ones_and_markers_the_points(solved):
    result = read(solved("cartpole"))
    (phase,) = result.phases
    curve, knots, inner = plots.trajectory_figure(result).axes[0].get_lines()
    assert curve.get_xydata() == pytest.approx(np.stack([phase.dense_time, phase.curves["state"]["q1"].dense], axis=1))
    assert len(phase.dense_time) > 10 * len(phase.time)
    assert knots.get_xdata() == pytest.approx(phase.knots)
    assert inner.get_xdata() == pytest.approx((phase.knots[1:] + phase.knots[:-1]) / 2)
    assert (knots.get_marker(), knots.get_linestyle()) != (inner.get_marker(), "-")


def test_bounds_near_the_curve_are_lines_and_others_words(solved):
    result = read(solved("cartpole"))
    bounds = bounds_of(result.build()[0])
    assert bounds["main"]["u"] == Range(-20, 20)
    q1 = plots.trajectory_figure(result, bounds).axes[0]
    assert [line.get_ydata()[0] for line in q1.get_lines() if line.get_label() == "bound"] == [2]
    assert q1.get_title(loc="right") == "bound ↓ −2"
    assert "bound" not in labels(plots.trajectory_figure(result).axes[0])


@pytest.mark.parametrize("where", ["points", "dense"])
@pytest.mark.parametrize(("bound", "amount", "broken"), [(1.0, 1e-6, 0), (1.0, 1e-3, 1), (1e4, 9e-3, 0), (1e4, 2.0, 1)])
def test_a_bound_is_violated_at_points_or_where_a_check_fails(solved, bound, amount, broken, where):
    result = read(solved("cartpole"))
    (phase,) = result.phases
    inside = {"points": np.full(len(phase.time), 0.9 * bound), "dense": np.full(len(phase.dense_time), 0.9 * bound)}
    inside[where][-1] = bound + amount
    curve = replace(phase.curves["control"]["u"], **inside)
    pushed = replace(result, phases=(replace(phase, curves={"control": {"u": curve}}),))
    alone = broken * (where == "points")
    for failing, expected in (({}, alone), ({"main": {"u"}}, broken), ({"main": {"q1"}}, alone)):
        (ax,) = plots.trajectory_figure(pushed, {"main": {"u": Range(-bound, bound)}}, broken=failing).axes
        assert labels(ax).count("violated bound") == expected
        assert labels(ax).count("bound") == 1 - expected


def test_path_constraint_on_one_name_is_a_bound(solved):
    result = read(solved("bounded"))
    assert bounds_of(result.build()[0])["main"]["x"].upper == pytest.approx(1 / 9)


def test_unreadable_problem_is_drawn_without_bounds(solved, folder):
    changed = folder / "changed.h5"
    changed.write_bytes(solved("cartpole").read_bytes())
    with h5py.File(changed, "a") as file:
        spec = json.loads(file["spec/full"].asstr()[()])
        spec["mesh"] = "of another version"
        del file["spec/full"]
        file["spec/full"] = json.dumps(spec)
    result = trajopt("plot", changed, "--only", "u")
    assert result.exit_code == 0
    assert "warning" in result.stderr and "without bounds" in result.stderr
    assert trajopt("plot", changed, "--only", "u", "--no-bounds").stderr == ""


def test_unsolved_result_says_so(solved):
    figure = plots.trajectory_figure(read(solved("unsolved")))
    assert "NOT SOLVED: ran out of iterations" in figure.get_suptitle()
    assert trajopt("plot", solved("unsolved"), "--error").exit_code == 0


def test_several_pictures_are_several_files_or_pages(solved, folder):
    assert trajopt("plot", solved("bounded"), "--error", "--mesh").stdout.split() == [
        "bounded-error.png",
        "bounded-mesh.png",
    ]
    assert trajopt("plot", solved("bounded"), "--error", "--mesh", "-o", "both.pdf").exit_code == 0
    content = (folder / "both.pdf").read_bytes()
    assert content.startswith(b"%PDF") and b"/Count 2" in content
    refused = trajopt("plot", solved("bounded"), "--error", "--mesh", "-o", "both.png")
    assert refused.exit_code == 2
    assert "one file cannot hold two pictures" in refused.stderr


def test_several_results_go_to_a_folder(solved, folder):
    (folder / "out").mkdir()
    pair = solved("cartpole"), solved("bounded")
    assert trajopt("plot", *pair, "-o", "out", "--only", "v,v1").exit_code == 2  # neither has both
    few = ("--only", "u")
    assert trajopt("plot", *pair, *few, "-o", "out").stdout.split() == ["out/cartpole.png", "out/bounded.png"]
    assert trajopt("plot", *pair, *few, "-o", "one.png").stdout.split() == ["one.png"]  # in one picture
    assert trajopt("plot", pair[0], pair[0], "-o", "out").exit_code == 2
    assert trajopt("plot", pair[0], *few, "-o", "missing/").stdout.split() == ["missing/cartpole.png"]  # it is made


def test_chosen_names(solved):
    result = read(solved("cartpole"))
    assert titles(plots.trajectory_figure(result, only=("u", "q2"))) == [
        "q2 [rad]",
        "u [N]",
        "costate of q2 [objective/rad]",
    ]
    refused = trajopt("plot", solved("cartpole"), "--only", "q9")
    assert refused.exit_code == 2
    assert 'there is no "q9"' in refused.stderr
    assert trajopt("plot", solved("cartpole"), "--only", "u", "--error").exit_code == 2
    assert trajopt("plot", solved("cartpole"), "--only", "u", "--mesh").exit_code == 2


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("-o", "picture.jpg"), 2, "end the name with .png or .pdf"),
        (("-o", "picture"), 2, "no suffix"),
        (("-o", "missing/picture.png"), 3, "folder does not exist"),
        (("-o", "foreign.png"), 3, "not drawn by trajopt"),
        (("-o", "foreign.png", "--force"), 0, ""),
    ],
)
def test_targets(solved, folder, arguments, code, words):
    (folder / "foreign.png").write_bytes(b"\x89PNG\r\n\x1a\n of somebody else")
    result = trajopt("plot", solved("cartpole"), "--only", "u", *arguments)
    assert result.exit_code == code
    assert words in result.stderr
    assert drawn_by_us(folder / "foreign.png") == ("--force" in arguments)


@pytest.mark.parametrize("suffix", [".png", ".pdf"])
def test_our_own_picture_is_replaced_and_comes_out_the_same(solved, folder, suffix):
    pictures = []
    for _ in range(2):
        assert trajopt("plot", solved("cartpole"), "--only", "u", "-o", f"u{suffix}").exit_code == 0
        pictures.append((folder / f"u{suffix}").read_bytes())
    assert pictures[0] == pictures[1]
    assert sorted(path.name for path in folder.iterdir()) == [f"u{suffix}"]


def test_what_is_no_result_is_refused(folder):
    (folder / "text.h5").write_text("no HDF5")
    assert trajopt("plot", "text.h5").exit_code == 3
    assert trajopt("plot", "missing.h5").exit_code == 3


def chain(states: int, name: str = "x") -> str:
    """A problem file with many states, long names and odd characters."""
    lines = [f"  {name}{i}: {{unit: '$kg', rate: {name}{i + 1}, initial: 0}}" for i in range(states - 1)]
    lines.append(f"  {name}{states - 1}: {{unit: '$kg', rate: u, initial: 0, final: 1}}")
    mesh = "mesh: [{method: trapezoid, segments: 3}]"
    head = ["trajopt: 1", "name: 'costs $5, or $6'", "time: {initial: 0, final: 1}", "states:", *lines]
    return "\n".join([*head, "controls: {u: {}}", "objective: {minimize: {integral: u**2}}", mesh])


@pytest.mark.parametrize(("states", "name"), [(1, "x"), (8, "a_rather_long_name_of_a_state_")])
def test_panels_of_one_and_of_many_states_do_not_overlap(folder, states, name):
    (folder / "chain.yaml").write_text(chain(states, name))
    assert trajopt("solve", "chain.yaml", "-q").exit_code == 0
    figure = plots.trajectory_figure(read(folder / "chain.h5"))
    assert len(figure.axes) == 2 * states + 1
    renderer = FigureCanvasAgg(figure).get_renderer()
    boxes = [ax.get_tightbbox(renderer).frozen() for ax in figure.axes]
    assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])
    assert not any((box.min < 0).any() or (box.max > figure.bbox.size).any() for box in boxes)


def test_too_many_panels_are_refused_with_a_way_out(folder):
    (folder / "chain.yaml").write_text(chain(90))
    assert trajopt("solve", "chain.yaml", "-q").exit_code == 0
    result = read(folder / "chain.h5")
    with pytest.raises(SpecError, match="--only"):
        plots.trajectory_figure(result)
    assert len(plots.trajectory_figure(result, only=("x0", "x89", "u")).axes) == 5


@pytest.mark.parametrize(
    ("ticks", "texts"),
    [
        ([0, 0.5, 1], ["0", "0.5", "1"]),
        ([-1e-9, 0, 1e-9], ["−1e−09", "0", "1e−09"]),
        ([0.1 + 0.2, 0.4], ["0.3", "0.4"]),
        ([2.86735, 2.8674, 2.86745], ["2.86735", "2.8674", "2.86745"]),
        ([3.0], ["3"]),
    ],
)
def test_numbers_beside_an_axis(ticks, texts):
    assert Numbers().format_ticks(ticks) == texts


def test_no_window_system_and_no_start_up_time_is_needed(solved, folder):
    script = (
        "import sys; from trajopt.cli.result_files.plot import plot; assert 'matplotlib' not in sys.modules\n"
        f"plot([__import__('pathlib').Path({str(solved('cartpole'))!r})], output='u.png', only='u')\n"
        "assert 'matplotlib.pyplot' not in sys.modules"
    )
    environment = {name: value for name, value in os.environ.items() if name != "DISPLAY"} | {"MPLBACKEND": "TkAgg"}
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    assert (folder / "u.png").exists()


def test_a_home_that_cannot_be_written_is_no_trouble(solved, folder):
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("MPL", "XDG"))}
    done = process("plot", solved("cartpole"), "--only", "u", env=environment | {"HOME": "/proc"})
    assert (done.returncode, done.stdout, done.stderr) == (0, "cartpole.png\n", "")


def test_outputs_and_path_constraints_are_stored_shown_and_drawn(tmp_path):
    text = """
trajopt: 1
states: {x: {rate: v, unit: m, initial: 0, final: 1}, v: {rate: u, unit: m/s, initial: 0, final: 0}}
controls: {u: {unit: m/s^2}}
parameters: {half: 0.5}
expressions: {power: {value: u*v, unit: W, note: mechanical}, twice: 2*power, fixed: 2*half}
constraints: {path: [{name: bowl, expression: x + v, upper: 1.7}, {expression: v, upper: 9}]}
time: {initial: 0, final: 1}
objective: {minimize: {integral: u**2 + 0*twice}}
mesh: [{method: hermite-simpson, segments: 10}]
"""
    spec = load_text(text, "x.yaml")
    assert not [w for w in spec.warnings if "power" in w.what]  # an output is of use
    solution = solve(build(spec), steps(spec.mesh))
    path = tmp_path / "a.h5"
    write(path, solution, spec.text, spec.model_dump_json(), "test")
    phase = summarize(path)["phases"]["main"]
    assert list(phase["outputs"]) == ["power", "twice"] and phase["outputs"]["power"]["unit"] == "W"
    assert list(phase["path"]) == ["bowl"] and phase["path"]["bowl"]["max"] == pytest.approx(1.7, abs=1e-6)
    result = read(path)
    curves = result.phases[0].curves
    np.testing.assert_allclose(curves["output"]["twice"].dense, 2 * curves["output"]["power"].dense)
    x, v = (curves["state"][name].points for name in ("x", "v"))
    np.testing.assert_allclose(curves["path"]["bowl"].points, x + v)
    names = [ax.get_title(loc="left") for ax in plots.trajectory_figure(result, bounds_of(result.build()[0])).axes]
    assert "power [W]" in names and "bowl" in names and "twice" not in names  # which has no unit
    only = [ax.get_title(loc="left") for ax in plots.trajectory_figure(result, only=["twice"]).axes]
    assert "twice" in only


VANISHING = """
trajopt: 1
time: {initial: 0, final: {lower: 0.5, upper: 10, guess: 3}}
states: {x: {rate: v, initial: 0, final: 1}, v: {rate: u, initial: 0, final: 0}}
controls: {u: {lower: -1, upper: 1}}
phases:
  up: {controls: {u: {lower: 1}}}
  coast: {without: [u], states: {v: {rate: 0}}}
  down: {controls: {u: {upper: -1}}}
objective: {minimize: {terminal: "t[final]"}}
mesh: [{method: radau, segments: 3}]
"""


def drawn(text, folder):
    run = trajopt("solve", "-", "-o", folder / "own.h5", given=text)
    assert run.exit_code == 0, run.output
    return read(folder / "own.h5")


@pytest.mark.parametrize("text", [VANISHING, BRANCHES])
def test_panels_above_each_other_have_one_time_axis_whatever_phases_they_draw(folder, text):
    result = drawn(text, folder)
    figure = plots.trajectory_figure(result)
    assert len({ax.get_xlim() for ax in figure.axes}) == 1 and len(figure.axes) == 5
    low, high = figure.axes[0].get_xlim()
    ends = [time for phase in result.phases for time in phase.knots[[0, -1]]]
    assert low < min(ends) and max(ends) < high


def test_phases_beside_one_that_has_vanished_are_told_apart(folder):
    result = drawn(VANISHING, folder)
    assert result.phases[1].knots[-1] - result.phases[1].knots[0] < 1e-2
    shaded = [patch.get_extents().bounds for patch in plots.trajectory_figure(result).axes[0].patches]
    last = plots.trajectory_figure(result).axes[0].transData.transform((result.phases[2].knots[0], 0))[0]
    assert any(left == pytest.approx(last, abs=1) and wide > 50 for left, _, wide, _ in shaded)
