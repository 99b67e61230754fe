"""Every expression of a problem file, with its path and what it may refer to."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from ..expressions.expression import Expression
from ..schema.declarations import Residual
from ..schema.fields import Entry
from ..schema.phases import LinkEntry
from ..schema.sections import ConstraintEntry
from ..schema.spec import Spec
from ..yaml.document import Path

MAX_STEM = 40

# Where an expression stands decides what it may refer to.
CONSTANT, TRAJECTORY, BOUNDARY, GUESS = "constant", "trajectory", "boundary", "guess"

SOLVED = frozenset({TRAJECTORY, BOUNDARY})
"""Contexts of what the equations are made of; a guess is evaluated once, before them."""

# Sections whose expressions are constants, but for the rates and accelerations among them.
_SECTIONS = ("time", "states", "controls", "algebraic", "optimize", "nonsmooth", "guess")
_DYNAMICS = ("rate", "accel")
_OVER_TIME = ("formulas", "simulate")  # of a guess


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
    yield from _guessed(spec)
    for term, context in (("integral", TRAJECTORY), ("terminal", BOUNDARY)):
        if expression := getattr(spec.objective.terms, term):
            yield Use(("objective", spec.objective.sense, term), expression, context)
    for path, constraint in constraints(spec):
        yield Use((*path, "expression"), constraint.expression, BOUNDARY if path[1] == "boundary" else TRAJECTORY)
        for key in ("lower", "upper", "equals"):
            if bound := getattr(constraint, key):
                yield Use((*path, key), bound, CONSTANT)


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


def _guessed(spec: Spec) -> Iterator[Use]:
    for key in _OVER_TIME:
        for name, expression in (getattr(spec.guess, key) or {}).items():
            yield Use(("guess", key, name), expression, GUESS)


def _constants(value: object, path: Path) -> Iterator[Use]:
    """The expressions below a path, but for the dynamics."""
    if isinstance(value, Expression):
        yield Use(path, value, CONSTANT)
    elif isinstance(value, list):
        for i, item in enumerate(value):
            yield from _constants(item, (*path, i))
    elif isinstance(value, dict):
        for key, item in value.items():
            yield from _constants(item, (*path, key))
    elif isinstance(value, Entry):
        for key, item in value:
            if key not in (*_DYNAMICS, *_OVER_TIME):
                yield from _constants(item, (*path, key))


def constraint_names(spec: Spec) -> list[str]:
    """A name for each constraint, all different: the one given, or one made from its expression."""
    return _names([constraint for _, constraint in constraints(spec)], "constraint")


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
    names: list[str] = []
    taken = {entry.name for entry in entries}
    for entry in entries:
        name = entry.name
        if not name:
            text = entry.expression.text if entry.expression else ""
            stem = re.sub(r"\W+", "_", text).strip("_")[:MAX_STEM].strip("_") or default
            candidates = (stem if i == 1 else f"{stem}_{i}" for i in range(1, len(taken) + len(names) + 3))
            name = next(c for c in candidates if c not in taken and c not in names)
        names.append(name)
    return names
