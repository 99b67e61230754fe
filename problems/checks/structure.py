"""Checks of how a problem is put together: dynamics that are complete, a model's names, abs and max, the solver."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from ..chains.check import value_mistakes
from ..expressions.expression import Expression
from ..expressions.smooth import SLACK
from ..expressions.tree import rate_of
from ..names.occurrences import constraints
from ..names.symbols import UNKNOWN, Symbols
from ..nonsmooth.rewrite import consistent, untreated
from ..schema.fields import Bounded
from ..schema.spec import Spec
from ..text import brief, did_you_mean
from ..yaml.document import Path
from ..yaml.locations import Finding

_SHOWN = 5


def structure_mistakes(spec: Spec, symbols: Symbols, numbers: Mapping[Path, float]) -> list[Finding]:
    """Every mistake in how the problem is put together.

    spec: as the schema has passed it.
    symbols: its names and values.
    numbers: path -> value of every constant of the file that has one, in the unit of the file.
    """
    found = [*untreated(spec, symbols), *_widths(spec, numbers), *_tolerance(spec), *value_mistakes(spec, symbols)]
    if spec.solver.engine == "newton":
        found += _inequalities(spec, symbols, numbers)
    return [*found, *_residuals(spec, symbols)]


def structure_warnings(spec: Spec, symbols: Symbols) -> list[Finding]:
    """What is odd in a spec without mistakes."""
    return [*consistent(spec, symbols).warnings, *_high_index(spec, symbols)]


def _widths(spec: Spec, numbers: Mapping[Path, float]) -> Iterator[Finding]:
    """alpha or beta: positive, and one, or one for each entry of the mesh schedule."""
    if spec.nonsmooth is None or not spec.nonsmooth.widths:
        return
    path, meshes = ("nonsmooth", spec.nonsmooth.treatment), len(spec.mesh)
    given = len(spec.nonsmooth.widths)
    if given not in (1, meshes):
        what = f"there are {given} values for {_count(meshes, 'entry')} of the mesh schedule"
        yield Finding(path, what, "give one value, or one for each entry of mesh:")
    for i in range(given):
        if numbers.get((*path, i), 1.0) <= 0:
            what = f"the width of the smoothing is {numbers[*path, i]:g}"
            yield Finding(path if given == 1 else (*path, i), what, "write a positive number such as 0.01")


def _tolerance(spec: Spec) -> Iterator[Finding]:
    if "tol" in spec.solver.options:
        remedy = "write it as tolerance: in each entry of mesh:"
        yield Finding(("solver", "tol"), "the tolerance of the solver belongs to the mesh", remedy)


def scaling_mistakes(spec: Spec, symbols: Symbols) -> Iterator[Finding]:
    """Sizes are given for unknowns only; with `nonsmooth`, for a spec that is otherwise right."""
    if not isinstance(spec.scaling, dict):
        return
    slack = consistent(spec, symbols) if spec.nonsmooth else None
    variables = symbols.variables
    known = [*(variable.name for variable in variables), *spec.optimize]
    known += [variable.name for variable in (*slack.controls, *slack.parameters)] if slack else []
    for name in spec.scaling:
        if name not in known:
            remedy = did_you_mean(name, known, f"those that have one are {_listed(known)}")
            what = f"{brief(name)} is no state, control or other unknown, so it has no size"
            yield Finding(("scaling", name), what, remedy)


def _inequalities(spec: Spec, symbols: Symbols, numbers: Mapping[Path, float]) -> Iterator[Finding]:
    """What Newton's method cannot do: a range of more than one value, of a variable or of a constraint."""
    remedy = "make it one value, remove it, or leave out engine: newton"
    for path, entry, bounds in _limited(spec, symbols):
        lower, upper = (numbers.get((*path, key)) for key in ("lower", "upper"))
        if getattr(entry, "equals", None) is None and lower != upper:
            what = f"the Newton engine takes {'no bounds' if bounds else 'equality constraints only'}"
            at = (*path, "lower" if lower is not None else "upper") if bounds else path
            yield Finding(at, what, remedy)
    if spec.complementarity:
        what = "the Newton engine takes equality constraints only, and complementarity is made of inequalities"
        yield Finding(("complementarity",), what, "leave out engine: newton")
    if spec.nonsmooth and spec.nonsmooth.treatment == SLACK:
        what = "the Newton engine takes no bounds, and slack variables have them"
        yield Finding(("nonsmooth",), what, "write nonsmooth: {tanh: 0.01}, or leave out engine: newton")


