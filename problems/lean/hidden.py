"""Libraries that others load only because they are there."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager


class Onlooker(threading.Thread):
    """A thread that shows what others do, and imports nothing that is hidden."""


@contextmanager
def hidden(*names: str, absent: bool = False) -> Iterator[None]:
    """A block in which some libraries seem not to be loaded, though they may be.

    names: of the libraries.
    absent: whether they seem not to be installed either: an import of them fails at once.

    With several threads nothing is hidden, since another may be importing them for itself; those that only look on
    do not count.
    """
    if sum(not isinstance(thread, Onlooker) for thread in threading.enumerate()) > 1:
        yield
        return
    loaded = {name: sys.modules.pop(name) for name in names if name in sys.modules}
    if absent:
        sys.modules.update(dict.fromkeys(names))  # type: ignore[arg-type]  # None: as documented for the import system
    try:
        yield
    finally:
        for name in names if absent else ():
            del sys.modules[name]
        sys.modules.update(loaded)
