"""The units of measurements: of columns, of what they are compared with, and of the squares that are added."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from ..measured import compared
from ..names.occurrences import measured_path
from ..names.symbols import Symbols
from ..schema.measurements import MeanEntry, MeasuredEntry
from ..tables.series import TIME
from ..text import brief
from ..yaml.document import Path
from .infer import Reader, Value
from .measure import Measure, pure, same

UnitOf = Callable[[Path, str], Value]
"""(path, text) -> the unit that the text means."""


def sum_of_squares(
    name: str, entry: MeasuredEntry, symbols: Symbols, time: Value, unit_of: UnitOf, reader: Reader
) -> Iterator[tuple[Path, Value]]:
    """Look at measurements; what does not fit is added to the findings of the reader.

    name, entry: of the measurements.
    symbols: of the phase.
    time: the unit of its time.
    unit_of: what a text means.
    reader: of its expressions.

    Yields the path and the unit of what they add to the objective: a pure number, where deviations are given.
    """
    path: Path = ("measurements", name)
    given = {column: unit_of((*path, "units", column), text) for column, text in entry.units.items()}
    _agree(reader, path, TIME, given.get(TIME), time, "the time of the problem")
    squared: tuple[str, Measure] | None = None
    for column, expression in compared(entry, symbols).items():
        meant = entry.means.get(column, expression) if isinstance(entry, MeanEntry) else expression
        value = reader.read(measured_path(path, column), meant)
        own = given.get(column)
        _agree(reader, path, column, own, value, "what it is compared with")
        exactness = entry.exactness(column)
        if entry.deviations is not None and isinstance(exactness, str):
            _agree(reader, path, exactness, given.get(exactness), own or value, f"{column}, whose deviation it is,")
        unit = own or value
        if exactness is not None or not isinstance(unit, Measure):
            continue
        if squared is None:
            squared = column, unit
        elif not same(unit, squared[1]):
            told = f"{brief(squared[0])} is {squared[1].told}, and {brief(column)} {unit.told}: their squares are added"
            reader.add(path, told, "give deviations:, a standard deviation of each in its unit")
    if entry.deviations is not None:
        yield path, pure()
    elif entry.weights is None and squared is not None:
        yield path, squared[1].power(2)


def _agree(reader: Reader, path: Path, column: str, own: Value, wanted: Value, of: str) -> None:
    """Whether the unit that a column is said to have is that of something else."""
    if isinstance(own, Measure) and isinstance(wanted, Measure) and not same(own, wanted):
        what = f"the column {brief(column)} is {own.told}, and {of} is {wanted.told}"
        reader.clash((*path, "units", column), what, own, wanted)
