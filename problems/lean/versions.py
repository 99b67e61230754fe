"""The version of an installed package, read off the name of its folder.

`importlib.metadata` tells the same, and loads readers of mail, tables and archives for it: a fifteenth of a solve.
"""

from __future__ import annotations

import os
import re
import sys
from functools import cache


def version(package: str) -> str:
    """As `importlib.metadata.version`, which is asked where no folder tells, as in an archive.

    package: its name, as it is installed.

    Raises `importlib.metadata.PackageNotFoundError` if there is no such package.
    """
    own = re.compile(rf"{re.escape(package)}-([^-]+)\.dist-info", re.IGNORECASE)
    for folder in sys.path:
        for name in names_in(folder or os.curdir):
            if (found := own.fullmatch(name)) and os.path.isfile(os.path.join(folder, name, "METADATA")):
                return found[1]
    from importlib.metadata import version

    return version(package)


@cache
def names_in(folder: str) -> tuple[str, ...]:
    """What was in a folder when it was first asked for; nothing where it is none that can be read."""
    try:
        return tuple(os.listdir(folder))
    except OSError:
        return ()
