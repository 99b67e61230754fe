"""IPOPT's linear solvers: all but MUMPS are libraries of others, which IPOPT loads when it first solves."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from .outcome import Status

MUMPS = "mumps"
SOLVERS = (MUMPS, "ma27", "ma57", "ma77", "ma86", "ma97", "pardiso", "pardisomkl", "spral", "wsmp")
"""Those that IPOPT may have been built to load."""
_REMEDY = "name the file that holds it: --set solver.hsllib=..., or pardisolib"
_LOADED = {
    "linear_solver": ((MUMPS,), "IPOPT cannot load the linear solver {}", f"write mumps, or {_REMEDY}"),
    "linear_system_scaling": (("none", "slack-based"), "IPOPT cannot load the scaling {}", f"write none, or {_REMEDY}"),
}
"""Option -> its values that need no library; what is said where a library is missing, and the remedy."""
_NEEDED = {"ma97": "ma97_default_control_d"}
"""Solver -> a function of its library without which IPOPT 3.14.11 crashes, and does not say that it is missing."""


def missing_libraries(options: Mapping[str, object], problem: Callable[[], Any]) -> dict[str, tuple[str, str]]:
    """Options that name a library that IPOPT cannot load -> what is wrong, and the remedy.

    options: of IPOPT, as it takes them.
    problem: makes one of cyipopt with a single unknown, which has these options; it is solved.
    """
    known = {name.lower().rpartition(".")[2]: (name, str(value).lower()) for name, value in options.items()}
    asked = {key: known[key] for key, (own, *_) in _LOADED.items() if key in known and known[key][1] not in own}
    if not asked or not (_crashes(known) or _refuses(problem())):
        return {}
    return {name: (_LOADED[key][1].format(value), _LOADED[key][2]) for key, (name, value) in asked.items()}


def _crashes(known: Mapping[str, tuple[str, str]]) -> bool:
    """Whether IPOPT would end the process where it should say that a library is missing."""
    needed = _NEEDED.get(known.get("linear_solver", ("", MUMPS))[1])
    try:
        return needed is not None and not hasattr(ctypes.CDLL(known.get("hsllib", ("", "libhsl.so"))[1]), needed)
    except OSError:
        return True


def _refuses(problem: Any) -> bool:
    """Whether IPOPT, which takes the name of any library, cannot use it once it runs."""
    problem.add_option("print_level", 0)
    _, info = problem.solve(np.array([0.5]))
    return Status.from_code(info["status"]) is Status.INVALID_OPTION
