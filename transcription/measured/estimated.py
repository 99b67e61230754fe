"""Parameters that were estimated from measurements."""

from __future__ import annotations

from dataclasses import field

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.text import short_repr


@short_repr
@dataclass(frozen=True)
class Estimates:
    """As `structure.estimates` finds them.

    names: of the static parameters, (P,), and their values. deviations: (P,) standard errors; NaN where a parameter
    stands on a bound, and where there are none. correlation: (P, P).

    residuals: the sum of weighted squares. measurements, free: numbers of values and of what was free to fit them.
    scale: s. given: whether the deviations of the measurements were. why_not: why there are no standard errors, or "".
    """

    names: tuple[str, ...]
    values: np.ndarray
    deviations: np.ndarray
    correlation: np.ndarray
    residuals: float
    measurements: int
    free: int
    scale: float
    given: bool
    why_not: str = field(default="")
