"""The folder of one run over the library.

index.html       the table of this run, with seconds
library.json     the same for programs
library.md       docs/library.md, and
baseline.json    the baseline, both with the rows of this run in place of their own
results/         the result file of every solve
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ...problems.errors import FileError, Mistake
from ..reproduction.folder import INDEX, RESULTS, claim, write_text
from .baseline import FILE, baseline, baseline_text, renewed
from .rows import Row
from .table import MADE_BY, as_json, library_html, markdown

PAGE, TABLE = "library.md", "library.json"


def prepare_page(folder: Path) -> Path:
    """Make the folder, or make sure that it and what will be replaced in it is ours; gives where results go.

    Raises FileError.
    """
    claim(folder, (RESULTS,))
    for path in (folder / name for name in (PAGE, TABLE, FILE)):
        if path.exists() and not (path.is_file() and MADE_BY in path.read_text(encoding="utf-8", errors="replace")):
            what = f"it exists and was not made by '{MADE_BY}'"
            raise FileError(Mistake(str(path), what, "move it, or choose another folder with -o"))
    write_text(folder / INDEX, library_html([]))
    return folder / RESULTS


def report_library(folder: Path, rows: Sequence[Row], regressions: Sequence[str] | None) -> None:
    """Write all tables.

    folder: that was prepared.
    rows: of this run.
    regressions: what got worse, in words; None where nobody compared.

    Raises FileError.
    """
    whole = renewed(rows, baseline())
    write_text(folder / PAGE, markdown(whole))
    write_text(folder / FILE, baseline_text(whole))
    write_text(folder / TABLE, as_json(rows, regressions))
    write_text(folder / INDEX, library_html(rows, regressions))
