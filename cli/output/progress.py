"""A live line on a terminal while IPOPT iterates; a line now and then where standard error is none."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from time import monotonic

from ...problems.text import shorten
from .printing import dumb_terminal, one_line

NAME_WIDTH = 20
INTERVAL = 10.0  # seconds


@contextmanager
def live_text(text: str) -> Iterator[Callable[[str], None] | None]:
    """Show a text on one line of a terminal; gives a function that changes it, or None where nothing is shown.

    The line is gone when the block ends.
    """
    if not sys.stderr.isatty() or dumb_terminal():
        yield None
        return
    from rich.console import Console
    from rich.live import Live
    from rich.text import Text

    def line(text: str) -> Text:
        return Text(text, no_wrap=True, overflow="ellipsis")

    console = Console(stderr=True)
    with Live(line(text), console=console, transient=True, redirect_stdout=False, redirect_stderr=False) as live:
        yield lambda text: live.update(line(text))


@contextmanager
def live_line(name: str, wanted: bool) -> Iterator[Callable[[int, dict], None] | None]:
    """The progress callback of `transcription.solve.solve`, or None where nothing should be shown.

    Where standard error is no terminal it is a plain line every INTERVAL seconds.
    """
    if not wanted:
        yield None
        return
    name = shorten(one_line(name), NAME_WIDTH)
    with live_text(f"{name}: building") as show:
        tell = show or EverySoOften(lambda text: print(text, file=sys.stderr, flush=True))
        yield lambda mesh, record: tell(f"{name}: {_state(mesh, record)}")


class EverySoOften:
    """Passes a text on only if the last one, or the beginning, is `interval` seconds past."""

    def __init__(self, tell: Callable[[str], None], interval: float = INTERVAL, clock: Callable[[], float] = monotonic):
        self.tell, self.interval, self.clock = tell, interval, clock
        self.last = clock()

    def __call__(self, text: str) -> None:
        if self.clock() - self.last >= self.interval:
            self.last = self.clock()
            self.tell(text)


def _state(mesh: int, record: dict) -> str:
    return (
        f"mesh {mesh + 1}, iteration {record['iteration']}, "
        f"J = {record['objective']:.6g}, infeasibility {record['primal_infeasibility']:.0e}"
    )


def print_iteration(mesh: int, record: dict) -> None:
    """One line for each iteration on standard error, for --verbose."""
    if record["iteration"] == 0:
        print(f"mesh {mesh + 1}\n iter  objective        infeasibility  dual        mu", file=sys.stderr)
    print(
        f"{record['iteration']:5d}  {record['objective']:<15.8g}  {record['primal_infeasibility']:<13.2e}  "
        f"{record['dual_infeasibility']:<10.2e}  {record['mu']:.1e}",
        file=sys.stderr,
    )
