"""Mistakes in the cases of a sweep, told once each and with the axis, before anything is solved."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from ...problems.errors import Mistake, SpecError
from .plan import GRID, SAMPLE, Plan

MAX_LISTED = 200
"""Cases of one axis that are looked at before the first is solved; workers look at all the others."""

MAX_TOLD = 10


def looked_at(plan: Plan) -> list[int]:
    """The cases that find nearly all mistakes: each value of a list, and the ends and the middle of each range.

    Each is looked at with the first values of the other axes of a grid: as many as the axes are long together.
    """
    if plan.design == SAMPLE:
        numbers = [np.argsort([float(v) if axis.span else 0 for v in axis.values])[[0, -1]] for axis in plan.axes]
        return sorted({0, *(int(i) for ends in numbers for i in ends)})
    if plan.design != GRID:
        return _chosen(len(plan), all(axis.span for axis in plan.axes))
    cases = {0}
    for position, axis in enumerate(plan.axes):
        for i in _chosen(len(axis.values), axis.span is not None):
            cases.add(plan.number([i if k == position else 0 for k in range(len(plan.axes))]))
    return sorted(cases)


def check_cases(plan: Plan, load: Callable[[list[str]], object]) -> None:
    """Load the cases of `looked_at`. Raises SpecError with what is wrong in them, each mistake once."""
    found: dict[tuple[str, str], Mistake] = {}
    for number in looked_at(plan):
        try:
            load(plan.overrides(number))
        except SpecError as error:
            for mistake in error.mistakes:
                found.setdefault((mistake.what, mistake.remedy), in_case(mistake, plan.values(number)))
    if found:
        told = list(found.values())
        more = Mistake("--over", f"there are {len(told) - MAX_TOLD} more mistakes like these", "mend these first")
        raise SpecError([*told[:MAX_TOLD], *([more] if len(told) > MAX_TOLD else [])])


def in_case(mistake: Mistake, values: Mapping[str, str]) -> Mistake:
    """The mistake with the axis and its value, or with all values of the case if it stands elsewhere in the file."""
    path = mistake.where.removeprefix("--set ")
    if mistake.where.startswith("--set ") and path in values:
        return replace(mistake, where=f"--over {path}={values[path]}")
    case = ", ".join(f"{path}={value}" for path, value in values.items())
    return replace(mistake, where=f"--over {case}: {mistake.where}")


def _chosen(length: int, of_range: bool) -> list[int]:
    """Indices along an axis."""
    count = 3 if of_range else MAX_LISTED
    return sorted({int(i) for i in np.linspace(0, length - 1, min(count, length))})
