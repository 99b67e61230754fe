"""What is wrong with measurements: columns, what they are compared with, times, how exact they are."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite

from ..expressions.functions import is_inconsistent
from ..expressions.signature import name_trouble
from ..expressions.tree import Operation
from ..language.times import TimeParameter
from ..measured import compared
from ..names.occurrences import measured_path
from ..names.roles import with_article
from ..names.symbols import Symbols
from ..phases.observed import observed_phases
from ..quantities import Range
from ..schema.measurements import MeanEntry, MeasuredEntry
from ..schema.spec import Spec
from ..tables.series import TIME
from ..text import brief, did_you_mean, shorten
from ..yaml.document import Path
from ..yaml.locations import Finding

MAX_TIMES = 2000
"""Distinct ones of a phase: each is a knot of every mesh."""


def measurement_mistakes(
    spec: Spec, symbols: Symbols, times: tuple[Range | None, Range | None], alone: bool
) -> Iterator[Finding]:
    """Every mistake in the measurements of a phase.

    spec, symbols: of the phase.
    times: ranges of its initial and its final time, None where mistaken.
    alone: whether it is all of the file, which measurements make phases of where its time is free.
    """
    if not spec.measurements or spec.static:  # of which `phases.timeless` tells
        return
    first: Path = ("measurements", next(iter(spec.measurements)))
    if spec.objective.sense == "maximize":
        what = "squared residuals are minimised, and the objective is maximised"
        yield Finding(first, what, "write minimize: with the sign of the terms changed")
    yield from _free_alone(spec, symbols, first, times) if alone else _free_in_phase(spec, first, times)
    for name, entry in spec.measurements.items():
        path: Path = ("measurements", name)
        if trouble := name_trouble(name, ()):
            yield Finding(path, *trouble)
        if entry.data:
            yield from _columns(entry, path, symbols)
            yield from _values(entry, path, symbols)
            yield from _times(entry, path, times)
        else:
            yield Finding((*path, "file"), "the columns of the file are missing", "give the CSV file, or data:")
        yield from _functions(entry, path, symbols)
    distinct = {own for entry in spec.measurements.values() for own in entry.data.get(TIME, ())}
    if len(distinct) > MAX_TIMES:
        what = f"there are {len(distinct)} distinct times, and each is a knot of the mesh"
        yield Finding(first, what, f"leave out some, up to {MAX_TIMES} remain; neighbours may be averaged")


def measurement_warnings(spec: Spec, symbols: Symbols) -> Iterator[Finding]:
    """Columns that count for nothing.

    spec, symbols: of the phase.
    """
    of_file: dict[str, set[str]] = {}  # several entries may share one
    for entry in spec.measurements.values():
        of_file.setdefault(entry.source, set()).update(compared(entry, symbols), _named(entry))
    for name, entry in spec.measurements.items():
        path = _place(entry, ("measurements", name))
        elsewhere = of_file[entry.source] if entry.source else ()
        used = {TIME, *compared(entry, symbols), *_named(entry), *elsewhere}
        others = [column for column in entry.data if column not in used]
        if others:
            known = [state.name for state in symbols.states]
            remedy = did_you_mean(others[0], known, "say by compare: what they measure, if they do")
            what = f"columns count for nothing: {shorten(', '.join(map(brief, others)))}"
            yield Finding(path, what, remedy)


def _named(entry: MeasuredEntry) -> list[str]:
    """The columns that say how exact others are."""
    given = entry.deviations if entry.deviations is not None else entry.weights
    own = given.values() if isinstance(given, dict) else [given]
    return [name for name in own if isinstance(name, str)]


def _place(entry: MeasuredEntry, path: Path) -> Path:
    return (*path, "file" if entry.source else "data")


def _columns(entry: MeasuredEntry, path: Path, symbols: Symbols) -> Iterator[Finding]:
    """Columns that are named are there."""
    columns = [column for column in entry.data if column != TIME]
    listed = f"the columns are {', '.join(map(brief, columns))}"
    for column in entry.compare:
        if column not in columns:
            what = f"there is no column {brief(column)}"
            yield Finding((*path, "compare", column), what, did_you_mean(column, columns, listed))
    for column in entry.units:
        if column not in entry.data:
            what = f"there is no column {brief(column)}"
            yield Finding((*path, "units", column), what, did_you_mean(column, entry.data, listed))
    for key in ("deviations", "weights"):
        given = getattr(entry, key)
        for column, own in given.items() if isinstance(given, dict) else [("", given)]:
            place = (*path, key, column) if column else (*path, key)
            if column and column not in columns:
                yield Finding(place, f"there is no column {brief(column)}", did_you_mean(column, columns, listed))
            if isinstance(own, str) and own not in columns:
                yield Finding(place, f"there is no column {brief(own)}", did_you_mean(own, columns, listed))
    declared = any(symbols.roles.get(column) == "expression" for column in columns)  # and is mistaken itself
    if not entry.compare and not compared(entry, symbols) and not declared:
        known = [state.name for state in symbols.states]
        example = known[0] if known else "x"
        remedy = did_you_mean(columns[0], known, f"say by compare: what they measure, {{{columns[0]}: {example}}}")
        yield Finding(_place(entry, path), f"no column is named as a state: {', '.join(map(brief, columns))}", remedy)


def _values(entry: MeasuredEntry, path: Path, symbols: Symbols) -> Iterator[Finding]:
    """Every column has a value, and deviations and weights are positive where there is one."""
    for column in compared(entry, symbols):
        row = entry.data.get(column)
        if row is None:
            continue
        if all(value is None for value in row):
            yield Finding(_place(entry, path), f"the column {brief(column)} has no values", "remove it, or fill it in")
        own = entry.exactness(column)
        key = "deviations" if entry.deviations is not None else "weights"
        if isinstance(entry.deviations, dict) and own is None:
            what = f"{brief(column)} has no standard deviation"
            yield Finding((*path, key), what, f"add {column}: with a number, or the name of a column of them")
        for i, exactness in enumerate(entry.data.get(own, ()) if isinstance(own, str) else ()):
            if row[i] is not None and (exactness is None or exactness <= 0):
                shown = "missing" if exactness is None else f"{exactness:g}"
                when = f"at time {entry.data[TIME][i]:g}"
                what = f"{own} of {column} is {shown} {when}"
                yield Finding(_place(entry, path), what, "write a positive number, or leave the measurement out too")
                break


def _times(entry: MeasuredEntry, path: Path, times: tuple[Range | None, Range | None]) -> Iterator[Finding]:
    """Measurements lie within the time of the phase."""
    initial, final = times
    if initial is None or final is None:
        return
    begins, ends = initial.lower, final.upper
    near = 1e-9 * (ends - begins) if isfinite(ends - begins) else 0.0
    outside = [t for t in entry.data[TIME] if not begins - near <= t <= ends + near]
    if outside:
        what = f"the time {outside[0]:g} is not from {begins:g} to {ends:g}"
        yield Finding(_place(entry, path), what, "change time: of the problem, or leave these measurements out")


def _free_alone(
    spec: Spec, symbols: Symbols, first: Path, times: tuple[Range | None, Range | None]
) -> Iterator[Finding]:
    """Why a file whose time is free cannot be one of phases that end where something is measured."""
    if not observed_phases(spec):
        return
    why = "an end of the time is free, so there is a phase of its own before the first or after the last measurement"
    for i, _ in enumerate(spec.constraints.integral):
        what = f"{why}, and an integral constraint is of one phase"
        yield Finding(
            ("constraints", "integral", i), what, "name the integral under integrals:, and bound integral.NAME"
        )
    if any(isinstance(own, TimeParameter) for own in spec.optimize.values()):
        what = f"{why}; t[initial], t[final] and t[duration] in equations would be those of a phase"
        yield Finding(first, what, "give time: both ends; a free duration T may scale the time: rate: T*f, from 0 to 1")
    measured = [t for entry in spec.measurements.values() for t in entry.data[TIME]]
    for own, end, edge in zip(times, ("initial", "final"), (max(measured), min(measured)), strict=True):
        if own is not None and own.fixed and (edge <= own.lower if end == "initial" else edge >= own.lower):
            what = f"all is measured at the {end} time, and the time is free at the other end"
            remedy = "write the squared residuals as terminal: of the objective, ((x[initial] - value)/deviation)**2"
            yield Finding(first, what, remedy.replace("initial", end))


def _free_in_phase(spec: Spec, first: Path, times: tuple[Range | None, Range | None]) -> Iterator[Finding]:
    """What is measured in a phase has a time that is known, or is at an end that is."""
    known = [own for own in times if own is not None and own.fixed]
    if None in times or len(known) == 2:
        return
    measured = {t for entry in spec.measurements.values() for t in entry.data.get(TIME, ())}
    means = any(isinstance(entry, MeanEntry) for entry in spec.measurements.values())
    if means or not (known and all(t == known[0].lower for t in measured)):
        what = "the times of measurements are knots of the mesh, and here an end of the time is free"
        earliest, last = min(measured, default=0.0), max(measured, default=0.0)
        begins = f"begin the phase at t = {earliest:g}, the first of them, where one before it ends"
        ends = f"let a phase end at t = {last:g}, the last of them, and another go on from there"
        remedy = ", and ".join(own for own, end in zip((begins, ends), times, strict=True) if end not in known)
        yield Finding(first, what, f"{remedy}; or scale the time by a free duration T: rate: T*f, from 0 to 1")


def _functions(entry: MeasuredEntry, path: Path, symbols: Symbols) -> Iterator[Finding]:
    """What is measured depends on states, and on nothing that is free at an instant."""
    states = {state.name for state in symbols.states}
    for column, expression in entry.compare.items():
        place = measured_path(path, column)
        if not symbols.sound(place, expression):
            continue
        names = symbols.function(expression).names
        others = sorted(names - states - symbols.static - {"t"})
        if others:
            role = with_article(symbols.roles.get(others[0], "unknown"))
            what = f"{others[0]} is {role}, whose value at one instant costs nothing, so it cannot be measured there"
            yield Finding(place, what, f"make {others[0]} a state, and its rate the control")
        elif not names & (states | symbols.static):
            yield Finding(place, "this depends on nothing that is to be found", "compare with states or parameters")
        for node in (node for part in symbols.function(expression).parts for node in part.nodes):
            if isinstance(node, Operation) and is_inconsistent(node.symbol) and not symbols.is_constant(node):
                what = f"{node.symbol} is not smooth"
                yield Finding(place, what, "write it smooth, such as sqrt(y**2 + 1e-6) for abs(y)")
