"""Which IPOPT runs: that of cyipopt's own wheel, or the newer one in the wheel of CasADi, loaded in its place.

A problem file chooses by a word of a closed list, never by a path: it is data. A process has one of them, the first
that it loads, as the dynamic linker binds cyipopt to whatever has IPOPT's names by then.
"""

from __future__ import annotations

import ctypes
import sys
from contextlib import nullcontext
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

from ...problems.errors import Mistake, SpecError
from ...problems.lean.hidden import hidden
from ..libraries.alone import LOCK

OPTION = "library"
BUNDLED, CASADI = "bundled", "casadi"
PRELOADED = {CASADI: f"{__package__}.preload_casadi"}
"""Word -> the module that has loaded it; without one the library is loaded where it is first asked for."""
FILE = "libipopt.so.3"
"""Of IPOPT in the wheel of CasADi on Linux; elsewhere the linker would go on with cyipopt's own."""


class Loaded(NamedTuple):
    """The IPOPT of this process: its word, and its version, "3.14.19"."""

    library: str
    version: str


_loaded: list[Loaded] = []


def load_library(wanted: str | None = None) -> Any:
    """The module cyipopt, bound to an IPOPT.

    wanted: BUNDLED or CASADI; None for the one that is loaded, BUNDLED if there is none yet.

    Raises SpecError, at solver.library, if it is not installed, or another is loaded already.
    """
    with LOCK:
        if not _loaded:
            _loaded.append(_load(wanted or BUNDLED))
        if wanted not in (None, _loaded[0].library):
            what = f"this process has loaded the {_loaded[0].library} IPOPT already, and can have only one"
            raise _mistake(what, "solve this problem in a process of its own, or with that library")
        import cyipopt
    return cyipopt


def loaded() -> Loaded:
    """What `load_library` has loaded; it is called first where it was not yet."""
    load_library()
    return _loaded[0]


def _load(library: str) -> Loaded:
    if library == CASADI:
        if "ipopt_wrapper" in sys.modules:
            raise _mistake("cyipopt was imported before trajopt, with an IPOPT of its own", "import it after the solve")
        path = str(_casadi())
        try:
            version = _version(ctypes.CDLL(path))
            ctypes.CDLL(path, ctypes.RTLD_GLOBAL)  # before cyipopt, which then finds it first
        except (OSError, AttributeError) as error:  # of another machine, or too old to tell its version
            raise _mistake("the IPOPT of the package casadi does not fit", "pip install casadi==3.8.2") from error
        _import()
        return Loaded(library, version)
    return Loaded(library, ".".join(map(str, _import().IPOPT_VERSION)))


def _import() -> Any:
    """Import cyipopt without scipy.optimize, unless SciPy is loaded.

    cyipopt imports it for `minimize_ipopt`, which trajopt does not use: 0.45 s of a 1 s run.
    """
    with nullcontext() if "scipy" in sys.modules else hidden("scipy", absent=True):
        import cyipopt
    return cyipopt


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
