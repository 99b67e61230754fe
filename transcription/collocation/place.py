"""Where the functions of a problem are evaluated, and the values that they get there."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.quantities import State
from ..constraint_kinds import BOUND, ConstraintKind
from ..program.templates import item


@dataclass(frozen=True)
class Place:
    """Points that one rule reaches.

    over: the Set of the rule's index, or None for a single point. values: index -> the values at that point, by name.
    weight: index -> its quadrature weight in time. points: (M,) the numbers of the points, and quadrature: (M,) their
    weights for a phase of duration 1. computed: the states that are no variables there. asked: the kind of the rows
    that hold them to a range of theirs.
    """

    name: str
    over: Any
    values: Callable[[Any], dict]
    weight: Callable[[Any], Any]
    points: np.ndarray
    quadrature: np.ndarray
    computed: Sequence[State] = ()
    asked: ConstraintKind = BOUND


class Values(dict):
    """Names -> Pyomo items, made when they are asked for: a defect asks for few of them, at several points."""

    def __init__(self, makers: Mapping[str, tuple[Any, str]], k: Any, time: Callable[[Any], Any]) -> None:
        super().__init__()
        self.makers, self.k, self.time = makers, k, time

    def __missing__(self, name: str) -> Any:
        if name == "t":
            self[name] = self.time(self.k)
        else:
            component, key = self.makers[name]
            self[name] = item(component, key, self.k)
        return self[name]

    def names(self) -> list[str]:
        """All names but t."""
        return [*self.makers, *(name for name in self if name != "t" and name not in self.makers)]
