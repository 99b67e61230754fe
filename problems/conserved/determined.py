"""Which algebraic variables the states determine, and which functions are of the states alone then."""

from __future__ import annotations

from collections.abc import Iterator

from ..lean.records import dataclass
from ..probe import depends_on, names_asked
from ..problem import Phase
from ..quantities import Constraint, Function, Range


@dataclass(frozen=True)
class Determined:
    """names: of algebraic variables that the states determine, whatever the controls are. residuals: that do it."""

    names: frozenset[str] = frozenset()
    residuals: tuple[Constraint, ...] = ()


def determined(phase: Phase) -> Determined:
    """What the residuals without controls determine: as many algebraic variables as there are such residuals.

    phase: any.
    """
    algebraic = [own.name for own in phase.algebraic]
    others = {own.name for own in (*phase.controls, *phase.delayed)}
    alone = [own for own in phase.residuals if not depends_on(own.function, others)] if algebraic else []
    asked = [{name for name in algebraic if depends_on(own.function, {name})} for own in alone]
    square = [group for group in _connected(asked) if len(set().union(*(asked[i] for i in group))) == len(group)]
    names = frozenset(name for group in square for i in group for name in asked[i])
    return Determined(names, tuple(alone[i] for group in square for i in sorted(group)))


def of_states_alone(phase: Phase, function: Function) -> bool:
    """Whether a function over time depends on nothing but states, what they determine, time and parameters.

    phase: that it is of.
    function: of the values at one time.
    """
    inputs = {own.name for own in phase.inputs}
    return not depends_on(function, inputs) or not depends_on(function, inputs - determined(phase).names)


def open_at(phase: Phase, end: str, function: Function) -> bool:
    """Whether a function over time is of the states alone, which are not all given at an end.

    phase: that it is of.
    end: initial or final.
    function: of the values at one time.
    """
    if not of_states_alone(phase, function):
        return False
    asked, own = names_asked(function), determined(phase)
    if not asked.isdisjoint(own.names):
        asked = asked.union(*(names_asked(residual.function) for residual in own.residuals))
    given = {state.name for state in phase.states if getattr(state, end).fixed}
    given |= {"t"} if getattr(phase, f"{end}_time").fixed else set()
    return not asked <= given | {own.name for own in phase.inputs}


def needed_at(phase: Phase, end: str) -> Determined:
    """What has to be determined at an end of a phase: nothing, if no constraint and no bound is about it.

    phase, end: as of `open_at`.
    """
    own = determined(phase)
    asked = any(depends_on(c.function, own.names) and open_at(phase, end, c.function) for c in phase.path)
    bounded = any(variable.name in own.names and variable.bounds != Range() for variable in phase.algebraic)
    return own if asked or bounded else Determined()


def _connected(sets: list[set[str]]) -> Iterator[set[int]]:
    """The numbers of the sets in groups: two that share a member are in one."""
    left = set(range(len(sets)))
    while left:
        group = {left.pop()}
        while more := {i for i in left if any(sets[i] & sets[j] for j in group)}:
            group |= more
            left -= more
        yield group
