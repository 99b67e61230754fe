"""`trajopt animate`: how the system moves, as a film or as poses in one picture."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import command
from ..options import Force, Picture, Results
from .targets import PICTURES, targets_of

if TYPE_CHECKING:
    from ...results.file.read import Result

FILMS = (".gif", ".mp4")
FPS, FRAMES = 20, (24, 240)
POSES = 9

Frames = Annotated[
    int | None,
    typer.Option("--frames", metavar="N", min=2, max=1000, show_default=False, help="Number of pictures or poses."),
]
FramesPerSecond = Annotated[int, typer.Option("--fps", metavar="N", min=1, max=50, help="Pictures a second.")]


@command
def animate(
    results: Results,
    *,
    output: Picture = None,
    frames: Frames = None,
    fps: FramesPerSecond = FPS,
    force: Force = False,
) -> None:
    """Draw how the system moves: a film, or poses in one picture.

    A name that ends with .gif or .mp4 makes a film, .png or .pdf a picture.

    Example: trajopt animate cartpole.h5 -o swing.gif --frames 60

    Without -o the film is <name of the result>.gif in the current folder. Without --frames it runs in real time if that
    gives 24 to 240 pictures, and a picture shows 9 poses. MP4 needs the program ffmpeg.
    """
    targets = [path for (path,) in targets_of(results, output, [".gif"])]

    from ...results.file.read import read
    from ...results.pictures.animate import animate as film
    from ...results.pictures.animate import stop_action_figure
    from ...results.pictures.film import check_film
    from ...results.pictures.style import check_picture, save_figure

    for path in targets:
        check_picture(path, (*FILMS, *PICTURES), force)
        check_film(path)
    for result, path in zip(map(read, results), targets, strict=True):
        if path.suffix.lower() in FILMS:
            film(result, path, frames or _real_time(result, fps), fps)
        else:
            save_figure([stop_action_figure(result, frames or POSES)], path, result.problem)
        print(path)


def _real_time(result: Result, fps: int) -> int:
    duration = result.phases[-1].knots[-1] - result.phases[0].knots[0]
    least, most = FRAMES
    return int(min(max(duration * fps, least), most))
