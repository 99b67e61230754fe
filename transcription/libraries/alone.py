"""What is process-wide while a program is built, and the lock around it.

Pyomo keeps templates only while two switches of its modules are set, and the garbage collector is one for all threads:
building a program in one thread changes both for the others. What solving takes most of its time for, the engine, needs
neither.
"""

from __future__ import annotations

import gc
import threading
from collections.abc import Iterator
from contextlib import contextmanager

LOCK = threading.RLock()
"""Held by the one thread that builds a program, imports the engine, or makes a scheme that others share."""


@contextmanager
def building() -> Iterator[None]:
    """One thread at a time, without looking for garbage.

    Building makes a hundred thousand objects and no garbage; looking for some takes a third of its time.
    """
    with LOCK:
        enabled = gc.isenabled()
        gc.disable()
        try:
            yield
        finally:
            if enabled:
                gc.enable()
