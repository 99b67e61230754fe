"""`trajopt plot`: curves of result files -> pictures."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ...problems.errors import FileError, Mistake, SpecError
from ..errors import command
from ..options import Force, Picture, Results
from ..output.printing import one_line
from .targets import PICTURES, folder_of, targets_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ...results.file.read import Result

Only = Annotated[str, typer.Option("--only", metavar="NAME,NAME", help="Draw these names only, with their costates.")]
Errors = Annotated[
    bool, typer.Option("--error", help="Draw epsilon over time, eta of each segment and its part of the error bar.")
]
Meshes = Annotated[bool, typer.Option("--mesh", help="Draw the history of the meshes.")]
Plane = Annotated[str, typer.Option("--xy", metavar="NAME,NAME", help="Draw the second against the first.")]
NoBounds = Annotated[bool, typer.Option("--no-bounds", help="Leave the bounds out.")]


@command
def plot(
    results: Results,
    *,
    output: Picture = None,
    error: Errors = False,
    mesh: Meshes = False,
    no_bounds: NoBounds = False,
    only: Only = "",
    xy: Plane = "",
    force: Force = False,
) -> None:
    """Draw states, controls and costates over time.

    Without time, two static parameters are drawn as a plane.

    With --error, --mesh and --xy what these say is drawn instead. Several results stand in one picture, overlay.png, or
    with -o FOLDER in one each.

    Example: trajopt plot cartpole.h5 --error -o error.pdf

    Without -o the pictures are <name of the result>.png, <name>-error.png and <name>-mesh.png in the current folder. A
    file ending with .pdf holds several pictures, one on a page; .svg is for editing and for the web. A picture that
    trajopt has drawn is replaced, any other file only with --force.
    """
    kinds = [kind for kind, wanted in (("error", error), ("mesh", mesh)) if wanted] or ["trajectory"]
    if xy or (len(results) > 1 and kinds == ["trajectory"] and not (output and Path(output).is_dir())):
        _draw_together(results, output, xy, only, kinds, no_bounds, force)
        return
    targets = targets_of(results, output, [_ending(kind) for kind in kinds])

    from ...results.file.read import read
    from ...results.pictures.style import check_picture, save_figure

    for path in (path for paths in targets for path in paths):
        check_picture(path, PICTURES, force)
    names = _split(only)
    if names and kinds == ["mesh"]:
        raise SpecError(Mistake("--only", "the history of the meshes shows no states", "leave --only out"))
    for result, paths in zip(map(read, results), targets, strict=True):
        figures = [_figure(kind, result, names, no_bounds) for kind in kinds]
        groups = [figures] if len(paths) == 1 else [[figure] for figure in figures]
        for path, group in zip(paths, groups, strict=True):
            save_figure(group, path, result.problem)
            print(path)


def _split(names: str) -> tuple[str, ...]:
    return tuple(filter(None, (name.strip() for name in names.split(","))))


def _draw_together(
    results: Sequence[Path],
    output: str | None,
    xy: str,
    only: str,
    kinds: Sequence[str],
    no_bounds: bool,
    force: bool,
) -> None:
    """One picture of all results: over time, or one quantity against another."""
    pair = _split(xy)
    if xy and len(pair) != 2:
        raise SpecError(Mistake(f"--xy {xy}", "it takes two names", "write --xy x,y: y is drawn against x"))
    others = (["--only"] if only else []) + [f"--{kind}" for kind in kinds if kind != "trajectory"]
    if xy and others:
        what = "two names are drawn against each other, and nothing else"
        raise SpecError(Mistake(f"--xy {xy}", what, f"leave out {' and '.join(others)}"))
    default = "overlay.png" if len(results) > 1 else f"{results[0].stem}-xy.png"
    folder = folder_of(output)
    path = folder / default if folder is not None else Path(str(output))

    from ...results.file.read import read
    from ...results.pictures.overlay import overlay_figure, path_in_plane
    from ...results.pictures.style import check_picture, save_figure

    check_picture(path, PICTURES, force)
    found = list(map(read, results))
    if xy:
        figure = path_in_plane(found, *pair)
    else:
        bounds = [] if no_bounds else list(map(_bounds, found))
        figure = overlay_figure(found, bounds, _split(only), list(map(_broken, found, bounds)))
    save_figure([figure], path, found[0].problem)
    print(path)


def draw_trajectory(path: Path, force: bool) -> Path:
    """The picture of one result in the current folder, for `solve --plot`."""
    from ...results.file.read import read
    from ...results.pictures.style import check_picture, save_figure

    target, result = Path(f"{path.stem}.png"), read(path)
    check_picture(target, PICTURES, force)
    save_figure([_figure("trajectory", result, (), False)], target, result.problem)
    return target


def _ending(kind: str) -> str:
    return ".png" if kind == "trajectory" else f"-{kind}.png"


def _figure(kind: str, result: Result, names: Sequence[str], no_bounds: bool) -> Figure:
    from ...results.pictures.error_plots import error_figure
    from ...results.pictures.mesh_plots import mesh_figure
    from ...results.pictures.plots import trajectory_figure

    if result.static and len(result.phases[0].parameters) == 2:
        from ...results.pictures.plane import plane_figure

        return plane_figure(result)
    if kind == "trajectory":
        bounds = {} if no_bounds else _bounds(result)
        return trajectory_figure(result, bounds, names, _broken(result, bounds))
    return error_figure(result, names) if kind == "error" else mesh_figure(result)


def _bounds(result: Result) -> dict:
    """The bounds of the problem; if the file does not tell them, that is said and the picture is drawn without."""
    from ...results.file.bounds import bounds_of

    try:
        return bounds_of(result.build()[0])
    except FileError as error:
        print(f"warning: {one_line(str(error))}; drawn without bounds", file=sys.stderr)
        return {}


def _broken(result: Result, bounds: dict) -> dict:
    """What a check says does not hold; if a damaged file does not let it be looked at, that is said."""
    from ...results.audit.broken import broken_bounds

    try:
        return broken_bounds(result, bounds) if bounds else {}
    except FileError as error:
        print(f"warning: {one_line(str(error))}; its bounds are looked at in its points only", file=sys.stderr)
        return {}
