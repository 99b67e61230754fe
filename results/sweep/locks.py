"""Locks between processes, on files; one that is killed leaves none behind."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ...problems.errors import FileError, Mistake


class Lock:
    """A lock on a file, which is made if it is not there."""

    def __init__(self, path: Path) -> None:
        try:
            self.descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        except OSError as error:
            what = f"its folder cannot be written ({error.strerror})"
            raise FileError(Mistake(str(path), what, "choose another folder with -o")) from error

    def take(self, alone: bool, wait: bool) -> bool:
        """Whether it was got. alone: no one else may have it. wait: for those who do."""
        how = (fcntl.LOCK_EX if alone else fcntl.LOCK_SH) | (0 if wait else fcntl.LOCK_NB)
        try:
            fcntl.flock(self.descriptor, how)
        except BlockingIOError:
            self.release()
            return False
        return True

    def release(self) -> None:
        os.close(self.descriptor)


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """One process at a time is in the block."""
    lock = Lock(path)
    lock.take(alone=True, wait=True)
    try:
        yield
    finally:
        lock.release()
