"""Checks of a whole file: each of its phases by itself, and what connects them."""

from __future__ import annotations

import keyword
from collections.abc import Iterator, Mapping

from ..expressions.expression import Expression
from ..expressions.functions import is_inconsistent
from ..expressions.signature import name_trouble
from ..expressions.tree import Lookup, Operation, skeleton
from ..language.functions import called_functions
from ..language.plain import shared_in_plain
from ..names.symbols import Symbols
from ..names.variables import states
from ..phases.between import Between
from ..phases.merge import home, phase_specs, phases_as_written
from ..phases.order import TIME, Passage, expression_links, forward, goes_on_in_time, own_entries, passages
from ..quantities import Range
from ..schema.declarations import OPEN_END, Time
from ..schema.phases import LinkEntry
from ..schema.sections import ConstraintEntry
from ..schema.spec import Spec
from ..text import brief, did_you_mean
from ..yaml.document import Path
from ..yaml.locations import OPEN_TIME, UNUSED, Finding
from .guesses import computed_guess, misnamed, uneven, unordered
from .names import check_names
from .values import NO_STATES, check_phase

OF_INTEGRALS = ("integral",)
"""What stands before the point in integral.work is no phase."""

_SMOOTH = "write it smooth, such as sqrt(y**2 + 1e-6) for abs(y)"


def check_spec(spec: Spec, whole: bool = True) -> tuple[list[Finding], list[Finding]]:
    """Every mistake and every warning that concerns more than one value of a file.

    spec: as the schema has passed it.
    whole: whether every value is the file's own; else some stand for mistaken ones, and nothing can be computed that
        needs all of them.
    """
    if not spec.phases and not spec.waypoints:
        if spec.links:
            what = "there are links, but no phases to link"
            return [Finding(("links",), what, "add phases:, or write the conditions under constraints.boundary")], []
        found, warned = check_phase(spec, whole)
        if found or not own_entries(spec):
            return found + (list(computed_guess(spec)) if whole and not found else []), warned
    errors = list(_structure(spec))
    if errors:
        return errors, []
    written = phases_as_written(spec)
    warnings: list[Finding] = []
    open_ends = list(_open_ends(spec))
    for name, phase in written.items():
        if not phase.states:
            errors.append(Finding(("phases", name), f"the phase {name} has no states", NO_STATES.remedy))
            continue
        found, warned = check_phase(phase, whole, name)
        errors += (_at_home(spec, name, finding) for finding in found)
        warnings += (_at_home(spec, name, finding) for finding in warned)
    if not all(phase.states for phase in written.values()):
        return errors, []
    own = phase_specs(spec)
    if open_ends:
        errors = [*open_ends, *(error for error in errors if error.kind != OPEN_TIME)]
    symbols = {name: Symbols(phase) for name, phase in own.items()}
    called = called_functions(spec)
    spec, mistaken_calls = shared_in_plain(spec)
    between = Between(symbols, Symbols(spec))
    connected = [
        *_calls(mistaken_calls),
        *_expressions(spec, between),
        *check_names(spec),
        *_frames(spec, between),
        *_absent(spec, between),
    ]
    if whole and not errors and not connected:
        connected += [*_passages(spec, own, symbols), *_objective(spec, own), *_ranges(spec, between)]
        connected += computed_guess(spec) if not connected else []
    return list(dict.fromkeys(errors + connected)), [*_everywhere(spec, own, warnings, called)]


def _at_home(spec: Spec, phase: str, finding: Finding) -> Finding:
    return finding._replace(path=home(spec, phase, finding.path))


def _structure(spec: Spec) -> Iterator[Finding]:
    """Names of phases, and phases that links name."""
    if spec.phases and spec.waypoints:
        what = "phases: and waypoints: are both given"
        yield Finding(("waypoints",), what, "keep one: waypoints make phases by themselves")
        return
    names = list(own_entries(spec))
    if len(names) < len(spec.waypoints) + 1 and spec.waypoints:
        yield Finding(("waypoints",), "two waypoints have one name", "give each its own name")
    for i, name in enumerate(names):
        path: Path = ("phases", name) if spec.phases else ("waypoints", i, "name")
        if trouble := name_trouble(name, (*keyword.kwlist, *OF_INTEGRALS)):
            yield Finding(path, *trouble)
    yield from _waypoints(spec)
    for i, link in enumerate(spec.links):
        for key, name in (("from", link.source), ("to", link.target)):
            if link.expression is None and not link.apart and name not in names:
                remedy = did_you_mean(name, names, f"the phases are {', '.join(names)}")
                yield Finding(("links", i, key), f'there is no phase "{name}"', remedy)
    yield from _said_twice(spec)


