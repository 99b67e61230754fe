"""Columns over time: a CSV file with a column of times, and others named after what they are of."""

from __future__ import annotations

from itertools import pairwise
from math import isnan
from pathlib import Path
from typing import Any

from ..text import brief
from .columns import column_numbers, read_rows, refuse

TIME = "time"
NAMES_OF_TIME = (TIME, "t")

Series = dict[str, list[Any]]
"""TIME -> times, increasing, and name of each column -> its numbers, None where there is none."""


def by_time(columns: dict[Any, Any]) -> dict[Any, Any]:
    """What is given by column, that of the times called TIME: t is another name of it.

    columns: column -> anything.
    """
    own = next((name for name in NAMES_OF_TIME if name in columns), TIME)
    return {TIME if name == own else name: value for name, value in columns.items()}


def read_series(folder: Path, file: str, gaps: bool = False) -> Series:
    """The columns of a CSV file over time.

    folder: that of the problem file.
    file: the path in it.
    gaps: whether cells may be empty, and a time may stand on several lines.

    Raises `columns.ColumnsError` with every mistake.
    """
    rows = read_rows(folder, file)
    header = rows[0][1]
    time = next((name for name in NAMES_OF_TIME if name in header), None)
    if time is None:
        listed = f"its columns are {', '.join(map(brief, header))}"
        raise refuse(f"{brief(file)} has no column time", f"call the column of the times time, or t; {listed}")
    if len(header) < 2:
        raise refuse(f"{brief(file)} has a column of times alone", "add columns, named after what they are of")
    places = {name: k for k, name in enumerate(header)}
    numbers = column_numbers(rows, places, file, {name for name in header if name != time} if gaps else ())
    times = numbers[:, places[time]]
    for (before, after), (line, _) in zip(pairwise(times), rows[2:], strict=True):
        if after < before or (after == before and not gaps):
            what = f"{brief(file)}, line {line}: the time {after:g} follows {before:g}"
            raise refuse(what, f"sort the lines by time{'' if gaps else ', and give each time once'}")
    return by_time({name: [None if isnan(v) else v for v in numbers[:, k].tolist()] for name, k in places.items()})
