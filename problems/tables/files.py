"""The data of a problem file that stand in CSV files beside it, put into its own: tables, and guesses over time."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..text import brief
from ..wishes.values import result_as_guess
from ..yaml.document import Path as Place
from ..yaml.locations import Finding
from .columns import ColumnsError, ColumnTrouble
from .csv_file import read_table
from .series import read_series

NO_FOLDER = ColumnTrouble(
    "a text has no folder that the file could be in", "write the table here, as points: and values:"
)
NO_FOLDER_OF_SERIES = NO_FOLDER._replace(remedy="write the columns here, as data: {time: [0, 1], x: [0, 1]}")
OF_FILE = ("file", "arguments", "value")
"""Keys that say where a table is; `points`, `values` and `source` take their place."""


def read_files(data: dict[str, Any], folder: Path | None) -> list[Finding]:
    """Every mistake in the CSV files that a problem file names; what stands in those without any is put in their place.

    data: of the problem file, changed in place: what is in a mistaken file is taken out.
    folder: that of the problem file; None if it is a text.

    What a problem then holds is all that its solution needs, also when the CSV file is gone.
    """
    return [*_tables(data, folder), *_over_time(data, folder)]


def _tables(data: dict[str, Any], folder: Path | None) -> Iterator[Finding]:
    given = data.get("tables")
    tables: dict[str, Any] = given if isinstance(given, dict) else {}
    for name, entry in list(tables.items()):
        if not isinstance(entry, dict) or not _is_read(entry):
            continue
        try:
            if folder is None:
                raise ColumnsError([NO_FOLDER])
            grid = read_table(folder, entry["file"], name, entry.get("arguments"), entry.get("value"))
        except ColumnsError as error:
            yield from (Finding(("tables", name, "file"), what, remedy) for what, remedy in error.troubles)
            del tables[name]
            continue
        rest = {key: value for key, value in entry.items() if key not in OF_FILE}
        tables[name] = {"points": dict(grid.points), "values": grid.values, "source": brief(entry["file"]), **rest}


def _is_read(entry: dict[str, Any]) -> bool:
    """Whether a table is in a file, by keys of the right types; what is wrong with others is the schema's to say."""
    arguments, value = entry.get("arguments"), entry.get("value")
    named = arguments is None or (isinstance(arguments, list) and all(isinstance(name, str) for name in arguments))
    of_file = isinstance(entry.get("file"), str) and named and (value is None or isinstance(value, str))
    return of_file and entry.get("points") is None and entry.get("values") is None


def _over_time(data: dict[str, Any], folder: Path | None) -> Iterator[Finding]:
    """Guesses and measurements."""
    guesses = ((place, owner, "guess", False) for place, owner in _owners(data))
    sets = (
        ((*place, "measurements"), owner["measurements"], name, True)
        for place, owner in _owners(data)
        if isinstance(owner.get("measurements"), dict)
        for name in list(owner["measurements"])
    )
    for place, owner, key, gaps in [*guesses, *sets]:
        entry = owner.get(key)
        if not isinstance(entry, dict) or not isinstance(entry.get("file"), str | int | float) or entry.get("data"):
            continue
        file = str(entry.pop("file"))  # YAML takes 2024 for a number
        if key == "guess" and (of_result := result_as_guess(file)):
            yield Finding((*place, key, "file"), *of_result)
            continue
        try:
            if folder is None:
                raise ColumnsError([NO_FOLDER_OF_SERIES])
            entry |= {"data": read_series(folder, file, gaps), "source": brief(file)}
        except ColumnsError as error:
            yield from (Finding((*place, key, "file"), what, remedy) for what, remedy in error.troubles)
            if gaps:  # without columns nothing can be said of them
                del owner[key]


def _owners(data: dict[str, Any]) -> Iterator[tuple[Place, dict[str, Any]]]:
    """The top level and the phases, each with its place."""
    yield (), data
    phases = data.get("phases")
    for name, own in phases.items() if isinstance(phases, dict) else ():
        if isinstance(own, dict):
            yield ("phases", name), own
