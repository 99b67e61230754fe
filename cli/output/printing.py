"""What goes to standard output: tables, fields, titles, JSON."""

from __future__ import annotations

import json
import math
import os
import shutil
import sys
import textwrap
from collections.abc import Mapping, Sequence
from typing import Literal

import typer

from ...problems.text import printable

ENDLESS = 100_000  # letters: the width of what is no terminal
WORDS = 12  # letters that a column of words can do with


def print_table(columns: Sequence[str], rows: Sequence[Sequence[str]], right: Sequence[str] = ()) -> None:
    """A table on standard output; the columns named in `right` hold numbers.

    On a terminal that is wide enough, texts of several words go on below themselves. Elsewhere a row is one line, whole
    and plain, for grep and awk.
    """
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    console = Console(force_terminal=sys.stdout.isatty())
    table, needed = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style=""), 0
    for column, *cells in zip(columns, *rows, strict=True):
        words = any(" " in cell for cell in (column, *cells))
        needed += WORDS if words else 2 + max(map(len, (column, *cells)))
        side: Literal["left", "right"] = "right" if column in right else "left"
        table.add_column(Text.assemble((one_line(column), "bold")), justify=side, no_wrap=not words, overflow="fold")
    for row in rows:
        table.add_row(*(Text(one_line(cell)) for cell in row))
    if not console.is_terminal or needed > console.width:
        console.width = ENDLESS
    with console.capture() as drawn:
        console.print(table)
    print("\n".join(line.rstrip() for line in drawn.get().rstrip("\n").split("\n")))


def cell(value: float | None, form: str) -> str:
    """A number as a table shows it; what has no finite value is left empty."""
    return "" if value is None or not math.isfinite(value) else f"{value:{form}}"


def print_json(row: Mapping) -> None:
    """One object on one line, null for a number that is not finite."""
    from ...results.file.json_values import for_json

    print(json.dumps(for_json(row), allow_nan=False), flush=True)


def print_title(text: str, passed: bool) -> None:
    """A line in bold, green or red, as far as the terminal has these and its user wants them."""
    colour = None if os.environ.get("NO_COLOR") else "green" if passed else "red"
    typer.secho(one_line(text), bold=True, fg=colour, color=False if dumb_terminal() else None)


def dumb_terminal() -> bool:
    """Whether the terminal takes no codes that move the cursor or change colours."""
    return os.environ.get("TERM", "dumb") == "dumb"


def print_field(name: str, text: str) -> None:
    """One line "name  text"; longer than a terminal is wide, it goes on below the text."""
    lines = [one_line(text)]
    if sys.stdout.isatty():
        lines = textwrap.wrap(lines[0], max(_width() - 12, 20), break_long_words=False, break_on_hyphens=False)
    print(f"{name:<12}" + "\n            ".join(lines))


def one_line(text: str) -> str:
    """The text without line breaks or characters that would steer a terminal."""
    return printable(text.strip())


def plural(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}{'es' if noun.endswith('sh') else 's'}"


def _width() -> int:
    return shutil.get_terminal_size().columns
