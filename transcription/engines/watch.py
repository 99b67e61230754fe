"""Who looks on at a solve, and when it has to end."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import inf

from ...problems.lean.records import dataclass


class Limit:
    """When a solve has to end: after some seconds from now, or when `stop` says so.

    clock: of these seconds.
    """

    def __init__(
        self,
        seconds: float | None,
        stop: Callable[[], bool] | None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.end, self.stop, self.clock = inf if seconds is None else clock() + seconds, stop, clock

    def reached(self) -> bool:
        return self.asked() or self.left() < 0

    def left(self) -> float:
        """Seconds until the end; infinite without one."""
        return self.end - self.clock()

    def asked(self) -> bool:
        """Whether it was `stop` that said so."""
        return self.stop is not None and self.stop()


@dataclass(frozen=True)
class Watch:
    """Who looks on: `progress` and `stop` of `solve`, and the number of the solve that progress is told."""

    progress: Callable[[int, dict], None] | None
    stop: Callable[[], bool] | None
    number: int

    def next(self, more: int) -> Watch:
        return replace(self, number=self.number + more)

    def callbacks(self) -> dict[str, Callable | None]:
        return {"progress": self.progress and partial(self.progress, self.number), "stop": self.stop}
