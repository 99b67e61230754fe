"""Rows of a guess through what was measured: there a trajectory is near the data, whatever the parameters are."""

from __future__ import annotations

from collections.abc import Mapping
from collections.abc import Set as AbstractSet

import numpy as np

from ..measured import measurements_of
from ..names.symbols import Symbols
from ..quantities import Range
from ..schema.spec import Spec
from .rows import GuessRow, GuessSpan


def observed_rows(
    spec: Spec, symbols: Symbols, names: AbstractSet[str], span: GuessSpan, ends: Mapping[str, tuple[Range, Range]]
) -> dict[str, GuessRow]:
    """Name -> row, of the variables that are measured by themselves: straight lines through the means at each time.

    spec, symbols: of the phase, without mistakes.
    names: of its variables.
    span: of its time.
    ends: name of each state -> what the file asks for at both ends; a given value is where the line begins or ends.

    None where an end of the time is free.
    """
    if not span.fixed or span.final <= span.initial:
        return {}
    points: dict[str, list[np.ndarray]] = {}
    for own in measurements_of(spec, symbols):
        points.setdefault(own.expression, []).append(np.array([own.times, own.values]))
    return {
        name: _line(np.concatenate(points[name], axis=1), span, *ends.get(name, (Range(), Range())))
        for name in names & points.keys()
    }


def _line(points: np.ndarray, span: GuessSpan, initial: Range, final: Range) -> GuessRow:
    """points: (2, M) of times and values, in any order."""
    times, which = np.unique(points[0], return_inverse=True)
    values = np.bincount(which, points[1]) / np.bincount(which)
    s = (times - span.initial) / (span.final - span.initial)
    if initial.fixed:
        s, values = np.append(0.0, s[s > 0]), np.append(initial.lower, values[s > 0])
    if final.fixed:
        s, values = np.append(s[s < 1], 1.0), np.append(values[s < 1], final.lower)
    return GuessRow(s, values)
