"""The beginning of a worker of `trajopt sweep`: it prints nothing on standard output, and ends with its parent."""

from __future__ import annotations

import os
import signal
from typing import TYPE_CHECKING, Any

from ...problems.lean.hidden import Onlooker
from ..streams import NAMES

if TYPE_CHECKING:
    from multiprocessing.process import BaseProcess


def prepare_workers(flag: Any) -> None:
    """Called first in each worker; solves end when `flag.value` is not zero.

    Ctrl-C reaches all processes of a terminal, and the parent alone decides what becomes of it.
    """
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    os.dup2(NAMES.index("stderr"), NAMES.index("stdout"))
    import multiprocessing

    if (parent := multiprocessing.parent_process()) is not None:
        Onlooker(target=_end_with, args=(parent,), daemon=True).start()
    from ...results.sweep.case import watch

    watch(flag)


def _end_with(parent: BaseProcess) -> None:
    """However the parent ends, also by kill -9."""
    parent.join()
    os._exit(1)
