"""A CSV file of columns beside a problem: a line of names, then lines of numbers. It is foreign data."""

from __future__ import annotations

import csv
from collections.abc import Container, Mapping, Sequence
from math import isfinite, nan
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..files import reason_of
from ..text import brief
from .choices import MAX_VALUES

MAX_BYTES = 10_000_000
MAX_TOLD = 10  # mistakes of one file

_opened = [0]
"""CSV files so far, of this process."""

Rows = list[tuple[int, list[str]]]
"""The line and the cells of each row that is neither empty nor a comment."""


class ColumnTrouble(NamedTuple):
    """A mistake in a file: what is wrong, and how to mend it."""

    what: str
    remedy: str


class ColumnsError(ValueError):
    """A file holds not what it should; `troubles` are all the mistakes that were found."""

    def __init__(self, troubles: Sequence[ColumnTrouble]):
        self.troubles = tuple(troubles)
        super().__init__("\n".join(f"{trouble.what}; {trouble.remedy}" for trouble in troubles))


def refuse(what: str, remedy: str) -> ColumnsError:
    return ColumnsError([ColumnTrouble(what, remedy)])


def read_rows(folder: Path, file: str) -> Rows:
    """The lines of a CSV file, the names of its columns first, each name once.

    folder: that of the problem file.
    file: the path in it.

    Raises ColumnsError with the mistake.
    """
    rows = _rows(_text(_inside(folder, file), file), file)
    header = rows[0][1]
    if len(header) == 1 and any(mark in header[0] for mark in ";\t"):
        raise refuse(f"{brief(file)} has one column, {brief(header[0])}", "write commas between the columns")
    if twice := next((name for i, name in enumerate(header) if name in header[:i]), None):
        raise refuse(f"{brief(file)} has two columns {brief(twice)}", "give each column its own name")
    return rows


def column_numbers(rows: Rows, columns: Mapping[str, int], file: str, gaps: Container[str] = ()) -> np.ndarray:
    """The numbers in columns, shape (rows, columns).

    rows: of `read_rows`.
    columns: name of each -> its place in a line.
    file: for messages.
    gaps: names of columns whose cells may be empty; an empty one becomes not-a-number.

    Raises ColumnsError with every mistake.
    """
    if len(rows) - 1 > MAX_VALUES // len(columns):
        what = f"{brief(file)} has {len(rows) - 1} lines of numbers"
        raise refuse(what, f"write at most {MAX_VALUES // len(columns)}; leave out what the curve does not need")
    width, troubles = len(rows[0][1]), []
    numbers = np.full((len(rows) - 1, len(columns)), nan)
    for i, (line, cells) in enumerate(rows[1:]):
        if len(cells) != width:
            what = f"{brief(file)}, line {line}: there are {len(cells)} cells for {width} columns"
            troubles.append(ColumnTrouble(what, "write a number for each column, with a point for decimals"))
            continue
        for j, (name, k) in enumerate(columns.items()):
            if not cells[k] and name in gaps:
                continue
            number = number_of(cells[k])
            if number is None:
                shown = f'"{brief(cells[k])}" is no finite number' if cells[k] else "the cell is empty"
                what = f"{brief(file)}, line {line}, column {brief(name)}: {shown}"
                troubles.append(ColumnTrouble(what, "write a number such as 0.5 or 1e4"))
            else:
                numbers[i, j] = number
    if troubles:
        more = [ColumnTrouble(f"{brief(file)} has more mistakes like these", "mend these first")] * (
            len(troubles) > MAX_TOLD
        )
        raise ColumnsError([*troubles[:MAX_TOLD], *more])
    return numbers


def _inside(folder: Path, file: str) -> Path:
    """The file itself, if it is one and lies in the folder."""
    plain = Path(file)
    if plain.is_absolute() or ".." in plain.parts:
        what = f"the file {brief(file)} is not in the folder of the problem file"
        raise refuse(what, "put it there, or in a folder in it, and write its path from there")
    try:
        path = (folder / plain).resolve()
        inside, exists, ordinary = path.is_relative_to(folder.resolve()), path.exists(), path.is_file()
    except (OSError, RuntimeError, ValueError):  # a circle of links, a name that no file can have
        raise refuse(f"{brief(file)} cannot be the name of a file", "write the path of a CSV file") from None
    if not inside:
        what = f"{brief(file)} is a link that leads out of the folder of the problem file"
        raise refuse(what, "put the file itself there")
    if not exists:
        raise refuse(f"there is no file {brief(file)}", f"check the name: it is looked for in {folder or '.'}")
    if not ordinary:
        raise refuse(f"{brief(file)} is no ordinary file", "give a CSV file")
    return path


def opened_table() -> int:
    """CSV files that this process has opened: whoever keeps what was read asks whether the problem file was all."""
    return _opened[0]


def _text(path: Path, file: str) -> str:
    _opened[0] += 1
    try:
        with path.open("rb") as stream:
            content = stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise refuse(f"{brief(file)} cannot be read ({reason_of(error)})", "check its permissions") from error
    if len(content) > MAX_BYTES:
        what = f"{brief(file)} is larger than {MAX_BYTES // 1_000_000} MB"
        raise refuse(what, "leave out points that the curve does not need")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise refuse(f"{brief(file)}, line {line}: this is not UTF-8", "save the file as UTF-8 text") from error


def _rows(text: str, file: str) -> Rows:
    reader = csv.reader(text.splitlines(keepends=True), skipinitialspace=True)
    rows: Rows = []
    try:
        for row in reader:
            cells = [cell.strip() for cell in row]
            if any(cells) and not cells[0].startswith("#"):
                rows.append((reader.line_num, cells))
    except csv.Error as error:
        what = f"{brief(file)}, line {reader.line_num}: this cannot be read as CSV ({error})"
        raise refuse(what, "write numbers with commas between them") from error
    if len(rows) < 2:
        what = f"{brief(file)} has {'no lines' if not rows else 'no line of numbers'}"
        raise refuse(what, "write the names of the columns on its first line, and numbers below")
    return rows


def number_of(cell: str) -> float | None:
    """The number in a cell; None for what is no finite one."""
    try:
        number = float(cell) if "_" not in cell else float("nan")
    except ValueError:
        return None
    return number if isfinite(number) else None
