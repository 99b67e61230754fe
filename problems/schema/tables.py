"""Tables of data in a problem file: points of one, two or three arguments, and the values there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import Field, PlainValidator, WithJsonSchema

from ..expressions.signature import function_names
from ..tables.choices import ERROR, LINEAR, MAX_ARGUMENTS, MAX_VALUES, MONOTONE, WAYS
from ..text import brief, did_you_mean
from ..yaml.document import Path, in_words
from .declarations import NOTE, UNIT
from .fields import Entry, Text, mistake, number

if TYPE_CHECKING:  # tables import SciPy
    from ..tables.table import Table

_KINK = (
    "straight lines have a kink at every point, and a kink inside a segment takes the order from the method and the "
    "convergence from Newton's (Kelly 2017, section 5.5)"
)
_NO_KINK = (
    "write kind: cubic, or say by smooth: over which distance from a point its kink is rounded, in the argument's unit"
)


class Wrong(NamedTuple):
    """A mistake in a table: where below it, what, and the remedy."""

    path: Path
    what: str
    remedy: str


def _points(value: Any) -> list[float]:
    if not isinstance(value, list):
        raise mistake(f"this must be a list of numbers, not {in_words(value)}", "write for example [0, 0.5, 1]")
    points = [number(point) for point in value]
    if len(points) < 2:
        raise mistake(f"there {'is one point' if points else 'are no points'} here", "give at least two")
    for i, (before, after) in enumerate(pairwise(points)):
        if after <= before:
            what = f"the points do not increase: entry {i + 2} is {after:g}, after {before:g}"
            raise mistake(what, "sort them, and the values with them; each must be larger than the one before")
    return points


def _grid(value: Any) -> list[Any]:
    if not isinstance(value, list) or not value:
        remedy = "write a list of numbers, for two arguments a list of such lists"
        raise mistake(f"the values are {in_words(value)}", remedy)
    rows: list[Any] = _row(value, ())
    return rows


def _row(value: Any, at: tuple[int, ...]) -> Any:
    """The numbers at a place of the grid: one, or lists of them that are all of one shape."""
    if not isinstance(value, list):
        try:
            return number(value)
        except ValueError as error:
            where = f"value {' of row '.join(str(i + 1) for i in reversed(at))}"
            raise mistake(f"{where} is {in_words(value)}", "write a finite number such as 0.5 or 1e4") from error
    if len(at) == MAX_ARGUMENTS:
        raise mistake(f"the values are lists in lists, more than {MAX_ARGUMENTS} deep", "a table has up to 3 arguments")
    rows = [_row(own, (*at, i)) for i, own in enumerate(value)]
    shapes = [np.shape(row) for row in rows]
    if odd := next((i for i, shape in enumerate(shapes) if shape != shapes[0]), None):
        what = f"row {odd + 1} of the values has the shape {_shape(shapes[odd])}, row 1 {_shape(shapes[0])}"
        raise mistake(what, "give all rows the same number of values")
    return rows


def _shape(shape: tuple[int, ...]) -> str:
    return " x ".join(map(str, shape)) or "of a number"


def _outside(value: Any) -> str | dict[str, str]:
    for way in value.values() if isinstance(value, dict) else [value]:
        if way not in WAYS:
            remedy = "write error, hold or extrapolate, or one of these for each argument: {h: hold}"
            raise mistake(f"{in_words(way)} is not what can be done outside", remedy)
    return {str(name): way for name, way in value.items()} if isinstance(value, dict) else value


def _smooth(value: Any) -> float | dict[str, float]:
    given = {str(name): number(own) for name, own in value.items()} if isinstance(value, dict) else {"": number(value)}
    if not given or min(given.values()) <= 0:
        what = f"the distance over which kinks are rounded is {min(given.values()):g}" if given else "nothing is given"
        raise mistake(what, "write a positive number, or one for each argument: {h: 100}")
    return given if isinstance(value, dict) else given[""]


_LIST = {"type": "array", "items": {"type": "number"}, "minItems": 2}
_WAY = {"enum": list(WAYS)}

if TYPE_CHECKING:
    Points = list[float]
    Values = list[Any]
    Outside = str | dict[str, str]
    Smooth = float | dict[str, float]
else:
    Points = Annotated[Any, PlainValidator(_points), WithJsonSchema(_LIST)]
    Values = Annotated[Any, PlainValidator(_grid), WithJsonSchema({"type": "array"})]
    Outside = Annotated[
        Any,
        PlainValidator(_outside),
        WithJsonSchema({"anyOf": [_WAY, {"type": "object", "additionalProperties": _WAY}]}),
    ]
    Smooth = Annotated[
        Any,
        PlainValidator(_smooth),
        WithJsonSchema({"anyOf": [{"type": "number"}, {"type": "object", "additionalProperties": {"type": "number"}}]}),
    ]


class TableEntry(Entry):
    """A table of data that expressions call like a function: points and values here, or in a CSV file beside this."""

    points: dict[str, Points] | None = Field(None, description="argument -> its points, increasing; up to 3 arguments")
    values: Values | None = Field(
        None, description="values at the points: a list; for two arguments a list of lists, the first argument's first"
    )
    file: Text | None = Field(None, description="CSV file in the folder of this file, instead of points: and values:")
    arguments: list[Text] | None = Field(None, description="columns of the CSV file that are arguments, in their order")
    value: Text | None = Field(None, description="column of the CSV file that holds the values")
    kind: Literal["cubic", "monotone", "linear"] = Field(
        "cubic", description="cubic: C2 spline (default); monotone: PCHIP, C1 only; linear: needs smooth:"
    )
    outside: Outside = Field(
        ERROR, description="beyond the points: error (default: the argument is bounded), hold or extrapolate"
    )
    smooth: Smooth | None = Field(None, description="for linear: distance from a point over which its kink is rounded")
    unit: Text = Field("", description=UNIT)
    units: dict[str, Text] = Field({}, description="argument -> its unit, a text")
    source: Text = Field("", description="where the numbers are from; default the CSV file")
    note: Text = Field("", description=NOTE)

    def mistakes(self) -> list[Wrong]:
        """What does not fit together in it."""
        found = list(self._of_parts())
        return found or [*self._of_shape(), *self._of_kind(), *self._of_arguments()]

    def _of_parts(self) -> Iterator[Wrong]:
        given = [key for key in ("points", "values") if getattr(self, key) is not None]
        if self.file is not None and given:
            yield Wrong(("file",), f"file and {given[0]} are both given", f"keep the file, or {' and '.join(given)}")
        elif self.file is None and (self.arguments is not None or self.value is not None):
            key = "arguments" if self.arguments is not None else "value"
            yield Wrong(
                (key,), f"{key}: names columns of a CSV file, and there is none", f"add file:, or remove {key}:"
            )
        elif len(given) < 2:
            lacking = next(key for key in ("points", "values") if key not in given)
            yield Wrong((), f"the table has no {lacking}", "add points: {h: [0, 1]} and values: [2, 3], or file:")
        elif not 1 <= len(self.points or ()) <= MAX_ARGUMENTS:
            what = f"the table has {len(self.points or ()) or 'no'} arguments"
            yield Wrong(("points",), what, f"give points of one to {MAX_ARGUMENTS} arguments")

    def _of_shape(self) -> Iterator[Wrong]:
        values = np.array(self.values or (), float)
        given, wanted = values.shape, tuple(map(len, self.axes.values()))
        if given != wanted:
            names = " and ".join(self.axes)
            what = f"the values are {_shape(given)}, the points of {names} {_shape(wanted)}"
            yield Wrong(
                ("values",), what, "give a value for each point, in lists of lists where there are two arguments"
            )
        elif values.size > MAX_VALUES:
            what = f"the table has {values.size} values"
            yield Wrong(("values",), what, f"give at most {MAX_VALUES}")

    def _of_kind(self) -> Iterator[Wrong]:
        if self.kind == LINEAR and self.smooth is None:
            yield Wrong(("kind",), _KINK, _NO_KINK)
        elif self.kind != LINEAR and self.smooth is not None:
            yield Wrong(("smooth",), f"smooth: rounds the kinks of kind: linear, and {self.kind} has none", "remove it")
        elif self.kind == MONOTONE and len(self.axes) > 1:
            what = f"monotone takes one argument, and the table has {len(self.axes)}"
            yield Wrong(("kind",), what, "write kind: cubic, or kind: linear with smooth:")
        elif self.kind == LINEAR:
            for name, points in self.axes.items():
                least, distance = float(np.diff(points).min()), self._by_argument(self.smooth).get(name)
                if distance is None:
                    yield Wrong(("smooth",), f"the distance for {name} is missing", f"add {name}: to smooth:")
                elif distance >= least / 2:
                    what = f"kinks {least:g} apart in {name} cannot each be rounded over {distance:g} to both sides"
                    yield Wrong(("smooth",), what, f"write less than {least / 2:g}")

    def _of_arguments(self) -> Iterator[Wrong]:
        for name in self.axes:
            if not name.isidentifier() or not name.isascii():
                what = f'"{brief(name)}" cannot be the name of an argument'
                yield Wrong(("points",), what, "use a letter, then letters, digits and _")
        for key in ("outside", "smooth", "units"):
            given = getattr(self, key)
            for name in given if isinstance(given, dict) else ():
                if name not in self.axes:
                    remedy = did_you_mean(name, self.axes, f"they are {', '.join(self.axes)}")
                    yield Wrong((key, name), f"{brief(name)} is no argument of the table", remedy)

    @property
    def axes(self) -> Mapping[str, list[float]]:
        """The points of each argument; none where they are mistaken."""
        return self.points or {}

    def _by_argument(self, given: Any) -> dict[str, Any]:
        return given if isinstance(given, dict) else dict.fromkeys(self.axes, given)

    @cached_property
    def curve(self) -> Table:
        """The fitted table, for an entry without mistakes."""
        from ..tables.table import fitted

        outside = {name: ERROR for name in self.axes} | self._by_argument(self.outside)
        smooth = {} if self.smooth is None else self._by_argument(self.smooth)
        return fitted("", self.axes, self.values, self.kind, outside, smooth)


def called_names(data: Any) -> frozenset[str]:
    """The names of the tables and of the functions in the data of a problem file, mistaken ones too."""
    tables = data.get("tables") if isinstance(data, dict) else None
    names = (name for name in tables if isinstance(name, str)) if isinstance(tables, dict) else ()
    return function_names(data).union(names)
