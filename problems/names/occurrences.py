"""Every expression of a problem file, with its path and what it may refer to."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence, Set
from typing import NamedTuple

from ..expressions.expression import Expression
from ..schema.declarations import Residual
from ..schema.fields import Entry, expressions_below, held
from ..schema.phases import LinkEntry
from ..schema.sections import ConstraintEntry
from ..schema.spec import Spec
from ..yaml.document import Path

MAX_STEM = 40

# Where an expression stands decides what it may refer to.
CONSTANT, TRAJECTORY, BOUNDARY, GUESS, MEASURED = "constant", "trajectory", "boundary", "guess", "measured"
HISTORY = "history"

SOLVED = frozenset({TRAJECTORY, BOUNDARY})
"""Contexts of what the equations are made of; a guess is evaluated once, before them, and what
is measured at some times only."""

# Sections whose expressions are constants, but for the dynamics among them.
_SECTIONS = ("time", "states", "controls", "algebraic", "optimize", "nonsmooth", "guess")
_DYNAMICS = ("rate", "next", "accel")
_OVER_TIME = ("formulas", "simulate")  # of a guess
_NO_CONSTANTS = frozenset((*_DYNAMICS, *_OVER_TIME, HISTORY))


class Use(NamedTuple):
    """An expression of the file: its path, and what it may refer to."""

    path: Path
    expression: Expression
    context: str


def uses(spec: Spec) -> Iterator[Use]:
    """Every expression of the file."""
    for name, parameter in spec.parameters.items():
        yield Use(("parameters", name), parameter.value, CONSTANT)
    for section in _SECTIONS:
        yield from _constants(getattr(spec, section), (section,))
    for name, named in spec.expressions.items():
        yield Use(("expressions", name), named.value, TRAJECTORY)
    yield from _dynamics(spec)
    yield from _histories(spec)
    yield from _at_times(spec)
    for term, context in (("integral", TRAJECTORY), ("terminal", BOUNDARY)):
        if expression := getattr(spec.objective.terms, term):
            yield Use(("objective", spec.objective.sense, term), expression, context)
    for path, expression in expressions_below(spec.drawing, ("drawing",)):
        yield Use(path, expression, TRAJECTORY)
    yield from _complementary(spec)
    for path, constraint in constraints(spec):
        yield Use((*path, "expression"), constraint.expression, BOUNDARY if path[1] == "boundary" else TRAJECTORY)
        for key in ("lower", "upper", "equals"):
            if bound := getattr(constraint, key):
                yield Use((*path, key), bound, CONSTANT)


def _complementary(spec: Spec) -> Iterator[Use]:
    for i, entry in enumerate(spec.complementarity):
        yield Use(("complementarity", i, "a"), entry.a, TRAJECTORY)
        yield Use(("complementarity", i, "b"), entry.b, TRAJECTORY)


def constraints(spec: Spec) -> Iterator[tuple[Path, ConstraintEntry]]:
    """Every constraint with its path, such as ("constraints", "path", 0)."""
    for kind in ("path", "boundary", "integral"):
        for i, constraint in enumerate(getattr(spec.constraints, kind)):
            yield ("constraints", kind, i), constraint


def _dynamics(spec: Spec) -> Iterator[Use]:
    for name, state in spec.states.items():
        for key in _DYNAMICS:
            if expression := getattr(state, key):
                yield Use(("states", name, key), expression, TRAJECTORY)
    for i, residual in enumerate(spec.residuals):
        yield Use(("residuals", i, "expression"), residual.expression, TRAJECTORY)


def _histories(spec: Spec) -> Iterator[Use]:
    for name, state in spec.states.items():
        for path, own in ((("states", name), state), (("states", name, "velocity"), state.velocity)):
            if own is not None and own.history is not None:
                yield Use((*path, "history"), own.history, HISTORY)


def _at_times(spec: Spec) -> Iterator[Use]:
    """What is guessed over time, and what is measured."""
    for key in _OVER_TIME:
        for name, expression in (getattr(spec.guess, key) or {}).items():
            yield Use(("guess", key, name), expression, GUESS)
    for name, entry in spec.measurements.items():
        for column, expression in entry.compare.items():
            yield Use(measured_path(("measurements", name), column), expression, MEASURED)


def measured_path(path: Path, column: str) -> Path:
    """Where what a column is compared with stands; path: of its measurements."""
    return (*path, "compare", column)


def _constants(value: object, path: Path) -> Iterator[Use]:
    """The expressions below a path, but for the dynamics."""
    if isinstance(value, Expression):
        yield Use(path, value, CONSTANT)
    for key, item in held(value):
        if not (isinstance(value, Entry) and key in _NO_CONSTANTS):
            yield from _constants(item, (*path, key))


def constraint_names(spec: Spec) -> list[str]:
    """A name for each constraint, all different: the one given, or one made from its expression."""
    return _names([constraint for _, constraint in constraints(spec)], "constraint")


def complementarity_names(spec: Spec) -> list[str]:
    """A name for each pair, all different, and none of a constraint unless it was given."""
    texts = [f"{entry.a.text} {entry.b.text}" for entry in spec.complementarity]
    return _made([entry.name for entry in spec.complementarity], texts, "pair", set(constraint_names(spec)))


def residual_names(spec: Spec) -> list[str]:
    """A name for each residual, all different."""
    return _names(spec.residuals, "residual")


def link_names(spec: Spec) -> list[str]:
    """A name for each link that is an expression, all different."""
    return _names([link for link in spec.links if link.expression is not None], "link")


def boundary_names(spec: Spec) -> list[str]:
    """A name for each boundary constraint of the top level, all different."""
    return _names(spec.constraints.boundary, "constraint")


def _names(entries: Sequence[ConstraintEntry | Residual | LinkEntry], default: str) -> list[str]:
    texts = [entry.expression.text if entry.expression else "" for entry in entries]
    return _made([entry.name for entry in entries], texts, default)


def _made(given: Sequence[str], texts: Sequence[str], default: str, others: Set[str] = frozenset()) -> list[str]:
    """The names that are given, and for each that is none one of its text."""
    names: list[str] = []
    taken = {*given, *others}
    for own, text in zip(given, texts, strict=True):
        stem = re.sub(r"\W+", "_", text).strip("_")[:MAX_STEM].strip("_") or default
        candidates = (stem if i == 1 else f"{stem}_{i}" for i in range(1, len(taken) + len(names) + 3))
        names.append(own or next(c for c in candidates if c not in taken and c not in names))
    return names
