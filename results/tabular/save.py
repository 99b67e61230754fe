"""Columns -> CSV or Parquet."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from ...problems.errors import FileError, Mistake, SpecError
from ...problems.files import check_suffix, replacing
from .columns import Column

CSV, PARQUET = ".csv", ".parquet"


def check_table_format(path: Path) -> None:
    """Refuse, before any work is done, a name of neither format, or Parquet without pandas. Raises SpecError."""
    check_suffix(path, "table", (CSV, PARQUET), f"end the name with {CSV} or {PARQUET}")
    if path.suffix.lower() == PARQUET and not (find_spec("pandas") and find_spec("pyarrow")):
        what = "Parquet files need the packages pandas and pyarrow, which are not installed"
        raise SpecError(Mistake(str(path), what, f"run: pip install pandas pyarrow, or end the name with {CSV}"))


def csv_text(table: Mapping[str, Column], units: bool) -> str:
    """The table with a line of names, numbers with all their digits; what is not finite is left empty.

    table: name -> column.
    units: whether the names carry them: x [m].
    """
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(f"{name} [{own.unit}]" if units and own.unit else name for name, own in table.items())
    for start in range(0, _rows(table), 10_000):
        parts = [_cells(column.values[start : start + 10_000]) for column in table.values()]
        writer.writerows(zip(*parts, strict=True))
    return stream.getvalue()


def _rows(table: Mapping[str, Column]) -> int:
    return len(next(iter(table.values())).values)


def _cells(values: np.ndarray) -> list[str]:
    if values.dtype == object:
        return [str(value) for value in values]
    return ["" if not finite else repr(float(v)) for v, finite in zip(values, np.isfinite(values), strict=True)]


def save_table(table: Mapping[str, Column], path: Path, units: bool) -> None:
    """Write a table; the suffix says the format, as `check_format` has passed it.

    table: name -> column.
    path: of the file; one that is there is replaced.
    units: as of `csv_text`. Parquet has them in the metadata of pandas, as `frame.attrs["units"]`.

    Raises FileError.
    """
    with replacing(path) as temporary:
        if path.suffix.lower() == CSV:
            temporary.write_text(csv_text(table, units), encoding="utf-8")
            return
        import pandas

        frame = pandas.DataFrame({name: column.values for name, column in table.items()})
        frame.attrs["units"] = {name: column.unit for name, column in table.items() if column.unit}
        try:
            frame.to_parquet(temporary, engine="pyarrow", index=False)
        except (ImportError, ValueError) as error:
            raise FileError(Mistake(str(path), f"pandas cannot write it ({error})", "write .csv")) from error
