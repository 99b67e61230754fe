"""The door through which every result file is opened: it is foreign data until it is as the layout declares."""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from io import BytesIO
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import Any

import h5py

from ...problems.catalog import shipped
from ...problems.errors import FileError, Mistake, SpecError
from ...problems.files import reason_of
from ...problems.text import shorten
from ..declared.conform import Conformance, SymbolValues
from ..declared.layout import HEAD, RESULT, VERSION
from ..declared.nodes import LayoutError, endless
from ..declared.words import Group

FORMAT, FORMAT_VERSION = "trajopt result", 1
DEEPEST = 50  # levels of the stored problem
DIGITS = 300  # of a whole number that is a float, too

PROBLEM_FILES, SWEEP = (".yaml", ".yml"), "sweep.json"
ANOTHER = "give a result written by 'trajopt solve'"
DAMAGED = "it is damaged, or another version of trajopt wrote it: solve the problem again"

_HDF5_ERRORS = (OSError, RuntimeError, ValueError, KeyError, TypeError, OverflowError)
"""What h5py makes of a structure that is damaged."""


@contextmanager
def open_result(source: Path | bytes, layout: Group = RESULT) -> Iterator[h5py.File]:
    """A result file, or the content of one, open for reading and as the layout says.

    source: path, or content.
    layout: what it must have; the whole of it, if none is given.

    Raises FileError if it cannot be read or is no result of this version; also out of the block, if the values that are
    read there do not have their check sum. Raises SpecError if it is a problem.
    """
    path = Path("the solution") if isinstance(source, bytes) else source
    size = len(source) if isinstance(source, bytes) else _size(path)
    try:
        if _endless(source):
            raise FileError(Mistake(str(path), "its texts cannot be read", DAMAGED))
        file = h5py.File(BytesIO(source) if isinstance(source, bytes) else source, "r")
    except _HDF5_ERRORS as error:
        if path.suffix.lower() in PROBLEM_FILES:
            raise SpecError(_a_problem(str(path), str(path))) from error
        raise FileError(_unopened(path, error)) from error
    with file:
        _check(file, path, size, layout)
        try:
            yield file
        except (OSError, RuntimeError) as error:  # of HDF5: a block does nothing but read
            raise FileError(Mistake(str(path), "its values cannot be read", DAMAGED)) from error


def hdf5_version() -> str:
    """Of the library that reads and writes results."""
    return str(h5py.version.hdf5_version)


def head_of_file(path: Path) -> dict[str, Any]:
    """Whose result a file is, "problem", and whether it is a solution, "solved"; nothing if it is no result."""
    try:
        with open_result(path, HEAD) as file:
            return {name: file.attrs[name] for name in HEAD.attributes}
    except (FileError, SpecError):
        return {}


def stored_problem(file: h5py.File) -> dict[str, Any]:
    """The problem file that an open result holds, full, as plain data. Raises FileError if it is none."""
    try:
        data = json.loads(file["spec/full"].asstr()[()], parse_int=_whole)
    except (ValueError, RecursionError):
        data = None
    if not isinstance(data, dict) or _deeper(data, DEEPEST):
        raise FileError(Mistake(f"{file.filename}: /spec/full", "it holds no problem that can be read", DAMAGED))
    return data


def _whole(digits: str) -> int | float:
    """A number without a point; one that no float holds is infinite, which no problem file may have."""
    return int(digits) if len(digits) <= DIGITS else float(digits)


def _size(path: Path) -> int:
    """Of a file that can be opened without waiting for anything."""
    try:
        found = os.stat(path)
    except OSError as error:
        if isinstance(error, FileNotFoundError):
            raise _missing(path) from error
        what = f"it cannot be read ({reason_of(error)})"
        raise FileError(Mistake(str(path), what, ANOTHER)) from error
    if (path / SWEEP).is_file():
        what = "it is the folder of a sweep, not one result"
        raise SpecError(Mistake(str(path), what, f"make a page of it: trajopt report {path}; its table is index.csv"))
    if not stat.S_ISREG(found.st_mode):
        what = "it is a folder" if stat.S_ISDIR(found.st_mode) else "it is no ordinary file"
        raise FileError(Mistake(str(path), what, ANOTHER))
    return found.st_size


