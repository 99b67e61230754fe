"""The whole of the paper, and the pendulum of the introduction, solved, drawn and checked into one folder.

index.html     all figures with their captions, and all checks
figures/       the figures, each as .png and .pdf
results/       the result file of every solve
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from PIL import Image
from PIL.PngImagePlugin import PngInfo

from ...problems.build import build_all
from ...problems.catalog import find_problem
from ...problems.errors import Mistake, SpecError
from ...problems.files import replacing
from ...problems.load import load
from ...problems.text import did_you_mean
from ...transcription.continuation import solve_spec
from ..file.read import read
from ..file.summary import summarize
from ..file.write import check_target, write
from ..pictures.style import check_picture, look, save_figure
from . import LIBRARY, page
from .chapter import Chapter, MeasuredEffort, PaperCheck
from .figures import biped, block, cartpole, min_work, pendulum, points, refinement, splines
from .figures.example import Example, Picture, Run, Solutions, SolvedRun
from .folder import FIGURES, INDEX, RESULTS, claim, write_text
from .paper_values import EFFORTS, VALUES

EXAMPLES: dict[str, Example] = {
    module.EXAMPLE.name: module.EXAMPLE
    for module in (block, splines, refinement, cartpole, biped, min_work, points, pendulum)
}
FORMATS = (".png", ".pdf")
COLOURS = 256  # of a .png


def examples(names: Sequence[str]) -> list[Example]:
    """The examples of these names, all of them if there are none. Raises SpecError for an unknown name."""
    mistakes = []
    for name in (name for name in names if name not in EXAMPLES):
        known = (*EXAMPLES, LIBRARY)
        remedy = did_you_mean(name, known, always=f"the examples are {', '.join(known)}")
        mistakes.append(Mistake(name, "there is no such example", remedy))
    if mistakes:
        raise SpecError(mistakes)
    return [EXAMPLES[name] for name in dict.fromkeys(names)] or list(EXAMPLES.values())


def reproduce(
    names: Sequence[str],
    folder: Path,
    *,
    every: bool = False,
    figures: bool = True,
    command: str = "",
    progress: Callable[[str], None] = lambda text: None,
) -> list[Chapter]:
    """Solve, draw and check examples; results, figures and page go to a folder.

    names: of the examples, all of them if none is named.
    folder: made if it is not there; else empty, or filled by an earlier call.
    every: also the solves that no figure shows, so that every number is checked.
    figures: whether figures are drawn.
    command: what the user typed, for the result files.
    progress: called with a text before each piece of work.

    Raises SpecError for an unknown example, FileError if the folder holds something else or a file cannot be written.
    """
    chosen = examples(names)
    prepare(folder, chosen, figures)
    chapters = []
    for example in chosen:
        solved, unsolved = _solve(example, folder / RESULTS, every, command, progress)
        chapters.append(_chapter(example, solved, unsolved, every))
        if figures and not unsolved:
            _draw(example, solved, folder, progress)
    write_text(folder / INDEX, page.html(chapters, _sizes(folder, chapters) if figures else None))
    return chapters


def prepare(folder: Path, chosen: Sequence[Example], figures: bool) -> None:
    """Make the folder, or make sure that it is one of ours and that nothing foreign in it would be replaced.

    folder: for all that comes out.
    chosen: the examples whose pictures will be written.
    figures: whether there will be pictures.

    Raises FileError.
    """
    claim(folder, (RESULTS, FIGURES) if figures else (RESULTS,))
    for picture in (picture for example in chosen for picture in example.pictures if figures):
        for suffix in FORMATS:
            check_picture(_picture_path(folder, picture, suffix), FORMATS)
    write_text(folder / INDEX, page.html([], None))


# -- solving --------------------------------------------------------------------------------------------------------


def _solve(
    example: Example, folder: Path, every: bool, command: str, progress: Callable[[str], None]
) -> tuple[Solutions, dict[str, str]]:
    """The results of the runs of an example, and how those ended that were not solved."""
    solved, unsolved = {}, {}
    for name, run in example.runs.items():
        if run.shown or every:
            progress(f"solving {name}")
            solved[name] = _run(run, folder / f"{name}.h5", command)
            if not solved[name].result.solved:
                unsolved[name] = solved[name].result.message
    return solved, unsolved


def _run(run: Run, path: Path, command: str) -> SolvedRun:
    spec = load(find_problem(run.problem), run.overrides)
    check_target(path, spec.name)
    solution = solve_spec(spec, build_all(spec))
    write(path, solution, spec.text, spec.model_dump_json(), command)
    meshes = summarize(path)["meshes"]
    seconds = tuple(sum(mesh["seconds"].values()) for mesh in meshes)
    return SolvedRun(read(path), tuple(mesh["iterations"] for mesh in meshes), seconds)


# -- checking -------------------------------------------------------------------------------------------------------


def _chapter(example: Example, solved: Solutions, unsolved: Mapping[str, str], every: bool) -> Chapter:
    """The numbers of an example; without `every` only those of the runs that there are."""
    numbers = {name: float(number) for name, number in example.measure(solved).items()}
    checks = tuple(
        PaperCheck(example.name, value, numbers[value.name])
        for value in VALUES[example.name]
        if every or value.name in numbers
    )
    efforts = tuple(_efforts(example, solved))
    words = {name: run.effort for name, run in solved.items()}
    captions = {picture.file: picture.caption.format_map(words) for picture in example.pictures}
    return Chapter(example, captions, checks, efforts, example.table(solved) if every else (), unsolved)


def _efforts(example: Example, solved: Solutions) -> Iterator[MeasuredEffort]:
    for paper in EFFORTS:
        if paper.example == example.name:
            run = solved[paper.run]
            yield MeasuredEffort(paper, run.iterations[paper.mesh], run.seconds[paper.mesh])


# -- drawing --------------------------------------------------------------------------------------------------------


def _draw(example: Example, solved: Solutions, folder: Path, progress: Callable[[str], None]) -> None:
    for picture in example.pictures:
        progress(f"drawing {picture.file}")
        with look():
            figure = picture.draw(solved)
        for suffix in FORMATS:
            save_figure([figure], _picture_path(folder, picture, suffix), picture.title)
        _shrink(_picture_path(folder, picture, ".png"))


def _shrink(path: Path) -> None:
    """The picture in 256 colours, which are enough for curves: a third of the bytes."""
    with Image.open(path) as image:
        told = PngInfo()
        for key, text in image.text.items():  # type: ignore[attr-defined]  # of a PNG
            told.add_text(key, text)
        small = image.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE)
        resolution = image.info["dpi"]
    with replacing(path) as temporary:
        small.save(temporary, "PNG", pnginfo=told, dpi=resolution, optimize=True)


def _picture_path(folder: Path, picture: Picture, suffix: str) -> Path:
    return folder / FIGURES / f"{picture.file}{suffix}"


def _sizes(folder: Path, chapters: Sequence[Chapter]) -> dict[str, tuple[int, int]]:
    """The width and the height of each picture, in pixels."""
    drawn = (picture for chapter in chapters if not chapter.unsolved for picture in chapter.example.pictures)
    sizes = {}
    for picture in drawn:
        with Image.open(_picture_path(folder, picture, ".png")) as image:
            sizes[picture.file] = image.size
    return sizes