def _said_twice(spec: Spec) -> Iterator[Finding]:
    """Links that say of two phases, or of an expression, what another has said."""
    said: dict[object, int] = {}
    for i, link in enumerate(spec.links):
        formulas = (link.expression, link.lower, link.upper, link.equals)
        own = link.source, link.target, *(formula and skeleton(formula.root) for formula in formulas)
        if link.apart or (first := said.setdefault(own, i)) == i:
            continue
        if link.expression is None:
            what = f"links.{first} has said that {link.target} goes on from {link.source}"
            yield Finding(("links", i), what, "keep one of the two, with all that jumps under except: of it")
        else:
            yield Finding(("links", i), f"links.{first} says this already", "keep one of the two")


def _waypoints(spec: Spec) -> Iterator[Finding]:
    """Waypoints give values of states."""
    known = [state.name for state in states(spec)]
    for i, waypoint in enumerate(spec.waypoints):
        for name in waypoint.states:
            if name not in known:
                remedy = did_you_mean(name, known, f"the states are {', '.join(known)}")
                yield Finding(("waypoints", i, name), f"{brief(name)} is not a state", remedy)


def _open_ends(spec: Spec) -> Iterator[Finding]:
    """Nobody says when the first phase begins, or when the last ends."""
    entries = own_entries(spec)
    before = forward(spec)
    for end, where, outer in (
        ("initial", "the first phase begins", [name for name in entries if name not in before]),
        ("final", "the last phase ends", [name for name in entries if name not in before.values()]),
    ):
        missing = [name for name in outer if getattr(entries[name].time, end) is None]
        if missing and getattr(spec.time, end) == OPEN_END:
            remedy = f"write time: {{{end}: ...}}, at the top level or in the phase {missing[0]}"
            path: Path = ("time",) if spec.time != Time() else ("phases", missing[0])
            yield Finding(path, f"nothing says when {where}", remedy)


def _calls(mistaken: list[Finding]) -> Iterator[Finding]:
    """The mistakes in calls of functions that are about the ends of several phases; others are told by the phases."""
    for finding in mistaken:
        if finding.path[:2] == ("constraints", "boundary") or "terminal" in finding.path or finding.path[0] == "links":
            yield finding


def _expressions(spec: Spec, between: Between) -> Iterator[Finding]:
    """The names in everything that is about the ends of several phases."""
    for path, expression, constant in _uses(spec):
        yield from between.findings(path, expression, constant)
        for node in expression.nodes:
            if isinstance(node, Operation) and is_inconsistent(node.symbol) and not constant:
                what = f"{node.symbol} is not smooth, and nonsmooth: is about expressions of one phase"
                yield Finding(path, what, _SMOOTH)
    for name in spec.measurements if spec.phases or spec.waypoints else ():
        what = "with phases, measurements belong to one of them"
        yield Finding(("measurements", name), what, "move them into a phase")
    for i, _ in enumerate(spec.constraints.integral):
        what = "with phases, an integral constraint belongs to one of them"
        remedy = "move it into a phase; for the whole trajectory use a state with this as its rate"
        yield Finding(("constraints", "integral", i), what, remedy)


def _frames(spec: Spec, between: Between) -> Iterator[Finding]:
    """What the guess says of the whole trajectory: names that some phase has, keyframes that fit together."""
    guess = spec.guess
    known = [v.name for own in between.phases.values() for v in (*own.states, *own.controls, *own.algebraic)]
    whole = guess.model_copy(update={"constants": {}, "formulas": {}})  # these are of every phase
    yield from misnamed(whole, known, "a state or a control of any phase")
    for name, row in guess.keyframes.items():
        for i, value in enumerate(row):
            yield from between.findings(("guess", "keyframes", name, i), value, constant=True)
    yield from uneven(guess)
    times = [between.shared.number(v, 0.0) for v in guess.keyframes.get("time", ()) if not between.unsound(v)]
    yield from unordered(times)


def _absent(spec: Spec, between: Between) -> Iterator[Finding]:
    """What a phase is said to be without, or a link to leave out, is there; a phase that is late has a time."""
    shared = [*spec.states, *spec.controls, *spec.algebraic, *spec.integrals]
    for phase, entry in own_entries(spec).items():
        for i, name in enumerate(entry.without):
            if name not in shared:
                remedy = did_you_mean(name, shared, f"the top level has {', '.join(shared)}")
                yield Finding(("phases", phase, "without", i), f"the top level has no {brief(name)}", remedy)
    for i, link in enumerate(spec.links):
        if link.expression is not None or link.apart:
            continue
        if TIME in link.left_out and link.target in spec.phases and spec.phases[link.target].time.initial is None:
            remedy = f"add time: {{initial: ...}} to the phase {link.target}, or remove t from except:"
            yield Finding(("links", i, "except"), f"nothing says when {link.target} begins", remedy)
        own = [between.phases[phase] for phase in (link.source, link.target) if phase in between.phases]
        states = sorted({state.name for symbols in own for state in symbols.states})
        for name in link.left_out:
            if name not in (*states, TIME):
                remedy = did_you_mean(name, states, "name a state, or t for the time")
                yield Finding(("links", i, "except"), f'there is no state "{name}" to leave out', remedy)


