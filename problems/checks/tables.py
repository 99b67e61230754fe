"""What a table of data is not about: values that are given, and lie outside of its points where it says error."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite

import numpy as np

from ..names.lookups import KeptWithin, kept_within
from ..names.occurrences import SOLVED
from ..names.symbols import Symbols
from ..quantities import Range
from ..schema.spec import Spec
from ..yaml.document import Path
from ..yaml.locations import Finding

SAMPLES = 501
_REMEDY = "change that, add points to the table, or write outside: hold or extrapolate in it"


def beyond_tables(spec: Spec, symbols: Symbols) -> Iterator[Finding]:
    """Arguments of tables that cannot stay within the points; spec: otherwise without mistakes."""
    variables = {v.name: v for v in symbols.variables}
    for use in symbols.uses:
        if use.context not in SOLVED or use.path[0] == "expressions":
            continue
        for own in kept_within(symbols.function(use.expression)):
            if spec.solver.engine == "newton":
                what = f"the Newton engine takes no bounds, and outside: error bounds {own.argument}"
                remedy = "write outside: extrapolate or hold, or leave out engine: newton"
                yield Finding(("tables", own.table, "outside"), what, remedy)
            elif own.name in variables:
                entry, path = variables[own.name].entry, variables[own.name].path
                given = {path: symbols.range(entry)} if own.end is None else {}
                ends = [own.end] if own.end else ["initial", "final"]
                given |= {(*path, end): symbols.range(getattr(entry, end, None)) for end in ends}
                yield from _apart(own, given)
            elif own.name == "t":
                ends = [own.end] if own.end else ["initial", "final"]
                yield from _apart(own, {("time", end): symbols.range(getattr(spec.time, end)) for end in ends})
            elif own.function.names == {"t"}:
                yield from _over_time(own, use.path, *(symbols.range(e) for e in (spec.time.initial, spec.time.final)))


def _apart(own: KeptWithin, given: dict[Path, Range]) -> Iterator[Finding]:
    """What of these ranges has nothing in common with the points."""
    for path, asked in given.items():
        common = asked.intersection(own.points)
        if common.lower > common.upper:
            what = f"{own.name} is {asked} here, and the table {own.table} has points from {own.points}"
            yield Finding(path, what, _REMEDY)


def _over_time(own: KeptWithin, path: Path, initial: Range, final: Range) -> Iterator[Finding]:
    """An argument that is known at every time."""
    if not (initial.fixed and final.fixed and isfinite(initial.lower) and isfinite(final.lower)):
        return
    t = np.linspace(initial.lower, final.lower, SAMPLES)
    with np.errstate(all="ignore"):
        values = np.broadcast_to(own.function({"t": t}, np), t.shape)
    if own.points.excess(values).max() > 0:
        at = int(np.argmax(own.points.excess(values)))
        what = f"{own.argument} of {own.table} is {values[at]:g} at t = {t[at]:g}, and its points are {own.points}"
        yield Finding(path, what, _REMEDY)
