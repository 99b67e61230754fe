"""What is no mistake and yet hardly meant: a warning each, before a solve finds it out the hard way."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import inf

from ..expressions.expression import Expression
from ..expressions.tree import Lookup, Name, Node, Operation, OperatorChain
from ..measured import compared
from ..names.delays import parameters_of
from ..names.occurrences import constraints
from ..names.roles import ALGEBRAIC, CONTROL, TABLE
from ..names.symbols import Symbols
from ..schema.spec import Spec
from ..yaml.locations import UNUSED, Finding

DEGREES = frozenset(("deg", "degs", "degree", "degrees", "°"))
_ANGLED = frozenset(("sin", "cos", "tan", "cot", "sec", "csc"))


def odd(spec: Spec, symbols: Symbols) -> Iterator[Finding]:
    """The warnings about a spec of one phase without mistakes."""
    yield from _moves_nothing(symbols)
    yield from _unreachable(spec, symbols)
    yield from _in_no_time(spec, symbols)
    yield from _degrees(spec, symbols)


def _moves_nothing(symbols: Symbols) -> Iterator[Finding]:
    """Controls that stand in the objective at most."""
    used = _names_in((use.expression for use in symbols.uses), symbols)
    moving = (use.expression for use in symbols.uses if use.path[0] in ("states", "residuals", "constraints"))
    named = _names_in(moving, symbols)
    for control in symbols.controls:
        if control.name in used - named:
            what = f"the control {control.name} stands in no rate, so it moves nothing"
            yield Finding(control.path, what, f"use {control.name} in the rate of a state, or remove it")


def _names_in(expressions: Iterable[Expression], symbols: Symbols) -> set[str]:
    """All names in expressions, and in the definitions that these need."""
    found, waiting = set[str](), list(expressions)
    while waiting:
        new = {leaf.name for leaf in waiting.pop().leaves} - found
        found |= new
        waiting += [symbols.definitions[name] for name in new if name in symbols.definitions]
    return found


def _unreachable(spec: Spec, symbols: Symbols) -> Iterator[Finding]:
    """States whose constant rate does not lead from one end to the other."""
    first, last = (symbols.range(getattr(spec.time, end)) for end in ("initial", "final"))
    longest, shortest = last.upper - first.lower, max(last.lower - first.upper, 0.0)
    for state in symbols.states:
        rate = getattr(state.entry, "rate", None)
        if state.velocity_of or rate is None or symbols.function(rate).names:
            continue
        constant = symbols.number(rate, 0.0)
        moves = sorted((constant * shortest, constant * longest if constant else 0.0))
        start, end = symbols.range(state.entry.initial), symbols.range(state.entry.final)
        least, most = start.lower + moves[0], start.upper + moves[1]
        if end.upper < least - 1e-9 * (1 + abs(least)) or end.lower > most + 1e-9 * (1 + abs(most)):
            what = f"{state.name} cannot get from {start} to {end}: its rate is {constant:g} at every time"
            yield Finding((*state.path, "final"), what, "change the rate, or leave one of the two ends out")


def _in_no_time(spec: Spec, symbols: Symbols) -> Iterator[Finding]:
    """A minimum time with a control that nothing limits and that acts without a bound."""
    terms = spec.objective.terms
    if spec.objective.sense != "minimize" or terms.integral or terms.terminal is None or spec.time.final.value:
        return
    if symbols.function(terms.terminal).names - {"t[initial]"} != {"t[final]"}:
        return
    held = [part for _, own in constraints(spec) for part in symbols.function(own.expression).parts]
    limited = {leaf.name for part in held for leaf in part.leaves}
    given = filter(None, (_rate(state.entry) for state in symbols.states))
    rates = [part.root for own in given for part in symbols.function(own).parts]
    for control in symbols.controls:
        bounds = symbols.range(control.entry)
        free = bounds.lower == -inf and bounds.upper == inf and control.name not in limited
        if free and any(_acts_without_bound(root, control.name) for root in rates):
            what = (
                f"the control {control.name} has no bounds, and the time is to be short: it may become no time at all"
            )
            yield Finding(control.path, what, "add lower: and upper:, or a term of the objective that makes it dear")


def _rate(entry: object) -> Expression | None:
    return getattr(entry, "rate", None) or getattr(entry, "accel", None)


def _acts_without_bound(root: Node, name: str) -> bool:
    """Whether a name stands outside of every function, as in u/m, not as in sin(u)."""
    if isinstance(root, Name):
        return root.name == name
    if isinstance(root, Operation):
        return root.symbol in ("-", "**") and _acts_without_bound(root.operands[0], name)
    parts = [root.first, *(link.operand for link in root.links)] if isinstance(root, OperatorChain) else []
    return any(_acts_without_bound(part, name) for part in parts)


def _degrees(spec: Spec, symbols: Symbols) -> Iterator[Finding]:
    """Angles in degrees that stand as they are under sin, cos and the like."""
    variables = symbols.variables
    angles = {own.name: own.path for own in variables if _unit(own.entry) in DEGREES}
    angles |= {name: ("parameters", name) for name, own in spec.parameters.items() if own.unit.strip() in DEGREES}
    told = set()
    for use in symbols.uses:
        for node in use.expression.nodes:
            if not (isinstance(node, Operation) and node.symbol in _ANGLED):
                continue
            for name in _summed(node.operands[0]):
                if name in angles and name not in told:
                    told.add(name)
                    what = f"{name} has the unit deg, but {node.symbol}({name}) takes it as radians"
                    yield Finding((*angles[name], "unit"), what, f"write {node.symbol}(pi/180*{name}), or unit: rad")


def _unit(entry: object) -> str:
    return str(getattr(entry, "unit", "")).strip()


def _summed(node: Node) -> Iterator[str]:
    """The names that a sum or a difference is made of, without factors."""
    if isinstance(node, Name):
        yield node.name
    elif isinstance(node, Operation) and node.symbol == "-":
        yield from _summed(node.operands[0])
    elif isinstance(node, OperatorChain) and all(link.symbol in "+-" for link in node.links):
        for part in (node.first, *(link.operand for link in node.links)):
            yield from _summed(part)


# What should stand in some expression: its role, and the section that declares it.
_USED = {
    "parameter": "parameters",
    "expression": "expressions",
    CONTROL: "controls",
    ALGEBRAIC: "algebraic",
    "static parameter": "optimize",
    TABLE: "tables",
}


def unused(spec: Spec, symbols: Symbols, called: Iterable[str] = ()) -> Iterator[Finding]:
    """A warning for each name that no expression uses.

    spec: without mistakes, its functions written out.
    symbols: of it.
    called: keys of the functions that it called before.
    """
    used = [node for use in symbols.uses for node in use.expression.nodes]
    named = {node.table if isinstance(node, Lookup) else node.name for node in used if isinstance(node, Lookup | Name)}
    named |= parameters_of(symbols.uses)
    named |= {column for entry in spec.measurements.values() for column in compared(entry, symbols)}
    outputs = {name for name, written in spec.expressions.items() if written.unit or written.note}
    outputs = {name for name in outputs if "(" not in name}.union(called)
    for name, role in symbols.roles.items():
        if role in _USED and name not in named | outputs:
            what = f"the {role} {name} is used nowhere"
            yield Finding((_USED[role], name), what, "remove it, or use it in an expression", UNUSED)
