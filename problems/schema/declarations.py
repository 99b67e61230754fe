"""What a problem file declares by name: parameters, time, states, controls, algebraic variables, static parameters."""

from __future__ import annotations

from typing import Any, ClassVar, Self

from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from .fields import Entry, Formula, Shorthand, Text, mistake

LOWER = "lower bound; default none"
UPPER = "upper bound; default none"
UNIT = "unit, a text for tables and plots"
NOTE = "a remark for readers"


class Parameter(Shorthand):
    """A constant: a number, or an expression of other parameters."""

    value: Formula = Field(description="number or expression of other parameters")
    unit: Text = Field("", description=UNIT)
    note: Text = Field("", description=NOTE)


class NamedExpression(Shorthand):
    """An expression that others may use by its name; one that varies in time is an output of the solution."""

    value: Formula = Field(description="expression of t, states, controls, parameters and other named expressions")
    unit: Text = Field("", description=UNIT)
    note: Text = Field("", description=NOTE)


class EndValue(Shorthand):
    """The value at one end of time: fixed, or in a range."""

    value: Formula | None = Field(None, description="the fixed value; then no lower and upper")
    lower: Formula | None = Field(None, description=LOWER)
    upper: Formula | None = Field(None, description=UPPER)

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        given = [k for k in type(self).model_fields if getattr(self, k) is not None]
        if "value" in given and len(given) > 1:
            raise mistake(f"value and {given[1]} are both given", "keep the value, or lower and upper")
        if not given:
            raise mistake("nothing is given here", "write a number, or {lower: ..., upper: ...}, or remove the key")
        return self


class TimeEnd(EndValue):
    """The initial or the final time: fixed, or free in a range."""

    guess: Formula | None = Field(
        None, description="initial guess of a free time; default the middle of its range, if that has two ends"
    )


OPEN_END = TimeEnd.model_construct()
"""What `load` takes for a time that nothing is said of: with phases they say it, else it is a mistake."""


class Time(Entry):
    """When the trajectory begins and ends."""

    initial: TimeEnd = Field(
        OPEN_END, description="initial time: number, expression of parameters, or {lower, upper, guess}"
    )
    final: TimeEnd = Field(
        OPEN_END, description="final time: number, expression of parameters, or {lower, upper, guess}"
    )
    unit: Text = Field("s", description="unit of time; default s")

    @model_serializer(mode="wrap")
    def _what_is_given(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return {key: value for key, value in handler(self).items() if getattr(self, key) != OPEN_END}


class Velocity(Entry):
    """The rate of a state with second-order dynamics: a state too, with bounds and ends of its own."""

    name: Text = Field("", description="its name in expressions; default <state>_dot")
    unit: Text = Field("", description=UNIT + "; default the state's, per unit of time")
    lower: Formula | None = Field(None, description=LOWER)
    upper: Formula | None = Field(None, description=UPPER)
    initial: EndValue | None = Field(None, description="value or {lower, upper} at the initial time; default free")
    final: EndValue | None = Field(None, description="value or {lower, upper} at the final time; default free")
    history: Formula | None = Field(
        None,
        description="its values before the initial time, for x(t - tau): number, or expression of t and parameters",
    )
    note: Text = Field("", description=NOTE)


class StateEntry(Entry):
    """A state, given by its rate of change, by its acceleration, or by residuals."""

    unit: Text = Field("", description=UNIT)
    rate: Formula | None = Field(
        None,
        description="time derivative: an expression of t, states, controls and parameters; "
        "without rate: and accel: the residuals determine it, as x[rate]",
    )
    next: Formula | None = Field(
        None, description="value at the next step, instead of rate: time is then discrete, t = 0, 1, 2, ..."
    )
    accel: Formula | None = Field(
        None, description="second derivative, instead of rate: the state then stands for itself and its velocity"
    )
    velocity: Velocity | None = Field(None, description="{name, unit, lower, upper, initial, final, note} of its rate")
    lower: Formula | None = Field(None, description=LOWER)
    upper: Formula | None = Field(None, description=UPPER)
    initial: EndValue | None = Field(None, description="value or {lower, upper} at the initial time; default free")
    final: EndValue | None = Field(None, description="value or {lower, upper} at the final time; default free")
    history: Formula | None = Field(
        None,
        description="its values before the initial time, for x(t - tau): number, or expression of t and parameters",
    )
    note: Text = Field("", description=NOTE)

    @model_validator(mode="after")
    def _one_kind_of_dynamics(self) -> Self:
        for key in ("accel", "velocity", "next"):
            if self.rate is not None and getattr(self, key) is not None:
                raise mistake(f"rate and {key} are both given", f"keep the rate, or state the dynamics by {key}: alone")
        for key in ("accel", "velocity"):
            if self.next is not None and getattr(self, key) is not None:
                raise mistake(f"next and {key} are both given", f"keep next:, or state the dynamics by {key}: alone")
        return self

    @property
    def second_order(self) -> bool:
        """Whether the state has a velocity that is a state as well."""
        return self.accel is not None or self.velocity is not None

    def velocity_of(self, name: str) -> str:
        """The name of the velocity of a second-order state that is called `name`."""
        return (self.velocity.name if self.velocity else "") or f"{name}_dot"


class IntegralState(StateEntry):
    """The state that a named integral is, see `language.integrals`; no file has it."""


class Control(Entry):
    """A control: a function of time to be found."""

    unit: Text = Field("", description=UNIT)
    lower: Formula | None = Field(None, description=LOWER)
    upper: Formula | None = Field(None, description=UPPER)
    note: Text = Field("", description=NOTE)


class Algebraic(Entry):
    """An algebraic variable: a function of time that the residuals determine."""

    unit: Text = Field("", description=UNIT)
    lower: Formula | None = Field(None, description=LOWER)
    upper: Formula | None = Field(None, description=UPPER)
    note: Text = Field("", description=NOTE)


class Residual(Shorthand):
    """0 = expression, at every collocation point."""

    short: ClassVar[str] = "expression"

    name: Text = Field("", description="name in results; default made from the expression")
    expression: Formula = Field(description="zero at every time: of t, states, x[rate], algebraic variables, controls")


class Static(Entry):
    """A static parameter: one number to be found."""

    lower: Formula | None = Field(None, description=LOWER)
    upper: Formula | None = Field(None, description=UPPER)
    guess: Formula | None = Field(
        None, description="initial guess; default the middle of its range, or what is next to 0 in an open one"
    )
    unit: Text = Field("", description=UNIT)
    note: Text = Field("", description=NOTE)
