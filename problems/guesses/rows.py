"""Rows of a guess: the values of one variable at times of its own, keyframes or columns of data."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from ..expressions.expression import Expression
from ..schema.sections import GuessEntry
from ..sets import distinct
from ..tables.series import TIME

APART = 1e-9
"""Of the duration: places that are closer count as one, so that slopes between them are none of rounding."""


class GuessRow(NamedTuple):
    """s: (K,) normalised times, increasing. values: (K,), straight lines between them, held before and after."""

    s: np.ndarray
    values: np.ndarray


class GuessSpan(NamedTuple):
    """What a guess is about: from its initial to its final time, in the unit of time; fixed: whether both are given."""

    initial: float
    final: float
    fixed: bool


def rows_of(
    guess: GuessEntry, number: Callable[[Expression | None, float], float], span: GuessSpan
) -> dict[str, GuessRow]:
    """Name -> row, of keyframes and of data.

    The first keyframe is put at the initial and the last at the final time. Data stand at their own times where both
    ends are given; else they are put there as keyframes are.

    guess: of the file, without mistakes.
    number: the value of an expression of parameters.
    span: what it is about.
    """
    frames = {name: np.array([number(v, 0.0) for v in row]) for name, row in guess.keyframes.items()}
    times = frames.pop(TIME, None)
    rows = {name: GuessRow(np.linspace(0, 1, len(row)) if times is None else _from_0_to_1(times), row)
            for name, row in frames.items()}  # fmt: skip
    columns = {name: np.array(row, float) for name, row in guess.data.items()}
    if not columns:
        return rows
    times = columns.pop(TIME)
    s = (times - span.initial) / (span.final - span.initial) if span.fixed else _from_0_to_1(times)
    return rows | {name: GuessRow(s, row) for name, row in columns.items()}


def _from_0_to_1(times: np.ndarray) -> np.ndarray:
    s: np.ndarray = (times - times[0]) / (times[-1] - times[0])
    return s


def combined(values: Mapping[str, GuessRow], s: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """The places of all rows in one, (K,) from 0 to 1, and the values of each there, (K,).

    values: name -> row.
    s: places that should be among them.
    """
    places = distinct(np.concatenate([[0.0, 1.0], s, *(row.s for row in values.values())]))
    places = places[(places >= 0) & (places <= 1)]
    places = places[np.diff(places, prepend=-1.0) > APART]
    places[-1] = 1.0
    return places, {name: np.interp(places, row.s, row.values) for name, row in values.items()}
