"""The section `drawing:`: what a problem looks like, shape by shape."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, field_validator, model_validator

from .fields import Entry, Formula, Text, mistake

MAX_SHAPES = 200
SHAPES = ("line", "point", "circle", "box", "ground")
COLORS = ("black", "orange", "sky", "green", "blue", "vermilion", "purple", "grey")
WHOLE = "whole"

Pair = Annotated[list[Formula], Field(min_length=2, max_length=2)]
Color = Literal["black", "orange", "sky", "green", "blue", "vermilion", "purple", "grey"]

_SIZES = {"circle": ("radius",), "box": ("width", "height")}


class ShapeEntry(Entry):
    """One shape: a line, a point, a circle, a box or the ground. Expressions are of t, states, controls, parameters."""

    line: Annotated[list[Pair], Field(min_length=2, max_length=1000)] | None = Field(
        None, description="corners of a line: [[x, y], [x, y], ...]"
    )
    point: Pair | None = Field(None, description="a small mark at [x, y]")
    circle: Pair | None = Field(None, description="a disc around [x, y], with radius:")
    box: Pair | None = Field(None, description="a rectangle around [x, y], with width: and height:")
    ground: Formula | None = Field(None, description="a level line at this height")
    radius: Formula | None = Field(None, description="of a circle")
    width: Formula | None = Field(None, description="of a box")
    height: Formula | None = Field(None, description="of a box")
    angle: Formula | None = Field(None, description="by which a box is turned, counter-clockwise, in radians")
    trail: Any = Field(
        False, description="true: its middle leaves its path behind; whole: the path is there from the start"
    )
    obstacle: bool = Field(
        False, description="whether it is drawn as what must not be touched, in plots of x and y too"
    )
    dashed: bool = Field(False, description="whether a line is drawn with dashes")
    color: Color | None = Field(None, description="one of " + ", ".join(COLORS))
    name: Text = Field("", description="a remark for readers")

    @field_validator("trail")
    @classmethod
    def _known_trail(cls, value: Any) -> Any:
        if not isinstance(value, bool) and value != WHOLE:
            raise mistake("a trail is true, false or whole", "write trail: true")
        return value

    @model_validator(mode="after")
    def _one_shape(self) -> Self:
        given = [kind for kind in SHAPES if getattr(self, kind) is not None]
        if len(given) != 1:
            what = f"{' and '.join(given)} are both given" if given else "there is no shape here"
            raise mistake(what, "give one of line:, point:, circle:, box: and ground:")
        (kind,) = given
        wanted = _SIZES.get(kind, ())
        if missing := next((size for size in wanted if getattr(self, size) is None), None):
            raise mistake(f"the {missing} of the {kind} is missing", f"add {missing}: 0.1")
        known = (*wanted, "angle") if kind == "box" else wanted
        sizes = ("radius", "width", "height", "angle")
        if extra := next((size for size in sizes if getattr(self, size) is not None and size not in known), None):
            raise mistake(f"a {kind} has no {extra}", f"remove {extra}:")
        if self.dashed and kind != "line":
            raise mistake(f"a {kind} is not dashed", "remove dashed:")
        if self.trail and kind in ("line", "ground"):
            raise mistake(f"a {kind} has no middle to leave a trail", "give a point: with the trail")
        return self

    @property
    def kind(self) -> str:
        """One of SHAPES; "" for a shape that is not there."""
        return next((kind for kind in SHAPES if getattr(self, kind) is not None), "")
