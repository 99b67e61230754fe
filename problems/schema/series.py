"""Columns of numbers over time in a problem file."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import PlainValidator, WithJsonSchema

from ..tables.choices import MAX_VALUES
from ..tables.series import TIME, Series, by_time
from ..text import brief
from ..yaml.document import in_words
from .fields import mistake, number


def _columns(value: Any) -> Series:
    """Columns of one length over times that increase; none where nothing is given."""
    if value == {}:
        return {}
    columns = _lists(value)
    if len(columns[TIME]) < 2:
        raise mistake("there are less than two times", "give at least two")
    for i, (before, after) in enumerate(pairwise(columns[TIME])):
        if after <= before:
            what = f"the times do not increase: entry {i + 2} is {after:g}, after {before:g}"
            raise mistake(what, "sort them, and the columns with them; each must be larger than the one before")
    return columns


def _samples(value: Any) -> Series:
    """Columns of one length over times that do not fall; None stands for what was not measured."""
    if value == {}:
        return {}
    columns = _lists(value, gaps=True)
    for i, (before, after) in enumerate(pairwise(columns[TIME])):
        if after < before:
            what = f"the times fall: entry {i + 2} is {after:g}, after {before:g}"
            raise mistake(what, "sort them, and the columns with them")
    return columns


def _lists(value: Any, gaps: bool = False) -> Series:
    """Lists of numbers of one length, that of the times among them; gaps: whether None may stand among the others."""
    if not isinstance(value, dict) or not all(isinstance(row, list) for row in value.values()):
        what = f"the data are {in_words(value)}" if not isinstance(value, dict) else "a column is no list"
        raise mistake(what, "write lists of numbers by name: {time: [0, 0.5, 1], x: [0, 0.2, 1]}")
    value = by_time(value)
    if TIME not in value or len(value) < 2:
        what = "the data have no time" if TIME not in value else "the data have times alone"
        raise mistake(what, "write {time: [0, 0.5, 1], x: [0, 0.2, 1]}, with columns named after what they are of")
    if sum(map(len, value.values())) > MAX_VALUES:
        raise mistake(f"there are more than {MAX_VALUES} numbers here", "leave out what is not needed")
    columns: Series = {}
    for name, row in value.items():
        if len(row) != len(value[TIME]):
            what = f"{brief(name)} has {len(row)} values, and there are {len(value[TIME])} times"
            raise mistake(what, "give all columns the same number of values")
        columns[str(name)] = [None if gaps and own is None and name != TIME else _number(name, own) for own in row]
    return columns


def _number(name: str, value: Any) -> float:
    try:
        return number(value)
    except ValueError as error:
        raise mistake(f"a value of {brief(name)} is {in_words(value)}", "write a finite number") from error


_OBJECT = {"type": "object", "additionalProperties": {"type": "array", "items": {"type": ["number", "null"]}}}

if TYPE_CHECKING:
    Columns = Series
    Samples = Series
else:
    Columns = Annotated[Any, PlainValidator(_columns), WithJsonSchema(_OBJECT)]
    Samples = Annotated[Any, PlainValidator(_samples), WithJsonSchema(_OBJECT)]
