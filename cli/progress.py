"""A live line on a terminal while IPOPT iterates; nothing where standard error is no terminal."""

from __future__ import annotations

import os
import shutil
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ..problems.syntax import shorten
from .common import one_line

SECONDS_BETWEEN = 0.1  # often enough to look alive, too seldom to cost anything
NAME_WIDTH = 20


@contextmanager
def live_line(name: str, wanted: bool) -> Iterator[Callable[[int, dict], None] | None]:
    """The progress callback of `transcription.solve.solve`, or None where nothing should be shown.

    The line is gone when the block ends.
    """
    if not (wanted and sys.stderr.isatty() and os.environ.get("TERM", "dumb") != "dumb"):
        yield None
        return
    line = _Line(shorten(one_line(name), NAME_WIDTH))
    line.write(f"{line.name}: building")
    try:
        yield line.show
    finally:
        line.write("")


class _Line:
    """The last line of a terminal, written over and over."""

    def __init__(self, name: str):
        self.name, self.written = name, 0.0

    def show(self, mesh: int, record: dict) -> None:
        if time.monotonic() - self.written >= SECONDS_BETWEEN:
            self.write(
                f"{self.name}: mesh {mesh + 1}, iteration {record['iteration']}, "
                f"J = {record['objective']:.6g}, infeasibility {record['primal_infeasibility']:.0e}"
            )

    def write(self, text: str) -> None:
        self.written = time.monotonic()
        sys.stderr.write(f"\r{text[: shutil.get_terminal_size().columns - 1]}\x1b[K")
        sys.stderr.flush()


def print_iteration(mesh: int, record: dict) -> None:
    """One line for each iteration on standard error, for --verbose."""
    if record["iteration"] == 0:
        print(f"mesh {mesh + 1}\n iter  objective        infeasibility  dual        mu", file=sys.stderr)
    print(
        f"{record['iteration']:5d}  {record['objective']:<15.8g}  {record['primal_infeasibility']:<13.2e}  "
        f"{record['dual_infeasibility']:<10.2e}  {record['mu']:.1e}",
        file=sys.stderr,
    )
