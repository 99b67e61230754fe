"""Writing files so that nothing a user had is lost."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import FileError, Mistake

PIPES = ("/dev/stdin", "/dev/fd/", "/proc/self/fd/")
"""Where shells put what they pipe in, as <(...) does; a FIFO by any other name could hang for ever."""

_temporaries: set[Path] = set()


def check_writable(path: Path, force: bool = True) -> None:
    """Raise FileError if a file at `path` could not be written, or if it exists and may not be replaced."""
    if not path.parent.is_dir():
        raise FileError(Mistake(str(path), "its folder does not exist", f"create {path.parent} or choose another name"))
    if path.is_dir():
        raise FileError(Mistake(str(path), "it is a folder", "give the name of a file"))
    if path.exists() and not path.is_file():
        raise FileError(Mistake(str(path), "it is no ordinary file", "give the name of a file"))
    try:
        tempfile.TemporaryFile(dir=path.parent).close()
    except OSError as error:
        what = f"its folder cannot be written ({error.strerror})"
        raise FileError(Mistake(str(path), what, "choose another folder")) from error
    if path.exists() and not force:
        raise FileError(Mistake(str(path), "the file exists", "choose another name, or replace it with --force"))


def make_folder(path: Path) -> None:
    """Make a folder, and those above it, that is not there yet. Raises FileError."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(Mistake(str(path), f"it cannot be made ({error.strerror})", "choose another folder")) from error


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary file in the same folder that becomes `path` at the end, or vanishes if anything goes wrong.

    An older file at `path` stays whole until the new one is complete and on the disk. Raises FileError if the
    operating system refuses.
    """
    temporary = None
    try:
        descriptor, name = tempfile.mkstemp(prefix=f".{path.stem}.", suffix=path.suffix, dir=path.parent)
        temporary = Path(name)
        _temporaries.add(temporary)
        os.close(descriptor)
        temporary.chmod(0o666 & ~_umask())
        yield temporary
        with temporary.open("rb") as written:
            os.fsync(written.fileno())
        temporary.replace(path)
    except OSError as error:
        what = f"it cannot be written ({error.strerror or error})"
        raise FileError(Mistake(str(path), what, "choose another place, or make room there")) from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)
            _temporaries.discard(temporary)


def remove_temporaries() -> None:
    """Remove the temporary files that are being written, for a process that ends in the middle of it."""
    for temporary in tuple(_temporaries):
        temporary.unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
