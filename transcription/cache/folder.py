"""The cache folder: where it is, and whether it is safe. It is opened once, and what was checked is what is used.

Entries are run as code, so the folder and its files must be the user's, and nobody else may write there. A cache that
is not safe, or cannot be made, is no mistake: then there is none.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

SWITCH, OFF = "TRAJOPT_CACHE", "off"
"""The environment variable that names a folder in place of the usual one, or says that there is to be none."""


def place() -> Path | None:
    """The folder, whether it is there or not; None where the cache is off or there is no home."""
    named = os.environ.get(SWITCH, "")
    if named.lower() == OFF:
        return None
    if named:
        return Path(named).absolute()
    base = os.environ.get("XDG_CACHE_HOME", "")
    if not os.path.isabs(base):  # as the XDG specification says
        base = os.path.expanduser("~/.cache")
    return Path(base, "trajopt") if os.path.isabs(base) else None


@contextmanager
def opened_folder(make: bool = False) -> Iterator[int]:
    """A descriptor of the folder.

    make: whether it is made where it is not there.

    Raises OSError if there is none, or it is not safe: a link, another user's, or open to others.
    """
    folder = place()
    if folder is None:
        raise FileNotFoundError(f"switched off by {SWITCH}, or there is no home")
    if make and not folder.is_dir():
        folder.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        found = os.fstat(descriptor)
        if found.st_uid != os.geteuid():
            raise PermissionError("it belongs to another user")
        if stat.S_IMODE(found.st_mode) & 0o077:
            raise PermissionError("others may use it (chmod 700 makes it safe)")
        yield descriptor
    finally:
        os.close(descriptor)
