"""`trajopt reproduce`: the paper, whole, or the library of shipped problems."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ...problems.errors import Mistake, SpecError
from ...results.reproduction import LIBRARY
from ..errors import NOT_SOLVED, command
from ..options import Json, Quiet
from ..output.printing import one_line, plural, print_json, print_table, print_title
from ..output.progress import live_text
from ..streams import native_output
from .library import reproduce_library

if TYPE_CHECKING:
    from ...results.reproduction.chapter import Chapter

NAMES = (
    "Examples: block, splines, refinement, cartpole, biped, min_work, points, pendulum. Without any, all of them. "
    "Or library: all shipped problems."
)


@command
def reproduce(
    examples: Annotated[list[str] | None, typer.Argument(metavar="EXAMPLE...", help=NAMES, show_default=False)] = None,
    *,
    output: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", metavar="DIR", help="Folder for all that is made; default ./reproduction or ./library."
        ),
    ] = None,
    check: Annotated[
        bool,
        typer.Option(
            "--check",
            help="Check every number, also of meshes and methods that no figure shows. Of the library: that nothing "
            "is worse than in the kept baseline.",
        ),
    ] = False,
    no_figures: Annotated[bool, typer.Option("--no-figures", help="Solve and check only, draw nothing.")] = False,
    only: Annotated[
        list[str] | None,
        typer.Option("--only", metavar="NAME", help="Of the library: only this problem; given again, these."),
    ] = None,
    fast: Annotated[bool, typer.Option("--fast", help="Of the library: without the problems that take long.")] = False,
    jobs: Annotated[
        str | None,
        typer.Option("--jobs", "-j", metavar="N", help="Of the library: processes; default one for each CPU."),
    ] = None,
    json_: Json = False,
    quiet: Quiet = False,
) -> None:
    """Reproduce the figures and numbers of the paper, or the library.

    Example: trajopt reproduce cartpole biped -o figures_of_the_paper

    Example: trajopt reproduce library --fast --check

    DIR/index.html shows the figures and the checks, DIR/figures has each figure as .png and .pdf, DIR/results the
    result files. DIR must be new, empty, or made by this command. The numbers of all that the figures show are always
    checked; --check adds those of other meshes and methods, and figures are drawn with it too. Exit code 1 if a number
    is off or a problem was not solved.

    With library, DIR/index.html and DIR/library.json are a table of all shipped problems, solved and verified: the
    objective with its error bar beside the published one. Exit code 1 if one is not solved or verified, or if its error
    bar does not hold; with --check instead if one is worse than in the baseline: a digit, another optimum, a fifth more
    iterations.
    """
    if LIBRARY in (examples or ()):
        others = [name for name in examples or () if name != LIBRARY]
        reproduce_library(others, output or Path(LIBRARY), only or (), fast, jobs, check, json_, quiet)
        return
    if unused := [name for name, value in (("--only", only), ("--fast", fast), ("--jobs", jobs)) if value]:
        raise SpecError(
            Mistake(name, "it is of the library only", "leave it out, or write: trajopt reproduce library")
            for name in unused
        )
    output = output or Path("reproduction")
    from ...results.reproduction.folder import INDEX
    from ...results.reproduction.reproduce import reproduce as run

    with native_output(2), live_text("reproducing", not quiet) as show:
        chapters = run(
            examples or (), output, every=check, figures=not no_figures, progress=show,
            command=shlex.join(["trajopt", *sys.argv[1:]]),
        )  # fmt: skip
    if json_:
        print_json(_summary(chapters, output))
    elif not quiet:
        _print(chapters)
        print(output / INDEX)
    if not all(chapter.passed for chapter in chapters):
        raise typer.Exit(NOT_SOLVED)


def _print(chapters: Sequence[Chapter]) -> None:
    from ...results.reproduction.page import shown_number

    for chapter in filter(lambda chapter: chapter.table, chapters):
        head, *rows = chapter.table
        print_table(head, rows, right=head)
        print()
    if efforts := [effort for chapter in chapters for effort in chapter.efforts]:
        head = ("", "paper: iterations", "seconds", "here: iterations", "seconds ")
        print_table(head, [effort.row for effort in efforts], right=head[1:])
        print()
    checks = [check for chapter in chapters for check in chapter.checks]
    rows = [
        (
            "pass" if c.passed else "FAIL",
            c.example,
            c.value.name,
            c.value.expected,
            shown_number(c.number),
            c.value.source,
        )
        for c in checks
    ]
    print_table(("", "example", "check", "expected", "got", "source"), rows, right=("got",))
    unsolved = [(run, message) for chapter in chapters for run, message in chapter.unsolved.items()]
    for run, message in unsolved:
        print(f"FAIL  {run} was not solved: {one_line(message)}")
    failed = sum(not check.passed for check in checks) + len(unsolved)
    verdict = f"{plural(failed, 'failure')}" if failed else "all pass"
    print()
    print_title(f"{plural(len(checks), 'check')}: {verdict}", not failed)


def _summary(chapters: Sequence[Chapter], folder: Path) -> dict:
    return {
        "folder": str(folder),
        "passed": all(chapter.passed for chapter in chapters),
        "unsolved": {run: message for chapter in chapters for run, message in chapter.unsolved.items()},
        "checks": [
            {"example": c.example, "check": c.value.name, "expected": c.value.expected, "got": c.number,
             "passed": c.passed, "source": c.value.source}
            for chapter in chapters for c in chapter.checks
        ],
        "efforts": [
            {"what": e.paper.what, "paper": {"iterations": e.paper.iterations, "seconds": e.paper.seconds},
             "here": {"iterations": e.iterations, "seconds": e.seconds}}
            for chapter in chapters for e in chapter.efforts
        ],
    }  # fmt: skip
