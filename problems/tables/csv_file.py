"""A table of data in a CSV file: a line of names, then one line for each point of a full grid, in any order."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import prod
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..text import brief, did_you_mean
from .choices import MAX_ARGUMENTS
from .columns import ColumnsError, ColumnTrouble, column_numbers, number_of, read_rows, refuse


class Grid(NamedTuple):
    """points: name of each argument -> its points, increasing. values: nested lists, one index for each argument."""

    points: Mapping[str, list[float]]
    values: list[Any]


def read_table(folder: Path, file: str, name: str, arguments: Sequence[str] | None, value: str | None) -> Grid:
    """The table in a CSV file.

    folder: that of the problem file.
    file: the path in it.
    name: of the table.
    arguments: the columns that are arguments. None for the first alone where nothing stands twice in it, so that no
        grid of several arguments has it, and else for all but that of the values.
    value: the column of the values; None for the only one that is no argument, the one called as the table, or, of a
        grid, the last.

    Raises ColumnsError with every mistake.
    """
    rows = read_rows(folder, file)
    header = rows[0][1]
    if arguments is None and len(header) > 2 and value != header[0]:
        first = [number_of(cells[0]) for _, cells in rows[1:]]
        arguments = header[:1] if len(set(first)) == len(first) > 1 else None
    if value is None and name in header and name not in (arguments or header[:1]):
        value = name
    columns = _columns(header, arguments, value, file)
    numbers = column_numbers(rows, columns, file)
    return _grid(list(columns)[:-1], numbers, [line for line, _ in rows[1:]], file)


def _columns(
    header: list[str], arguments: Sequence[str] | None, value: str | None, file: str
) -> dict[str, int]:  # fmt: skip
    """Name -> index of the columns of the arguments, and of the values as the last."""
    missing = [name for name in (*(arguments or ()), *([value] if value else ())) if name not in header]
    if missing:
        remedy = f"its columns are {', '.join(map(brief, header))}"
        raise ColumnsError(
            [
                ColumnTrouble(f"{brief(file)} has no column {brief(name)}", did_you_mean(name, header, remedy))
                for name in missing
            ]
        )
    if arguments is None:
        arguments = [name for name in header if name != (value or header[-1])]
    others = [name for name in header if name not in arguments]
    if value is None and len(others) != 1:
        listed = f"its columns are {', '.join(map(brief, header))}"
        what = f"which column of {brief(file)} has the values over {' and '.join(map(brief, arguments))} is not clear"
        raise refuse(what, f"add value: with its name; {listed}")
    value = value or others[0]
    if not 1 <= len(arguments) <= MAX_ARGUMENTS or value in arguments or len(set(arguments)) < len(arguments):
        what = f"the arguments of {brief(file)} are {', '.join(map(brief, arguments)) or 'none'}"
        raise refuse(what, "name one to three columns under arguments:, each once, and another under value:")
    return {name: header.index(name) for name in (*arguments, value)}


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
        raise refuse(what, "keep one of the two lines")
    size = prod(len(own) for own in points)
    if size > len(place):
        absent = next(_absent(place[order]))
        at = np.unravel_index(absent, [len(own) for own in points])
        missing = _at(names, [own[k] for own, k in zip(points, at, strict=True)])
        what = f"{brief(file)} has {len(place)} of the {size} points of a full grid: {missing} is missing, for one"
        remedy = f"write a line for every pair of points of {' and '.join(names)}"
        raise refuse(what, f"{remedy}; of curves over one column name that under arguments:")
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
