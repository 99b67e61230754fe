"""The loop of a sweep: cases are handed to an engine as they become ready, and their answers to the store."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Future, wait
from operator import itemgetter
from typing import Any

from ...problems.lean.records import dataclass
from .case import ERROR, INTERRUPTED, WORKER_DIED, Answer, Left, Task, failed
from .engines import Engine
from .plan import Plan
from .store import Store

TICK = 0.2
"""Seconds between two looks at whether to stop."""

DEATHS = 2
"""Workers that a case may take with it before it is given up."""


@dataclass(frozen=True)
class Job:
    """What all cases share: text and name of the problem file, overrides, what is told as the command; full: whether
    full results are kept; chain: whether cases start from their neighbours.
    """

    text: str
    file: str
    overrides: tuple[str, ...]
    command: str
    full: bool
    chain: bool


def todo(plan: Plan, store: Store, full: bool, shard: tuple[int, int] | None) -> tuple[list[int], list[int]]:
    """The cases of this process, and those of them that are missing or failed.

    plan: all cases.
    store: what is finished.
    full: whether a full result is wanted of each.
    shard: (i, n), every n-th case from the i-th; None for all.
    """
    own = list(range(len(plan))) if shard is None else list(range(shard[0] - 1, len(plan), shard[1]))
    return own, [number for number in own if not store.finished(number, full)]


def run(
    plan: Plan,
    store: Store,
    engine: Engine,
    job: Job,
    cases: Sequence[int],
    *,
    stop: Callable[[], bool],
    report: Callable[[Mapping[str, Any] | None], None],
) -> None:
    """Solve the cases.

    plan, store, job: of the sweep.
    engine: where they are solved.
    cases: those to solve.
    stop: asked several times a second; true ends the sweep, and what is finished is kept.
    report: called with the record of each case, and with None several times a second.

    Raises FileError if the folder cannot be written any more; what is finished is kept.
    """
    loop = _Loop(plan, store, engine, job, cases)
    try:
        while loop.unfinished and not stop():
            loop.submit()
            for record in loop.answers(stop):
                report(record)
            report(None)
        engine.stop()
        if loop.running:
            for record in loop.last_answers():
                report(record)
    finally:
        engine.stop()
        engine.close()


class _Loop:
    """ready: cases whose neighbour has ended; waiting: neighbour -> those who wait for it."""

    def __init__(self, plan: Plan, store: Store, engine: Engine, job: Job, cases: Sequence[int]) -> None:
        self.plan, self.store, self.engine, self.job = plan, store, engine, job
        self.unfinished = set(cases)
        self.running: dict[Future[Answer], int] = {}
        self.deaths: dict[int, int] = {}
        self.ready: deque[int] = deque()
        self.waiting: dict[int, list[int]] = {}
        for number in cases:
            before = plan.before(number) if job.chain else None
            if before in self.unfinished and before is not None:
                self.waiting.setdefault(before, []).append(number)
            else:
                self.ready.append(number)

    def submit(self) -> None:
        while self.ready and len(self.running) < self.engine.capacity:
            number = self.ready.popleft()
            self.running[self.engine.submit(self._task(number))] = number

    def _task(self, number: int) -> Task:
        job, origin = self.job, self._origin(number)
        return Task(
            number,
            self.plan.values(number),
            job.text,
            job.file,
            job.overrides,
            origin,
            self._line(number, origin[0]) if origin else None,
            job.chain,
            job.full,
            job.command,
        )

    def _origin(self, number: int) -> tuple[int, Left] | None:
        """The nearest case on the way back along the chain that is solved, with what it leaves."""
        before = self.plan.before(number) if self.job.chain else None
        while before is not None:
            if left := self.store.left(before):
                return before, left
            before = self.plan.before(before)
        return None

    def _line(self, number: int, before: int) -> tuple[Left, float] | None:
        """What the case before the one that a case starts from has left, and the step to it, if they are on a line."""
        earlier = self.plan.before(before)
        share = None if earlier is None else self.plan.share(earlier, before, number)
        left = None if earlier is None or share is None else self.store.left(earlier)
        return (left, share) if left and share else None

    def answers(self, stop: Callable[[], bool]) -> list[Mapping[str, Any]]:
        """The records of the cases that have ended by now, which are kept. Workers go on with others while these are
        written, unless it is to stop.

        stop: as of `run`.
        """
        done, _ = wait(self.running, timeout=TICK, return_when=FIRST_COMPLETED)
        ended = sorted(((self.running.pop(future), future) for future in done), key=itemgetter(0))
        if not stop():
            self.submit()
        return [record for number, future in ended for record in self._ended(number, future)]

    def last_answers(self) -> list[Mapping[str, Any]]:
        """After a stop: what the workers had finished, or were asked to end, which is dropped."""
        if self.engine.waits:
            wait(self.running)
        ended = [(number, future) for future, number in self.running.items() if future.done()]
        return [record for number, future in ended for record in self._ended(number, future)]

    def _ended(self, number: int, future: Future[Answer]) -> list[Mapping[str, Any]]:
        answer = self._answer(number, future)
        if answer is None or answer.record["status"] == INTERRUPTED:
            return []
        self.store.keep(answer)
        self.unfinished.discard(number)
        self.ready.extendleft(reversed(self.waiting.pop(number, [])))
        return [answer.record]

    def _answer(self, number: int, future: Future[Answer]) -> Answer | None:
        """None for a case that is tried once more."""
        try:
            return future.result()
        except CancelledError:
            return None
        except Exception as error:
            if not _worker_died(error):
                return self._failed(number, ERROR, f"{type(error).__name__}: {error}")
        self.deaths[number] = self.deaths.get(number, 0) + 1
        if self.deaths[number] < DEATHS:
            self.ready.appendleft(number)
            return None
        return self._failed(number, WORKER_DIED, f"its worker died {DEATHS} times (out of memory, or killed)")

    def _failed(self, number: int, status: str, message: str) -> Answer:
        return Answer(failed(number, self.plan.values(number), status, message))


def _worker_died(error: Exception) -> bool:
    """Whether it says so, here or on a Dask cluster, whose package may not be installed."""
    return isinstance(error, BrokenExecutor) or type(error).__name__ == "KilledWorker"
