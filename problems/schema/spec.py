"""The schema of a problem file: every key with its meaning, unit and default.

`Spec` is what `load.load` returns. Its JSON Schema (`schema()`) documents the file format; a key that is not named
here is a mistake. A value that may be computed is a `Formula`: a number or an expression, held as an `Expression`.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any

from pydantic import (
    ConfigDict,
    Field,
    PrivateAttr,
    field_validator,
    model_serializer,
    model_validator,
)

from ..errors import Mistake
from ..expressions.expression import Expression
from ..expressions.smooth import SLACK, SQRT, TANH
from ..models import MODELS
from ..text import brief, did_you_mean, shorten, tidy
from ..yaml.document import kind
from ..yaml.locations import Finding, Places
from .declarations import LOWER, NOTE, UPPER, Algebraic, Control, Parameter, Residual, State, Static, Time
from .solving import DEFAULT_METHOD, DEFAULT_SEGMENTS, MAX_MESHES, Mesh, Reference, Refine, Solver
from .values import Entry, Formula, Scaling, Text, Widths, mistake

MAX_NAMES = 1000  # in one section
MAX_KEYFRAMES = 10_000


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
    def sense(self) -> str:
        """The key that is given: "minimize" or "maximize"."""
        return "maximize" if self.minimize is None else "minimize"

    @property
    def terms(self) -> Terms:
        return self.minimize or self.maximize


class Constraint(Entry):
    """lower <= expression <= upper, or expression = equals."""

    name: Text = Field("", description="name in results; default made from the expression")
    expression: Formula = Field(description="at the boundary of x[initial], x[final], t[final]; else of t, x, u")
    lower: Formula | None = Field(None, description=LOWER)
    upper: Formula | None = Field(None, description=UPPER)
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

    constants: dict[str, Formula] = Field({}, description="state, control or algebraic variable -> value at every time")
    keyframes: dict[str, Annotated[list[Formula], Field(min_length=2, max_length=MAX_KEYFRAMES)]] = Field(
        {},
        description="state, control or algebraic variable -> values; "
        "time -> their times (optional, first is initial, last is final)",
    )

    @classmethod
    def _unfold(cls, data: Any) -> Any:
        if isinstance(data, str) and data != "linear":
            remedy = "write linear, {constants: ...} or {keyframes: ...}"
            raise mistake(f'"{brief(data)}" is not a kind of guess', remedy)
        return {} if isinstance(data, str) else data

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema, handler):
        return _or_word("linear", handler(core_schema), handler)


def _or_word(word: str, reference: dict, handler) -> dict:
    """The JSON Schema of a mapping for which one word may stand."""
    schema = handler.resolve_ref_schema(reference)
    long = dict(schema)
    schema.clear()
    schema.update({"anyOf": [{"const": word}, long]})
    return reference


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
    def _one_way(self):
        if self.tanh is not None and self.sqrt is not None:
            raise mistake("tanh and sqrt are both given", "keep one of them")
        return self

    @model_serializer(mode="wrap")
    def _short_form(self, handler):
        return SLACK if self.kind == SLACK else handler(self)

    @property
    def kind(self) -> str:
        """ "slack", "tanh" or "sqrt"."""
        return TANH if self.tanh is not None else SQRT if self.sqrt is not None else SLACK

    @property
    def widths(self) -> list[Expression]:
        """alpha or beta: one, or one for each mesh entry; none for slack."""
        return self.tanh or self.sqrt or []

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema, handler):
        return _or_word(SLACK, handler(core_schema), handler)


class Spec(Entry):
    """A problem file."""

    trajopt: Any = Field(description="version of the file format: 1", json_schema_extra={"const": 1})
    name: Text = Field("", description="name of the problem; default the name of the file")
    source: Text = Field("", description="where the problem is stated")
    note: Text = Field("", description=NOTE)
    parameters: dict[str, Parameter] = Field(
        {}, max_length=MAX_NAMES, description="name -> number, expression, or {value, unit, note}"
    )
    expressions: dict[str, Formula] = Field(
        {}, max_length=MAX_NAMES, description="name -> expression that others may use by that name"
    )
    model: Text = Field(
        "",
        description="name of a shipped model: it gives states, controls, algebraic variables, dynamics, constraints; "
        "the file its parameters, and bounds and ends where there are any",
    )
    time: Time = Field(description="{initial, final, unit}")
    states: dict[str, State] = Field(
        {},
        max_length=MAX_NAMES,
        description="name -> {unit, rate, lower, upper, initial, final, note}; or {accel, velocity, ...} for rate",
    )
    controls: dict[str, Control] = Field({}, max_length=MAX_NAMES, description="name -> {unit, lower, upper, note}")
    algebraic: dict[str, Algebraic] = Field(
        {}, max_length=MAX_NAMES, description="algebraic variables: name -> {unit, lower, upper, note}"
    )
    residuals: list[Residual] = Field(
        [],
        max_length=MAX_NAMES,
        description="expressions that are zero at every time: as many as algebraic variables and implicit rates",
    )
    optimize: dict[str, Static] = Field(
        {}, max_length=MAX_NAMES, description="static parameters to find: name -> {lower, upper, guess, unit, note}"
    )
    objective: Objective = Field(description="{minimize: {integral:, terminal:}}, or maximize")
    nonsmooth: Nonsmooth | None = Field(
        None, description="how abs, min and max become consistent: slack, {tanh: alpha} or {sqrt: beta}"
    )
    constraints: Constraints = Field(Constraints(), description="{path, boundary, integral}, each a list")
    guess: Guess = Field(Guess(), description="initial trajectory: linear (default), constants or keyframes")
    scaling: Scaling = Field(
        "none",
        description="none (default: the solver's own, by gradients), auto (by bounds, guess, Jacobian), or auto with "
        "the sizes of some states, velocities, controls, algebraic variables or static parameters: {name: size}",
    )
    refine: Refine | None = Field(
        None, description="refine the mesh until the error meets a tolerance; default only where mesh is left out"
    )
    mesh: list[Mesh] = Field(
        default_factory=lambda: [Mesh(method=DEFAULT_METHOD, segments=DEFAULT_SEGMENTS)],
        min_length=1,
        max_length=MAX_MESHES,
        description="schedule: each entry starts from the solution before it; left out, the mesh is chosen and refined",
    )
    solver: Solver = Field(Solver(), description="engine, accept, coarse_start, options of the engine such as max_iter")
    reference: Reference | None = Field(None, description="known objective to compare with")

    model_config = ConfigDict(
        extra="forbid", frozen=True, json_schema_extra={"anyOf": [{"required": ["states"]}, {"required": ["model"]}]}
    )

    _text: str = PrivateAttr("")
    _places: Places = PrivateAttr(Places("", {}))
    _warnings: tuple[Mistake, ...] = PrivateAttr(())

    @field_validator("trajopt")
    @classmethod
    def _version(cls, value: Any) -> int:
        if value != 1 or isinstance(value, bool):
            raise mistake(f"the version of the file format is {kind(value)}, not 1", "write trajopt: 1")
        return 1

    @field_validator("model")
    @classmethod
    def _known_model(cls, value: str) -> str:
        if value and value not in MODELS:
            remedy = did_you_mean(value, MODELS, f"the models are {', '.join(MODELS)}")
            raise mistake(f'there is no model "{brief(value)}"', remedy)
        return value

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

    @property
    def overrides(self) -> tuple[str, ...]:
        """The paths of the overrides that make another problem, or another mesh, of the file."""
        shown = dict.fromkeys(self._places.overrides.values())
        return tuple(path for path in shown if path.split(".")[0] not in ("solver", "reference", "name", "note"))

    def __repr__(self) -> str:
        """The name, and what the file declares, in four lines; `model_dump` gives all of it."""
        groups = ("states", "controls", "algebraic", "optimize", "parameters", "expressions")
        named = {group: getattr(self, group) for group in groups}
        declared = [f"{group} {shorten(', '.join(names), 60)}" for group, names in named.items() if names]
        if self.model:
            declared.insert(0, f"model {self.model}")
        meshes = shorten(", ".join(f"{entry.method} {entry.number_of_segments}" for entry in self.mesh))
        refined = f", refined to {self.refine.tolerance:g}" if self.refine else ""
        half = (len(declared) + 1) // 2
        lines = [
            f"<Spec {shorten(tidy(self.name))}: {self.objective.sense}, engine {self.solver.engine}",
            *("; ".join(part) for part in (declared[:half], declared[half:]) if part),
            f"mesh {meshes}{refined}>",
        ]
        return "\n  ".join(lines)

    __str__ = __repr__

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