def _missing(path: Path) -> FileError | SpecError:
    """Of a name that no file has: SpecError if it means a problem."""
    result, problems = path.with_name(f"{path.name}.h5"), [path.with_name(path.name + own) for own in PROBLEM_FILES]
    if result.is_file():
        return FileError(Mistake(str(path), "there is no such file", f"did you mean {result}?"))
    if problem := next((str(own) for own in problems if own.is_file()), str(path) if str(path) in shipped() else ""):
        return SpecError(_a_problem(str(path), problem))
    return FileError(Mistake(str(path), "there is no such file", ANOTHER))


def _a_problem(given: str, file: str) -> Mistake:
    return Mistake(given, "this is a problem, not a result", f"solve it first: trajopt solve {file}")


def _endless(source: Path | bytes) -> bool:
    """Whether HDF5 would not come back from the file."""
    if isinstance(source, bytes):
        return endless(source)
    with source.open("rb") as stream:
        if not os.fstat(stream.fileno()).st_size:
            return False
        with mmap(stream.fileno(), 0, access=ACCESS_READ) as content:
            return endless(content)


def _unopened(path: Path, error: Exception) -> Mistake:
    """Why HDF5 does not open a file."""
    if isinstance(error, PermissionError):
        return Mistake(str(path), "it cannot be read (permission denied)", "check its permissions")
    if isinstance(error, BlockingIOError) or "already open for" in str(error):
        return Mistake(str(path), "another program has it open for writing", "wait until that has closed it")
    return Mistake(str(path), "it cannot be read as HDF5", ANOTHER)


def _check(file: h5py.File, path: Path, size: int, layout: Group) -> None:
    """Raise FileError if it is no result, one of a newer version, or not as the layout says."""
    try:
        _check_format(file, path, size)
        Conformance(size).group(file.id, layout, SymbolValues())
        if layout is RESULT:
            _check_meshes(file)
    except LayoutError as error:
        where = f"{path}: {shorten(error.where)}"
        raise FileError(Mistake(where, error.what, DAMAGED)) from error
    except _HDF5_ERRORS as error:
        raise FileError(Mistake(str(path), "its structure cannot be read", DAMAGED)) from error


def _check_meshes(file: h5py.File) -> None:
    """Raise LayoutError if a mesh of several phases is one of one phase, or the reverse."""
    several = len(file["phase"]) > 1
    for number, mesh in file["mesh"].items():
        if ("phase" in mesh) != several:
            raise LayoutError(f"/mesh/{number}", "it is the mesh of another number of phases")


def _check_format(file: h5py.File, path: Path, size: int) -> None:
    try:
        known = str(file.attrs.get("format")) == FORMAT
    except _HDF5_ERRORS:
        known = False
    if not known:
        raise FileError(Mistake(str(path), "it is no trajopt result", "give a file written by 'trajopt solve'"))
    Conformance(size).group(file.id, VERSION, SymbolValues())
    version = int(file.attrs["format_version"])
    if version > FORMAT_VERSION:
        what = f"it has format version {version}, this trajopt reads up to {FORMAT_VERSION}"
        raise FileError(Mistake(str(path), what, "update trajopt"))
    if version < 1:
        raise FileError(Mistake(str(path), f"there is no format version {version}", DAMAGED))


def _deeper(data: Mapping[str, Any] | list[Any], levels: int) -> bool:
    """Whether plain data are nested deeper than so many levels."""
    level: list[Any] = [data]
    for _ in range(levels):
        inner = (own.values() if isinstance(own, dict) else own for own in level)
        level = [item for items in inner for item in items if isinstance(item, dict | list)]
    return bool(level)
