"""Arrays as sets. NumPy's own functions load `numpy.ma` at their first call, which takes as long as a small solve."""

from __future__ import annotations

import numpy as np


def distinct(values: np.ndarray) -> np.ndarray:
    """The values in rising order, each once, as of `np.unique`; they are finite, of any shape."""
    rising = np.sort(values, axis=None)
    new = np.ones(rising.shape, bool)
    new[1:] = rising[1:] != rising[:-1]
    return rising[new]


def without(values: np.ndarray, others: np.ndarray) -> np.ndarray:
    """The distinct values that are none of the others, as of `np.setdiff1d`."""
    own = distinct(values)
    return own[~np.isin(own, others)]
