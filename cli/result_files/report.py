"""`trajopt report`: a result, or the folder of a sweep, as one page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ...problems.files import write_whole
from ..errors import command
from ..options import Force, Quiet
from ..output.progress import live_text
from .targets import targets_of

Sources = Annotated[
    list[Path],
    typer.Argument(metavar="RESULT|FOLDER...", help="Result files, or folders of 'trajopt sweep'.", show_default=False),
]
Output = Annotated[str | None, typer.Option("-o", "--output", metavar="FILE", help="Name of the page, or a folder.")]
NoVerify = Annotated[bool, typer.Option("--no-verify", help="Leave the checks of 'trajopt verify' out.")]


@command
def report(
    sources: Sources,
    *,
    output: Output = None,
    no_verify: NoVerify = False,
    force: Force = False,
    quiet: Quiet = False,
) -> None:
    """Write one page of HTML that tells all of a result, or of a sweep.

    It needs no network and nothing beside it: the problem in equations, curves to zoom and to read values off, meshes,
    errors and where the error bar comes from, how the solver got there, the checks of 'trajopt verify', and how to
    reproduce it. Of a sweep: a table of all cases to sort and to filter, and what became of them over the swept values.

    Example: trajopt report cartpole.h5 -o cartpole.html

    Without -o the page is <name of the result or folder>.html in the current folder. A page that trajopt has written is
    replaced, any other file only with --force.
    """
    targets = [path for (path,) in targets_of(list(map(_named, sources)), output, [".html"])]

    from ...results.report.page import check_page

    for path in targets:
        check_page(path, force)
    for source, path in zip(sources, targets, strict=True):
        with live_text(f"reporting {source}", not quiet):
            text = _sweep(source) if source.is_dir() else _result(source, not no_verify)
        write_whole(path, text)
        if not quiet:
            print(path)


def _named(source: Path) -> Path:
    """What the page is called after: a result, or a folder, whose whole name counts."""
    return Path(f"{source.resolve().name}.h5") if source.is_dir() else source


def _result(path: Path, verified: bool) -> str:
    """The page of a result file."""
    from ...results.file.summary import summarize
    from ...results.report.result import result_page
    from ..output.table import table_rows

    facts = list(table_rows(summarize(path)))
    if not verified:
        return result_page(path, facts, None)
    from ...results.verify import verify

    return result_page(path, facts, verify(path))


def _sweep(folder: Path) -> str:
    from ...results.report.sweep import sweep_page

    return sweep_page(folder)
