"""What cases are solved on: local processes, or a Dask cluster that is there already.

An engine takes tasks and gives futures of `concurrent.futures`; how many it can work on at once is its `capacity`.
"""

from __future__ import annotations

import logging
import multiprocessing
import os
import time
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from multiprocessing.sharedctypes import RawValue
from typing import Any, Protocol, TypeVar

from ...problems.errors import Mistake, SpecError
from ...transcription.engines.ipopt_library import PRELOADED
from .case import Answer, Task, solve_case

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS", "BLIS_NUM_THREADS")
PATIENCE = 10  # seconds to reach a scheduler
STARTS, PAUSE = 5, 0.1
"""Attempts to start a worker, and seconds between the second and the third; they grow."""

T = TypeVar("T")


class Engine(Protocol):
    """Where cases are solved."""

    @property
    def capacity(self) -> int: ...

    @property
    def waits(self) -> bool:
        """Whether what is being solved ends soon after `stop`."""
        ...

    def submit(self, task: Task) -> Future[Answer]:
        """Begin a case; at most `capacity` may be unfinished. A worker that dies is an error of the future."""
        ...

    def stop(self) -> None:
        """Ask all workers to end what they are at."""
        ...

    def close(self) -> None:
        """Wait until all workers have ended."""
        ...


class LocalEngine:
    """Processes on this machine, one thread each.

    Each is a pool of its own, of one worker: so it is known which case a killed worker was at, and the others go on.
    They come from a fork server, which has loaded once what all of them need, and has no threads.
    """

    waits = True

    def __init__(self, jobs: int, prepare: Callable[[Any], None], library: str | None = None) -> None:
        """jobs: number of processes. prepare: called in each of them first, with the flag that asks it to stop.
        library: as `solver.library` of the file says; it is there."""
        self.capacity, self.prepare = jobs, prepare
        os.environ.update({name: "1" for name in ONE_THREAD})  # before NumPy is imported there
        self.context = multiprocessing.get_context("forkserver")
        first = [PRELOADED[library]] if library in PRELOADED else []
        self.context.set_forkserver_preload([*first, f"{__package__}.preload"])
        self.flag = RawValue("b", 0)  # has no lock, which a killed worker might hold for ever
        self.slots: list[tuple[ProcessPoolExecutor, Future[Any] | None]] = [(self._pool(), None) for _ in range(jobs)]

    def _pool(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(1, self.context, self.prepare, (self.flag,))

    def submit(self, task: Task) -> Future[Answer]:
        return self.begin(solve_case, task)

    def begin(self, work: Callable[..., T], *arguments: Any) -> Future[T]:
        """Begin any work, in a process that is free: at most `capacity` may be unfinished."""
        free = next(i for i, (_, future) in enumerate(self.slots) if future is None or future.done())
        pool, _ = self.slots[free]
        for attempt in range(STARTS):
            try:
                future = pool.submit(work, *arguments)
                break
            except (BrokenExecutor, OSError, EOFError):  # the worker has died since, or the fork server
                pool.shutdown(wait=False)
                time.sleep(attempt * PAUSE)
                pool = self._pool()
        else:
            future = Future[T]()
            future.set_exception(BrokenExecutor("no process can be started"))
        self.slots[free] = pool, future
        return future

    def stop(self) -> None:
        self.flag.value = 1

    def close(self) -> None:
        for pool, _ in self.slots:
            pool.shutdown(cancel_futures=True)


class ClusterEngine:
    """A Dask cluster: its workers need trajopt, and nothing of the folder. Those that die are Dask's to replace."""

    waits = False

    def __init__(self, address: str) -> None:
        """Raises SpecError if `distributed` is not installed, or nobody answers at the address."""
        try:
            from distributed import Client
        except ImportError as error:
            what = "a cluster needs the package distributed, which is not installed"
            raise SpecError(Mistake("--scheduler", what, "install it: pip install distributed")) from error
        try:
            self.client = Client(address, timeout=PATIENCE)
        except (OSError, ValueError, TypeError) as error:
            what = "no scheduler of Dask answers there"
            raise SpecError(Mistake(f"--scheduler {address}", what, "start one: dask scheduler")) from error
        # it warns of each answer that is lost with a worker, and has it computed anew: nothing a user has to do
        logging.getLogger("distributed.client").setLevel(logging.ERROR)
        self.capacity = max(sum(self.client.nthreads().values()), 1)
        self.executor: Executor = self.client.get_executor(pure=False, retries=1)

    def submit(self, task: Task) -> Future[Answer]:
        return self.executor.submit(solve_case, task)

    def stop(self) -> None:
        """Cases that are being solved go on, and nobody waits for them."""

    def close(self) -> None:
        self.executor.shutdown(wait=False)
        self.client.close()
