"""`trajopt plot` and `trajopt animate`: result files -> pictures."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ...problems.errors import FileError, Mistake, SpecError
from ..common import command
from ..options import Force, Results
from ..output.printing import one_line

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...results.file.read import Result

PICTURES, FILMS = (".png", ".pdf"), (".gif", ".mp4")
FPS, FRAMES = 20, (24, 240)
POSES = 9

Picture = Annotated[str, typer.Option("-o", "--output", metavar="FILE", help="Name of the picture, or a folder.")]
Only = Annotated[str, typer.Option("--only", metavar="NAME,NAME", help="Draw these names only, with their costates.")]
Errors = Annotated[bool, typer.Option("--error", help="Draw epsilon over time and eta of each segment.")]
Meshes = Annotated[bool, typer.Option("--mesh", help="Draw the history of the meshes.")]
NoBounds = Annotated[bool, typer.Option("--no-bounds", help="Leave the bounds out.")]
Frames = Annotated[
    int, typer.Option("--frames", metavar="N", min=2, max=1000, show_default=False, help="Number of pictures or poses.")
]
FramesPerSecond = Annotated[int, typer.Option("--fps", metavar="N", min=1, max=50, help="Pictures a second.")]


@command
def plot(
    results: Results,
    *,
    output: Picture = None,
    error: Errors = False,
    mesh: Meshes = False,
    no_bounds: NoBounds = False,
    only: Only = "",
    force: Force = False,
) -> None:
    """Draw states, controls and costates over time.

    With --error and --mesh what these say is drawn instead.

    Example: trajopt plot cartpole.h5 --error -o error.pdf

    Without -o the pictures are <name of the result>.png, <name>-error.png and <name>-mesh.png in the current folder. A
    file ending with .pdf holds several pictures, one on a page. A picture that trajopt has drawn is replaced, any other
    file only with --force.
    """
    kinds = [kind for kind, wanted in (("error", error), ("mesh", mesh)) if wanted] or ["trajectory"]
    targets = _targets(results, output, [_ending(kind) for kind in kinds])

    from ...results.file.read import read
    from ...results.pictures.style import check_picture, save

    for path in (path for paths in targets for path in paths):
        check_picture(path, PICTURES, force)
    names = tuple(filter(None, (name.strip() for name in only.split(","))))
    if names and kinds == ["mesh"]:
        raise SpecError(Mistake("--only", "the history of the meshes shows no states", "leave --only out"))
    for result, paths in zip(map(read, results), targets, strict=True):
        figures = [_figure(kind, result, names, no_bounds) for kind in kinds]
        groups = [figures] if len(paths) == 1 else [[figure] for figure in figures]
        for path, group in zip(paths, groups, strict=True):
            save(group, path, result.problem)
            print(path)


def draw_trajectory(path: Path, force: bool) -> Path:
    """The picture of one result in the current folder, for `solve --plot`."""
    from ...results.file.read import read
    from ...results.pictures.style import check_picture, save

    target, result = Path(f"{path.stem}.png"), read(path)
    check_picture(target, PICTURES, force)
    save([_figure("trajectory", result, (), False)], target, result.problem)
    return target


def _ending(kind: str) -> str:
    return ".png" if kind == "trajectory" else f"-{kind}.png"


def _figure(kind: str, result: Result, names: Sequence[str], no_bounds: bool) -> Figure:
    from ...results.pictures.mesh_plots import mesh_figure
    from ...results.pictures.plots import error_figure, trajectory_figure

    if kind == "trajectory":
        return trajectory_figure(result, {} if no_bounds else _bounds(result), names)
    return error_figure(result, names) if kind == "error" else mesh_figure(result)


def _bounds(result: Result) -> dict:
    """The bounds of the problem; if an old file does not tell them, that is said and the picture is drawn without."""
    from ...results.file.read import bounds_of

    try:
        return bounds_of(result.build()[0])
    except SpecError as error:
        print(f"warning: {one_line(str(error))}; drawn without bounds", file=sys.stderr)
        return {}


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
    targets = [path for (path,) in _targets(results, output, [".gif"])]

    from ...results.file.read import read
    from ...results.pictures.animate import animate as film
    from ...results.pictures.animate import check_film, stop_action_figure
    from ...results.pictures.style import check_picture, save

    for path in targets:
        check_picture(path, (*FILMS, *PICTURES), force)
        check_film(path)
    for result, path in zip(map(read, results), targets, strict=True):
        if path.suffix.lower() in FILMS:
            film(result, path, frames or _real_time(result, fps), fps)
        else:
            save([stop_action_figure(result, frames or POSES)], path, result.problem)
        print(path)


def _real_time(result: Result, fps: int) -> int:
    duration = result.phases[-1].knots[-1] - result.phases[0].knots[0]
    least, most = FRAMES
    return int(min(max(duration * fps, least), most))


def _targets(results: Sequence[Path], output: str | None, endings: Sequence[str]) -> list[list[Path]]:
    """For each result the files to write: one for each ending, or one for all that -o names.

    Raises SpecError if two pictures would go to one file that cannot hold them, FileError if a folder is missing.
    """
    if output is None or Path(output).is_dir():
        targets = [[Path(output or "") / (path.stem + ending) for ending in endings] for path in results]
        flat = [path for paths in targets for path in paths]
        if twice := next((path for path in flat if flat.count(path) > 1), None):
            raise SpecError(
                Mistake(str(twice), "two of the pictures would go to this file", "draw one of them with -o")
            )
        return targets
    if output.endswith(os.sep):
        raise FileError(Mistake(f"-o {output}", "there is no such folder", "create it first"))
    if len(results) > 1:
        raise FileError(
            Mistake(f"-o {output}", f"this is no folder, but there are {len(results)} results", "create it first")
        )
    if len(endings) > 1 and Path(output).suffix.lower() != ".pdf":
        raise SpecError(Mistake(f"-o {output}", "one file cannot hold two pictures", "give a .pdf, or a folder"))
    return [[Path(output)]]
