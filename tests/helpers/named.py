"""Shipped problems by their names, and the methods of the table by their kinds."""

import os
from collections.abc import Sequence
from itertools import product
from typing import Any, TypeVar

from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load
from trajopt.problems.problem import Problem
from trajopt.transcription.schemes.scheme import Scheme
from trajopt.transcription.schemes.table import METHODS, find

ALL = bool(os.environ.get("TRAJOPT_SLOW"))
"""Whether the tests do all that they can, however long it takes."""

COLLOCATION = [name for name in METHODS if isinstance(find(name), Scheme)]
FAMILIES = [name for name, method in METHODS.items() if method.nodes]
"""Those that take a degree."""


T = TypeVar("T")


def share(items: Sequence[T], of: int, first: int = 0) -> list[T]:
    """One of so many items, from the first on; all of them where TRAJOPT_SLOW is set."""
    return list(items if ALL else items[first::of])


def crossed(*axes: Sequence[Any]) -> list[tuple[Any, ...]]:
    """Tuples in which every item of every axis stands at least once; all that there are where TRAJOPT_SLOW is set."""
    if ALL:
        return list(product(*axes))
    rows = range(max(map(len, axes)))
    return [tuple(axis[row % len(axis)] for axis in axes) for row in rows]


def problem_named(name: str, *overrides: str) -> Problem:
    return build(load(shipped()[name], overrides))
