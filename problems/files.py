"""Writing files so that nothing a user had is lost."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from errno import ELOOP, ESRCH
from functools import cache
from pathlib import Path

from .errors import FileError, Mistake, SpecError

PIPES = ("/dev/stdin", "/dev/fd/", "/proc/self/fd/")
"""Where shells put what they pipe in, as <(...) does; a FIFO by any other name could hang for ever."""
PREFIX = ".trajopt-"
"""Of temporary files: short, so that any name that a file may have leaves room for it, whatever the name is."""

_temporaries: set[Path] = set()


def check_writable(path: Path, force: bool = True) -> None:
    """Raise FileError if a file at `path` could not be written, or if it exists and may not be replaced."""
    where = str(path)
    try:
        target = followed(path)
        where = where if target == path else f"{path} -> {target}"
        if not target.parent.is_dir():
            remedy = f"create {target.parent} or choose another name"
            raise FileError(Mistake(where, "its folder does not exist", remedy))
        if target.is_dir():
            raise FileError(Mistake(where, "it is a folder", "give the name of a file"))
        if target.exists() and not target.is_file():
            raise FileError(Mistake(where, "it is no ordinary file", "give the name of a file"))
        there = target.exists()
    except OSError as error:
        raise FileError(Mistake(where, f"it cannot be written ({reason_of(error)})", "choose another name")) from error
    try:
        tempfile.TemporaryFile(dir=target.parent).close()
    except OSError as error:
        what = f"its folder cannot be written ({reason_of(error)})"
        raise FileError(Mistake(where, what, "choose another folder")) from error
    if there and not force:
        raise FileError(Mistake(where, "the file exists", "choose another name, or replace it with --force"))


def make_folder(path: Path) -> None:
    """Make a folder, and those above it, that is not there yet. Raises FileError."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(Mistake(str(path), f"it cannot be made ({error.strerror})", "choose another folder")) from error


def check_not_protected(path: Path) -> None:
    """Raise FileError if there is a file at `path` that nobody may write: it is not to be replaced unasked."""
    if path.is_file() and not path.stat().st_mode & 0o222:
        raise FileError(Mistake(str(path), "it is read-only", "choose another name, or replace it with --force"))


def followed(path: Path) -> Path:
    """The file that a name means: a symbolic link is kept, and what it points to is written. Raises OSError."""
    if not path.is_symlink():
        return path
    meant = Path(os.path.realpath(path))
    if meant.is_symlink():
        raise OSError(ELOOP, os.strerror(ELOOP), str(path))
    return meant


def check_suffix(path: Path, what: str, suffixes: Sequence[str], remedy: str) -> None:
    """Refuse a name that says another format.

    path: of a file to come.
    what: it will be, as "picture".
    suffixes: those that the path may have, in lower case, as ".png".
    remedy: what to do.

    Raises SpecError.
    """
    if path.suffix.lower() not in suffixes:
        other = f'no {what} is written with the suffix "{path.suffix}"' if path.suffix else "the name has no suffix"
        raise SpecError(Mistake(str(path), other, remedy))


def check_ours(path: Path, force: bool, is_ours: Callable[[Path], bool], foreign: str) -> None:
    """Refuse, before any work is done, a path that cannot be written to, or a file that is not to be replaced.

    path: of a file to come.
    force: whether any file may be replaced.
    is_ours: whether an earlier file was written by the same kind of command, and may be replaced; may raise OSError.
    foreign: what is said of any other, as "was not drawn by trajopt".

    Raises FileError.
    """
    check_writable(path)
    if force or not path.exists():
        return
    try:
        ours = is_ours(path)
    except OSError as error:
        what = f"it cannot be read ({reason_of(error)})"
        raise FileError(Mistake(str(path), what, "choose another file with -o")) from error
    if not ours:
        remedy = "choose another file with -o, or replace it with --force"
        raise FileError(Mistake(str(path), f"it exists and {foreign}", remedy))


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A temporary file in the same folder that becomes `path` at the end, or vanishes if anything goes wrong.

    An older file at `path` stays whole until the new one is complete and on the disk. What a process that was killed
    has left of its own is removed. Raises FileError if the operating system refuses.
    """
    temporary = None
    try:
        target = followed(path)
        remove_left(target.parent)
        prefix = f"{PREFIX}{_machine()}-{os.getpid()}-"
        descriptor, name = tempfile.mkstemp(prefix=prefix, suffix=target.suffix[:20], dir=target.parent)
        temporary = Path(name)
        _temporaries.add(temporary)
        os.close(descriptor)
        temporary.chmod(0o666 & ~_umask())
        yield temporary
        with temporary.open("rb") as written:
            os.fsync(written.fileno())
        temporary.replace(target)
    except OSError as error:
        what = f"it cannot be written ({reason_of(error)})"
        raise FileError(Mistake(str(path), what, "choose another place, or make room there")) from error
    finally:
        if temporary is not None:
            temporary.unlink(missing_ok=True)
            _temporaries.discard(temporary)


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file whole, a text as UTF-8, or leave the older one. Raises FileError."""
    with replacing(path) as temporary:
        temporary.write_bytes(content.encode() if isinstance(content, str) else content)


@cache
def remove_left(folder: Path) -> None:
    """Remove the temporary files in a folder whose process, on this machine, has ended; once a folder."""
    for left in folder.glob(f"{PREFIX}{_machine()}-*"):
        owner = left.name.removeprefix(f"{PREFIX}{_machine()}-").partition("-")[0]
        if owner.isdigit() and not _runs(int(owner)):
            left.unlink(missing_ok=True)


def _machine() -> str:
    return "".join(c for c in os.uname().nodename if c.isalnum())[:30]


def _runs(process: int) -> bool:
    """Whether there is a process of this number."""
    try:
        os.getpgid(process)
    except OSError as error:
        return error.errno != ESRCH
    return True


def reason_of(error: OSError) -> str:
    """What the operating system says, as a part of a sentence."""
    return (error.strerror or str(error)).lower()


def remove_temporaries() -> None:
    """Remove the temporary files that are being written, for a process that ends in the middle of it."""
    for temporary in tuple(_temporaries):
        temporary.unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
