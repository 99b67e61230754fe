"""A table of data in a CSV file: a line of names, then one line for each point of a full grid, in any order."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping, Sequence
from math import isfinite, prod
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..text import brief, did_you_mean
from .choices import MAX_ARGUMENTS, MAX_VALUES

MAX_BYTES = 10_000_000
MAX_TOLD = 10  # mistakes of one file

Cells = list[tuple[int, list[str]]]
"""The line and the cells of each row that is neither empty nor a comment."""


class Trouble(NamedTuple):
    """A mistake in a file: what is wrong, and how to mend it."""

    what: str
    remedy: str


class TableFileError(ValueError):
    """A file holds no table; `troubles` are all the mistakes that were found."""

    def __init__(self, troubles: Sequence[Trouble]):
        self.troubles = tuple(troubles)
        super().__init__("\n".join(f"{trouble.what}; {trouble.remedy}" for trouble in troubles))


class Grid(NamedTuple):
    """points: name of each argument -> its points, increasing. values: nested lists, one index for each argument."""

    points: Mapping[str, list[float]]
    values: list[Any]


def read_table(folder: Path, file: str, arguments: Sequence[str] | None, value: str | None) -> Grid:
    """The table in a CSV file.

    folder: that of the problem file.
    file: the path in it.
    arguments: the columns that are arguments; None for those before the last, or all but that of the value.
    value: the column of the values; None for the last, or the only one that is no argument.

    Raises TableFileError with every mistake.
    """
    rows = _cells(_text(_inside(folder, file), file), file)
    columns = _columns(rows[0][1], arguments, value, file)
    numbers, lines = _numbers(rows, columns, file)
    return _grid(list(columns)[:-1], numbers, lines, file)


def _refuse(what: str, remedy: str) -> TableFileError:
    return TableFileError([Trouble(what, remedy)])


def _inside(folder: Path, file: str) -> Path:
    """The file itself, if it is one and lies in the folder."""
    plain = Path(file)
    if plain.is_absolute() or ".." in plain.parts:
        what = f"the file {brief(file)} is not in the folder of the problem file"
        raise _refuse(what, "put it there, or in a folder in it, and write its path from there")
    try:
        path = (folder / plain).resolve()
        inside, exists, ordinary = path.is_relative_to(folder.resolve()), path.exists(), path.is_file()
    except (OSError, RuntimeError, ValueError):  # a circle of links, a name that no file can have
        raise _refuse(f"{brief(file)} cannot be the name of a file", "write the path of a CSV file") from None
    if not inside:
        what = f"{brief(file)} is a link that leads out of the folder of the problem file"
        raise _refuse(what, "put the file itself there")
    if not exists:
        raise _refuse(f"there is no file {brief(file)}", f"check the name: it is looked for in {folder or '.'}")
    if not ordinary:
        raise _refuse(f"{brief(file)} is no ordinary file", "give a CSV file")
    return path


def _text(path: Path, file: str) -> str:
    try:
        with path.open("rb") as stream:
            content = stream.read(MAX_BYTES + 1)
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise _refuse(f"{brief(file)} cannot be read ({reason})", "check its permissions") from error
    if len(content) > MAX_BYTES:
        what = f"{brief(file)} is larger than {MAX_BYTES // 1_000_000} MB"
        raise _refuse(what, "leave out points that the curve does not need")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise _refuse(f"{brief(file)}, line {line}: this is not UTF-8", "save the file as UTF-8 text") from error


def _cells(text: str, file: str) -> Cells:
    reader = csv.reader(text.splitlines(keepends=True), skipinitialspace=True)
    rows: Cells = []
    try:
        for row in reader:
            cells = [cell.strip() for cell in row]
            if any(cells) and not cells[0].startswith("#"):
                rows.append((reader.line_num, cells))
    except csv.Error as error:
        what = f"{brief(file)}, line {reader.line_num}: this cannot be read as CSV ({error})"
        raise _refuse(what, "write numbers with commas between them") from error
    if len(rows) < 2:
        what = f"{brief(file)} has {'no lines' if not rows else 'no line of numbers'}"
        raise _refuse(what, "write the names of the columns on its first line, and numbers below")
    return rows


def _columns(
    header: list[str], arguments: Sequence[str] | None, value: str | None, file: str
) -> dict[str, int]:  # fmt: skip
    """Name -> index of the columns of the arguments, and of the values as the last."""
    if len(header) == 1 and any(mark in header[0] for mark in ";\t"):
        raise _refuse(f"{brief(file)} has one column, {brief(header[0])}", "write commas between the columns")
    if twice := next((name for i, name in enumerate(header) if name in header[:i]), None):
        raise _refuse(f"{brief(file)} has two columns {brief(twice)}", "give each column its own name")
    missing = [name for name in (*(arguments or ()), *([value] if value else ())) if name not in header]
    if missing:
        remedy = f"its columns are {', '.join(map(brief, header))}"
        raise TableFileError(
            [
                Trouble(f"{brief(file)} has no column {brief(name)}", did_you_mean(name, header, remedy))
                for name in missing
            ]
        )
    if arguments is None:
        arguments = [name for name in header if name != (value or header[-1])]
    others = [name for name in header if name not in arguments]
    if value is None and len(others) != 1:
        listed = f"its columns are {', '.join(map(brief, header))}"
        raise _refuse(
            f"which column of {brief(file)} holds the values is not clear", f"add value: with its name; {listed}"
        )
    value = value or others[0]
    if not 1 <= len(arguments) <= MAX_ARGUMENTS or value in arguments or len(set(arguments)) < len(arguments):
        what = f"the arguments of {brief(file)} are {', '.join(map(brief, arguments)) or 'none'}"
        raise _refuse(what, "name one to three columns under arguments:, each once, and another under value:")
    return {name: header.index(name) for name in (*arguments, value)}


def _numbers(rows: Cells, columns: dict[str, int], file: str) -> tuple[np.ndarray, list[int]]:
    """The numbers (rows, columns), those of the values last, and the line of each row."""
    if len(rows) - 1 > MAX_VALUES:
        what = f"{brief(file)} has {len(rows) - 1} lines of numbers"
        raise _refuse(what, f"write at most {MAX_VALUES}; leave out points that the curve does not need")
    width, troubles = len(rows[0][1]), []
    numbers = np.zeros((len(rows) - 1, len(columns)))
    for i, (line, cells) in enumerate(rows[1:]):
        if len(cells) != width:
            what = f"{brief(file)}, line {line}: there are {len(cells)} cells for {width} columns"
            troubles.append(Trouble(what, "write a number for each column, with a point for decimals"))
            continue
        for j, (name, k) in enumerate(columns.items()):
            number = _number(cells[k])
            if number is None:
                shown = f'"{brief(cells[k])}" is no finite number' if cells[k] else "the cell is empty"
                what = f"{brief(file)}, line {line}, column {brief(name)}: {shown}"
                troubles.append(Trouble(what, "write a number such as 0.5 or 1e4"))
            else:
                numbers[i, j] = number
    if troubles:
        more = [Trouble(f"{brief(file)} has more mistakes like these", "mend these first")] * (len(troubles) > MAX_TOLD)
        raise TableFileError([*troubles[:MAX_TOLD], *more])
    return numbers, [line for line, _ in rows[1:]]


def _number(cell: str) -> float | None:
    try:
        number = float(cell) if "_" not in cell else float("nan")
    except ValueError:
        return None
    return number if isfinite(number) else None


def _grid(names: list[str], numbers: np.ndarray, lines: list[int], file: str) -> Grid:
    """The values in the order of the points, each of which must be there once."""
    found = [np.unique(column, return_inverse=True) for column in numbers[:, :-1].T]
    points, index = [own for own, _ in found], np.stack([i.ravel() for _, i in found], axis=1)
    place = np.ravel_multi_index(tuple(index.T), [len(own) for own in points])
    order = np.argsort(place, kind="stable")
    again = np.flatnonzero(np.diff(place[order]) == 0)
    if len(again):
        first, second = (lines[order[again[0] + k]] for k in (0, 1))
        what = (
            f"{brief(file)}, line {second}: {_at(names, numbers[order[again[0] + 1]])} stands on line {first} already"
        )
        raise _refuse(what, "keep one of the two lines")
    size = prod(len(own) for own in points)
    if size > len(place):
        absent = next(_absent(place[order]))
        at = np.unravel_index(absent, [len(own) for own in points])
        missing = _at(names, [own[k] for own, k in zip(points, at, strict=True)])
        what = f"{brief(file)} has {len(place)} of the {size} points of a full grid: {missing} is missing, for one"
        raise _refuse(what, f"write a line for every pair of points of {' and '.join(names)}")
    values = numbers[order, -1].reshape([len(own) for own in points])
    return Grid(dict(zip(names, (own.tolist() for own in points), strict=True)), values.tolist())


def _absent(places: np.ndarray) -> Iterator[int]:
    """The places from 0 on that are not among these, which increase."""
    expected = 0
    for place in places.tolist():
        yield from range(expected, place)
        expected = place + 1
    yield expected


def _at(names: list[str], numbers: Sequence[float]) -> str:
    return ", ".join(f"{name} = {number:g}" for name, number in zip(names, numbers, strict=False))
