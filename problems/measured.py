"""Measurements of a phase: columns of data and the functions that they are compared with."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from .expressions.expression import Expression
from .names.symbols import Symbols
from .names.variables import reference
from .quantities import Measured
from .schema.measurements import MeanEntry, MeasuredEntry
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


def measurements_of(spec: Spec, symbols: Symbols) -> Iterator[Measured]:
    """The measurements of a phase, quantity by quantity.

    spec, symbols: of the phase, without mistakes.
    """
    if not spec.measurements:
        return
    initial, final = symbols.range(spec.time.initial), symbols.range(spec.time.final)
    ends = initial.lower, final.upper
    for name, entry in spec.measurements.items():
        times = np.array(entry.data[TIME], float)
        means = entry.means if isinstance(entry, MeanEntry) else {}
        for column, expression in compared(entry, symbols).items():
            values, deviations = _numbers(entry.data[column]), _of(entry, column, len(times))
            there = np.isfinite(values) & np.isfinite(deviations)
            yield Measured(
                name=f"{name}.{column}",
                column=column,
                function=symbols.function(expression),
                expression=means.get(column, expression).text,
                unit=_unit(means.get(column, expression).text, symbols, spec),
                times=times[there],
                values=values[there],
                deviations=deviations[there],
                exact=entry.deviations is not None,
                spans=spans(times[there], *ends) if column in means else None,
                state=expression.text if column in means else "",
            )


def spans(times: np.ndarray, begin: float, end: float) -> np.ndarray:
    """From when to when the mean at each time is, (M, 2): half the way to its neighbours, as far to the other side of
    the first and the last, and no farther than the ends of the phase.

    times: (M,), which do not fall.
    begin, end: of the phase.
    """
    own, which = np.unique(times, return_inverse=True)
    if len(own) == 1:
        return np.tile([begin, end], (len(times), 1))
    inner = (own[1:] + own[:-1]) / 2
    first, last = max(begin, 2 * own[0] - inner[0]), min(end, 2 * own[-1] - inner[-1])
    edges = np.concatenate([[first], inner, [last]])
    return np.stack([edges[:-1], edges[1:]], axis=1)[which]


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
    varying = symbols.variables
    units: Mapping[str, str] = {variable.name: variable.unit for variable in varying}
    return units.get(name) or (spec.expressions[name].unit if name in spec.expressions else "")
