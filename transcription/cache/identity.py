"""What everything in the cache depends on besides its content: the program, its libraries, Python, and the processor.

Files are told by size and time, without reading them, and libraries are found without importing them: this takes
2 ms, and a changed file makes another identity even where the version stays.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from functools import cache
from hashlib import blake2b
from importlib.util import find_spec
from pathlib import Path

from ...problems.lean.versions import names_in

LIBRARIES = ("numpy", "scipy", "pydantic", "pydantic_core", "pyomo", "symengine", "yaml")
BINARY = "lib"  # the folder of SymEngine, with LLVM in it
PROCESSOR = Path("/proc/cpuinfo")
TOLD = (b"vendor_id", b"cpu family", b"model", b"stepping", b"flags", b"CPU ", b"Features")
"""Lines that tell one kind of processor from another, on x86 and on ARM; others change by the second."""


@cache
def identity() -> bytes | None:
    """All of it; None where it cannot be told, and nothing is to be kept."""
    try:
        own = Path(__file__).parents[1]
        files = [*_files(str(own), ".py"), *_files(str(_problems()), ".py")]
        told = [sys.version, os.uname().machine, _processor(), files, [_library(name) for name in LIBRARIES]]
    except (OSError, ImportError):
        return None
    return blake2b(repr(told).encode()).digest()


def _problems() -> Path:
    from ... import problems

    return Path(problems.__path__[0])


def _library(name: str) -> list:
    """The place, the versions that are installed beside it, and the files that differ between them."""
    spec = find_spec(name)
    if spec is None or not spec.submodule_search_locations:
        return []
    folder = spec.submodule_search_locations[0]
    beside, _ = os.path.split(folder)
    versions = [own for own in names_in(beside) if own.startswith(f"{name}-")]
    binaries = list(_files(os.path.join(folder, BINARY), ".so")) if name == "symengine" else []
    return [folder, sorted(versions), _file(spec.origin or folder), binaries]


def _files(folder: str, suffix: str) -> Iterator[tuple[str, int, int]]:
    with os.scandir(folder) as found:
        for own in sorted(found, key=lambda own: own.name):
            if own.is_dir(follow_symlinks=False):
                if own.name != "__pycache__":
                    yield from _files(own.path, suffix)
            elif own.name.endswith(suffix):
                yield _file(own.path)


def _file(path: str) -> tuple[str, int, int]:
    found = os.stat(path)
    return path, found.st_size, found.st_mtime_ns


def _processor() -> bytes:
    """The kind of the first processor. Raises OSError where the system does not tell."""
    with PROCESSOR.open("rb") as lines:
        first = lines.read(8192).partition(b"\n\n")[0]
    told = [line for line in first.splitlines() if line.startswith(TOLD)]
    if not any(b"flags" in line or b"Features" in line for line in told):
        raise OSError("the system does not tell what its processor can do")
    return b"\n".join(told)
