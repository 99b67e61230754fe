"""What this installation of trajopt is made of, what it can do, and what is missing for the rest."""

from __future__ import annotations

import os
import platform
import shutil
import sys
from collections.abc import Callable, Iterator
from importlib.metadata import PackageNotFoundError, requires, version
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

from ..transcription.cache.folder import place

ENVIRONMENT = (
    "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "PYTHONPATH", "PYTHONOPTIMIZE", "PYTHONUTF8",
    "PYTHONIOENCODING", "MPLBACKEND", "MPLCONFIGDIR", "TMPDIR", "TRAJOPT_CACHE", "LD_LIBRARY_PATH", "LANG",
    "LC_ALL", "TERM",
)  # fmt: skip
"""Variables that change what trajopt does."""


class OptionalPart(NamedTuple):
    """What trajopt can do without: what it gives, what it needs, and how to get that."""

    gives: str
    packages: tuple[str, ...]
    programs: tuple[str, ...]
    remedy: str


PARTS = {
    "films": OptionalPart("MP4 films (GIF without)", (), ("ffmpeg",), "install the program ffmpeg"),
    "tables": OptionalPart("Parquet tables (CSV without)", ("pandas", "pyarrow"), (), "pip install pandas pyarrow"),
    "datasets": OptionalPart("results in xarray", ("xarray", "h5netcdf"), (), "pip install xarray h5netcdf"),
    "fast": OptionalPart("a faster IPOPT: solver.library=casadi", ("casadi",), (), "pip install casadi==3.8.2"),
    "cluster": OptionalPart("sweeps on a Dask cluster", ("distributed",), (), "pip install distributed"),
}


def processors() -> int:
    """How many processors this process may use; all of the machine where the system does not say which."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def installation(load: bool = True) -> dict[str, Any]:
    """Versions, libraries and optional parts of this installation, as plain data.

    load: whether to ask the libraries themselves; one that is broken may end the process.

    The keys: "trajopt", "folder", "python", "system", "environment"; "packages", name -> version, None for one that is
    missing; "misfits", a sentence for each package that is missing or of a version that trajopt does not work with;
    "ipopt" and "hdf5", versions; "linear_solvers", name -> whether it works; "derivatives", "llvm" or "lambda";
    "caches", whose -> folder; "parts", name -> what it gives, what is missing and the remedy; "unusable", key -> why
    there is None in its place.
    """
    packages = dict(_packages())
    unusable: dict[str, str] = {}

    def asked(key: str, ask: Callable[[], Any]) -> Any:
        try:
            return ask() if load else None
        except Exception as error:  # of a library that is broken, which may raise anything
            unusable[key] = f"{type(error).__name__}: {error}"
            return None

    return {
        "trajopt": version("trajopt"),
        "folder": str(Path(__file__).parents[1]),
        "python": f"{platform.python_version()}, {sys.executable}",
        "system": f"{platform.platform()}, {processors()} processors",
        "environment": {name: os.environ[name] for name in ENVIRONMENT if name in os.environ},
        "packages": packages,
        "misfits": list(_misfits(packages)),
        "ipopt": asked("ipopt", _ipopt),
        "linear_solvers": asked("linear_solvers", _linear_solvers),
        "hdf5": asked("hdf5", _hdf5),
        "derivatives": asked("derivatives", _derivatives),
        "caches": {"trajopt": str(place() or ""), "matplotlib": asked("caches", _cache_of_matplotlib)},
        "parts": {name: _part(part) for name, part in PARTS.items()},
        "unusable": unusable,
    }


def _requirements() -> Iterator[Any]:
    """What trajopt itself requires, without its optional parts."""
    from packaging.requirements import Requirement

    parsed = (Requirement(text) for text in requires("trajopt") or ())
    return (own for own in parsed if own.marker is None or own.marker.evaluate({"extra": ""}))


def _packages() -> Iterator[tuple[str, str | None]]:
    for own in _requirements():
        try:
            yield own.name, version(own.name)
        except PackageNotFoundError:
            yield own.name, None


def _misfits(found: dict[str, str | None]) -> Iterator[str]:
    for own in _requirements():
        there = found[own.name]
        if there is None or not own.specifier.contains(there, prereleases=True):
            what = "is missing" if there is None else f"has version {there}"
            yield f"{own.name} {what}: pip install '{own}'"


def _ipopt() -> str:
    from ..transcription.engines.ipopt_library import loaded

    return loaded().version


def _linear_solvers() -> dict[str, bool]:
    from ..transcription.engines.ipopt import check_options
    from ..transcription.engines.linear_solvers import SOLVERS

    return {name: not check_options({"linear_solver": name}) for name in SOLVERS}


def _hdf5() -> str:
    from .file.door import hdf5_version

    return hdf5_version()


def _derivatives() -> str:
    from ..transcription.program.backend import available_backend

    return available_backend()


def _cache_of_matplotlib() -> str:
    """Where it keeps the list of fonts; it makes itself a temporary folder if it may not write there."""
    from matplotlib import get_cachedir

    return get_cachedir()


def _part(part: OptionalPart) -> dict[str, Any]:
    missing = [name for name in part.packages if find_spec(name) is None]
    missing += [name for name in part.programs if shutil.which(name) is None]
    return {"gives": part.gives, "missing": missing, "remedy": part.remedy if missing else ""}
