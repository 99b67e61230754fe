"""`drawing:` in a file: any problem becomes a film and a path, obstacles are drawn, mistakes have their place."""

from math import pi

import numpy as np
import pytest
from command_line import solved_once, trajopt
from PIL import Image

from trajopt.problems.drawings.drawing import drawings_of, obstacles_of
from trajopt.problems.drawings.shapes import Circle, Ground, Polyline, Rectangle
from trajopt.problems.errors import SpecError
from trajopt.results.file.bounds import bounds_of
from trajopt.results.file.read import read
from trajopt.results.pictures.animate import scene
from trajopt.results.pictures.overlay import CYCLE, overlay_figure, path_in_plane
from trajopt.results.pictures.style import GREY
from trajopt.transcription.loading import load_yaml

pytestmark = pytest.mark.usefixtures("folder")

FILE = """trajopt: 1
name: drawn
parameters: {r: 0.2, b: 1}
time: {initial: 0, final: 1}
states:
  x: {unit: m, rate: vx, initial: 0, final: 1}
  y: {unit: m, rate: vy, initial: 0, final: 1}
controls: {vx: {unit: m/s}, vy: {unit: m/s}}
expressions: {half: x/2, tip(l): l*cos(x)}
objective: {minimize: {integral: vx**2 + vy**2}}
mesh: [{method: hermite-simpson, segments: 4}]
drawing:
  - {ground: -r}
  - {circle: [b, 0.3], radius: r, obstacle: true}
  - {box: [x, y], width: 0.2, height: 0.1, angle: pi/2*x, trail: true}
  - {line: [[0, 0], [half, tip(r)]], color: green}
  - {point: [x, -y], trail: whole}
"""
PHASES = """trajopt: 1
name: stages
time: {initial: 0, final: 2}
states: {x: {rate: v, initial: 0, final: 1}, v: {rate: u, initial: 0, final: 0}}
controls: {u: {}}
phases:
  on: {time: {final: 1}, states: {m: {rate: -1, initial: 3}}}
  off: {}
objective: {minimize: {integral: u**2}}
mesh: [{method: hermite-simpson, segments: 3}]
drawing:
  - {point: [x, 0]}
  - {circle: [x, m], radius: 0.1}
"""


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder = tmp_path_factory.mktemp("drawn")
    (folder / "drawn.yaml").write_text(FILE)
    return solved_once(folder / "drawn.h5", folder / "drawn.yaml")


def test_shapes_at_one_time():
    (drawing,) = drawings_of(load_yaml(FILE)).values()
    ground, disc, box, line, point = drawing({"x": 1.0, "y": 0.5, "vx": 1, "vy": 1, "t": 1.0})
    assert ground == Ground(-0.2)
    assert disc == Circle("obstacle", (1.0, 0.3), 0.2)
    assert box == Rectangle("cart", (1.0, 0.5), 0.2, 0.1, pi / 2, "path")
    assert line == Polyline("pole", [(0.0, 0.0), (0.5, pytest.approx(0.2 * np.cos(1.0)))], "green")
    assert point == Circle("tip", (1.0, -0.5), 0.0, "wire")
    assert obstacles_of(load_yaml(FILE)) == [disc]


def test_a_turned_box_has_turned_corners(result):
    stage = scene(read(result))
    assert stage.box[1][0] == pytest.approx(1.2)  # the disc around b
    assert set(stage.traces) == {2, 4}
    assert stage.traces[2][-1] == pytest.approx([1, 1])


def test_film_and_poses(result, folder):
    assert trajopt("animate", result, "--frames", "3").exit_code == 0
    assert Image.open("drawn.gif").n_frames == 3
    assert trajopt("animate", result, "-o", "poses.svg").exit_code == 0
    assert (folder / "poses.svg").read_text().startswith("<?xml")


def test_one_quantity_against_another_with_the_obstacles(result):
    figure = path_in_plane([read(result)], "x", "y")
    (ax,) = figure.axes
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.get_aspect()) == ("x [m]", "y [m]", 1)
    assert [patch.get_radius() for patch in ax.patches] == [0.2]
    line = ax.get_lines()[0]
    assert line.get_xdata() == pytest.approx(line.get_ydata(), abs=1e-6)
    assert trajopt("plot", result, "--xy", "x,y").stdout == "drawn-xy.png\n"
    for wrong, words in (("x", "two names"), ("x,z", 'there is no "z"'), ("x,y,vx", "two names")):
        told = trajopt("plot", result, "--xy", wrong)
        assert told.exit_code == 2 and words in told.stderr
    told = trajopt("plot", result, "--xy", "x,y", "--mesh")
    assert told.exit_code == 2 and told.stderr.endswith("; leave out --mesh\n")


