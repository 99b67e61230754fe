"""The cases of a sweep: axes -> a grid, axes gone through together, the lines of a table, or a sample."""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from ...problems.errors import FileError, Mistake, SpecError
from ...problems.files import reason_of
from ...problems.lean.records import dataclass
from ...problems.schema.solving import MAX_CASES
from ...problems.text import brief
from .axes import Axis

FARTHEST = 2.0
"""Of a step: what a line through two cases is believed for, beyond the second."""

GRID, ZIP, LIST, SAMPLE = "grid", "zip", "list", "sample"


@dataclass(frozen=True)
class Plan:
    """The cases, numbered from 0; a grid in the order of its axes, the last one fastest.

    design: GRID, whose axes are its dimensions; or ZIP, LIST, SAMPLE, whose axes have one value for each case.
    """

    design: str
    axes: tuple[Axis, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        lengths = tuple(len(axis.values) for axis in self.axes)
        return lengths if self.design == GRID else lengths[:1]

    def __len__(self) -> int:
        return prod(self.shape)

    @property
    def paths(self) -> list[str]:
        return [axis.path for axis in self.axes]

    @property
    def ordered(self) -> bool:
        """Whether a case is like the one before it."""
        return self.design in (GRID, ZIP)

    def place(self, number: int) -> tuple[int, ...]:
        """The index of a case along each axis."""
        if self.design == GRID:
            return tuple(int(i) for i in np.unravel_index(number, self.shape))
        return (number,) * len(self.axes)

    def number(self, place: Sequence[int]) -> int:
        """The other way round, for a grid."""
        return int(np.ravel_multi_index(tuple(place), self.shape))

    def values(self, number: int) -> dict[str, str]:
        """Path -> value, as YAML, of a case."""
        return {axis.path: axis.values[i] for axis, i in zip(self.axes, self.place(number), strict=True)}

    def overrides(self, number: int) -> list[str]:
        return [f"{path}={value}" for path, value in self.values(number).items()]

    def before(self, number: int) -> int | None:
        """The neighbour that a chained case starts from: the one before along the last axis; for the first of a line,
        the first of the line before. None for the very first.
        """
        if number == 0:
            return None
        if self.design != GRID:
            return number - 1
        place = list(self.place(number))
        axis = max(axis for axis, i in enumerate(place) if i)
        place[axis] -= 1
        return self.number(place)

    def share(self, earlier: int, before: int, number: int) -> float | None:
        """The step to a case from the one before it, as a part of the step that led to that; None where the three are
        not on one line of numbers, or it leads back, or farther than FARTHEST.

        earlier, before, number: of cases, each the neighbour of the next.
        """
        places = [self.values(own) for own in (earlier, before, number)]
        varied = [path for path in self.paths if len({place[path] for place in places}) > 1]
        try:
            first, second, third = (float(place[path]) for path in varied for place in places)
        except ValueError:  # several are varied, or what is has no numbers
            return None
        share = (third - second) / (second - first) if second != first else 0.0
        return share if 0 < share <= FARTHEST else None


def stored_plan(about: Mapping[str, Any], where: str) -> Plan:
    """The plan that `store.about` has kept.

    about: as a file has it.
    where: of the file, for the message.

    Raises SpecError for what is none.
    """
    try:
        axes = tuple(Axis(str(own["path"]), tuple(map(str, own["values"]))) for own in about["axes"])
        plan = Plan(str(about["design"]), axes)
        alike = plan.design == GRID or len({len(axis.values) for axis in axes}) == 1
        sound = bool(axes) and plan.design in (GRID, ZIP, LIST, SAMPLE) and alike and 0 < len(plan) <= MAX_CASES
    except (KeyError, TypeError, ValueError):
        sound = False
    if not sound:
        raise SpecError(Mistake(where, "it holds no plan of a sweep", "give the folder of a 'trajopt sweep'"))
    return plan


def grid(axes: Sequence[Axis]) -> Plan:
    """Every combination. Raises SpecError for a path that is given twice, and for too many cases."""
    return _checked(Plan(GRID, tuple(axes)))


def zipped(axes: Sequence[Axis]) -> Plan:
    """The first values of all axes, then the second ones, ... Raises SpecError where their numbers differ."""
    lengths = {len(axis.values) for axis in axes}
    if len(lengths) > 1:
        told = ", ".join(f"{axis.path} has {len(axis.values)}" for axis in axes)
        raise SpecError(Mistake("--zip", f"the axes have different numbers of values: {told}", "give as many of each"))
    return _checked(Plan(ZIP, tuple(axes)))


def sampled(axes: Sequence[Axis], count: int, seed: int) -> Plan:
    """A Latin hypercube: each range is cut into as many parts as there are cases, and each part has one case.

    axes: the COUNT of a range has no meaning here; the values of a list come up equally often.
    count: number of cases.
    seed: the same one gives the same cases.
    """
    from scipy.stats import qmc

    _checked(Plan(ZIP, tuple(replace(axis, values=axis.values[:1]) for axis in axes)))
    shares = qmc.LatinHypercube(len(axes), seed=np.random.default_rng(seed)).random(count)
    drawn = []
    for axis, share in zip(axes, shares.T, strict=True):
        if axis.span:
            values = [repr(number) for number in axis.span.at(share)]
        else:
            values = [axis.values[int(i)] for i in share * len(axis.values)]
        drawn.append(replace(axis, values=tuple(values)))
    return Plan(SAMPLE, tuple(drawn))


def listed_in_file(path: Path) -> Plan:
    """The cases of a CSV file: paths in its first line, one case in each other line.

    Raises FileError if it cannot be read, SpecError for what is no such table.
    """
    try:
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError as error:
        raise FileError(Mistake(str(path), "there is no such file", "give a CSV file with --list")) from error
    except OSError as error:
        what = f"the file cannot be read ({reason_of(error)})"
        raise FileError(Mistake(str(path), what, "give a CSV file with --list")) from error
    except UnicodeDecodeError as error:
        raise SpecError(Mistake(str(path), "this is not UTF-8 text", "save the table as CSV in UTF-8")) from error
    reader = csv.reader(text.splitlines(), skipinitialspace=True)
    rows = [(reader.line_num, [cell.strip() for cell in row]) for row in reader if any(cell.strip() for cell in row)]
    if len(rows) < 2:
        what = "the file has no cases"
        raise SpecError(Mistake(str(path), what, "write paths in its first line, and a case in each other line"))
    (_, paths), *cases = rows
    _check_table(path, paths, cases)
    columns = zip(*(values for _, values in cases), strict=True)
    return _checked(Plan(LIST, tuple(map(Axis, paths, columns))))


def _check_table(path: Path, paths: list[str], cases: list[tuple[int, list[str]]]) -> None:
    if "" in paths:
        raise SpecError(Mistake(f"{path}:1", "a column has no path", "write a path such as parameters.u_max above it"))
    known: dict[tuple[str, ...], int] = {}
    for line, values in cases:
        if len(values) != len(paths) or "" in values:
            what = f"the line has {len(values)} values" if len(values) != len(paths) else "a value is missing"
            raise SpecError(Mistake(f"{path}:{line}", what, f"give one for each of the {len(paths)} paths"))
        if tuple(values) in known:
            what = f"the case is that of line {known[tuple(values)]} again"
            raise SpecError(Mistake(f"{path}:{line}", what, "remove one of them"))
        known[tuple(values)] = line


def _checked(plan: Plan) -> Plan:
    path, times = Counter(plan.paths).most_common(1)[0]
    if times > 1:
        raise SpecError(Mistake(f"--over {path}", "the path is given twice", "give all its values at once"))
    bad = next((path for path in plan.paths if "=" in path), None)
    if bad:
        raise SpecError(Mistake(f"--over {brief(bad)}", "this is not a path", "write parameters.u_max"))
    if len(plan) > MAX_CASES:
        what = f"the grid has {len(plan)} cases"
        raise SpecError(Mistake("--over", what, f"sweep at most {MAX_CASES}, or draw a --sample of them"))
    return plan
