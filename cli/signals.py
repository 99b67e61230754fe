"""Signals: at any moment they end the process as 128 + their number, without a traceback or a temporary file.

A command that has something to keep is asked first: inside a block of `Stop`, the first signal only sets a flag, and
a second one ends the process at once. No exception is raised in either case: it might come in the middle of a callback,
of a destructor or of Python's own way out, where nobody can catch it.
"""

from __future__ import annotations

# Python has these before it runs anything of ours. In the middle of another import a signal would come unguarded.
import atexit
import os
import signal
import sys

TYPE_CHECKING = False
if TYPE_CHECKING:
    from types import FrameType, TracebackType
    from typing import NoReturn

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
SHOW_CURSOR = b"\x1b[?25h"  # a live line hides it
STOPPING = b"\nstopping after this iteration; once more to stop at once, without a result\n"


class Stop:
    """In the block `with Stop() as stop` the first signal makes stop() true, and a second one ends the process."""

    def __init__(self) -> None:
        self.number = 0
        self.before = {number: signal.getsignal(number) for number in SIGNALS}

    def __call__(self) -> bool:
        return self.number != 0

    @property
    def exit_code(self) -> int:
        return 128 + self.number

    def __enter__(self) -> Stop:
        for number, handler in self.before.items():
            if handler is not signal.SIG_IGN:
                signal.signal(number, self._note)
        return self

    def __exit__(self, kind: type | None, error: BaseException | None, traceback: TracebackType | None) -> None:
        for number, handler in self.before.items():
            signal.signal(number, handler)

    def _note(self, number: int, frame: FrameType | None) -> None:
        if self():
            _end(number, frame)
        self.number = number
        if os.isatty(2):  # not print: the signal may have come in the middle of another one
            os.write(2, STOPPING)


def end_on_signals() -> None:
    """From now on signals end the process; one that is ignored, as under nohup, stays ignored."""
    for number in SIGNALS:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _end)


def leave(code: int) -> NoReturn:
    """End the process with this exit code, after what libraries have registered for its end."""
    atexit._run_exitfuncs()
    os._exit(code)


def _end(number: int, frame: FrameType | None) -> NoReturn:
    # Nothing is imported now, and what is there may be half loaded.
    if remove := getattr(sys.modules.get("trajopt.problems.files"), "remove_temporaries", None):
        remove()
    os.write(2, (SHOW_CURSOR if os.isatty(2) else b"") + b"interrupted\n")
    os._exit(128 + number)
