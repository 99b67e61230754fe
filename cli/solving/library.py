"""`trajopt reproduce library`: all shipped problems, solved and verified, in one table."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from ...problems.errors import Mistake, SpecError
from ..errors import NOT_SOLVED
from ..output.printing import plural, print_json, print_table, print_title
from ..output.progress import live_text
from ..streams import native_output
from .cases import processes_of
from .workers import prepare_workers as prepare_worker

if TYPE_CHECKING:
    from ...results.library.rows import Row


def reproduce_library(
    others: Sequence[str],
    folder: Path,
    only: Sequence[str],
    fast: bool,
    jobs: str | None,
    check: bool,
    json_: bool,
    quiet: bool,
) -> None:
    """Solve, verify, write and print.

    others: examples that were named beside it, a mistake.
    folder: for all that is made.
    only: names of problems, all of them if there are none.
    fast: without the slow problems.
    jobs: number of processes as typed, None for one for each CPU.
    check: whether the rows are compared with the baseline.
    json_: whether JSON is printed.
    quiet: whether neither progress nor the table is printed.

    Raises SpecError, FileError; ends with exit code 1 if something got worse, without `check` if something failed.
    """
    if others:
        raise SpecError(Mistake(" ".join(others), "library stands alone", "reproduce the examples in another command"))
    from ...results.library.baseline import baseline, regressions
    from ...results.library.report import prepare_page, report_library
    from ...results.library.solve import problems, solve_library

    names = problems(only, fast)
    processes = processes_of(jobs)
    results = prepare_page(folder)
    with native_output(2), live_text("solving", not quiet) as show:
        rows = solve_library(
            names, results, processes=processes, prepare=prepare_worker,
            command=shlex.join(["trajopt", *sys.argv[1:]]), progress=show,
        )  # fmt: skip
    worse = regressions(baseline(), rows) if check else None
    report_library(folder, rows, worse)
    if json_:
        passed = all(row.passed for row in rows)
        told = [row.told for row in rows]
        print_json({"folder": str(folder), "passed": passed, "regressions": worse, "problems": told})
    elif not quiet:
        _print(rows, worse)
        print(folder / "index.html")
    if worse or (worse is None and not all(row.passed for row in rows)):
        raise typer.Exit(NOT_SOLVED)


def _print(rows: Sequence[Row], worse: Sequence[str] | None) -> None:
    from ...results.library.table import COLUMNS, NUMBERS, cells, verdict

    hidden = ("tags", "source of the reference")
    head = [name for name in COLUMNS if name not in hidden]
    print_table(head, [[told[name] for name in head] for told in map(cells, rows)], right=NUMBERS)
    print()
    for row in rows:
        for name in row.failed:
            print(f"FAIL  {row.name}: {name}")
    for line in worse or ():
        print(f"WORSE {line}")
    print_title(verdict(rows), all(row.passed for row in rows))
    if worse is not None:
        print_title(f"compared with the baseline: {plural(len(worse), 'regression')}", not worse)
