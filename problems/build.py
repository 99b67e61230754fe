"""Spec -> Problem: expressions become functions, bounds become numbers, ranges are intersected."""

from __future__ import annotations

import re

from .guess import initial_guess
from .problem import Constraint, Phase, Problem, Range, State, Variable
from .spec import Spec
from .symbols import Symbols, constraints

MAX_NAME = 40


def build(spec: Spec) -> Problem:
    """The continuous problem that a loaded spec states."""
    symbols = Symbols(spec)
    statics = tuple(Variable(name, p.unit, symbols.range(p)) for name, p in spec.optimize.items())
    sense = 1 if spec.objective.minimize else -1
    return Problem(name=spec.name, sense=sense, phases=(_phase(spec, symbols),), parameters=statics)


def _phase(spec: Spec, symbols: Symbols) -> Phase:
    times = symbols.range(spec.time.initial), symbols.range(spec.time.final)
    states = tuple(_state(name, state, symbols) for name, state in spec.states.items())
    controls = tuple(Variable(name, c.unit, symbols.range(c)) for name, c in spec.controls.items())
    terms = spec.objective.terms
    return Phase(
        name="main",
        initial_time=times[0],
        final_time=times[1],
        states=states,
        controls=controls,
        guess=initial_guess(spec, symbols, states, controls, times),
        lagrange=symbols.function(terms.integral) if terms.integral else None,
        mayer=symbols.function(terms.terminal) if terms.terminal else None,
        time_unit=spec.time.unit,
        **_constraints(spec, symbols),
    )


def _state(name, state, symbols: Symbols) -> State:
    bounds = symbols.range(state)
    return State(
        name=name,
        unit=state.unit,
        bounds=bounds,
        rate=symbols.function(state.rate),
        initial=intersection(bounds, symbols.range(state.initial)),
        final=intersection(bounds, symbols.range(state.final)),
    )


def _constraints(spec: Spec, symbols: Symbols) -> dict[str, tuple[Constraint, ...]]:
    built: dict[str, list[Constraint]] = {"path": [], "boundary": [], "integral": []}
    names = constraint_names(spec)
    for (path, constraint), name in zip(constraints(spec), names, strict=True):
        function = symbols.function(constraint.expression)
        built[path[1]].append(Constraint(name, function, symbols.range(constraint)))
    return {kind: tuple(items) for kind, items in built.items()}


def intersection(a: Range, b: Range) -> Range:
    """What two ranges have in common."""
    return Range(max(a.lower, b.lower), min(a.upper, b.upper))


def constraint_names(spec: Spec) -> list[str]:
    """A name for each constraint, all different: the one given, or one made from its expression."""
    names: list[str] = []
    taken = {constraint.name for _, constraint in constraints(spec)}
    for _, constraint in constraints(spec):
        name = constraint.name
        if not name:
            stem = re.sub(r"\W+", "_", constraint.expression.text).strip("_")[:MAX_NAME].strip("_") or "constraint"
            candidates = (stem if i == 1 else f"{stem}_{i}" for i in range(1, len(taken) + len(names) + 3))
            name = next(c for c in candidates if c not in taken and c not in names)
        names.append(name)
    return names
