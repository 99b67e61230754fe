"""Drawings of the shipped problems, films and stop-action pictures."""

import shutil
from itertools import pairwise
from math import cos, pi, sin

import numpy as np
import pytest
from command_line import solved_once, trajopt
from matplotlib.figure import Figure
from PIL import Image

from trajopt.problems.drawings.drawing import drawings_of
from trajopt.problems.drawings.shapes import Circle, Polyline, Rectangle
from trajopt.results.file.read import read
from trajopt.results.pictures.animate import scene, stop_action
from trajopt.results.pictures.style import COLOURS, PARTS
from trajopt.transcription.loading import load_file

pytestmark = pytest.mark.usefixtures("folder")

DRAWN = {  # a shipped problem that draws itself -> the override that makes it small
    "cartpole": "mesh.-1.segments=10",
    "pendulum": "mesh.-1.segments=20",
    "block_move_min_force": "mesh.-1.segments=4",
    "brachistochrone": "mesh.-1.segments=6",
    "shot_put": "mesh.-1.segments=2",
    "biped": "mesh.-1.segments=5",
}


@pytest.fixture(scope="module")
def solved(tmp_path_factory):
    """name -> a result file, each solved once."""
    folder = tmp_path_factory.mktemp("results")

    def solve(name: str):
        small = ["--set", DRAWN[name]] if name in DRAWN else []
        return solved_once(folder / f"{name}.h5", name, *small)

    return solve


def shapes_of(name, role, values):
    (drawing,) = drawings_of(load_file(name)).values()
    return [shape for shape in drawing(values) if shape.role == role]


@pytest.mark.parametrize("angle", [0.0, 0.7, pi])
def test_cart_pole_hangs_at_zero_and_turns_counter_clockwise(angle):
    values = {"q1": 0.3, "q2": angle, "v1": 0.0, "v2": 0.0, "u": 1.0, "t": 0.0}
    (cart,) = shapes_of("cartpole", "cart", values)
    (tip,) = shapes_of("cartpole", "tip", values)
    (pole,) = shapes_of("cartpole", "pole", values)
    assert (cart.centre, cart.width, cart.height) == ((0.3, 0.0), 0.15, 0.05)
    assert tip.centre == pytest.approx((0.3 + 0.5 * sin(angle), -0.5 * cos(angle)))
    assert pole.points[0] == cart.centre and pole.points[1] == pytest.approx(tip.centre)


def test_biped_puts_its_swing_foot_down_one_step_ahead():
    """The final state of Table 4's walker, computed independently: P5 = (0.5, 0) m, and the knees do not come apart."""
    q = (-0.36192, -0.35099, -0.22793, 0.50165, 0.07129)
    values = {f"q{i}": angle for i, angle in enumerate(q, start=1)}
    tibia, femur, torso, swing_femur, swing_tibia = shapes_of("biped", "pole", values)
    (foot,) = shapes_of("biped", "tip", values)
    assert foot.centre == pytest.approx((0.5, 0.0), abs=1e-4)
    assert tibia.points[0] == pytest.approx((0, 0)) and tibia.points[1] == pytest.approx(femur.points[0])
    assert femur.points[-1] == pytest.approx(swing_femur.points[0]) and femur.points[-1] == pytest.approx(
        torso.points[0]
    )
    assert swing_tibia.points[-1] == pytest.approx(foot.centre)
    assert np.hypot(*np.diff(torso.points, axis=0)[0]) == pytest.approx(0.625)


@pytest.mark.parametrize("name", DRAWN)
def test_shipped_problem_knows_its_drawing(solved, name):
    result = read(solved(name))
    stage = scene(result)
    roles = {shape.role for pose in stage.at(stage.times[:2]) for shape in pose.shapes}
    assert roles <= PARTS.keys()
    assert np.isfinite(stage.box).all()
    assert (stage.start, stage.end) == (result.phases[0].knots[0], result.phases[0].knots[-1])


def test_problem_without_drawing_is_told_so(solved, folder):
    result = trajopt("animate", solved("van_der_pol"))
    assert result.exit_code == 2
    assert "no drawing" in result.stderr and "drawing: [{circle: [x1, x2]" in result.stderr
    assert not list(folder.iterdir())