def test_results_in_one_picture(result, folder):
    other = solved_once(folder / "other.h5", result.parent / "drawn.yaml", "--set", "states.x.final=2")
    figure = overlay_figure([read(result), read(other)])
    assert [ax.get_title(loc="left") for ax in figure.axes][:4] == ["x [m]", "y [m]", "vx [m/s]", "vy [m/s]"]
    lines = [line for line in figure.axes[0].get_lines() if line.get_label() in ("drawn", "other")]
    assert [line.get_ydata()[-1] for line in lines] == pytest.approx([1, 2])
    assert len({line.get_color() for line in lines}) == 2
    assert trajopt("plot", result, other).stdout == "overlay.png\n"
    assert trajopt("plot", result, other, "--only", "x,vx", "-o", "two.svg").exit_code == 0
    told = trajopt("plot", result, other, "--only", "z")
    assert told.exit_code == 2 and 'there is no "z"' in told.stderr


def bounds_drawn(figure):
    """Value -> colour of the bounds in the first panel."""
    return {line.get_ydata()[0]: line.get_color() for line in figure.axes[0].get_lines() if line.get_label() == "bound"}


def test_bounds_of_several_results_that_differ_are_drawn_each(folder):
    found = [
        read(
            solved_once(
                folder / f"{most}.h5",
                "block_move_min_force",
                "--method",
                "trapezoid",
                "--set",
                f"controls.u.upper={most}",
            )
        )
        for most in (5.5, 5.8)
    ]
    assert trajopt("plot", *(own.path for own in found)).stdout == "overlay.png\n"
    bounds = [bounds_of(own.build()[0]) for own in found]
    figure = overlay_figure(found, bounds, ["u"])
    assert bounds_drawn(figure) == {5.5: CYCLE[0], 5.8: CYCLE[1]}
    assert any("each bound in the colour of its result" in text.get_text() for text in figure.texts)
    alike = overlay_figure([found[0]] * 2, [bounds[0]] * 2, ["u"])
    assert bounds_drawn(alike) == {5.5: GREY}
    assert not any("colour of its result" in text.get_text() for text in alike.texts)
    assert not bounds_drawn(overlay_figure(found, [], ["u"]))


def test_what_a_phase_lacks_is_nowhere():
    drawings = drawings_of(load_yaml(PHASES))
    values = {"x": 0.5, "v": 1.0, "u": 0.0, "t": 0.0, "m": 2.0}
    assert drawings["on"](values)[1].centre == (0.5, 2.0)
    assert np.isnan(drawings["off"](values)[1].centre).all()


@pytest.mark.parametrize(
    ("shape", "place", "words"),
    [
        ("{circle: [x, w], radius: 1}", "drawing.0.circle.1", 'unknown name "w"'),
        ("{circle: [x, y]}", "drawing.0", "add radius: 0.1"),
        ("{circle: [x, y], radius: 1, box: [x, y]}", "drawing.0", "circle and box are both given"),
        ("{radius: 1}", "drawing.0", "give one of line:, point:, circle:, box: and ground:"),
        ("{point: [x]}", "drawing.0.point", "for example point: [x, y]"),
        ("{point: [x, y], color: pink}", "drawing.0.color", "is not one of the choices"),
        ("{point: [x, y], trail: long}", "drawing.0.trail", "write trail: true"),
        ("{ground: 0, width: 1}", "drawing.0", "a ground has no width"),
        ("{line: [[x, y], [x, y]], trail: true}", "drawing.0", "no middle"),
        ('{point: [x, "x[final]"]}', "drawing.0.point.1", "x[final] is a value at one end"),
    ],
)
def test_mistakes(shape, place, words):
    with pytest.raises(SpecError) as error:
        load_yaml(FILE[: FILE.index("drawing:")] + f"drawing: [{shape}]\n", (), "d.yaml")
    told = [str(mistake) for mistake in error.value.mistakes]
    assert any(own.startswith(f"d.yaml:12: {place}: ") and words in own for own in told), told


def test_a_drawing_has_the_numbers_of_its_phase(tmp_path):
    text = PHASES.replace("time: {initial", "parameters: {r: 0.1}\ntime: {initial").replace(
        "off: {}", "off: {parameters: {r: 0.3}}"
    )
    (tmp_path / "stages.yaml").write_text(text.replace("radius: 0.1", "radius: r").replace("[x, m]", "[x, 0]"))
    drawn = scene(read(solved_once(tmp_path / "stages.h5", tmp_path / "stages.yaml")))
    assert [pose.shapes[1].radius for pose in drawn.at(np.array([0.5, 1.5]))] == [0.1, 0.3]
