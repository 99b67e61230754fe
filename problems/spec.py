"""The schema of a problem file: every key with its meaning, unit and default.

`Spec` is what `load.load` returns. Its JSON Schema (`schema()`) documents the file format; a key that is not named
here is a mistake. A value that may be computed is a `Formula`: a number or an expression, held as an `Expression`.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, PrivateAttr, ValidationInfo, field_validator, model_validator

from .errors import Mistake
from .fields import MAX_SEGMENTS, Entry, Formula, Number, Option, Segments, Shorthand, Text, mistake
from .places import Finding, Places
from .syntax import nearest
from .yamltext import brief, kind

MAX_MESHES = 100
MAX_NAMES = 1000  # in one section
MAX_KEYFRAMES = 10_000

_LOWER = "lower bound; default none"
_UPPER = "upper bound; default none"
_UNIT = "unit, a text for tables and plots"
_NOTE = "a remark for readers"


class Parameter(Shorthand):
    """A constant: a number, or an expression of other parameters."""

    value: Formula = Field(description="number or expression of other parameters")
    unit: Text = Field("", description=_UNIT)
    note: Text = Field("", description=_NOTE)


class EndValue(Shorthand):
    """The value at one end of time: fixed, or in a range."""

    value: Formula | None = Field(None, description="the fixed value; then no lower and upper")
    lower: Formula | None = Field(None, description=_LOWER)
    upper: Formula | None = Field(None, description=_UPPER)

    @model_validator(mode="after")
    def _one_form(self):
        given = [k for k in type(self).model_fields if getattr(self, k) is not None]
        if "value" in given and len(given) > 1:
            raise mistake(f"value and {given[1]} are both given", "keep the value, or lower and upper")
        if not given:
            raise mistake("nothing is given here", "write a number, or {lower: ..., upper: ...}, or remove the key")
        return self


class TimeEnd(EndValue):
    """The initial or the final time: fixed, or free in a range."""

    guess: Formula | None = Field(None, description="initial guess of a free time; default the middle of its range")


class Time(Entry):
    """When the trajectory begins and ends."""

    initial: TimeEnd = Field(description="initial time: number, expression of parameters, or {lower, upper, guess}")
    final: TimeEnd = Field(description="final time: number, expression of parameters, or {lower, upper, guess}")
    unit: Text = Field("s", description="unit of time; default s")


class State(Entry):
    """A state, given by its rate of change."""

    unit: Text = Field("", description=_UNIT)
    rate: Formula = Field(description="time derivative: an expression of t, states, controls and parameters")
    lower: Formula | None = Field(None, description=_LOWER)
    upper: Formula | None = Field(None, description=_UPPER)
    initial: EndValue | None = Field(None, description="value or {lower, upper} at the initial time; default free")
    final: EndValue | None = Field(None, description="value or {lower, upper} at the final time; default free")
    note: Text = Field("", description=_NOTE)


class Control(Entry):
    """A control: a function of time to be found."""

    unit: Text = Field("", description=_UNIT)
    lower: Formula | None = Field(None, description=_LOWER)
    upper: Formula | None = Field(None, description=_UPPER)
    note: Text = Field("", description=_NOTE)


class Static(Entry):
    """A static parameter: one number to be found."""

    lower: Formula | None = Field(None, description=_LOWER)
    upper: Formula | None = Field(None, description=_UPPER)
    guess: Formula | None = Field(None, description="initial guess; default the middle of its range")
    unit: Text = Field("", description=_UNIT)
    note: Text = Field("", description=_NOTE)


class Terms(Entry):
    """The objective: an integral over time, a function of the two ends, or the sum of both."""

    integral: Formula | None = Field(None, description="integrand: an expression of t, states, controls, parameters")
    terminal: Formula | None = Field(None, description="function of the ends, such as t[final] or x[final]**2")

    @model_validator(mode="after")
    def _some_term(self):
        if self.integral is None and self.terminal is None:
            raise mistake("the objective is empty", "add integral: or terminal: with an expression")
        return self


class Objective(Entry):
    """What is to be made small, or large."""

    minimize: Terms | None = Field(None, description="{integral:, terminal:}: at least one of them")
    maximize: Terms | None = Field(None, description="{integral:, terminal:}: at least one of them")

    @model_validator(mode="after")
    def _one_sense(self):
        if (self.minimize is None) == (self.maximize is None):
            what = "neither minimize nor maximize is given" if self.minimize is None else "two objectives are given"
            raise mistake(what, "give one of minimize: and maximize:")
        return self

    @property
    def terms(self) -> Terms:
        return self.minimize or self.maximize


class Constraint(Entry):
    """lower <= expression <= upper, or expression = equals."""

    name: Text = Field("", description="name in results; default made from the expression")
    expression: Formula = Field(description="at the boundary of x[initial], x[final], t[final]; else of t, x, u")
    lower: Formula | None = Field(None, description=_LOWER)
    upper: Formula | None = Field(None, description=_UPPER)
    equals: Formula | None = Field(None, description="the value; instead of lower and upper")

    @model_validator(mode="after")
    def _bounded(self):
        if self.equals is not None and not self.lower is self.upper is None:
            raise mistake("equals is given together with lower or upper", "keep one of the two forms")
        if self.equals is self.lower is self.upper is None:
            raise mistake("the constraint has no bound", "add lower:, upper: or equals:")
        return self


class Constraints(Entry):
    """Conditions besides the dynamics and the bounds."""

    path: list[Constraint] = Field([], max_length=MAX_NAMES, description="conditions that hold at every time")
    boundary: list[Constraint] = Field([], max_length=MAX_NAMES, description="conditions on the values at both ends")
    integral: list[Constraint] = Field(
        [], max_length=MAX_NAMES, description="conditions on the integral over time of an expression"
    )


class Guess(Entry):
    """Where the solver starts: `linear`, or constants and keyframes for some names and linear for the others."""

    constants: dict[str, Formula] = Field({}, description="state or control -> value at every time")
    keyframes: dict[str, Annotated[list[Formula], Field(min_length=2, max_length=MAX_KEYFRAMES)]] = Field(
        {}, description="state or control -> values; time -> their times (optional, first is initial, last is final)"
    )

    @classmethod
    def _unfold(cls, data: Any) -> Any:
        if isinstance(data, str) and data != "linear":
            remedy = "write linear, {constants: ...} or {keyframes: ...}"
            raise mistake(f'"{brief(data)}" is not a kind of guess', remedy)
        return {} if isinstance(data, str) else data

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema, handler):
        reference = handler(core_schema)
        schema = handler.resolve_ref_schema(reference)
        long = dict(schema)
        schema.clear()
        schema.update({"anyOf": [{"const": "linear"}, long]})
        return reference


class Mesh(Entry):
    """One entry of the mesh schedule."""

    method: Text = Field(description="collocation method; `trajopt methods` lists them")
    segments: Segments = Field(description=f"number of equal segments, or relative widths; at most {MAX_SEGMENTS}")
    tolerance: Number = Field(1e-8, description="convergence tolerance of IPOPT (its option tol); default 1e-8")

    @field_validator("method")
    @classmethod
    def _known_method(cls, value: str, info: ValidationInfo) -> str:
        methods = (info.context or {}).get("methods", ())
        if methods and value not in methods:
            close = nearest(value, methods)
            remedy = f"did you mean {close}?" if close else "write one of " + ", ".join(methods)
            raise mistake(f'there is no method "{brief(value)}"', remedy)
        return value

    @field_validator("tolerance")
    @classmethod
    def _sensible(cls, value: float) -> float:
        if not 1e-16 <= value <= 1:
            raise mistake(f"the tolerance {value:g} is out of range", "write a number such as 1.0e-8")
        return value


class Solver(Entry):
    """How IPOPT runs. Every key but `accept` is an IPOPT option."""

    model_config = ConfigDict(extra="allow", frozen=True)
    __pydantic_extra__: dict[str, Option]

    accept: Literal["optimal", "acceptable"] = Field(
        "optimal", description="count IPOPT's acceptable point as solved (acceptable) or not (optimal, the default)"
    )

    @property
    def options(self) -> dict[str, int | float | str]:
        return dict(self.model_extra)


class Reference(Entry):
    """A value of the objective known from elsewhere."""

    objective: Number = Field(description="the known value")
    tolerance: Number = Field(1e-6, description="absolute difference allowed; default 1e-6")
    source: Text = Field("", description="where the value comes from")


class Spec(Entry):
    """A problem file."""

    trajopt: Any = Field(description="version of the file format: 1", json_schema_extra={"const": 1})
    name: Text = Field("", description="name of the problem; default the name of the file")
    source: Text = Field("", description="where the problem is stated")
    note: Text = Field("", description=_NOTE)
    parameters: dict[str, Parameter] = Field(
        {}, max_length=MAX_NAMES, description="name -> number, expression, or {value, unit, note}"
    )
    expressions: dict[str, Formula] = Field(
        {}, max_length=MAX_NAMES, description="name -> expression that others may use by that name"
    )
    time: Time = Field(description="{initial, final, unit}")
    states: dict[str, State] = Field(
        min_length=1, max_length=MAX_NAMES, description="name -> {unit, rate, lower, upper, initial, final, note}"
    )
    controls: dict[str, Control] = Field({}, max_length=MAX_NAMES, description="name -> {unit, lower, upper, note}")
    optimize: dict[str, Static] = Field(
        {}, max_length=MAX_NAMES, description="static parameters to find: name -> {lower, upper, guess, unit, note}"
    )
    objective: Objective = Field(description="{minimize: {integral:, terminal:}}, or maximize")
    constraints: Constraints = Field(Constraints(), description="{path, boundary, integral}, each a list")
    guess: Guess = Field(Guess(), description="initial trajectory: linear (default), constants or keyframes")
    mesh: list[Mesh] = Field(
        min_length=1, max_length=MAX_MESHES, description="schedule: each entry starts from the solution before it"
    )
    solver: Solver = Field(Solver(), description="accept, and IPOPT options such as max_iter")
    reference: Reference | None = Field(None, description="known objective to compare with")

    _text: str = PrivateAttr("")
    _places: Places = PrivateAttr(Places("", {}))
    _warnings: tuple[Mistake, ...] = PrivateAttr(())

    @field_validator("trajopt")
    @classmethod
    def _version(cls, value: Any) -> int:
        if value != 1 or isinstance(value, bool):
            raise mistake(f"the version of the file format is {kind(value)}, not 1", "write trajopt: 1")
        return 1

    @property
    def file(self) -> str:
        """Name of the file, as it was given."""
        return self._places.file

    @property
    def text(self) -> str:
        """Text of the file, as it was read."""
        return self._text

    @property
    def warnings(self) -> tuple[Mistake, ...]:
        """What is odd but can be solved."""
        return self._warnings

    def locate(self, mistakes: Iterable[Mistake]) -> list[Mistake]:
        """Mistakes found later, whose `where` is a path such as solver.max_iter, at their place in the file."""
        return self._places.locate(mistakes)

    def attach(self, text: str, places: Places, warnings: Iterable[Finding]) -> Spec:
        """The same spec, knowing the text it was read from."""
        self._text, self._places, self._warnings = text, places, places.mistakes(warnings)
        return self


def schema(methods: tuple[str, ...] = ()) -> dict[str, Any]:
    """JSON Schema of a problem file, for editors; `methods` are the names that a mesh entry may give."""
    result = {"$schema": "https://json-schema.org/draft/2020-12/schema", **Spec.model_json_schema()}
    if methods:
        result["$defs"]["Mesh"]["properties"]["method"]["enum"] = list(methods)
    return result
