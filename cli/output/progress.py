"""What is shown while something takes long: a live line on a terminal, elsewhere a line every 10 s."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event
from time import monotonic

from ...problems.lean.hidden import Onlooker
from ...problems.text import shorten
from .printing import dumb_terminal, one_line

NAME_WIDTH = 20
INTERVAL, REFRESH = 10.0, 0.25  # seconds between two lines, and between two looks of a live line


class _Now:
    """A text that changes; called with a new one."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __call__(self, text: str) -> None:
        self.text = text


@contextmanager
def live_text(text: str, wanted: bool = True) -> Iterator[Callable[[str], None]]:
    """Show a text while a block runs, on one line of a terminal that is gone at its end, or every INTERVAL seconds.

    text: to begin with.
    wanted: whether anything is shown.

    Gives a function that changes the text. The time shows itself, whatever the block is at.
    """
    now = _Now(text)
    if not wanted:
        yield now
    elif sys.stderr.isatty() and not dumb_terminal():
        with _live_line(now):
            yield now
    else:
        began = monotonic()
        with _again_and_again(lambda: _print_line(now.text, monotonic() - began), INTERVAL):
            yield now


@contextmanager
def live_line(name: str, wanted: bool) -> Iterator[Callable[[int, dict], None]]:
    """The progress callback of `transcription.solve.solve`; see `live_text`."""
    name = shorten(one_line(name), NAME_WIDTH)
    with live_text(f"{name}: building", wanted) as show:
        yield lambda mesh, record: show(f"{name}: {_state(mesh, record)}")


@contextmanager
def _live_line(now: _Now) -> Iterator[None]:
    from rich.console import Console
    from rich.live import Live
    from rich.text import Text

    def line() -> Text:
        return Text(now.text, no_wrap=True, overflow="ellipsis")

    with (
        Live(
            get_renderable=line, console=Console(stderr=True), auto_refresh=False, transient=True,
            redirect_stdout=False, redirect_stderr=False,
        ) as live,
        _again_and_again(live.refresh, REFRESH),
    ):  # fmt: skip
        live.refresh()
        yield


def _print_line(text: str, seconds: float) -> None:
    print(f"{seconds:4.0f} s  {one_line(text)}", file=sys.stderr, flush=True)


@contextmanager
def _again_and_again(show: Callable[[], object], interval: float) -> Iterator[None]:
    """Call a function every so many seconds until the block ends, or until nobody reads what it writes."""
    ended = Event()

    def run() -> None:
        try:
            while not ended.wait(interval):
                show()
        except OSError:
            return

    onlooker = Onlooker(target=run, daemon=True)
    onlooker.start()
    try:
        yield
    finally:
        ended.set()
        onlooker.join(interval)


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
