"""Which IPOPT runs: that of cyipopt's own wheel, or the newer one in the wheel of CasADi, loaded in its place.

A problem file chooses by a word of a closed list, never by a path: it is data. A process has one of them, the first
that it loads: both have the same names, which the dynamic linker may confuse.
"""

from __future__ import annotations

import ctypes
import sys
from ctypes import c_char_p, c_void_p
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from ...problems.errors import Mistake, SpecError
from ..libraries.alone import LOCK
from .c_interface import declared

OPTION = "library"
BUNDLED, CASADI = "bundled", "casadi"
PRELOADED = {CASADI: f"{__package__}.preload_casadi"}
"""Word -> the module that has loaded it; without one the library is loaded where it is first asked for."""
FILE = "libipopt.so.3"
"""Of IPOPT in the wheel of CasADi on Linux; elsewhere the linker would go on with cyipopt's own."""


class Loaded(NamedTuple):
    """The IPOPT of this process: its word, its version, "3.14.19", and the library itself."""

    library: str
    version: str
    functions: ctypes.CDLL


_loaded: list[Loaded] = []


def load_library(wanted: str | None = None) -> ctypes.CDLL:
    """IPOPT's C interface, see `c_interface`.

    wanted: BUNDLED or CASADI; None for the one that is loaded, BUNDLED if there is none yet.

    Raises SpecError, at solver.library, if it is not installed, or another is loaded already.
    """
    with LOCK:
        if not _loaded:
            _loaded.append(_load(wanted or BUNDLED))
        if wanted not in (None, _loaded[0].library):
            what = f"this process has loaded the {_loaded[0].library} IPOPT already, and can have only one"
            raise _mistake(what, "solve this problem in a process of its own, or with that library")
    return _loaded[0].functions


def loaded() -> Loaded:
    """What `load_library` has loaded; it is called first where it was not yet."""
    load_library()
    return _loaded[0]


def _load(library: str) -> Loaded:
    if library == BUNDLED:
        functions = _bundled()
        return Loaded(library, _version_of_file(functions), functions)
    if "ipopt_wrapper" in sys.modules:
        raise _mistake("cyipopt was imported before trajopt, with an IPOPT of its own", "import it after the solve")
    try:
        functions = declared(ctypes.PyDLL(str(_casadi())))
        return Loaded(library, _version(functions), functions)
    except (OSError, AttributeError) as error:  # of another machine, or too old to tell its version
        raise _mistake("the IPOPT of the package casadi does not fit", "pip install casadi==3.8.2") from error


def _bundled() -> ctypes.CDLL:
    """IPOPT in the wheel of cyipopt, whose extension gives its functions. It is loaded as a library and not imported,
    as that would import SciPy. Raises ImportError."""
    found = find_spec("ipopt_wrapper")
    if found is None or found.origin is None:
        raise ImportError("the package cyipopt-wheels is not installed")
    try:
        return declared(ctypes.PyDLL(found.origin))
    except (OSError, AttributeError) as error:
        raise ImportError(f"the IPOPT of the package cyipopt-wheels cannot be loaded: {error}") from error


class _Place(ctypes.Structure):
    """Of dladdr: where something is loaded from."""

    _fields_ = (("file", c_char_p), ("base", c_void_p), ("name", c_char_p), ("at", c_void_p))


def _version_of_file(library: ctypes.CDLL) -> str:
    """The version in the name of its file, as libipopt.so.3.14.11 has it; before 3.14.14 no function tells it."""
    place, function = _Place(), ctypes.cast(library.IpoptSolve, c_void_p)
    ctypes.CDLL(None).dladdr(function, ctypes.byref(place))
    return (place.file or b"").decode().rpartition(".so.")[2]


def _casadi() -> Path:
    """IPOPT in the wheel of CasADi, which is not imported: that takes 60 ms. Raises SpecError."""
    found = find_spec("casadi")
    if found is None or found.origin is None:  # without an origin it is any folder of that name
        raise _mistake("the package casadi is not installed", "pip install casadi==3.8.2, or leave out library")
    path = Path(found.origin).with_name(FILE)
    if not path.is_file():
        raise _mistake("the package casadi that is installed brings no IPOPT", "pip install casadi==3.8.2, on Linux")
    return path


def _version(library: ctypes.CDLL) -> str:
    numbers = [ctypes.c_int() for _ in range(3)]
    library.GetIpoptVersion(*map(ctypes.byref, numbers))
    return ".".join(str(number.value) for number in numbers)


def _mistake(what: str, remedy: str) -> SpecError:
    return SpecError(Mistake(f"solver.{OPTION}", what, remedy))
