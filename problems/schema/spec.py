"""The schema of a problem file: every key with its meaning, unit and default.

`Spec` is what `load.load` returns. Its JSON Schema (`language.json_schema`) documents the file format; a key that is
not named here is a mistake. A value that may be computed is a `Formula`: a number or an expression, held as an
`Expression`.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field, PrivateAttr, field_validator

from ..errors import Mistake
from ..text import brief, shorten, tidy
from ..yaml.document import Path, in_words
from ..yaml.locations import Finding, Locations
from .declarations import NOTE, Algebraic, Control, NamedExpression, Parameter, Residual, StateEntry, Static, Time
from .drawing import MAX_SHAPES, ShapeEntry
from .fields import MAX_TAGS, Entry, Number, Scaling, Tag, Text, mistake
from .measurements import MAX_SETS, MeasuredEntry
from .model import ModelEntry
from .phases import MAX_PHASES, NONE, LinkEntry, PhaseEntry, Waypoint
from .sections import MAX_NAMES, ComplementarityEntry, Constraints, GuessEntry, Nonsmooth, Objective
from .solving import (
    DEFAULT_METHOD,
    DEFAULT_SEGMENTS,
    MAX_AXES,
    MAX_MESHES,
    MAX_STEPS,
    MeshEntry,
    Reference,
    RefineEntry,
    Solver,
    Sweep,
)
from .tables import TableEntry


def _alternatives(schema: dict[str, Any]) -> None:
    """What a file needs: with phases, its states, times and objective may stand in these."""
    needed = [key for key in schema["required"] if key != "objective"]
    dynamics = {"anyOf": [{"required": ["states"]}, {"required": ["model"]}]}
    wanted = {"anyOf": [{"required": ["objective"]}, {"required": ["measurements"]}]}
    one = {"allOf": [{"required": ["time"]}, wanted, dynamics]}
    others = [{"required": [key]} for key in ("phases", "waypoints")]
    varying = {"anyOf": [{"required": [key]} for key in ("time", "states", "controls", "algebraic", "model")]}
    static = {"required": ["optimize"], "not": varying}
    schema |= {"required": needed, "anyOf": [one, *others, static]}


def _or_none(schema: dict[str, Any]) -> None:
    """The word none in place of a list."""
    long = {key: schema.pop(key) for key in ("type", "items", "maxItems")}
    schema["anyOf"] = [{"const": NONE}, long]


class Spec(Entry):
    """A problem file."""

    trajopt: Any = Field(description="version of the file format: 1", json_schema_extra={"const": 1})
    name: Text = Field("", description="name of the problem; default the name of the file")
    source: Text = Field("", description="where the problem is stated")
    note: Text = Field("", description=NOTE)
    tags: list[Tag] = Field(
        [],
        max_length=MAX_TAGS,
        description="words such as minimum-time: what kind of problem it is; `trajopt list --tag` looks for them",
    )
    units: Literal["on", "off"] = Field(
        "on",
        description="on (default): `trajopt check` looks whether the units of all expressions fit; off: it does not",
    )
    parameters: dict[str, Parameter] = Field(
        {}, max_length=MAX_NAMES, description="name -> number, expression, or {value, unit, note}"
    )
    expressions: dict[str, NamedExpression] = Field(
        {},
        max_length=MAX_NAMES,
        description="name -> expression, or {value, unit, note}, that others may use by that name; over time an output",
    )
    tables: dict[str, TableEntry] = Field(
        {}, max_length=MAX_NAMES, description="tables of data: name -> {points, values} or {file}, called as name(h)"
    )
    model: ModelEntry = Field(
        ModelEntry.model_construct(kind=""),
        description="a chain of links, {kind: chain, links: [...]}, or the name of a robot: it gives states, "
        "controls, dynamics; the file its parameters, and bounds and ends where there are any",
    )
    time: Time = Field(
        Time.model_construct(), description="{initial, final, unit}; with phases: when the first begins, the last ends"
    )
    states: dict[str, StateEntry] = Field(
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
    integrals: dict[str, NamedExpression] = Field(
        {},
        max_length=MAX_NAMES,
        description="name -> integrand, or {value, unit, note}; at the ends integral.name is the integral over time",
    )
    optimize: dict[str, Static] = Field(
        {}, max_length=MAX_NAMES, description="static parameters to find: name -> {lower, upper, guess, unit, note}"
    )
    objective: Objective = Field(description="{minimize: {integral:, terminal:}}, or maximize")
    measurements: dict[str, MeasuredEntry] = Field(
        {},
        max_length=MAX_SETS,
        description="of experiments: name -> {file, compare, deviations}; their squared residuals are minimised",
    )
    phases: dict[str, PhaseEntry] = Field(
        {},
        max_length=MAX_PHASES,
        description="in order, name -> what is of this phase alone: {time, states, constraints, objective, mesh, ...}",
    )
    links: list[LinkEntry] = Field(
        [],
        max_length=MAX_NAMES,
        description="between phases; default: time and every state of one name go on in the next phase; none: in none",
        json_schema_extra=_or_none,
    )
    waypoints: list[Waypoint] = Field(
        [],
        max_length=MAX_PHASES - 1,
        description="places to pass in order, [{x: 1, y: 2}]: short for phases that end there",
    )
    nonsmooth: Nonsmooth | None = Field(
        None, description="how abs, min and max become consistent: slack, {tanh: alpha} or {sqrt: beta}"
    )
    constraints: Constraints = Field(
        Constraints.model_construct(), description="{path, boundary, integral}, each a list"
    )
    complementarity: list[ComplementarityEntry] = Field(
        [], max_length=MAX_NAMES, description="pairs that are never both above zero: [{a: gap, b: force}]"
    )
    guess: GuessEntry = Field(
        GuessEntry.model_construct(), description="initial trajectory: linear (default), constants or keyframes"
    )
    scaling: Scaling = Field(
        "none",
        description="none (default: the solver's own, by gradients), auto (by bounds, guess, Jacobian), or auto with "
        "the sizes of some states, velocities, controls, algebraic variables or static parameters: {name: size}",
    )
    refine: RefineEntry | None = Field(
        None, description="refine the mesh until the error meets a tolerance; default only where mesh is left out"
    )
    mesh: list[MeshEntry] = Field(
        default_factory=lambda: [MeshEntry(method=DEFAULT_METHOD, segments=DEFAULT_SEGMENTS)],
        min_length=1,
        max_length=MAX_MESHES,
        description="schedule: each entry starts from the solution before it; left out, the mesh is chosen and refined",
    )
    solver: Solver = Field(
        Solver.model_construct(), description="engine, accept, coarse_start, options of the engine such as max_iter"
    )
    continuation: dict[str, Annotated[list[Number], Field(min_length=1, max_length=MAX_STEPS)]] = Field(
        {},
        max_length=MAX_AXES,
        description="path of a number -> the values to go through on the way to the one in the file",
    )
    drawing: list[ShapeEntry] = Field(
        [],
        max_length=MAX_SHAPES,
        description="what it looks like: lines, points, circles, boxes and the ground, for trajopt animate and plots",
    )
    reference: Reference | None = Field(None, description="known objective to compare with")
    sweep: Sweep | None = Field(None, description="what `trajopt sweep` varies: {over, zip, sample, seed, chain}")

    model_config = ConfigDict(extra="forbid", frozen=True, json_schema_extra=_alternatives)

    _text: str = PrivateAttr("")
    _locations: Locations = PrivateAttr(Locations("", {}))
    _warnings: tuple[Mistake, ...] = PrivateAttr(())

    @field_validator("links", mode="before")
    @classmethod
    def _none(cls, value: Any) -> Any:
        return [NONE] if value == NONE else value

    @field_validator("trajopt")
    @classmethod
    def _version(cls, value: Any) -> int:
        if value != 1 or isinstance(value, bool):
            raise mistake(f"the version of the file format is {in_words(value)}, not 1", "write trajopt: 1")
        return 1

    @field_validator("tags")
    @classmethod
    def _each_once(cls, value: list[str]) -> list[str]:
        if twice := next((tag for i, tag in enumerate(value) if tag in value[:i]), None):
            raise mistake(f'the tag "{brief(twice)}" is given twice', "remove one of them")
        return value

    @property
    def static(self) -> bool:
        """Whether there is no time: static parameters are all that is to be found."""
        return bool(self.optimize) and not (self.states or self.model.kind or self.phases or self.waypoints)

    @property
    def discrete(self) -> bool:
        """Whether time is discrete: some state is given by its next value."""
        return any(state.next is not None for state in self.states.values())

    @property
    def file(self) -> str:
        """Name of the file, as it was given."""
        return self._locations.file

    @property
    def text(self) -> str:
        """Text of the file, as it was read."""
        return self._text

    @property
    def warnings(self) -> tuple[Mistake, ...]:
        """What is odd but can be solved."""
        return self._warnings

    def locate(self, mistakes: Iterable[Mistake]) -> list[Mistake]:
        """Mistakes found later, whose `where` is a path such as solver.max_iter, with their line in the file."""
        return self._locations.locate(mistakes)

    def locate_findings(self, findings: Iterable[Finding]) -> list[Mistake]:
        """Mistakes found later, at paths in the file, with their line in it."""
        return list(self._locations.mistakes(findings))

    @property
    def overrides(self) -> dict[str, Any]:
        """The overrides that make another problem, or another mesh, of the file: path -> value, None for nothing."""
        places = {shown: place for place, shown in self._locations.overrides.items()}  # the innermost comes last
        kept = {shown: place for shown, place in places.items() if place[0] not in NO_OTHER_PROBLEM}
        data = self.model_dump(mode="json") if kept else {}
        found = {shown: _at(data, place) for shown, place in kept.items()}
        made = {shown: self._locations.written_out(place) for shown, place in kept.items() if found[shown] is None}
        return found | {shown: _at(data, place) for shown, place in made.items()}

    def __repr__(self) -> str:
        """The name, and what the file declares, in four lines; `model_dump` gives all of it."""
        groups = ("states", "controls", "algebraic", "optimize", "parameters", "expressions", "tables")
        named = {group: getattr(self, group) for group in groups}
        declared = [f"{group} {shorten(', '.join(names), 60)}" for group, names in named.items() if names]
        if self.model.kind:
            declared.insert(0, f"model {self.model.kind}")
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

    def attach(self, text: str, locations: Locations, warnings: Iterable[Finding]) -> Spec:
        """The same spec, knowing what it was read from.

        text: of the file.
        locations: where each of its values was given.
        warnings: what is odd in it.
        """
        self._text, self._locations, self._warnings = text, locations, locations.mistakes(warnings)
        return self


NO_OTHER_PROBLEM = ("solver", "reference", "name", "note", "tags")
"""Sections whose values change neither the problem nor its mesh."""


def _at(data: Any, place: Path) -> Any:
    """The value at a path of plain data; in its short form where it has a long one."""
    for step in place:
        found = (isinstance(data, dict) and step in data) or (isinstance(data, list) and step in range(len(data)))
        data = data[step] if found else None
    return data.get("value", data) if isinstance(data, dict) else data
