"""The table of engines, which solve nonlinear programs; each is imported when it is used, as SciPy takes long."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any

from ...problems.errors import Mistake
from .outcome import Outcome

MODULES = {"ipopt": "ipopt", "newton": "newton"}
"""Name in a problem file -> module of this room with `solve_program` and `check_options`, those of `ipopt`."""


def engine_solve(name: str) -> Callable[..., Outcome]:
    """The solve function of an engine, to the contract of `ipopt.solve_program`."""
    return _module(name).solve_program


def check_engine_options(name: str, options: Mapping[str, object]) -> Sequence[Mistake]:
    """What an engine does not take of its options; mistakes stand at solver.<name>."""
    return _module(name).check_options(options) if options else []


def _module(name: str) -> Any:
    return import_module(f".{MODULES[name]}", __package__)
