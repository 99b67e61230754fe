"""Standard output and standard error: closed ones, readers that have gone, full disks, and what libraries print."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import typer

from ..problems.errors import FileError, Mistake, SpecError
from ..problems.files import reason_of
from ..transcription.loading import STDIN

PIPED = "-"
NAMES = ("stdin", "stdout", "stderr")


def open_closed_ones() -> None:
    """A stream that is closed, as by `>&-`, becomes /dev/null: the next file to be opened must not take its place."""
    for descriptor, name in enumerate(NAMES):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest free number, which is this one
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(descriptor, "w" if descriptor else "r", closefd=False))
        stream = getattr(sys, name)
        if descriptor and isinstance(stream, io.TextIOWrapper) and stream.errors == "strict":
            stream.reconfigure(errors="backslashreplace")  # a name that its encoding does not have is no trouble


def piped_text(files: Sequence[str]) -> str | None:
    """What is read from standard input where one of the files is "-"; None if none is. Raises SpecError, FileError."""
    if PIPED not in files:
        return None
    from ..problems.yaml.document import MAX_BYTES, decode

    if files.count(PIPED) > 1:
        raise SpecError(Mistake(STDIN, "it is given twice", "write - once"))
    try:
        content = sys.stdin.buffer.read(MAX_BYTES + 1)
    except OSError as error:
        raise FileError(Mistake(STDIN, f"it cannot be read ({error.strerror})", "pipe a problem file in")) from error
    return decode(content, STDIN)


def refuse_standard_output(output: object, what: str, remedy: str) -> None:
    """Raise SpecError where -o names standard output, and what is written is a file.

    output: what -o names.
    what: that is written, as "a picture is a file".
    remedy: how to have something on standard output all the same; "" where nothing is there to be had.
    """
    if str(output) == PIPED:
        also = f", and {remedy}" if remedy else ""
        raise SpecError(Mistake("-o -", f"{what}, which standard output cannot hold", f"name a file{also}"))


def flush() -> None:
    """Write what is still in the buffers; a reader that has gone misses nothing it wanted."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:  # told by `flushed_output` already where it can be told
            continue


@contextmanager
def flushed_output() -> Iterator[None]:
    """Write standard output while errors can still be told. A reader that has gone, as in `| head -1`, is none."""
    try:
        try:
            yield
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        _discard_output()
        raise typer.Exit(0) from None
    except OSError as error:
        if error.filename is not None:  # of a file, not of the stream
            what = f"it cannot be read or written ({reason_of(error)})"
            raise FileError(Mistake(os.fsdecode(error.filename), what, "check its name and its folder")) from error
        _discard_output()
        what = f"it cannot be written ({error.strerror})"
        raise FileError(Mistake("standard output", what, "send it elsewhere")) from error


def _discard_output() -> None:
    """What is still in the buffer must not fail again when Python ends."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


@contextmanager
def native_output(descriptor: int) -> Iterator[None]:
    """What libraries in C (IPOPT) print on standard output goes to another descriptor: ours carries results only."""
    import ctypes

    flush = ctypes.CDLL(None).fflush
    sys.stdout.flush()
    flush(None)
    saved = os.dup(1)
    os.dup2(descriptor, 1)
    try:
        yield
    finally:
        flush(None)
        os.dup2(saved, 1)
        os.close(saved)
