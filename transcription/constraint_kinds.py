"""The kinds of constraints of a nonlinear program: one row each, with all that depends on the kind.

Messages, LaTeX, scaling, warm starts, costates, the error bar and `verify` read this table; a new kind is a new row.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum, auto

from ..problems.lean.records import dataclass
from ..problems.quantities import Constraint, EndConstraint, Range, State


class Multiplier(Enum):
    """What the multiplier of a row is for the continuous problem."""

    COSTATE = auto()  # with those of the other rows of its segment
    DENSITY = auto()  # times the quadrature weight of its point: a function of time
    NUMBER = auto()  # of a constraint that holds once


@dataclass(frozen=True)
class ConstraintKind:
    """phrase, heading: in messages and in LaTeX, with {} for the name of the state or the constraint.

    functions: the attribute of Phase that holds the constraints, or "" for those that the method makes itself.
    timed: whether a row holds at a time, or between two. model: whether the user's equations of motion are meant, which
    hold for any controls. sized: whether a row has the unit of the state it is named after.
    """

    name: str
    phrase: str
    heading: str
    functions: str
    multiplier: Multiplier
    timed: bool = True
    model: bool = False
    sized: bool = False

    def __str__(self) -> str:
        return self.name

    def __reduce__(self) -> tuple[Callable[[str], ConstraintKind], tuple[str]]:
        """A kind that is read from a pickle is the row of the table itself: they are compared by identity."""
        return kind_called, (self.name,)


# fmt: off
DEFECT = ConstraintKind(
    "defect", "the dynamics of {}", "Defect of {}", "", Multiplier.COSTATE, model=True, sized=True)
RESIDUAL = ConstraintKind(
    "residual", "residual '{}'", "Residual {}", "residuals", Multiplier.DENSITY, model=True)
DELAY = ConstraintKind(  # what a state at an earlier time is
    "delay", "the value of {}", "Value of {}", "", Multiplier.DENSITY, model=True)
PATH = ConstraintKind(
    "path", "path constraint '{}'", "Path constraint {}", "path", Multiplier.DENSITY)
PATH_END = ConstraintKind(  # of a path constraint at an end that is no collocation point
    "path end", "path constraint '{}'", "Path constraint {}", "", Multiplier.NUMBER)
RESIDUAL_END = ConstraintKind(  # of a residual at such an end, where a path constraint is about what it determines
    "residual end", "residual '{}'", "Residual {}", "", Multiplier.NUMBER, model=True)
BOUND = ConstraintKind(  # of a state that is no variable
    "bound", "the bounds of {}", "Bounds of {}", "", Multiplier.DENSITY, sized=True)
BOUND_INITIAL = ConstraintKind(
    "bound initial", "the initial value of {}", "Initial value of {}", "", Multiplier.NUMBER, sized=True)
BOUND_FINAL = ConstraintKind(
    "bound final", "the final value of {}", "Final value of {}", "", Multiplier.NUMBER, sized=True)
BOUNDARY = ConstraintKind(
    "boundary", "boundary constraint '{}'", "Boundary constraint {}", "boundary", Multiplier.NUMBER, timed=False)
CONDITION = ConstraintKind(  # without time
    "condition", "constraint '{}'", "Constraint {}", "boundary", Multiplier.NUMBER, timed=False)
INTEGRAL = ConstraintKind(
    "integral", "integral constraint '{}'", "Integral constraint {}", "integral", Multiplier.NUMBER, timed=False)
LINK = ConstraintKind(  # between the ends of phases
    "link", "link '{}'", "Link {}", "", Multiplier.NUMBER, timed=False)
ENDS = ConstraintKind(  # the same, where the file has it among the boundary constraints of the top level
    "ends", BOUNDARY.phrase, BOUNDARY.heading, "", Multiplier.NUMBER, timed=False)
# fmt: on


OF_STATES = (BOUND, BOUND_INITIAL, BOUND_FINAL)
"""What is asked of a state that is no variable."""

AT_ENDS = {PATH_END: PATH, RESIDUAL_END: RESIDUAL}
"""What holds at an end that is no collocation point -> what it is over time."""

KINDS = (DEFECT, RESIDUAL, DELAY, PATH, PATH_END, RESIDUAL_END, *OF_STATES, BOUNDARY, CONDITION, INTEGRAL, LINK, ENDS)


def kind_called(name: str) -> ConstraintKind:
    """The row of a name."""
    return next(kind for kind in KINDS if kind.name == name)


def range_of_state(kind: ConstraintKind, state: State) -> Range:
    """What rows of a kind, one of OF_STATES, hold a state to."""
    return {BOUND: state.bounds, BOUND_INITIAL: state.initial, BOUND_FINAL: state.final}[kind]


def kind_between(constraint: Constraint) -> ConstraintKind:
    """What a constraint on the ends of several phases is called."""
    return ENDS if isinstance(constraint, EndConstraint) else LINK
