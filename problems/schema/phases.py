"""Phases as a file states them: what each has of its own, the links between them, and waypoints."""

from __future__ import annotations

from typing import Any, Self

from pydantic import Field, GetJsonSchemaHandler, model_validator

from .declarations import (
    LOWER,
    NOTE,
    UPPER,
    Algebraic,
    Control,
    EndValue,
    NamedExpression,
    Parameter,
    Residual,
    StateEntry,
    TimeEnd,
)
from .fields import Entry, Formula, Text, mistake
from .measurements import MAX_SETS, MeasuredEntry
from .sections import MAX_NAMES, ComplementarityEntry, Constraints, GuessEntry, Objective
from .solving import MAX_MESHES, MeshEntry

MAX_PHASES = 200

NONE = "none"
"""For links: no phase goes on in another."""

OWN = "of this phase: over what the top level says of the same names"


class PhaseTime(Entry):
    """When a phase begins and ends."""

    initial: TimeEnd | None = Field(None, description="default the final time of the phase before it")
    final: TimeEnd | None = Field(None, description="default free, up to the end of the last phase")


class PhaseEntry(Entry):
    """One phase. What it does not say is as the top level says it."""

    note: Text = Field("", description=NOTE)
    time: PhaseTime = Field(
        PhaseTime.model_construct(), description="{initial, final}, each a number or {lower, upper, guess}"
    )
    parameters: dict[str, Parameter] = Field({}, max_length=MAX_NAMES, description=f"constants {OWN}")
    expressions: dict[str, NamedExpression] = Field({}, max_length=MAX_NAMES, description=f"expressions {OWN}")
    states: dict[str, StateEntry] = Field({}, max_length=MAX_NAMES, description=f"states {OWN}, key by key")
    controls: dict[str, Control] = Field({}, max_length=MAX_NAMES, description=f"controls {OWN}, key by key")
    algebraic: dict[str, Algebraic] = Field(
        {}, max_length=MAX_NAMES, description=f"algebraic variables {OWN}, key by key"
    )
    integrals: dict[str, NamedExpression] = Field({}, max_length=MAX_NAMES, description=f"integrals {OWN}")
    residuals: list[Residual] | None = Field(
        None, max_length=MAX_NAMES, description="in place of those of the top level"
    )
    without: list[Text] = Field(
        [],
        max_length=MAX_NAMES,
        description="states, controls, algebraic variables and integrals of the top level that this phase has not",
    )
    objective: Objective | None = Field(
        None, description="terms of this phase, added to those of the others; its integral is in place of the top's"
    )
    constraints: Constraints = Field(
        Constraints.model_construct(), description="of this phase, beside the path constraints of the top level"
    )
    complementarity: list[ComplementarityEntry] = Field(
        [], max_length=MAX_NAMES, description="of this phase, beside those of the top level"
    )
    measurements: dict[str, MeasuredEntry] = Field(
        {}, max_length=MAX_SETS, description="of this phase: name -> {file, compare, deviations}"
    )
    guess: GuessEntry | None = Field(None, description="in place of that of the top level")
    mesh: list[MeshEntry] | None = Field(
        None, min_length=1, max_length=MAX_MESHES, description="schedule, in place of that of the top level"
    )


class LinkEntry(Entry):
    """A condition between phases: of an expression, or that time and states go on from one phase to another."""

    apart: bool = Field(False, description="written none: no phase goes on in another, as of separate experiments")
    name: Text = Field("", description="name in results; default made from the expression")
    expression: Formula | None = Field(None, description="of values at the ends of phases, as boost.m[final]")
    lower: Formula | None = Field(None, description=LOWER)
    upper: Formula | None = Field(None, description=UPPER)
    equals: Formula | None = Field(None, description="the value; instead of lower and upper")
    source: Text = Field("", alias="from", description="phase whose end goes on in another")
    target: Text = Field("", alias="to", description="phase that begins there")
    left_out: list[Text] = Field(
        [], alias="except", max_length=MAX_NAMES, description="states that do not go on, or t for the time"
    )

    model_config = Entry.model_config | {"populate_by_name": True, "serialize_by_alias": True}

    @classmethod
    def _unfold(cls, data: Any) -> Any:
        return {"apart": True} if data == NONE else data

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        if self.apart:
            return self
        bounded = self.lower is not None or self.upper is not None
        if self.expression is not None and (self.source or self.target or self.left_out):
            raise mistake("expression and from, to are both given", "keep one, and make the other a link of its own")
        if self.expression is None and not (self.source and self.target):
            remedy = 'write {from: boost, to: upper, except: [m]}, or {expression: "...", equals: 0}'
            raise mistake("a link has an expression, or from: and to:", remedy)
        if self.expression is None and (bounded or self.equals is not None):
            raise mistake("a bound without an expression", "add expression:, or remove lower:, upper:, equals:")
        if self.expression is not None and self.equals is not None and bounded:
            raise mistake("equals is given together with lower or upper", "keep one of the two forms")
        if self.expression is not None and self.equals is None and not bounded:
            raise mistake("the link has no bound", "add lower:, upper: or equals:")
        return self


class Waypoint(Entry):
    """A place to pass, in order: a phase ends there and the next begins."""

    name: Text = Field("", description="name of the phase that ends here; default leg1, leg2, ...")
    time: TimeEnd | None = Field(None, description="when it is passed: a number or {lower, upper, guess}; default free")
    states: dict[str, EndValue] = Field(
        min_length=1, max_length=MAX_NAMES, description="state -> its value there, or {lower, upper}"
    )

    @classmethod
    def _unfold(cls, data: Any) -> Any:
        """{x: 1, y: 2} is short for {states: {x: 1, y: 2}}."""
        if not isinstance(data, dict) or "states" in data:
            return data
        if not data.keys() - {"name", "time"}:
            raise mistake(
                "no state has a value at this place", "add one to it, such as x: 1, or leave the waypoint out"
            )
        own = {key: value for key, value in data.items() if key in ("name", "time")}
        return own | {"states": {key: value for key, value in data.items() if key not in own}}

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        reference = handler(core_schema)
        definition = handler.resolve_ref_schema(reference)
        values = definition["properties"]["states"]["additionalProperties"]
        short = {"type": "object", "properties": {**definition["properties"]}, "additionalProperties": values}
        del short["properties"]["states"]
        long = dict(definition)
        definition.clear()
        definition |= {"anyOf": [short, long]}
        return reference
