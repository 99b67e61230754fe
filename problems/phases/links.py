"""The links of a problem, and its objective of the whole trajectory, as functions of the ends of all phases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import chain, count

from ..expressions.expression import Expression
from ..expressions.tree import Link, Name, OperatorChain
from ..names.occurrences import boundary_names, link_names
from ..names.symbols import Symbols
from ..problem import Phase
from ..quantities import Constraint, Continuity, Duration, EndConstraint, Function, Range
from ..schema.spec import Spec
from .between import Between
from .order import TIME, expression_links, goes_on_in_time, own_entries, passages

ZERO = Range(0.0, 0.0)


def links_of(
    spec: Spec, phases: Sequence[Phase], symbols: Mapping[str, Symbols]
) -> tuple[tuple[Constraint, ...], Function | None]:
    """The constraints between phases, and the terminal objective of the top level.

    spec: of the file, without mistakes, its functions written out.
    phases: all of them, in order.
    symbols: of each phase.
    """
    between = Between(symbols, Symbols(spec))
    links = [*_passages(spec, {phase.name: phase for phase in phases})]
    names = link_names(spec)
    for (number, link), name in zip(expression_links(spec), names, strict=True):
        assert link.expression is not None  # as it is one of these
        links.append(Constraint(name, between.function(link.expression), between.range(link, ("links", number))))
    for i, (constraint, name) in enumerate(zip(spec.constraints.boundary, boundary_names(spec), strict=True)):
        bounds = between.range(constraint, ("constraints", "boundary", i))
        links.append(EndConstraint(name, between.function(constraint.expression), bounds))
    terminal = spec.objective.terms.terminal
    return tuple(links), None if terminal is None else between.function(terminal)


def with_times_in_order(phase: Phase) -> Phase:
    """The phase, which does not end before it begins where its times leave that open."""
    if phase.final_time.lower >= phase.initial_time.upper:
        return phase
    text = "t[final] - t[initial]"
    last, first = Name(0, 0, TIME, "final"), Name(0, 0, TIME, "initial")
    duration = Expression(text, OperatorChain(0, len(text), last, (Link(0, len(text), "-", first),)))
    taken = {own.name for own in phase.boundary}
    name = next(own for own in chain(["duration"], map("duration_{}".format, count(2))) if own not in taken)
    return replace(phase, boundary=(*phase.boundary, Duration(name, duration, Range(lower=0.0))))


def _passages(spec: Spec, phases: Mapping[str, Phase]) -> list[Constraint]:
    """Time and states that go on from phase to phase, but for what is given as one number on both sides."""
    links: list[Constraint] = []
    for own in passages(spec):
        source, target = phases[own.source], phases[own.target]
        if goes_on_in_time(spec, own) and not (source.final_time.fixed and target.initial_time.fixed):
            links.append(continuity(TIME, own.source, own.target))
        ends = {state.name: state.final for state in source.states}
        integrals = {*spec.integrals, *own_entries(spec)[own.target].integrals}
        for state in target.states:
            goes_on = state.name in ends and state.name not in own.left_out and state.name not in integrals
            if goes_on and not (state.initial.fixed and ends[state.name].fixed):
                links.append(continuity(state.name, own.source, own.target))
    return links


def continuity(name: str, source: str, target: str) -> Continuity:
    """A state, or t, has the same value at the end of one phase and at the start of another.

    name: of the state in both.
    source: the phase that ends.
    target: the phase that begins.
    """
    end, start = Name(0, 0, f"{source}.{name}", "final"), Name(0, 0, f"{target}.{name}", "initial")
    text = f"{target}.{name}[initial] - {source}.{name}[final]"
    difference = Expression(text, OperatorChain(0, len(text), start, (Link(0, len(text), "-", end),)))
    return Continuity(f"{name} from {source} to {target}", difference, ZERO)