def test_film(solved, folder):
    result = trajopt("animate", solved("cartpole"), "--frames", "5", "--fps", "10")
    assert (result.exit_code, result.stdout) == (0, "cartpole.gif\n")
    film = Image.open("cartpole.gif")
    assert (film.n_frames, film.info["loop"], film.info["duration"]) == (5, 0, 100)
    assert b"Software: trajopt" in film.info["comment"]
    frames = []
    for k in range(5):
        film.seek(k)
        frames.append(np.asarray(film.convert("RGB"), int))
    assert film.info["duration"] == 800  # the last picture rests
    assert all((frame[0, 0] == 255).all() for frame in frames)  # white is white
    assert all(np.abs(a - b).max() > 100 for a, b in pairwise(frames))
    blue = (frames[0] == (0, 0x72, 0xB2)).all(axis=-1)
    assert blue.sum() > 100  # the cart, in its very colour
    assert trajopt("animate", solved("cartpole"), "--frames", "2").exit_code == 0  # our own film is replaced


def test_film_runs_in_real_time(solved):
    assert trajopt("animate", solved("cartpole"), "--fps", "15").exit_code == 0  # 2 s
    assert Image.open("cartpole.gif").n_frames == 30


@pytest.mark.parametrize(
    ("name", "code", "words"),
    [
        ("film.avi", 2, ".gif or .mp4"),
        ("foreign.gif", 3, "not drawn by trajopt"),
        ("missing/film.gif", 3, "folder does not exist"),
    ],
)
def test_targets(solved, folder, name, code, words):
    (folder / "foreign.gif").write_bytes(b"GIF89a of somebody else")
    result = trajopt("animate", solved("cartpole"), "--frames", "2", "-o", name)
    assert result.exit_code == code
    assert words in result.stderr


def test_mp4_without_ffmpeg_is_refused(solved, monkeypatch):
    monkeypatch.setenv("PATH", "/nowhere")
    result = trajopt("animate", solved("cartpole"), "-o", "film.mp4")
    assert result.exit_code == 2
    assert "install ffmpeg" in result.stderr


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="there is no ffmpeg")
def test_mp4(solved, folder):
    assert trajopt("animate", solved("cartpole"), "--frames", "5", "-o", "film.mp4").exit_code == 0
    content = (folder / "film.mp4").read_bytes()
    assert content[4:8] == b"ftyp" and b"Software: trajopt" in content


def test_stop_action_is_coloured_by_time_and_shows_the_path(solved):
    ax = Figure().add_subplot()
    stop_action(ax, read(solved("cartpole")), 9)
    carts = [patch for patch in ax.patches if type(patch).__name__ == "Rectangle"]
    light = [np.dot(cart.get_facecolor()[:3], (0.3, 0.6, 0.1)) for cart in carts]
    assert len(carts) == 9
    assert (np.diff(light) > 0).all()  # from dark to light, in grey print too
    path = ax.get_lines()[0].get_xydata()
    assert path[0] == pytest.approx((0, -0.5), abs=1e-6)
    assert path[-1] == pytest.approx((1, 0.5), abs=1e-6)
    assert ax.get_aspect() == 1
    assert ax.get_xlabel() == "x [m]"


def test_stop_action_of_the_biped_tells_its_parts_apart(solved):
    ax = Figure().add_subplot()
    stop_action(ax, read(solved("biped")), 4, spread=0.5, by_part=True)
    dashed = [line for line in ax.get_lines() if line.get_linestyle() == "--"]
    assert {line.get_color() for line in dashed} == {COLOURS["vermilion"]}
    assert [line.get_xdata()[0] for line in dashed[::2]] == pytest.approx([0, 0.5, 1.0, 1.5])
    assert [line.get_alpha() for line in dashed[::2]] == pytest.approx([0.35, 0.567, 0.783, 1.0], abs=1e-3)


@pytest.mark.parametrize("target", ["poses.png", "poses.pdf"])
def test_stop_action_picture(solved, folder, target):
    assert trajopt("animate", solved("shot_put"), "--frames", "4", "-o", target).exit_code == 0
    assert (folder / target).stat().st_size > 3000


def test_what_stands_still_is_drawn_once(solved):
    ax = Figure().add_subplot()
    stop_action(ax, read(solved("shot_put")), 6)
    assert sum(len(line.get_xdata()) == 2 and line.get_marker() == "o" for line in ax.get_lines()) == 1


def test_shapes_are_plain_values():
    assert Circle("tip", (0.0, 1.0), 0.1) == Circle("tip", (0.0, 1.0), 0.1, trace="")
    assert Polyline("pole", [(0, 0)]) != Polyline("pole", [(0, 1)])
    assert Rectangle("cart", (0, 0), 1, 1) != Rectangle("block", (0, 0), 1, 1)
