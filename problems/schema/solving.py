"""How a problem is solved, as a file says it: meshes, refinement, the solver, and what the answer should be."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, get_args

from pydantic import ConfigDict, Field, PlainValidator, ValidationInfo, WithJsonSchema, field_validator, model_validator

from ..quantities import MAX_SUBSTEPS
from ..text import brief, did_you_mean
from ..wishes.values import method_meant
from ..yaml.document import in_words
from .fields import MAX_SEGMENTS, Degree, Entry, Number, Option, Segments, Text, mistake

MAX_MESHES = 100
MAX_POINTS = 2_000_000  # of a mesh: some 200 MB before any unknown has a place
MAX_STARTS = 10_000
MAX_STEPS = 1000  # of a continuation
MAX_AXES, MAX_CASES, MAX_SEED = 20, 1_000_000, 2**32 - 1
"""Of a sweep."""
DEFAULT_METHOD, DEFAULT_SEGMENTS = "radau", 10
"""The first mesh where the file gives none; refinement is then on."""


def _whole_number(largest: int, of: str, smallest: int = 1) -> Any:
    """The type of a whole number from the smallest to the largest."""

    def whole(value: Any) -> int:
        is_whole = isinstance(value, int | float) and not isinstance(value, bool) and value % 1 == 0
        if not is_whole or not smallest <= value <= largest:
            what = f"this is no number of {of}: {in_words(value)}"
            raise mistake(what, f"write a whole number from {smallest} to {largest}")
        return int(value)

    schema = {"type": "integer", "minimum": smallest, "maximum": largest}
    return Annotated[Any, PlainValidator(whole), WithJsonSchema(schema)]


if TYPE_CHECKING:
    Substeps = int
    Meshes = int
    Cases = int
    Starts = int
    Seed = int
else:
    Substeps, Meshes = _whole_number(MAX_SUBSTEPS, "substeps"), _whole_number(MAX_MESHES, "meshes")
    Starts = _whole_number(MAX_STARTS, "starts", smallest=0)
    Cases, Seed = _whole_number(MAX_CASES, "cases"), _whole_number(MAX_SEED, "a sample", smallest=0)


class MeshEntry(Entry):
    """One entry of the mesh schedule."""

    method: Text = Field(description="collocation method, or shooting; `trajopt methods` lists them")
    segments: Segments = Field(description=f"number of equal segments, or relative widths; at most {MAX_SEGMENTS}")
    tolerance: Number = Field(1e-8, description="convergence tolerance of the solver (its option tol); default 1e-8")
    degree: Degree | None = Field(
        None, description="of gauss, radau, radau-left, lobatto, chebyshev: one for all segments, or a list; default 4"
    )
    form: Literal["integral", "differential"] | None = Field(
        None, description="of the defects of those methods; default differential from degree 4 on, integral below"
    )
    substeps: Substeps | None = Field(
        None, description="number of Runge-Kutta steps on each segment, for shooting methods; default 1"
    )
    control: Literal["constant", "linear", "quadratic"] | None = Field(
        None, description="constant, linear or quadratic on each substep, for shooting methods; default the last it has"
    )

    @model_validator(mode="after")
    def _as_many_degrees_as_segments(self) -> Self:
        if isinstance(self.degree, tuple):
            count = self.number_of_segments
            if len(self.degree) != count:
                raise mistake(f"there are {len(self.degree)} degrees for {count} segments", "give one for each segment")
        return self

    @model_validator(mode="after")
    def _that_fits(self) -> Self:
        count = self.number_of_segments
        degree = max(self.degree) if isinstance(self.degree, tuple) else self.degree
        for many, of in ((self.substeps, "substeps"), (degree, "points")):
            if many and many * count > MAX_POINTS:
                what = f"{count} segments of {many} {of} are more than the {MAX_POINTS} points that a mesh may have"
                raise mistake(what, "use fewer segments")
        return self

    @property
    def number_of_segments(self) -> int:
        return self.segments if isinstance(self.segments, int) else len(self.segments)

    @field_validator("method")
    @classmethod
    def _known_method(cls, value: str, info: ValidationInfo) -> str:
        methods = (info.context or {}).get("methods", ())
        if methods and value not in methods:
            meant = method_meant(value, methods)
            remedy = f"write {meant}" if meant else did_you_mean(value, methods, "write one of " + ", ".join(methods))
            raise mistake(f'there is no method "{brief(value)}"', remedy)
        return value

    @field_validator("tolerance")
    @classmethod
    def _sensible(cls, value: float) -> float:
        if not 1e-16 <= value <= 1:
            raise mistake(f"the tolerance {value:g} is out of range", "write a number such as 1.0e-8")
        return value


class RefineEntry(Entry):
    """Solve on finer and finer meshes after the schedule, until the error estimate meets a tolerance everywhere."""

    tolerance: Number = Field(
        1e-6, description="of eta on every segment, relative to 1 + the size of the state; default 1e-6"
    )
    max_meshes: Meshes = Field(10, description="number of meshes after the schedule, at most; default 10")

    objective: Number | None = Field(
        None, description="refine until the error bar of the objective is this small, relative to 1 + |J|; default none"
    )

    @field_validator("tolerance", "objective")
    @classmethod
    def _sensible(cls, value: float | None) -> float | None:
        if value is not None and not 1e-14 <= value <= 1:
            raise mistake(f"the tolerance {value:g} is out of range", "write a number such as 1.0e-6")
        return value


Engine = Literal["ipopt", "newton"]
ENGINES: tuple[str, ...] = get_args(Engine)
Library = Literal["bundled", "casadi"]
LIBRARIES: tuple[str, ...] = get_args(Library)


class Solver(Entry):
    """Which solver runs, and how. Every key but those named here is an option of that solver."""

    model_config = ConfigDict(extra="allow", frozen=True)
    __pydantic_extra__: dict[str, Option]

    engine: Engine = Field(
        "ipopt", description="ipopt (default), or newton: Newton's method on the KKT system, equality constraints only"
    )
    accept: Literal["optimal", "acceptable"] = Field(
        "optimal", description="count IPOPT's acceptable point as solved (acceptable) or not (optimal, the default)"
    )
    coarse_start: bool = Field(
        True, description="solve a large first mesh from the solution on a coarse one (default), or from the guess"
    )

    seconds: Number | None = Field(
        None, description="time limit for all meshes, in seconds; the last mesh that was solved is kept; default none"
    )

    library: Library | None = Field(
        None, description="IPOPT that runs: bundled (default), or casadi, a newer and faster one if CasADi is installed"
    )

    starts: Starts = Field(0, description="number of starts drawn within the bounds, beside the guess; default 0")
    seed: Seed = Field(0, description="whole number that the drawn starts depend on; default 0")

    @field_validator("seconds")
    @classmethod
    def _positive(cls, value: float | None) -> float | None:
        if value is not None and not value > 0:
            raise mistake(f"the time limit {value:g} is not positive", "write a number of seconds such as 60")
        return value

    @property
    def options(self) -> dict[str, int | float | str]:
        """Those that the engine checks: all that have no meaning of their own here, and the library if it is given."""
        return {**({"library": self.library} if self.library else {}), **(self.model_extra or {})}


class Reference(Entry):
    """A value of the objective known from elsewhere."""

    objective: Number = Field(description="the known value")
    tolerance: Number = Field(1e-6, description="absolute difference allowed; default 1e-6")
    source: Text = Field("", description="where the value comes from")

    @field_validator("tolerance")
    @classmethod
    def _no_less_than_nothing(cls, value: float) -> float:
        if value < 0:
            raise mistake(
                f"the tolerance {value:g} is negative", "write the difference that is allowed, such as 1.0e-6"
            )
        return value


class Sweep(Entry):
    """The cases of `trajopt sweep`; nothing else looks at it."""

    over: dict[str, Any] = Field(
        min_length=1,
        max_length=MAX_AXES,
        description='path of a field -> its values: "START:STOP:COUNT", "log:START:STOP:COUNT", or a list',
    )
    zip: bool = Field(False, description="go through the axes together (true) or solve every combination; default so")
    sample: Cases | None = Field(None, description="number of cases of a Latin hypercube over the ranges; default none")
    seed: Seed = Field(0, description="whole number that the sample depends on; default 0")
    chain: bool = Field(False, description="start each case from the case before it (true); default from the guess")
