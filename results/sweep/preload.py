"""What each worker needs, loaded once: the fork server imports this module, and its children have it all.

Importing it has an effect, so nobody else does.
"""

from __future__ import annotations

import ctypes

from ...problems.load import load_text
from ...transcription.engines.ipopt_library import load_library
from .case import solve_case

__all__ = ["load_text", "solve_case"]

M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3
"""Of glibc's malloc.h."""

KEPT = 64 << 20
"""Bytes that a worker keeps for its next case: IPOPT takes and frees the same memory again and again, and to have it
from the system each time is a twentieth of a case."""


def _keep_memory() -> None:
    """Where the C library is another, it does as it is used to."""
    if mallopt := getattr(ctypes.CDLL(None), "mallopt", None):
        for threshold in (M_TRIM_THRESHOLD, M_MMAP_THRESHOLD):
            mallopt(threshold, KEPT)


_keep_memory()
load_library()  # here, where there is one thread: see there
