"""Entries of the cache folder: one file each, named by the hash of what it is of, and checked before it is believed.

    MAGIC  blake2b(name + payload)  payload

A file is written under another name first, so that who reads sees all of it or none. What is damaged, too large or not
the user's alone is as if it were not there. The folder is bounded: the entries that were used longest ago go first.
"""

from __future__ import annotations

import os
import stat
import time
from hashlib import blake2b
from typing import NamedTuple

from .folder import opened_folder

MAGIC = b"trajopt cache 1\n"
DIGEST = 32
HEAD = len(MAGIC) + DIGEST

LIMIT, MOST = 200_000_000, 2000
"""Bytes and entries of the folder: each entry counts as at least the share of one in so many."""

LARGEST = LIMIT // 4  # of one entry
KEPT = 0.8  # of the limit, when it has been reached: so the next writers need not look again
DAY = 86_400.0
ABANDONED = 600.0  # seconds after which a file under another name belongs to nobody

_ahead = {"bytes": 0.0}  # that may be written until the folder is looked through again


class CachedFile(NamedTuple):
    """A file of the folder. used: the time at which it was, to a day."""

    name: str
    size: int
    used: float


def file_name_of(*content: bytes) -> str:
    """The name of the entry that is of this content."""
    told = blake2b(digest_size=DIGEST)
    for part in content:
        told.update(len(part).to_bytes(8, "big") + part)
    return told.hexdigest()


def read_entry(name: str) -> bytes | None:
    """The payload of an entry; None if there is none that can be believed."""
    try:
        with opened_folder() as folder:
            file = os.open(name, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, dir_fd=folder)
            with os.fdopen(file, "rb") as stream:
                found = os.fstat(file)
                if not _is_safe(found):
                    return None
                if time.time() - found.st_mtime > DAY:
                    os.utime(file)
                content = stream.read(LARGEST + 1)
    except OSError:
        return None
    payload = content[HEAD:]
    return payload if content[:HEAD] == MAGIC + _digest(name, payload) else None


def write_entry(name: str, payload: bytes) -> None:
    """Keep an entry, if that is possible."""
    if HEAD + len(payload) > LARGEST:
        return
    hidden = f".{name}.{os.getpid()}.{time.monotonic_ns()}"
    try:
        with opened_folder(make=True) as folder:
            flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
            file = os.open(hidden, flags, 0o600, dir_fd=folder)
            try:
                with os.fdopen(file, "wb") as stream:
                    stream.write(MAGIC + _digest(name, payload) + payload)
                os.replace(hidden, name, src_dir_fd=folder, dst_dir_fd=folder)
            except OSError:
                os.unlink(hidden, dir_fd=folder)
                raise
            _bound(folder, HEAD + len(payload))
    except OSError:
        return  # a full disk, a folder of somebody else: then nothing is kept


def entries() -> list[CachedFile]:
    """All of the folder, those used longest ago first. Raises OSError where it cannot be used."""
    with opened_folder() as folder:
        return sorted(_entries(folder), key=lambda own: own.used)


def clear() -> int:
    """Empty the folder; gives the number of entries that went. Raises OSError where it cannot be used."""
    with opened_folder() as folder:
        gone = _entries(folder)
        for own in gone:
            _unlink(own.name, folder)
    return sum(not own.name.startswith(".") for own in gone)


def _is_safe(found: os.stat_result) -> bool:
    """Whether a file is one of the user's, in which nobody else can write."""
    mine = found.st_uid == os.geteuid() and not found.st_mode & 0o022
    return stat.S_ISREG(found.st_mode) and mine and found.st_size <= LARGEST


def _digest(name: str, payload: bytes) -> bytes:
    told = blake2b(name.encode(), digest_size=DIGEST)
    told.update(payload)
    return told.digest()


def _entries(folder: int) -> list[CachedFile]:
    found = []
    with os.scandir(folder) as files:
        for file in files:
            try:
                own = file.stat(follow_symlinks=False)
            except FileNotFoundError:  # another process was faster
                continue
            if not stat.S_ISDIR(own.st_mode):
                found.append(CachedFile(file.name, own.st_size, own.st_mtime))
    return found


def _unlink(name: str, folder: int) -> None:
    try:
        os.unlink(name, dir_fd=folder)
    except FileNotFoundError:
        return  # another process was faster


def _bound(folder: int, written: int) -> None:
    """Delete what was used longest ago, if the folder has become too large. It is looked through at the first entry
    that a process writes, and after each tenth of the limit."""
    _ahead["bytes"] -= _counted(written)
    if _ahead["bytes"] > 0:
        return
    _ahead["bytes"] = LIMIT / 10
    found = _entries(folder)
    total, now = sum(_counted(own.size) for own in found), time.time()
    too_large = total > LIMIT
    for own in sorted(found, key=lambda own: own.used):
        is_left = own.name.startswith(".") and now - own.used > ABANDONED
        if is_left or (too_large and total > KEPT * LIMIT):
            _unlink(own.name, folder)
            total -= _counted(own.size)


def _counted(size: int) -> float:
    return max(size, LIMIT / MOST)
