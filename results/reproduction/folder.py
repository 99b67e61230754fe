"""The folder that `trajopt reproduce` fills: made, or known as its own by the page in it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ...problems.errors import FileError, Mistake
from ...problems.files import check_writable, write_whole
from .page import MARK

FIGURES, RESULTS, INDEX = "figures", "results", "index.html"


def claim(folder: Path, parts: Sequence[str]) -> None:
    """Make a folder and those in it, or make sure that it is one of ours. Raises FileError."""
    try:
        foreign = folder.exists() and (not folder.is_dir() or (any(folder.iterdir()) and not _is_ours(folder)))
        if foreign:
            what = "it exists and was not made by 'trajopt reproduce'"
            raise FileError(Mistake(str(folder), what, "choose another folder with -o"))
        for part in parts:
            (folder / part).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        what = f"this folder cannot be made or read ({error.strerror})"
        raise FileError(Mistake(str(folder), what, "choose another folder with -o")) from error


def _is_ours(folder: Path) -> bool:
    """Whether the page in a folder says that it was written here."""
    index = folder / INDEX
    return index.is_file() and MARK in index.read_text(encoding="utf-8", errors="replace")


def write_text(path: Path, text: str) -> None:
    """Write a text file whole, or leave the older one. Raises FileError."""
    check_writable(path)
    write_whole(path, text)
