"""Path constraints at the ends of time: what is given there must not contradict what holds at every time."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite

import numpy as np

from ..names.occurrences import constraints
from ..names.symbols import Symbols
from ..problem import Range
from ..schema.spec import Spec
from ..yaml.locations import Finding

ROUNDING = 1e-9
"""Of 1 + |bound|: by less than this a constraint may be missed, since values are computed."""


def impossible_at_ends(spec: Spec, symbols: Symbols) -> Iterator[Finding]:
    """Path constraints that cannot hold at an end where all that they depend on is given; spec: without mistakes."""
    for end in ("initial", "final"):
        given = dict(_given(spec, symbols, end))
        for path, constraint in constraints(spec):
            function = symbols.function(constraint.expression)
            if path[1] != "path" or not function.names or not function.names <= given.keys():
                continue
            bounds = symbols.range(constraint)
            with np.errstate(all="ignore"):
                value = np.array(float(function({name: np.float64(own) for name, own in given.items()}, np)))
            if np.isfinite(value) and bounds.excess(value) > ROUNDING:
                what = f"this cannot hold at the {end} time: it is {value:.6g} there, and {_asked(bounds)} is asked"
                names = ", ".join(f"{name}[{end}]" for name in sorted(function.names))
                yield Finding((*path, "expression"), what, f"change the constraint, or what is given for {names}")


def _given(spec: Spec, symbols: Symbols, end: str) -> Iterator[tuple[str, float]]:
    """The values that are fixed at one end, by name."""
    times = symbols.range(getattr(spec.time, end))
    if times.fixed:
        yield "t", times.lower
    for state in symbols.states:
        asked = symbols.range(getattr(state.entry, end))
        if asked.fixed:
            yield state.name, asked.lower


def _asked(bounds: Range) -> str:
    if bounds.fixed:
        return f"{bounds.lower:.6g}"
    if not isfinite(bounds.upper):
        return f"at least {bounds.lower:.6g}"
    return str(bounds) if isfinite(bounds.lower) else f"at most {bounds.upper:.6g}"
