"""What each phase is by itself: a spec of one phase, made of what the phase says and what the top level says.

What the top level says holds for every phase, but for the two ends of time: there it is about the whole trajectory. Its
initial time and initial values belong to phases that go on from no other, its final ones to those that go on in none.
Its boundary constraints and its terminal objective may name the ends of any phase, and belong to `between.Between`; the
keyframes of its guess go from the first phase to the last (see `guess`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeVar
from weakref import ref

from ..expressions.expression import Expression
from ..expressions.signature import signature
from ..expressions.tree import Link, Number, OperatorChain
from ..language.integrals import where_written
from ..language.means import place_of_mean
from ..language.plain import in_plain
from ..schema.declarations import StateEntry, Time, TimeEnd, Velocity
from ..schema.drawing import ShapeEntry
from ..schema.fields import Entry, expressions_below
from ..schema.phases import PhaseEntry
from ..schema.sections import Constraints, GuessEntry, Objective, Terms
from ..schema.solving import MeshEntry
from ..schema.spec import Spec
from ..yaml.document import Path
from .order import ALONE, forward, own_entries

_DYNAMICS = frozenset({"rate", "next", "accel"})  # a state has one of them
_VARIABLES = ("states", "controls", "algebraic")
_NAMED = ("parameters", "expressions", "states", "controls", "algebraic", "integrals")


class _Known(NamedTuple):
    """A spec, as long as somebody else holds it, and its phases; None for one that is the spec itself."""

    spec: ref[Spec]
    phases: dict[str, Spec | None]


_latest: list[_Known] = []
"""What was asked for last: the checks of a file, its problems and its meshes all ask. Gone with the spec."""


def phase_specs(spec: Spec) -> dict[str, Spec]:
    """Name -> the phase as a problem of its own; a file without phases is its only one."""
    for known in _latest:
        if known.spec() is spec:
            return {name: spec if phase is None else phase for name, phase in known.phases.items()}
    phases = phases_in_plain(spec)
    kept = {name: None if phase is spec else phase for name, phase in phases.items()}
    _latest[:] = [_Known(ref(spec, lambda _: _latest.clear()), kept)]
    return phases


def phases_in_plain(spec: Spec, marked: bool = False) -> dict[str, Spec]:
    """`phase_specs`, made anew.

    spec: of the file.
    marked: see `language.plain.in_plain`.
    """
    own = phases_as_written(spec)
    suffixes = {name: f"_of_{name}" if len(own) > 1 else "" for name in own}
    return {name: in_plain(phase, suffixes[name], marked)[0] for name, phase in own.items()}


def phases_as_written(spec: Spec) -> dict[str, Spec]:
    """The same with the functions of the file, and calls of them."""
    entries = own_entries(spec)
    if not entries:
        return {ALONE: spec}
    before = forward(spec)
    last = entries.keys() - set(before.values())
    meshes = {name: spec.mesh if own.mesh is None else own.mesh for name, own in entries.items()}
    length = max(map(len, meshes.values()))
    merged: dict[str, Spec] = {}
    for name, own in entries.items():
        previous = merged.get(before.get(name, ""))
        time = _time(spec, entries, name, previous, name in last)
        ends = _begin_and_end(spec, entries, before, name)
        merged[name] = _merged(spec, own, time, ends, _padded(meshes[name], length))
    return merged


def home(spec: Spec, phase: str, path: Path) -> Path:
    """Where in the file a value of a phase's own spec was given.

    spec: of the file.
    phase: name of the phase.
    path: of the value in `phases_as_written(spec)[phase]`.
    """
    own = own_entries(spec).get(phase)
    path = place_of_mean(spec, where_written(spec, path))
    if own is None or not path or not (spec.phases or spec.waypoints):
        return path
    path = place_of_mean(own, where_written(own, path))
    if path[:2] == ("time", "initial") and own.time.initial is None and (before := forward(spec).get(phase)):
        return home(spec, before, ("time", "final", *path[2:]))
    if (found := _constraint(spec, phase, path) or _waypoint(spec, phase, path)) is not None:
        return found
    if path[-1] == "lower" and not _given(own, path) and _given(own, upper := (*path[:-1], "upper")):
        return ("phases", phase, *upper)  # what is above it, is the phase's
    return ("phases", phase, *path) if _given(own, path) else path


def _constraint(spec: Spec, phase: str, path: Path) -> Path | None:
    """The place of a constraint: path constraints of the top level, and pairs, come first in every phase."""
    if path[0] == "complementarity" and len(path) > 1:
        number, shared = int(path[1]), len(spec.complementarity)
        return path if number < shared else ("phases", phase, path[0], number - shared, *path[2:])
    if path[0] != "constraints" or len(path) < 3 or not isinstance(path[2], int):
        return None
    shared = len(spec.constraints.path) if path[1] == "path" else 0
    if path[2] < shared:
        return path
    return ("phases", phase, "constraints", path[1], path[2] - shared, *path[3:])


def _waypoint(spec: Spec, phase: str, path: Path) -> Path | None:
    """The place of a final value in waypoints, if they make the phases."""
    names = list(own_entries(spec))
    number = names.index(phase)
    if number >= len(spec.waypoints):
        return None
    if path[:2] == ("time", "final") and spec.waypoints[number].time is not None:
        return ("waypoints", number, "time", *path[2:])
    if path[0] == "states" and path[2:3] == ("final",) and path[1] in spec.waypoints[number].states:
        return ("waypoints", number, str(path[1]), *path[3:])
    return None


def _given(own: PhaseEntry, path: Path) -> bool:
    """Whether a phase says something at a path, or at the part of it that replaces what the top level says."""
    value: Any = own
    for step in path:
        if isinstance(value, Entry):
            value = getattr(value, str(step), None)
        elif isinstance(value, Mapping):
            value = value.get(step)
        elif isinstance(value, list) and isinstance(step, int) and step < len(value):
            value = value[step]
        else:
            return value is not None
        if value is None or value in ([], {}, ""):
            return False
    return True


def _begin_and_end(
    spec: Spec, entries: Mapping[str, PhaseEntry], before: Mapping[str, str], name: str
) -> Callable[[str], tuple[bool, bool]]:
    """Whether a state begins in a phase, as no phase before it has it, and whether it ends there."""

    def has(phase: str, state: str) -> bool:
        own = entries[phase]
        return state not in own.without and (state in spec.states or state in own.states)

    def of_state(state: str) -> tuple[bool, bool]:
        following = [phase for phase, previous in before.items() if previous == name]
        return not has(before[name], state) if name in before else True, not any(has(f, state) for f in following)

    return of_state


def _merged(
    spec: Spec, own: PhaseEntry, time: Time, ends: Callable[[str], tuple[bool, bool]], mesh: list[MeshEntry]
) -> Spec:
    named = {group: _together(getattr(spec, group), getattr(own, group)) for group in _NAMED}
    named["states"] = {
        name: _with_ends(state, own.states.get(name), *ends(name)) for name, state in named["states"].items()
    }
    for group in (*_VARIABLES, "integrals"):
        named[group] = {name: entry for name, entry in named[group].items() if name not in own.without}
    constraints = Constraints.model_construct(
        path=[*spec.constraints.path, *own.constraints.path],
        boundary=own.constraints.boundary,
        integral=own.constraints.integral,
    )
    return spec.model_copy(
        update=named
        | {
            "time": time,
            "constraints": constraints,
            "complementarity": [*spec.complementarity, *own.complementarity],
            "objective": _objective(spec.objective, own.objective),
            "residuals": spec.residuals if own.residuals is None else own.residuals,
            "guess": own.guess or _at_all_times(spec.guess),
            "mesh": mesh,
            "drawing": _drawn(spec, named),
            "measurements": own.measurements,
            "phases": {},
            "links": [],
            "waypoints": [],
        }
    )


AnEntry = TypeVar("AnEntry", bound=Entry)
AnEnded = TypeVar("AnEnded", StateEntry, Velocity)


def _drawn(spec: Spec, named: Mapping[str, Mapping[str, Any]]) -> list[ShapeEntry]:
    """The drawing of the file; what is made of variables that only other phases have, is nowhere in this one."""
    own = {name for group in _VARIABLES for name in named[group]}
    every = {name for part in (spec, *spec.phases.values()) for group in _VARIABLES for name in getattr(part, group)}
    lacking = every - own
    return [ShapeEntry.model_construct() if lacking & _names_in(shape) else shape for shape in spec.drawing]


def _names_in(shape: ShapeEntry) -> set[str]:
    """The names in all expressions of a shape."""
    return {leaf.name for _, expression in expressions_below(shape) for leaf in expression.leaves}


def _together(shared: Mapping[str, Any], own: Mapping[str, Any]) -> dict[str, Any]:
    """Both, by name: of one name the own keys over the shared ones; numbers and expressions replace each other."""
    functions = {called.name for called in map(signature, own) if called}
    both = {
        name: entry for name, entry in shared.items() if not (called := signature(name)) or called.name not in functions
    }
    for name, entry in own.items():
        before = both.get(name)
        declared = isinstance(entry, Entry) and before is not None and "value" not in type(entry).model_fields
        both[name] = _over(before, entry) if declared else entry
    return both


def _over(shared: AnEntry, own: AnEntry) -> AnEntry:
    """An entry with the keys that another gives of its own in place of the shared ones."""
    given = {key: value for key, value in own if value != type(own).model_fields[key].default}
    if isinstance(velocity := given.get("velocity"), Velocity) and isinstance(shared, StateEntry) and shared.velocity:
        given["velocity"] = _over(shared.velocity, velocity)
    dropped = dict.fromkeys(_DYNAMICS, None) if _DYNAMICS & given.keys() else {}
    return shared.model_copy(update={**dropped, **given})


def _with_ends(state: AnEnded, own: AnEnded | None, first: bool, last: bool) -> AnEnded:
    """A state or a velocity without the end values that the top level means for other phases."""
    update: dict[str, Any] = {}
    for end, here in (("initial", first), ("final", last)):
        if not here and getattr(own, end, None) is None:
            update[end] = None
    if isinstance(state, StateEntry) and state.velocity is not None:
        update["velocity"] = _with_ends(state.velocity, getattr(own, "velocity", None), first, last)
    return state.model_copy(update=update)


def _objective(shared: Objective, own: Objective | None) -> Objective:
    """The terms of one phase: the integral of the top level is of every phase, its terminal term is of none."""
    integral = own.terms.integral if own and own.terms.integral is not None else shared.terms.integral
    terms = Terms.model_construct(integral=integral, terminal=own.terms.terminal if own else None)
    maximize = shared.sense == "maximize"
    return Objective.model_construct(minimize=None if maximize else terms, maximize=terms if maximize else None)


def _at_all_times(guess: GuessEntry) -> GuessEntry:
    """What the guess of the top level says of every phase; its keyframes and data are about the whole trajectory."""
    return GuessEntry(constants=guess.constants, formulas=guess.formulas, simulate=guess.simulate)


def _time(spec: Spec, entries: Mapping[str, PhaseEntry], name: str, previous: Spec | None, last: bool) -> Time:
    """When a phase is: it begins where the one before ends, and ends by itself, or with the whole."""
    own = entries[name].time
    initial = own.initial or (previous.time.final if previous else spec.time.initial)
    final = own.final or (spec.time.final if last else _on_the_way(spec, entries, name, initial))
    return Time.model_construct(initial=initial, final=final, unit=spec.time.unit)


def _on_the_way(spec: Spec, entries: Mapping[str, PhaseEntry], name: str, initial: TimeEnd) -> TimeEnd:
    """A free time between the start of a phase and the next final time that is given; the guess shares it out."""
    names = list(entries)
    later = names[names.index(name) + 1 :]
    count = next((k for k, own in enumerate(later, start=2) if entries[own].time.final), len(later) + 1)
    over = entries[later[count - 2]].time.final or spec.time.final
    begun, ends = _middle(initial), _middle(over)
    guess = None if begun is None or ends is None else _between(begun, ends, 1 / count)
    return TimeEnd.model_construct(lower=_ends(initial)[0], upper=_ends(over)[1], guess=guess)


def _ends(time: TimeEnd) -> tuple[Expression | None, Expression | None]:
    return (time.value, time.value) if time.value is not None else (time.lower, time.upper)


def _middle(time: TimeEnd) -> Expression | None:
    """The value of a time, or its guess, or the middle of its range."""
    known = time.value or time.guess
    if known is not None or time.lower is None or time.upper is None:
        return known
    return _between(time.lower, time.upper, 0.5)


def _between(a: Expression, b: Expression, share: float) -> Expression:
    """a + (b - a) share."""
    if "?" in (a.text, b.text):  # one of them is mistaken
        return a
    text = f"({a.text}) + (({b.text}) - ({a.text}))*{share!r}"
    span = 0, len(text)
    width = OperatorChain(*span, b.root, (Link(*span, "-", a.root), Link(*span, "*", Number(*span, share))))
    return Expression(text, OperatorChain(*span, a.root, (Link(*span, "+", width),)))


def _padded(mesh: list[MeshEntry], length: int) -> list[MeshEntry]:
    """A schedule as long as the longest: its last entry stands for what it lacks."""
    return [*mesh, *mesh[-1:] * (length - len(mesh))]
