"""The kinds of value that a problem file holds, and the two kinds of mapping: what `spec.py` is made of."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from types import NoneType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Protocol

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
    PlainSerializer,
    PlainValidator,
    ValidationInfo,
    WithJsonSchema,
    model_validator,
)
from pydantic_core import PydanticCustomError

from ..expressions.expression import Expression, parse
from ..expressions.tokens import ExpressionError
from ..quantities import LARGEST_NUMBER, MAX_DEGREE
from ..text import unprintable
from ..yaml.document import Path, in_words, scalar

MAX_SEGMENTS = 200_000
MAX_TEXT = 10_000
MAX_TAG = 40  # letters
MAX_TAGS = 100
TAG = "[a-z0-9]+(-[a-z0-9]+)*"
"""What a tag looks like, as a regular expression."""

STORED = "stored"
"""Key of the context of validation that says: from a result, so checked when it was solved."""

CALLED = "called"
"""Key of the context of validation that holds the names with arguments: tables of data, functions of the file."""

_BREAKS = "\t\n\r"  # in the notes of a file


def mistake(what: str, remedy: str) -> PydanticCustomError:
    """An error for a validator to raise; load.py finds its line in the file."""
    return PydanticCustomError("mistake", "{what}; {remedy}", {"what": what, "remedy": remedy})


def number(value: Any) -> float:
    """A finite number. Raises the error of `mistake` for anything else."""
    value = scalar(value) if isinstance(value, str) else value
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise mistake(f"this must be a number, not {in_words(value)}", "write a number such as 0.5 or 1.0e-8")
    if not math.isfinite(value):
        raise mistake(f"this must be a finite number, not {value}", "write a finite number, or leave the key out")
    if abs(value) >= LARGEST_NUMBER:
        raise mistake(f"{value:g} is too large a number", f"write one below {LARGEST_NUMBER:g}, or leave the key out")
    return float(value)


def _formula(value: Any, info: ValidationInfo) -> Expression:
    if isinstance(value, Expression):
        return value
    if isinstance(value, float) and math.isinf(value):
        raise mistake(
            "this is infinite, or a number above 1e308", "write a finite number; for no bound leave the key out"
        )
    if isinstance(value, float) and math.isnan(value):
        raise mistake("NaN is not a number", "write a finite number or an expression")
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise mistake(
            f"this must be a number or an expression, not {in_words(value)}", "write for example 0.5 or 2*pi*f"
        )
    try:
        return parse(value if isinstance(value, str) else repr(value), (info.context or {}).get(CALLED, frozenset()))
    except ExpressionError as error:
        raise mistake(error.what, error.remedy) from error


def _plain(expression: Expression) -> int | float | str:
    plain: int | float | str = scalar(expression.text)
    return plain


def _text(value: Any, info: ValidationInfo) -> Any:
    checked = (info.context or {}).get(STORED)
    if (
        not checked
        and isinstance(value, str)
        and (strange := next((c for c in value if unprintable(c) and c not in _BREAKS), None))
    ):
        raise mistake(f"the text holds the character {strange!a}, which cannot be printed", "remove it")
    return f"{value:g}" if isinstance(value, int | float) and not isinstance(value, bool) else value


def _tag(value: Any) -> str:
    if not isinstance(value, str) or not re.fullmatch(TAG, value):
        raise mistake(f"this is no tag: {in_words(value)}", "write lowercase letters, digits and hyphens: minimum-time")
    if len(value) > MAX_TAG:
        raise mistake(f"the tag has {len(value)} letters", f"write at most {MAX_TAG}")
    return value


def _segments(value: Any) -> int | tuple[float, ...]:
    if isinstance(value, list):
        if not 1 <= len(value) <= MAX_SEGMENTS:
            raise mistake(f"the list has {len(value)} widths", f"give 1 to {MAX_SEGMENTS} of them")
        widths = tuple(map(number, value))
        if min(widths) <= 0:
            raise mistake("a segment width is zero or negative", "write positive relative widths such as [1, 2, 1]")
        return widths
    if isinstance(value, bool) or not isinstance(value, int | float) or value % 1 != 0:
        raise mistake(f"this must be a whole number or a list of widths, not {in_words(value)}", "write for example 25")
    if not 1 <= value <= MAX_SEGMENTS:
        raise mistake(f"{value:g} segments are asked for", f"ask for 1 to {MAX_SEGMENTS}")
    return int(value)


def _option(value: Any) -> int | float | str:
    value = scalar(value) if isinstance(value, str) else value
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | str) or (isinstance(value, float) and math.isfinite(value)):
        return value
    raise mistake(f"a solver's option cannot be {in_words(value)}", "write a finite number, a word, or yes or no")


def _degree(value: Any) -> int | tuple[int, ...]:
    if isinstance(value, list):
        return tuple(map(_degree_of_segment, value))
    return _degree_of_segment(value)


def _degree_of_segment(value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int | float) or value % 1 != 0 or not 1 <= value <= MAX_DEGREE:
        raise mistake(
            f"the degree is {in_words(value)}", f"write a whole number from 1 to {MAX_DEGREE}, or a list of them"
        )
    return int(value)


def _scaling(value: Any) -> str | dict[str, float]:
    if isinstance(value, dict) and value:
        sizes = {str(name): number(size) for name, size in value.items()}
        if min(sizes.values()) <= 0:
            raise mistake("a size is zero or negative", "write the typical magnitude, a positive number")
        return sizes
    if isinstance(value, str) and value in ("none", "auto"):
        return value
    raise mistake(f"this must be none, auto, or sizes by name, not {in_words(value)}", "write for example auto")


_NUMBER_SCHEMA = {"type": ["number", "string"]}
_DEGREE_SCHEMA = {"type": "integer", "minimum": 1, "maximum": MAX_DEGREE}

Text = Annotated[str, Field(max_length=MAX_TEXT), BeforeValidator(_text)]

# What the type checker is told is what the validators return; pydantic is told to take their word for it.
if TYPE_CHECKING:
    Number = float
    Tag = str
    Formula = Expression
    Option = int | float | str
    Widths = list[Expression]
    Degree = int | tuple[int, ...]
    Scaling = str | dict[str, float]
    Segments = int | tuple[float, ...]
else:
    Number = Annotated[Any, PlainValidator(number), WithJsonSchema(_NUMBER_SCHEMA)]
    Tag = Annotated[
        Any, PlainValidator(_tag), WithJsonSchema({"type": "string", "pattern": f"^{TAG}$", "maxLength": MAX_TAG})
    ]
    Formula = Annotated[
        Any, PlainValidator(_formula), PlainSerializer(_plain), WithJsonSchema({"type": ["number", "string"]})
    ]
    Option = Annotated[Any, PlainValidator(_option), WithJsonSchema({"type": ["number", "string", "boolean"]})]
    Widths = Annotated[
        list[Formula],
        Field(min_length=1),
        BeforeValidator(lambda value: value if isinstance(value, list) else [value]),
        WithJsonSchema({"anyOf": [_NUMBER_SCHEMA, {"type": "array", "items": _NUMBER_SCHEMA, "minItems": 1}]}),
    ]
    Degree = Annotated[
        Any,
        PlainValidator(_degree),
        WithJsonSchema({"anyOf": [_DEGREE_SCHEMA, {"type": "array", "items": _DEGREE_SCHEMA}]}),
    ]
    Scaling = Annotated[
        Any,
        PlainValidator(_scaling),
        WithJsonSchema(
            {"anyOf": [{"enum": ["none", "auto"]}, {"type": "object", "additionalProperties": _NUMBER_SCHEMA}]}
        ),
    ]
    Segments = Annotated[
        Any,
        PlainValidator(_segments),
        WithJsonSchema({"anyOf": [{"type": "integer", "minimum": 1}, {"type": "array", "items": _NUMBER_SCHEMA}]}),
    ]


class Bounded(Protocol):
    """An entry that bounds a value: of a variable, of a constraint, at an end of time."""

    @property
    def lower(self) -> Expression | None: ...

    @property
    def upper(self) -> Expression | None: ...


def either_form(short: dict[str, Any], core_schema: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
    """The JSON Schema of a mapping for which something shorter may stand.

    short: JSON Schema of the short form.
    core_schema, handler: as pydantic gives them to `__get_pydantic_json_schema__`.
    """
    reference = handler(core_schema)
    definition = handler.resolve_ref_schema(reference)
    long = dict(definition)
    definition.clear()
    definition.update({"anyOf": [short, long]})
    return reference


class Entry(BaseModel):
    """A mapping of the file. A key with an empty value counts as left out."""

    model_config = ConfigDict(
        extra="forbid",
        frozen=True,
        defer_build=True,  # the validator of a file has those of its entries in it: each by itself is seldom used
        model_title_generator=lambda entry: entry.__name__.removesuffix("Entry"),
    )

    @model_validator(mode="before")
    @classmethod
    def _leave_out_empty(cls, data: Any) -> Any:
        data = cls._unfold({} if data is None else data)
        return {k: v for k, v in data.items() if v is not None} if isinstance(data, dict) else data

    @classmethod
    def _unfold(cls, data: Any) -> Any:
        """The long form of a short one."""
        return data


_PLAIN = frozenset((str, int, float, bool, NoneType))


def held(value: object) -> list[tuple[str | int, Any]]:
    """The values that an entry, a mapping or a list holds, with their keys, without plain texts and numbers."""
    items: Iterable[tuple[str | int, Any]] = ()
    if isinstance(value, Entry):
        items = value.__dict__.items()
    elif isinstance(value, dict):
        items = value.items()
    elif isinstance(value, list):
        items = enumerate(value)
    return [(key, inner) for key, inner in items if type(inner) not in _PLAIN]


def expressions_below(value: object, path: Path = ()) -> Iterator[tuple[Path, Expression]]:
    """Every expression that an entry, a mapping or a list holds, with its path; an expression holds itself.

    value: any.
    path: of the value.
    """
    if isinstance(value, Expression):
        yield path, value
    for key, inner in held(value):
        yield from expressions_below(inner, (*path, key))


class Shorthand(Entry):
    """A mapping for which a plain number or expression may stand: x means {value: x}, or the key that `short` names."""

    short: ClassVar[str] = "value"

    @classmethod
    def _unfold(cls, data: Any) -> Any:
        return data if isinstance(data, dict | cls) else {cls.short: data}

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return either_form(_NUMBER_SCHEMA, core_schema, handler)
