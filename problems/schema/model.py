"""The section `model:`: a chain of links, whose equations of motion trajopt makes, or a robot's name, which is one."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    Field,
    GetJsonSchemaHandler,
    SerializerFunctionWrapHandler,
    field_validator,
    model_serializer,
    model_validator,
)

from ..expressions.expression import parse
from ..expressions.signature import name_trouble
from ..text import brief, did_you_mean
from ..yaml.document import in_words
from .fields import Entry, Formula, Text, either_form, mistake

CHAIN = "chain"
FIVE_LINK_BIPED = "five_link_biped"
NAMES_OF_MODELS = (CHAIN, FIVE_LINK_BIPED)
"""What `kind:` may be: a chain, or the name of a robot, see `chains.robots`."""

FIXED, CART, FLOATING = "fixed", "cart", "floating"
BASE = "base"
"""The name of what the first link hangs on, for `parent:`."""

ABSOLUTE, RELATIVE = "absolute", "relative"
REVOLUTE, PRISMATIC, WELDED = "revolute", "prismatic", "fixed"
"""The kinds of joints: a link turns about it, slides through it, or neither."""

MAX_LINKS = 30
MAX_FORCES = 100


def is_chain(model: Any) -> bool:
    """Whether the section `model:` of a file is a chain, right or wrong."""
    return isinstance(model, dict) and model.get("kind") == CHAIN


def _word(value: str) -> str:
    if value and (trouble := name_trouble(value)):
        raise mistake(*trouble)
    return value


Word = Annotated[Text, AfterValidator(_word)]
"""A name that expressions can hold, or ""."""


class Driven(Entry):
    """What a motor may act on."""

    motor: Any = Field(None, description="true, or the name of its control: a motor acts here, from what is before it")

    @field_validator("motor")
    @classmethod
    def _known_motor(cls, value: Any) -> Any:
        if not isinstance(value, bool | str):
            what = f"this must be true or the name of a control, not {in_words(value)}"
            raise mistake(what, "write motor: true, or motor: u")
        return _word(value) if isinstance(value, str) else value


class CartEntry(Driven):
    """A cart that moves along x, which the first links hang on."""

    mass: Formula = Field(description="a number or an expression of parameters, kg")
    force: Formula | None = Field(None, description="a force on the cart along x beside the motor's: friction, springs")


class ChainLink(Driven):
    """A rigid link. It turns about a joint on the link before it, slides through it along itself, or is fixed there."""

    name: Word = Field("", description="its name; default link1, link2, ... in order")
    parent: Text = Field("", description="name of the link that it hangs on, or base; default the link before it")
    at: Formula | None = Field(None, description="where on that link, as a distance from its joint; default its length")
    joint: Literal["revolute", "prismatic", "fixed"] = Field(
        "revolute", description="revolute (default): turns; prismatic: slides along itself; fixed: as if welded"
    )
    mass: Formula = Field(description="a number or an expression of parameters, kg")
    length: Formula = Field(
        description="a number or an expression of parameters, m: from its joint to its tip, where the next link hangs"
    )
    com: Formula | None = Field(
        None, description="from its joint to its centre of mass; with inertia:; default a uniform rod"
    )
    inertia: Formula | None = Field(
        None, description="about its centre of mass, kg m^2; 0 for a point mass; default a uniform rod"
    )
    angle: Word = Field("", description="name of the state that is its angle; default q1, q2, ...; its rate is dq1")
    zero: Literal["up", "down", "right", "left"] | None = Field(
        None, description="where it points with an angle of zero; default that of the chain"
    )
    distance: Word = Field(
        "", description="of a prismatic joint: name of the state that is how far the link has slid out; its rate is dq1"
    )
    turn: Formula | None = Field(
        None, description="of a joint that does not turn: the angle from the link before it; default 0"
    )
    torque: Formula | None = Field(
        None, description="a torque on it from the link before it, beside the motor's: springs, damping, limits"
    )
    force: Formula | None = Field(
        None, description="of a prismatic joint: a force that pushes it out, beside the motor's: springs, damping"
    )


class ForceEntry(Entry):
    """A force from outside on a point of a link, such as a contact, a thruster or the wind."""

    link: Text = Field(description="name of the link")
    at: Formula | None = Field(None, description="where, as a distance from the joint; default its length")
    x: Formula = Field(parse("0"), description="to the right, N: an expression of t, states, controls, parameters")
    y: Formula = Field(parse("0"), description="upwards, N")


class LoopEntry(Entry):
    """Two points that are pinned together, which closes a loop: of a link, and of another one or of the base."""

    link: Text = Field(description="name of the link")
    at: Formula | None = Field(None, description="where on it, as a distance from its joint; default its length")
    to: Text = Field("base", description="name of the other link, or base (default)")
    to_at: Formula | None = Field(None, description="where on the other link; default its length")
    x: Formula | None = Field(None, description="with to: base: where, to the right of where the chain begins, m")
    y: Formula | None = Field(None, description="with to: base: where, upwards, m")


class StepEntry(Entry):
    """The step of a walker: at the final time a tip strikes the ground and stays, and the legs change roles."""

    foot: Text = Field(description="name of the link whose tip strikes")
    swap: Annotated[list[Annotated[list[Text], Field(min_length=2, max_length=2)]], Field(max_length=MAX_LINKS)] = (
        Field(description="pairs of links that change roles: [[stance_shank, swing_shank], ...]")
    )


class ModelEntry(Entry):
    """The dynamics: a chain of links in the plane, or a robot that is one, for which its name stands."""

    kind: Text = Field(description="chain, or the name of a robot")
    base: Literal["fixed", "cart", "floating"] = Field(
        "fixed", description="what the first link hangs on: fixed (default), cart, or floating, as in flight"
    )
    gravity: Formula = Field(parse("9.81"), description="downwards, m/s^2; default 9.81; 0 for a horizontal plane")
    angles: Literal["absolute", "relative"] = Field(
        "absolute", description="absolute (default): from the vertical; relative: from the link before it"
    )
    zero: Literal["up", "down", "right", "left"] = Field(
        "down", description="where a link points whose angle is zero; default down"
    )
    cart: CartEntry | None = Field(None, description="{mass, motor, force}, with base: cart")
    links: Annotated[list[ChainLink], Field(max_length=MAX_LINKS)] = Field([], description="from the base outwards")
    forces: Annotated[list[ForceEntry], Field(max_length=MAX_FORCES)] = Field(
        [], description="from outside: [{link: NAME, x: Fx, y: Fy}]"
    )
    loops: Annotated[list[LoopEntry], Field(max_length=MAX_LINKS)] = Field(
        [], description="closed loops: [{link: NAME, x: x, y: y}] pins its tip to the base, to: NAME to another link"
    )
    step: StepEntry | None = Field(
        None,
        description="{foot, swap} of a walker: the state at the final time becomes the initial one of the next step",
    )

    @classmethod
    def _unfold(cls, data: Any) -> Any:
        return {"kind": data} if isinstance(data, str) else data

    @field_validator("kind")
    @classmethod
    def _known_kind(cls, value: str) -> str:
        if value and value not in NAMES_OF_MODELS:
            remedy = did_you_mean(value, NAMES_OF_MODELS, f"the models are {', '.join(NAMES_OF_MODELS)}")
            raise mistake(f'there is no model "{brief(value)}"', remedy)
        return value

    @model_validator(mode="after")
    def _what_a_kind_has(self) -> Self:
        if self.kind == CHAIN and not self.links:
            raise mistake("a chain needs links", "add links: [{mass: 1, length: 0.5, motor: true}]")
        if self.kind in NAMES_OF_MODELS[1:] and self.model_fields_set != {"kind"}:
            raise mistake(f"{self.kind} takes no keys here", f"write model: {self.kind}, or kind: {CHAIN}")
        return self

    @model_serializer(mode="wrap")
    def _short_form(self, handler: SerializerFunctionWrapHandler) -> Any:
        return handler(self) if self.kind == CHAIN else self.kind

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: Any, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return either_form({"type": "string"}, core_schema, handler)
