"""Values of several phases over one axis of times.

Phases that follow each other make one curve with gaps. Phases at the same times, branches and separate experiments,
have a curve each; the axis then has the times of all, in order.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from math import isfinite
from typing import Any

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.text import short_repr

DIGITS = 7
LINES = 8  # colours of lines that stand beside each other

Series = dict[str, Any]


@short_repr
@dataclass(frozen=True)
class Times:
    """The axis of times of a chart.

    names: of the phases. parts: of each phase its times, (K,), increasing; one may stand twice. beside: whether some
    phases are at the same times.
    """

    names: Sequence[str]
    parts: Sequence[np.ndarray]
    beside: bool

    def axis(self) -> list[float | None]:
        """The times of the chart; between phases that follow each other the last one again."""
        return rounded_numbers(np.sort(np.concatenate(self.parts))) if self.beside else joined(self.parts, False)

    def curves(self, label: str, kind: str, colour: str, values: Sequence[np.ndarray]) -> list[Series]:
        """One series, or one for each phase where some are beside each other.

        label: what they are called.
        kind: as of `charts`; of "steps" each value holds until the next one.
        colour: of one series.
        values: of each phase at its times.
        """
        if not self.beside:
            return [plain_series(label, kind, colour, joined(values, True))]
        times = np.sort(np.concatenate(self.parts))
        at: Callable[..., np.ndarray] = _held if kind == "steps" else _between
        return [
            plain_series(f"{label}, {name}", kind, f"line{i % LINES}", rounded_numbers(at(times, own, part)))
            for i, (name, own, part) in enumerate(zip(self.names, self.parts, values, strict=True))
        ]

    def marks(self, label: str, colour: str, values: Sequence[np.ndarray]) -> Series:
        """Points of all phases.

        label: what they are called.
        colour: of them.
        values: of each phase at its times, NaN where no point is.
        """
        order = np.argsort(np.concatenate(self.parts), kind="stable")
        placed = rounded_numbers(np.concatenate(values)[order]) if self.beside else joined(values, True)
        return plain_series(label, "points", colour, placed)


def _between(times: np.ndarray, own: np.ndarray, values: np.ndarray) -> np.ndarray:
    return np.interp(times, own, values, left=np.nan, right=np.nan)


def _held(times: np.ndarray, own: np.ndarray, values: np.ndarray) -> np.ndarray:
    last = np.clip(np.searchsorted(own, times, side="right") - 1, 0, len(own) - 1)
    return np.where((times < own[0]) | (times > own[-1]), np.nan, values[last])


def plain_series(label: str, kind: str, colour: str, values: Sequence[float | None]) -> Series:
    """What a chart has of one curve.

    label: what it is called.
    kind, colour: as of `charts`.
    values: at the times of the chart.
    """
    return {"label": label, "kind": kind, "colour": colour, "values": values}


def rounded_numbers(values: Iterable[float | None]) -> list[float | None]:
    """Numbers of some digits; None for what is not finite."""
    return [float(f"{v:.{DIGITS}g}") if v is not None and isfinite(v) else None for v in values]


def joined(parts: Sequence[np.ndarray], gap: bool) -> list[float | None]:
    """The phases one after the other, with one place between them: a gap in a curve, the same time again in times."""
    found: list[float | None] = []
    for part in parts:
        if found:
            found.append(None if gap else found[-1])
        found += rounded_numbers(part)
    return found
