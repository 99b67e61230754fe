"""The beginning of a worker of `trajopt sweep`: it prints nothing on standard output, and ends with its parent."""

from __future__ import annotations

import os
import signal
import threading
from typing import Any

from ..streams import NAMES


def prepare_workers(flag: Any) -> None:
    """Called first in each worker; solves end when `flag.value` is not zero.

    Ctrl-C reaches all processes of a terminal, and the parent alone decides what becomes of it.
    """
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    os.dup2(NAMES.index("stderr"), NAMES.index("stdout"))
    threading.Thread(target=_end_with_parent, daemon=True).start()
    from ...results.sweep.case import watch

    watch(flag)


def _end_with_parent() -> None:
    """However the parent ends, also by kill -9."""
    import multiprocessing

    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
