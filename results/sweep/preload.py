"""What each worker needs, loaded once: the fork server imports this module, and its children have it all.

Importing it has an effect, so nobody else does.
"""

from __future__ import annotations

from ...problems.load import load_text
from ...transcription.engines.ipopt_library import load_library
from .case import solve_case

__all__ = ["load_text", "solve_case"]

load_library()  # here, where there is one thread: see there