def _conditions(spec: Spec) -> Iterator[tuple[Path, LinkEntry | ConstraintEntry]]:
    """What is asked of the ends of several phases: links with an expression, boundary constraints of the top level."""
    yield from ((("links", i), link) for i, link in expression_links(spec))
    yield from ((("constraints", "boundary", i), entry) for i, entry in enumerate(spec.constraints.boundary))


def _uses(spec: Spec) -> Iterator[tuple[Path, Expression, bool]]:
    """(path, expression, whether it must be a constant)."""
    for path, entry in _conditions(spec):
        if entry.expression is not None:
            yield (*path, "expression"), entry.expression, False
        for key in ("lower", "upper", "equals"):
            if (bound := getattr(entry, key)) is not None:
                yield (*path, key), bound, True
    if (terminal := spec.objective.terms.terminal) is not None:
        yield ("objective", spec.objective.sense, "terminal"), terminal, False


def _ranges(spec: Spec, between: Between) -> Iterator[Finding]:
    """Bounds on the ends of several phases leave room."""
    for path, entry in _conditions(spec):
        bounds = between.range(entry)
        if bounds.lower > bounds.upper:
            what = f"lower {bounds.lower:g} is above upper {bounds.upper:g}"
            yield Finding((*path, "lower"), what, "exchange or change them")


def _passages(spec: Spec, specs: Mapping[str, Spec], symbols: Mapping[str, Symbols]) -> Iterator[Finding]:
    """What goes on from phase to phase has room to do so."""
    for own in passages(spec):
        source, target = symbols[own.source], symbols[own.target]
        if goes_on_in_time(spec, own):
            before = source.range(specs[own.source].time.final)
            after = target.range(specs[own.target].time.initial)
            yield from _apart(own, TIME, before, after)
        finals = {state.name: source.range(state.entry.final) for state in source.states}
        for state in target.states:
            if state.name in finals and state.name not in own.left_out:
                yield from _apart(own, state.name, finals[state.name], target.range(state.entry.initial))


def _apart(own: Passage, name: str, before: Range, after: Range) -> Iterator[Finding]:
    common = before.intersection(after)
    if common.lower > common.upper:
        path: Path = ("phases", own.target) if own.number is None else ("links", own.number)
        what = f"{name} ends at {before} in {own.source}, begins at {after} in {own.target}, and should go on"
        jump = f"links: [{{from: {own.source}, to: {own.target}, except: [{name}]}}]"
        remedy = f"change one of the two, or let it jump: {jump}"
        yield Finding(path, what, remedy)


def _objective(spec: Spec, own: Mapping[str, Spec]) -> Iterator[Finding]:
    """There is an objective, and all phases want the same of it."""
    sense = spec.objective.sense
    for name, entry in own_entries(spec).items():
        if entry.objective is not None and entry.objective.sense != sense:
            what = f"the file says {sense}, and the phase {name} {entry.objective.sense}"
            yield Finding(("phases", name, "objective"), what, f"write {sense}, and change the sign of the terms")
    terms = [phase.objective.terms for phase in own.values()]
    measured = any(phase.measurements for phase in own.values())
    if not measured and spec.objective.terms.terminal is None and not any(t.integral or t.terminal for t in terms):
        yield Finding(("objective", sense), "the objective is empty", "add integral: or terminal: with an expression")


def _everywhere(spec: Spec, own: Mapping[str, Spec], warnings: list[Finding], called: set[str]) -> Iterator[Finding]:
    """Warnings of phases, each once; a name counts as used nowhere if no phase and no link uses it."""
    written = [
        *(expression for _, expression, _ in _uses(spec)),
        *(v for row in spec.guess.keyframes.values() for v in row),
    ]
    used = {name.name.rpartition(".")[2] for expression in written for name in expression.leaves} | called
    used |= {node.table for expression in written for node in expression.nodes if isinstance(node, Lookup)}
    seen: dict[Finding, int] = {}
    for warning in warnings:
        seen[warning] = seen.get(warning, 0) + 1
    for warning, count in seen.items():
        if warning.kind != UNUSED:
            yield warning
            continue
        owners = [phase for phase in own.values() if warning.path[-1] in getattr(phase, str(warning.path[-2]), {})]
        if warning.path[-1] not in used and (count >= len(owners) or warning.path[0] == "phases"):
            yield warning
