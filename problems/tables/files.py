"""The tables of a problem file that stand in CSV files beside it, put into its data."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..text import brief
from ..yaml.locations import Finding
from .csv_file import TableFileError, Trouble, read_table

NO_FOLDER = Trouble("a text has no folder that the file could be in", "write the table here, as points: and values:")
OF_FILE = ("file", "arguments", "value")
"""Keys that say where a table is; `points`, `values` and `source` take their place."""


def read_files(data: dict[str, Any], folder: Path | None) -> list[Finding]:
    """Every mistake in the CSV files that the tables of a problem file name; those without any are put in their place.

    data: of the problem file, changed in place: a table whose file is mistaken is taken out.
    folder: that of the problem file; None if it is a text.

    What a problem then holds is all that its solution needs, also when the CSV file is gone.
    """
    findings: list[Finding] = []
    given = data.get("tables")
    tables: dict[str, Any] = given if isinstance(given, dict) else {}
    for name, entry in list(tables.items()):
        if not isinstance(entry, dict) or not _is_read(entry):
            continue
        try:
            if folder is None:
                raise TableFileError([NO_FOLDER])
            grid = read_table(folder, entry["file"], entry.get("arguments"), entry.get("value"))
        except TableFileError as error:
            findings += [Finding(("tables", name, "file"), what, remedy) for what, remedy in error.troubles]
            del tables[name]
            continue
        rest = {key: value for key, value in entry.items() if key not in OF_FILE}
        tables[name] = {"points": dict(grid.points), "values": grid.values, "source": brief(entry["file"]), **rest}
    return findings


def _is_read(entry: dict[str, Any]) -> bool:
    """Whether a table is in a file, by keys of the right types; what is wrong with others is the schema's to say."""
    arguments, value = entry.get("arguments"), entry.get("value")
    named = arguments is None or (isinstance(arguments, list) and all(isinstance(name, str) for name in arguments))
    of_file = isinstance(entry.get("file"), str) and named and (value is None or isinstance(value, str))
    return of_file and entry.get("points") is None and entry.get("values") is None
