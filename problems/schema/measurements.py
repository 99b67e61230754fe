"""Measurements in a problem file: columns over time, what they are compared with, and how exact they are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import AfterValidator, Field, PlainValidator, WithJsonSchema, model_validator

from ..tables.series import by_time
from .fields import Entry, Formula, Text, mistake, number
from .series import Samples

MAX_SETS = 100


def _exactness(value: Any) -> float | str | dict[str, float | str]:
    """A positive number, the name of a column, or one of them by the name of the column that is meant."""
    if isinstance(value, dict) and value:
        return {str(name): _one(own) for name, own in value.items()}
    return _one(value)


def _one(value: Any) -> float | str:
    try:
        own = number(value)
    except ValueError:
        if isinstance(value, str) and value:
            return value
        raise
    if own <= 0:
        raise mistake(f"the number is {own:g}", "write a positive one")
    return own


_ONE = {"anyOf": [{"type": "number", "exclusiveMinimum": 0}, {"type": "string"}]}

if TYPE_CHECKING:
    Exactness = float | str | dict[str, float | str]
else:
    Exactness = Annotated[
        Any,
        PlainValidator(_exactness),
        WithJsonSchema({"anyOf": [*_ONE["anyOf"], {"type": "object", "additionalProperties": _ONE}]}),
    ]


class MeasuredEntry(Entry):
    """Measurements of one experiment: the sum of weighted squared residuals is added to what is minimised."""

    file: Text | None = Field(None, description="CSV file in the folder of this file: a column time, and others")
    data: Samples = Field({}, description="the same columns here: {time: [0, 0.5, 1], y1: [1, 0.8, null]}")
    source: Text = Field("", description="where data: come from")
    note: Text = Field("", description="a remark for readers")
    compare: dict[str, Formula] = Field(
        {},
        description="column -> expression of t, states, controls and parameters that it measures; default: the columns "
        "that are named as a variable or an expression, with that",
    )
    units: Annotated[dict[str, Text], AfterValidator(by_time)] = Field(
        {}, description="column -> its unit, a text; also that of time"
    )
    deviations: Exactness | None = Field(
        None, description="standard deviation of the values: a number, the name of a column, or these by column"
    )
    weights: Exactness | None = Field(
        None, description="in place of deviations: of the squared residuals, known but for a factor"
    )

    @model_validator(mode="after")
    def _one_of_each(self) -> Self:
        if self.file is not None and self.data:
            raise mistake("file and data are both given", "keep one of them")
        if self.file is None and not self.data:
            raise mistake("there are no measurements", "add file: with a CSV file, or data: {time: [...], x: [...]}")
        if self.deviations is not None and self.weights is not None:
            raise mistake("deviations and weights are both given", "keep one of them: weights are 1/deviation**2")
        return self

    def exactness(self, column: str) -> float | str | None:
        """What is given for a column: a number, the name of a column, or None."""
        given = self.deviations if self.deviations is not None else self.weights
        return given.get(column) if isinstance(given, dict) else given


class MeanEntry(MeasuredEntry):
    """Measurements of which some columns are compared with means; no file has it, see `language.means`.

    means: column -> what it is the mean of, in place of which `compare` has its integral.
    """

    means: dict[str, Formula]
