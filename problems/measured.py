"""Measurements of a phase: columns of data and the functions that they are compared with."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from .expressions.expression import Expression
from .names.symbols import Symbols
from .names.variables import reference
from .quantities import Measured
from .schema.measurements import MeasuredEntry
from .schema.spec import Spec
from .tables.series import TIME


def compared(entry: MeasuredEntry, symbols: Symbols) -> dict[str, Expression]:
    """Column -> what it is compared with: as the entry says, or the state or named expression of its name.

    entry: of the file.
    symbols: of the phase.
    """
    if entry.compare:
        return dict(entry.compare)
    states = {state.name for state in symbols.states}
    known = states | {name for name in symbols.definitions if name in symbols.varying}
    return {column: reference(column) for column in entry.data if column in known}


def measured(spec: Spec, symbols: Symbols) -> Iterator[Measured]:
    """The measurements of a phase, quantity by quantity.

    spec, symbols: of the phase, without mistakes.
    """
    for name, entry in spec.measurements.items():
        times = np.array(entry.data[TIME], float)
        for column, expression in compared(entry, symbols).items():
            values, deviations = _numbers(entry.data[column]), _of(entry, column, len(times))
            there = np.isfinite(values) & np.isfinite(deviations)
            yield Measured(
                name=f"{name}.{column}",
                column=column,
                function=symbols.function(expression),
                expression=expression.text,
                unit=_unit(expression.text, symbols, spec),
                times=times[there],
                values=values[there],
                deviations=deviations[there],
                exact=entry.deviations is not None,
            )


def _of(entry: MeasuredEntry, column: str, count: int) -> np.ndarray:
    """The standard deviations of a column, (count,), up to a common factor where weights are given or nothing is."""
    given = entry.exactness(column)
    if given is None:
        return np.ones(count)
    numbers = _numbers(entry.data[given]) if isinstance(given, str) else np.full(count, given)
    return numbers if entry.deviations is not None else 1 / np.sqrt(numbers)


def _numbers(column: list[float | None]) -> np.ndarray:
    return np.array([value if value is not None else float("nan") for value in column], float)


def _unit(name: str, symbols: Symbols, spec: Spec) -> str:
    """That of the state or the named expression that is measured by itself."""
    units: Mapping[str, str] = {state.name: state.unit for state in symbols.states}
    return units.get(name) or (spec.expressions[name].unit if name in spec.expressions else "")
