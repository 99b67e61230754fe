"""Pictures of the errors of a result, of its error bar, and of the history of its meshes."""

import json
from dataclasses import replace

import numpy as np
import pytest
from command_line import trajopt
from matplotlib.backends.backend_agg import FigureCanvasAgg

from trajopt.results.file.read import read
from trajopt.results.pictures import error_plots, mesh_plots

from .pictured import titles

pytestmark = pytest.mark.usefixtures("folder")


def test_error_picture_has_epsilon_on_the_left_and_eta_on_the_right(solved):
    result = read(solved("cartpole"))
    figure = error_plots.error_figure(result, ("q1", "v2"))
    assert titles(figure) == ["|ε| of q1 [m/s]", "η of q1 [m]", "|ε| of v2 [rad/s²]", "η of v2 [rad/s]"]
    left, right = figure.axes[:2]
    assert left.get_lines()[0].get_ydata() == pytest.approx(np.abs(result.phases[0].epsilon["q1"].dense))
    assert left.get_yscale() == right.get_yscale() == "log"
    (bars,) = right.patches
    eta = result.phases[0].eta["q1"]
    assert bars.get_data().values == pytest.approx(eta)
    assert right.get_title(loc="right") == f"max {eta.max():.2g} in segment {eta.argmax() + 1}"


def test_error_picture_has_what_each_segment_adds_to_the_bar(solved):
    result = read(solved("cartpole"))
    relative, shares = error_plots.error_figure(result).axes[-2:]
    (phase,) = result.phases
    assert shares.get_title(loc="left").startswith(f"part of the error bar {result.objective_error:.2g}")
    for ax, values in ((relative, phase.relative), (shares, phase.shares)):
        assert len(values) == 5 and ax.patches[0].get_data().values == pytest.approx(values)
    assert 0 < phase.shares.sum() <= result.objective_error
    told = trajopt("solve", "cartpole", "--segments", "5", "--json").stdout
    assert json.loads(told)["objective_error"] == pytest.approx(result.objective_error)


@pytest.mark.parametrize("lacks", [("relative",), ("shares",), ("relative", "shares")])
def test_what_a_result_lacks_is_told(solved, lacks, recwarn):
    result = read(solved("cartpole"))
    phase = replace(result.phases[0], **dict.fromkeys(lacks, np.zeros(0)))
    shown = error_plots.error_figure(replace(result, phases=(phase,))).axes[-2:]
    told = [ax.get_title(loc="right") == "not in this result" for ax in shown]
    assert told == ["relative" in lacks, "shares" in lacks]
    assert not recwarn.list


@pytest.mark.parametrize(
    ("name", "why"), [("pendulum", "finite differences have no costates"), ("unsolved", "the point is not optimal")]
)
def test_pictures_say_why_there_is_no_bar(solved, name, why):
    result = read(solved(name))
    assert np.isnan(result.objective_error) and result.phases[0].shares.size == 0
    for ax in (error_plots.error_figure(result).axes[-1], mesh_plots.mesh_figure(result).axes[3]):
        (text,) = ax.texts
        assert text.get_text().replace("\n", " ") == f"no error bar of the objective: {why}"
        assert not ax.axison
    assert trajopt("plot", solved(name), "--error", "--mesh").exit_code == 0


@pytest.mark.parametrize("name", ["pendulum", "biped"])
def test_panels_of_the_errors_and_of_the_meshes_do_not_overlap(solved, name):
    result = read(solved(name))
    for figure in (error_plots.error_figure(result), mesh_plots.mesh_figure(result)):
        renderer = FigureCanvasAgg(figure).get_renderer()
        boxes = [ax.get_tightbbox(renderer).frozen() for ax in figure.axes]
        assert not any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[:i])


def test_a_mesh_without_a_bar_is_left_out_of_the_picture(solved):
    result = read(solved("biped"))
    first, last = result.meshes
    unknown = replace(result, meshes=(replace(first, objective_error=np.nan), last))
    _, _, objective, bar, _ = mesh_plots.mesh_figure(unknown).axes
    assert np.isnan(bar.get_lines()[0].get_ydata()).tolist() == [True, False]
    assert np.isfinite([*objective.get_ylim(), *bar.get_ylim()]).all()


def test_mesh_picture_shows_every_mesh(solved):
    result = read(solved("biped"))
    edges, unknowns, objective, bar, eta = mesh_plots.mesh_figure(result).axes
    segments = [int(mesh.segments) for mesh in result.meshes]
    assert len(segments) == 2
    told = [f"{number}: hermite-simpson, {count}" for number, count in enumerate(segments, start=1)]
    assert [label.get_text() for label in edges.get_yticklabels()] == told
    assert [len(lines.get_segments()) for lines in edges.collections[1::2]] == [count + 1 for count in segments]
    drawn = ((unknowns, "unknowns"), (objective, "objective"), (bar, "objective_error"), (eta, "max_eta"))
    for ax, name in drawn:
        assert ax.get_lines()[0].get_ydata() == pytest.approx([getattr(mesh, name) for mesh in result.meshes])
    bars = [[mesh.objective - mesh.objective_error, mesh.objective + mesh.objective_error] for mesh in result.meshes]
    assert [list(line[:, 1]) for line in objective.collections[0].get_segments()] == bars
    low, high = objective.get_ylim()
    least = min(bars, key=lambda ends: ends[1] - ends[0])
    assert low <= least[0] < least[1] <= high


@pytest.mark.parametrize(("name", "ticks"), [("cartpole", [1]), ("biped", [1, 2])])
def test_meshes_are_counted_by_whole_numbers(solved, name, ticks):
    for ax in mesh_plots.mesh_figure(read(solved(name))).axes[1:]:
        low, high = ax.get_xlim()
        assert [tick for tick in ax.get_xticks() if low <= tick <= high] == ticks