class _Limited(NamedTuple):
    """What has lower and upper, its path, and whether it bounds a variable rather than a constraint."""

    path: Path
    entry: Bounded | None
    of_variable: bool


def _limited(spec: Spec, symbols: Symbols) -> Iterator[_Limited]:
    """All that has lower and upper."""
    for declared in symbols.variables:
        yield _Limited(declared.path, declared.entry, True)
    for path, owner in (*((state.path, state.entry) for state in symbols.states), (("time",), spec.time)):
        for end in ("initial", "final"):
            yield _Limited((*path, end), getattr(owner, end), True)
    yield from (_Limited(("optimize", name), entry, True) for name, entry in spec.optimize.items())
    yield from (_Limited(path, entry, False) for path, entry in constraints(spec))


def _residuals(spec: Spec, symbols: Symbols) -> Iterator[Finding]:
    """As many residuals as algebraic variables, and every one of these in some residual."""
    unknowns = [variable.name for variable in symbols.algebraic]
    if not spec.residuals:
        yield from _no_residuals(spec, symbols)
    elif len(spec.residuals) != len(unknowns):
        variables = _count(len(unknowns), "algebraic variable") + (f" ({_listed(unknowns)})" if unknowns else "")
        what = f"there must be as many residuals as algebraic variables, not {len(spec.residuals)} for {variables}"
        yield Finding(("residuals",), what, "a state without rate: or accel: makes its rate an algebraic variable")
    elif all(symbols.sound(("residuals", i, "expression"), r.expression) for i, r in enumerate(spec.residuals)):
        held = [_names(residual.expression, symbols) for residual in spec.residuals]
        for variable in symbols.algebraic:
            if not any(variable.name in names or UNKNOWN.text in names for names in held):
                what = f"{variable.name} stands in no residual, so nothing determines it"
                yield Finding(variable.path, what, f"use {variable.name} in residuals:")


def _no_residuals(spec: Spec, symbols: Symbols) -> Iterator[Finding]:
    for name in spec.algebraic:
        yield Finding(("algebraic", name), f"nothing determines {name}", f"add residuals: with {name} in one of them")
    for state in symbols.states:
        if state.implicit:
            key = "accel" if state.velocity_of else "rate"
            remedy = f"add {key}: an expression, or residuals: with {rate_of(state.name)} in one of them"
            yield Finding(state.path, f"nothing determines how {state.name} changes: {key} is missing", remedy)


def _count(number: int, noun: str) -> str:
    many = f"{noun[:-1]}ies" if noun.endswith("y") else f"{noun}s"
    return f"{number} {noun if number == 1 else many}"


def _listed(names: list[str]) -> str:
    shown = names if len(names) <= _SHOWN else [*names[:_SHOWN], "..."]
    return ", ".join(shown)


def _high_index(spec: Spec, symbols: Symbols) -> Iterator[Finding]:
    """A residual that leaves the algebraic variables alone makes a problem of higher index, hard for any method."""
    unknowns = {variable.name for variable in symbols.algebraic}
    for i, residual in enumerate(spec.residuals):
        if not unknowns & _names(residual.expression, symbols):
            what = "no algebraic variable and no x[rate] stands in this residual, so it restricts the states"
            yield Finding(("residuals", i, "expression"), what, "differentiate it by time until one does")


def _names(expression: Expression, symbols: Symbols) -> set[str]:
    """The names in an expression and in the definitions that it uses."""
    return {leaf.name for part in symbols.function(expression).parts for leaf in part.leaves}
