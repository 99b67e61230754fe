"""Bounds that keep the arguments of tables of data within their points, where a table says `outside: error`."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator
from dataclasses import field, replace
from itertools import chain, count

from ..lean.records import dataclass
from ..problem import Phase
from ..quantities import Constraint, Function, Range, State
from .lookups import KeptWithin, kept_within


@dataclass
class _Bounds:
    """variables: name -> its range at every time. ends: (name, end) -> its range there. path, boundary: arguments that
    are no names, each once, with the range of all the tables that have them."""

    variables: dict[str, Range] = field(default_factory=dict)
    ends: dict[tuple[str, str], Range] = field(default_factory=dict)
    path: dict[Hashable, KeptWithin] = field(default_factory=dict)
    boundary: dict[Hashable, KeptWithin] = field(default_factory=dict)


def within_tables(phase: Phase) -> Phase:
    """The phase with a bound on what is an argument of a table, and with a constraint on an argument that is no name.

    phase: with functions that are expressions of a file; those of a model look up nothing.
    """
    found = _Bounds()
    bounded = {"t", *(variable.name for variable in (*phase.states, *phase.found))}
    varying = bounded.union(own.name for own in phase.delayed)
    fixed_times = phase.initial_time.fixed and phase.final_time.fixed
    for own in _all(phase.over_time):
        asked = own.function.names & varying
        if own.name in bounded:
            found.variables[own.name] = found.variables.get(own.name, Range()).intersection(own.points)
        elif asked and not (asked == {"t"} and fixed_times):  # what is known at all times `checks` has looked at
            _add(found.path, own)
        elif own.function.names and not asked:
            _add(found.boundary, own)
    for own in _all(phase.at_ends):
        if own.end and own.name in {"t", *(state.name for state in phase.states)}:
            place = own.name, own.end
            found.ends[place] = found.ends.get(place, Range()).intersection(own.points)
        elif own.function.names:
            _add(found.boundary, own)
    return _bounded(phase, found) if found != _Bounds() else phase


def _all(functions: Iterable[Function]) -> Iterator[KeptWithin]:
    return (own for function in functions for own in kept_within(function))


def _add(constraints: dict[Hashable, KeptWithin], own: KeptWithin) -> None:
    known = constraints.get(own.key)
    points = own.points if known is None else known.points.intersection(own.points)
    constraints[own.key] = (known or own)._replace(points=points)


def _bounded(phase: Phase, found: _Bounds) -> Phase:
    times = found.variables.get("t", Range())
    initial, final = (times.intersection(found.ends.get(("t", end), Range())) for end in ("initial", "final"))
    taken = {constraint.name for constraint in (*phase.path, *phase.boundary, *phase.integral)}
    return replace(
        phase,
        initial_time=phase.initial_time.intersection(initial),
        final_time=phase.final_time.intersection(final),
        states=tuple(_state(state, found) for state in phase.states),
        controls=tuple(replace(u, bounds=_range(u.name, u.bounds, found)) for u in phase.controls),
        algebraic=tuple(replace(z, bounds=_range(z.name, z.bounds, found)) for z in phase.algebraic),
        path=(*phase.path, *_constraints(found.path.values(), taken)),
        boundary=(*phase.boundary, *_constraints(found.boundary.values(), taken)),
    )


def _range(name: str, bounds: Range, found: _Bounds) -> Range:
    return bounds.intersection(found.variables.get(name, Range()))


def _state(state: State, found: _Bounds) -> State:
    bounds = _range(state.name, state.bounds, found)
    initial, final = (
        bounds.intersection(own).intersection(found.ends.get((state.name, end), Range()))
        for end, own in (("initial", state.initial), ("final", state.final))
    )
    return replace(state, bounds=bounds, initial=initial, final=final)


def _constraints(arguments: Iterable[KeptWithin], taken: set[str]) -> Iterator[Constraint]:
    """A constraint for each, with a name of its own: "mach of thrust"."""
    for own in arguments:
        stem = f"{own.argument} of {own.table}"
        name = next(n for n in chain([stem], (f"{stem} {i}" for i in count(2))) if n not in taken)
        taken.add(name)
        yield Constraint(name, own.function, own.points)
