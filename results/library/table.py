"""The rows as tables: Markdown for the repository, HTML and JSON for a folder, texts for a terminal."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from ..report.page import rendered
from ..reproduction.page import MADE_BY as PAGES
from ..reproduction.page import machine
from .rows import COMPLETE, EXCLUDED, FINE, Row

TITLE = "The library, solved and verified"

FIRST_TRIES = Path(__file__).parent / "first_tries.md"
"""Written by hand: what some problems led to when they were written down."""

MADE_BY = "trajopt reproduce library"
"""Stands in every file that is written, by which it is known again."""

LASTING = ("problem", "tags", "objective", "error bar", "reference", "digits", "published digits", "bar holds",
           "segments", "points", "meshes", "iterations", "verify", "source of the reference")  # fmt: skip
"""Columns of what does not vary from run to run."""

COLUMNS = (*LASTING[:-2], "seconds", "verify", "seconds of verify", LASTING[-1])
NUMBERS = ("objective", "error bar", "reference", "digits", "segments", "points", "meshes", "iterations", "seconds",
           "seconds of verify")  # fmt: skip
"""Those columns that hold numbers."""

WORDS = {True: "yes", False: "NO", None: ""}

INTRODUCTION = """\
Every shipped problem, as its file says, and verified by `trajopt verify`.

- **error bar**: |J - J*| is at most that, as the solve claims; none for methods that give none.
- **digits**: in which objective and reference agree, no more than the reference has, and at most 8, as the solver's
  tolerance is 1e-8. Where the reference is zero: digits behind the point.
- **published digits**: whether all digits of the reference agree, as its file gives them and at most 10. Where the
  default has fewer, a finer solve tells: it has them all; or its error bar excludes the reference, which is off by its
  mesh or its rounding; or it is short of digits, too.
- **bar holds**: the difference is within the error bar and the tolerance that the file gives its reference.
- **segments**, **points**: of the last mesh, all phases together; **iterations**: over all meshes.

docs/reproduce.md says how this page is made.
"""


def cells(row: Row) -> dict[str, str]:
    """Column -> what it says of a row."""
    solved = row.verdict if row.solved else f"NOT SOLVED: {row.message}"
    return {
        "problem": row.name,
        "tags": ", ".join(row.tags),
        "objective": _number(row.objective, ".10g"),
        "error bar": _number(row.bar, ".1e"),
        "reference": _number(row.reference, ".10g"),
        "digits": _number(row.digits, ".1f"),
        "published digits": row.standing + (f": {row.finer.told}" if row.finer else ""),
        "bar holds": WORDS[row.holds],
        "segments": str(row.segments),
        "points": str(row.points),
        "meshes": str(row.meshes),
        "iterations": str(row.iterations),
        "seconds": f"{row.seconds:.2f}",
        "verify": solved,
        "seconds of verify": f"{row.verify_seconds:.2f}",
        "source of the reference": row.source,
    }


def _number(value: float | None, form: str) -> str:
    return "" if value is None else f"{value:{form}}"


def verdict(rows: Sequence[Row]) -> str:
    """What all rows together say, in one sentence."""
    counts = {
        "solved": sum(row.solved for row in rows),
        "verified": sum(bool(row.checks) and not row.failed for row in rows),
    }
    bars = [row.holds for row in rows if row.holds is not None]
    told = ", ".join(f"{count} {word}" for word, count in counts.items())
    standing = Counter(row.standing for row in rows if row.standing)
    settled = standing[COMPLETE] + standing[FINE] + standing[EXCLUDED]
    digits = f"all published digits in {settled} of {sum(standing.values())}"
    how = f"{standing[COMPLETE]} by default, {standing[FINE]} by a finer solve, {standing[EXCLUDED]} where they are off"
    return f"{len(rows)} problems: {told}, the error bar holds in {sum(bars)} of {len(bars)}; {digits} ({how})"


def markdown(rows: Sequence[Row]) -> str:
    """The page of the repository: nothing in it varies from run to run."""
    head = f"<!-- made by {MADE_BY} -->\n\n# {TITLE}\n\n{INTRODUCTION}\n{verdict(rows)}.\n"
    sides = ["---:" if name in NUMBERS else "---" for name in LASTING]
    lines = [LASTING, sides, *([cells(row)[name].replace("|", "\\|") for name in LASTING] for row in rows)]
    failed = "".join(f"- `{row.name}` fails in `verify`: {'; '.join(row.failed)}\n" for row in rows if row.failed)
    table = "".join(f"| {' | '.join(line)} |\n" for line in lines) + (f"\n{failed}" if failed else "")
    return f"{head}\n{table}\n{FIRST_TRIES.read_text('utf-8')}"


def library_html(rows: Sequence[Row], regressions: Sequence[str] | None = None) -> str:
    """A page that needs nothing else; one that says so as long as there are no rows.

    rows: of the table.
    regressions: what got worse, in words; None where nobody compared.
    """
    return rendered(
        "library.html",
        title=TITLE,
        made_by=PAGES,
        rows=[{"cells": cells(row), "bad": _bad(row)} for row in rows],
        columns=COLUMNS,
        numbers=NUMBERS,
        verdict=verdict(rows),
        date=f"{datetime.now(UTC):%Y-%m-%d}",
        machine=machine(),
        regressions=regressions,
        failures=[f"{row.name}: {'; '.join(row.failed)}" for row in rows if row.failed],
    )


def _bad(row: Row) -> list[str]:
    """The columns in which a row is not as it should be."""
    good = {"bar holds": row.holds is not False, "verify": row.solved and not row.failed}
    return [name for name, fine in good.items() if not fine]


def as_json(rows: Sequence[Row], regressions: Sequence[str] | None = None) -> str:
    """One object with all rows, times too.

    rows: of the table.
    regressions: what got worse, in words; None where nobody compared.
    """
    told = [row.told for row in rows]
    whole = {"made_by": MADE_BY, "machine": machine(), "regressions": regressions, "problems": told}
    return json.dumps(whole, indent=1, allow_nan=False) + "\n"
