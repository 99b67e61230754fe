"""What is seen of a sweep: a line while it runs, and a table at its end."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .printing import one_line, plural, print_field, print_title
from .progress import live_text

Record = Mapping[str, Any]


class Tally:
    """What a sweep has done so far; cases that were finished before it began are counted, but not its speed."""

    def __init__(self, cases: int, finished: int) -> None:
        self.cases, self.before, self.solved, self.failed = cases, finished, 0, 0
        self.began = time.monotonic()

    def count(self, record: Record) -> None:
        self.solved += bool(record["solved"])
        self.failed += not record["solved"]

    def __str__(self) -> str:
        """Such as "12 of 50 cases, 1 failed, 8.2 a second, 5 s left"."""
        ended, passed = self.solved + self.failed, time.monotonic() - self.began
        text = f"{self.before + ended} of {plural(self.cases, 'case')}, {self.failed} failed"
        if not ended:
            return text
        rate = ended / passed
        return f"{text}, {rate:.3g} a second, {_duration((self.cases - self.before - ended) / rate)} left"


def _duration(seconds: float) -> str:
    """As "45 s", "12 min" or "3.5 h"."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.1f} h"


@contextmanager
def watched(name: str, tally: Tally, quiet: bool) -> Iterator[Callable[[], None]]:
    """Gives a function to call several times a second: what is shown is the tally then."""
    name = one_line(name)
    with live_text(f"{name}: {tally}", not quiet) as show:
        yield lambda: show(f"{name}: {tally}")


def print_sweep(name: str, summary: Mapping[str, Any], folder: Path, seconds: float, done: int) -> None:
    """The table at the end.

    name: of the problem.
    summary: of `results.sweep.tables.summary_of`.
    folder: where the files are.
    seconds: that the cases of this run took together.
    done: the number of them.
    """
    cases, solved = summary["cases"], summary["solved"]
    print_title(f"{name}: {solved} of {plural(cases, 'case')} solved", solved == cases)
    counts = [f"{cases}", f"{solved} solved", f"{summary['failed']} failed"]
    counts += [f"{summary['missing']} missing"] if summary["missing"] else []
    print_field("cases", ", ".join(counts))
    for status, told in summary["reasons"].items():
        print_field("failed", f"{plural(told['cases'], 'case')} {status.replace('_', ' ')}: {told['message']}")
    if summary["inaccurate"]:
        print_field("accuracy", f"{plural(summary['inaccurate'], 'solved case')} not as accurate as was asked")
    for which in ("best", "worst"):
        if record := summary[which]:
            values = ", ".join(f"{path}={value}" for path, value in record["values"].items())
            print_field(which, f"{record['objective']:.10g}  ({values})")
    if done:
        print_field("seconds", f"{seconds:.1f}  ({plural(done, 'case')}, {done / seconds:.3g} a second)")
    print_field("files", f"{folder / 'index.csv'}, {folder / 'sweep.h5'}")
