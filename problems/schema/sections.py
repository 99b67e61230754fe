"""What a problem file wants, by section: objective, constraints, pairs, initial guess, and how abs becomes smooth."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    GetJsonSchemaHandler,
    SerializerFunctionWrapHandler,
    field_validator,
    model_serializer,
    model_validator,
)

from ..expressions.expression import Expression
from ..expressions.smooth import SLACK, SQRT, TANH
from ..tables.series import TIME, by_time
from ..text import brief, did_you_mean
from .declarations import LOWER, UPPER
from .fields import Entry, Formula, Number, Text, Widths, either_form, mistake
from .series import Columns

MAX_NAMES = 1000  # in one section
MAX_KEYFRAMES = 10_000
RELAX = [1.0, 0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6]
MAX_RELAX = 100  # values of a relaxation


def _short_forms(short: dict[str, Any], core_schema: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
    """The JSON Schema of a mapping with what `short_forms` writes out: short without time, sum: in discrete time."""
    reference = either_form(short, core_schema, handler)
    long = handler.resolve_ref_schema(reference)["anyOf"][1]
    long["properties"] = long["properties"] | {"sum": long["properties"]["integral"]}
    return reference


class Terms(Entry):
    """The objective: an integral over time, a function of the two ends, or the sum of both.

    Without time it is an expression; in discrete time sum: stands for integral:.
    """

    integral: Formula | None = Field(None, description="integrand: an expression of t, states, controls, parameters")
    terminal: Formula | None = Field(None, description="function of the ends, such as t[final] or x[final]**2")

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return _short_forms({"type": ["number", "string"]}, core_schema, handler)


class Objective(Entry):
    """What is to be made small, or large."""

    minimize: Terms | None = Field(None, description="{integral:, terminal:}: at least one of them")
    maximize: Terms | None = Field(None, description="{integral:, terminal:}: at least one of them")

    @model_validator(mode="after")
    def _one_sense(self) -> Self:
        if (self.minimize is None) == (self.maximize is None):
            what = "neither minimize nor maximize is given" if self.minimize is None else "two objectives are given"
            raise mistake(what, "give one of minimize: and maximize:")
        return self

    @property
    def sense(self) -> str:
        """The key that is given: "minimize" or "maximize"."""
        return "maximize" if self.minimize is None else "minimize"

    @property
    def terms(self) -> Terms:
        terms = self.minimize or self.maximize
        assert terms is not None  # as validated
        return terms


class ConstraintEntry(Entry):
    """lower <= expression <= upper, or expression = equals."""

    name: Text = Field("", description="name in results; default made from the expression")
    expression: Formula = Field(description="at the boundary of x[initial], x[final], t[final]; else of t, x, u")
    lower: Formula | None = Field(None, description=LOWER)
    upper: Formula | None = Field(None, description=UPPER)
    equals: Formula | None = Field(None, description="the value; instead of lower and upper")

    @model_validator(mode="after")
    def _bounded(self) -> Self:
        bounded = self.lower is not None or self.upper is not None
        if self.equals is not None and bounded:
            raise mistake("equals is given together with lower or upper", "keep one of the two forms")
        if self.equals is None and not bounded:
            raise mistake("the constraint has no bound", "add lower:, upper: or equals:")
        return self


class Constraints(Entry):
    """Conditions besides the dynamics and the bounds."""

    path: list[ConstraintEntry] = Field([], max_length=MAX_NAMES, description="conditions that hold at every time")
    boundary: list[ConstraintEntry] = Field(
        [], max_length=MAX_NAMES, description="conditions on the values at both ends"
    )
    integral: list[ConstraintEntry] = Field(
        [], max_length=MAX_NAMES, description="conditions on the integral over time of an expression"
    )

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        reference = _short_forms({}, core_schema, handler)
        alternatives = handler.resolve_ref_schema(reference)["anyOf"]
        alternatives[0] = alternatives[1]["properties"]["boundary"]
        return reference


class GuessEntry(Entry):
    """Where the solver starts: `linear`, or what is given for some names, and linear for the others."""

    constants: dict[str, Formula] = Field({}, description="state, control or algebraic variable -> value at every time")
    formulas: dict[str, Formula] = Field(
        {}, description="state, control or algebraic variable -> expression of t and parameters"
    )
    keyframes: Annotated[
        dict[str, Annotated[list[Formula], Field(min_length=2, max_length=MAX_KEYFRAMES)]], AfterValidator(by_time)
    ] = Field(
        {},
        description="state, control or algebraic variable -> values; "
        "time -> their times (optional, first is initial, last is final)",
    )
    file: Text | None = Field(
        None, description="CSV file in the folder of this file: a column time, and columns named as states, controls"
    )
    data: Columns = Field({}, description="the same columns here: {time: [0, 0.5, 1], x: [0, 0.2, 1]}")
    source: Text = Field("", description="where data: come from")
    simulate: dict[str, Formula] | None = Field(
        None,
        description="integrate the dynamics forward from the initial values: control -> expression of t and states; "
        "{} where controls are as guessed",
    )

    @classmethod
    def _unfold(cls, data: Any) -> Any:
        if isinstance(data, str) and data not in _WORDS:
            forms = "write linear, simulate, or {constants: ...}, {formulas: ...}, {keyframes: ...}, {file: ...}"
            raise mistake(f'"{brief(data)}" is not a kind of guess', did_you_mean(data, _WORDS, forms))
        return _WORDS[data] if isinstance(data, str) else data

    @model_validator(mode="after")
    def _one_place(self) -> Self:
        if self.file is not None and self.data:
            raise mistake("file and data are both given", "keep one of them")
        return self

    @property
    def named(self) -> dict[str, str]:
        """Name of each variable that is given -> the key under which it is, the last if there are several."""
        groups = {key: getattr(self, key) for key in ("constants", "formulas", "keyframes", "data")}
        return {name: key for key, group in groups.items() for name in group if name != TIME or key in _WITHOUT_TIME}

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return either_form({"enum": list(_WORDS)}, core_schema, handler)


_WORDS: dict[str, dict[str, Any]] = {"linear": {}, "simulate": {"simulate": {}}}
_WITHOUT_TIME = ("constants", "formulas")


class Nonsmooth(Entry):
    """How abs, min and max become consistent (paper, 5.5 and 8.5-8.6): `slack`, or one of these.

    Neither tanh nor sqrt means slack variables.
    """

    tanh: Widths | None = Field(
        None,
        description="|y| becomes y tanh(y/alpha): alpha > 0 in the unit of y, or a list with one for each mesh entry",
    )
    sqrt: Widths | None = Field(
        None,
        description="|y| becomes sqrt(y^2 + beta^2): beta > 0 in the unit of y, or a list with one for each mesh entry",
    )

    @classmethod
    def _unfold(cls, data: Any) -> Any:
        remedy = "write slack, {tanh: 0.01} or {sqrt: 0.01}"
        if isinstance(data, str) and data != SLACK:
            raise mistake(f'"{brief(data)}" is not a way to treat abs, min and max', remedy)
        if isinstance(data, dict) and not any(value is not None for value in data.values()):
            raise mistake("nothing is given here", remedy)
        return {} if isinstance(data, str) else data

    @model_validator(mode="after")
    def _one_way(self) -> Self:
        if self.tanh is not None and self.sqrt is not None:
            raise mistake("tanh and sqrt are both given", "keep one of them")
        return self

    @model_serializer(mode="wrap")
    def _short_form(self, handler: SerializerFunctionWrapHandler) -> Any:
        return SLACK if self.treatment == SLACK else handler(self)

    @property
    def treatment(self) -> str:
        """ "slack", "tanh" or "sqrt"."""
        if self.tanh is not None:
            return TANH
        return SQRT if self.sqrt is not None else SLACK

    @property
    def widths(self) -> list[Expression]:
        """alpha or beta: one, or one for each mesh entry; none for slack."""
        return self.tanh or self.sqrt or []

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return either_form({"const": SLACK}, core_schema, handler)


def _listed(value: Any) -> Any:
    return value if isinstance(value, list) else [value]


class ComplementarityEntry(Entry):
    """a >= 0, b >= 0 and a*b = 0 at every point of the mesh, by a*b <= relax, which goes down step by step."""

    name: Text = Field("", description="name in results; default made from a and b")
    a: Formula = Field(description="what may not be negative, as a gap: an expression of t, x, u")
    b: Formula = Field(description="what may not be negative, and only not zero where a is, as a contact force")
    relax: Annotated[list[Number], BeforeValidator(_listed), Field(min_length=1, max_length=MAX_RELAX)] = Field(
        RELAX, description="what a*b may be in each solve on the way, in its own unit; the last holds for the result"
    )

    @field_validator("relax")
    @classmethod
    def _goes_down(cls, value: list[float]) -> list[float]:
        if min(value) <= 0:
            what = f"what a*b may be is {min(value):g}, and with nothing left there is no way for the solver to move"
            raise mistake(what, "write positive numbers, such as [1, 0.01, 1e-6]")
        if any(later >= earlier for earlier, later in pairwise(value)):
            raise mistake("these numbers do not go down", "write each smaller than the one before: [1, 0.01, 1e-6]")
        return value

    @property
    def sides(self) -> tuple[tuple[str, Expression], ...]:
        """Key and expression of both."""
        return ("a", self.a), ("b", self.b)
