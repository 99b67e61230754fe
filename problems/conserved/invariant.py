r"""Path equalities that the dynamics keep by themselves: the norm of a quaternion, the sum of all compartments.

Where dg/dt = sum_i dg/dx_i f_i is zero whatever u is and whatever x with g(x) = c, that holds at all times if it does
at one. Asked for at every point besides, it says what the defects say already: the Jacobian loses rank, and the engine
takes many times the iterations. So it is asked for at the initial time only, and not at all where the initial values
have it. Then final values of all its states are one too many in the same way, and on a mesh, where g drifts by the
error of the scheme, they contradict each other by that: one of them is held to ALMOST only.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ..expressions.expression import Expression
from ..probe import derivatives, names_asked
from ..problem import Phase, Problem
from ..quantities import Constraint, Output, Range

SAMPLES, STEPS = 8, 20
ROUNDING = 1e-10
"""Of the sum of the moduli of dg/dx_i f_i: what their sum may be and count as zero."""

MET = 1e-9
"""Relative to 1 + |c|: what fixed initial or final values may miss an invariant by."""

ALMOST = 1e-6
"""Of the size of a state, or relative to 1 + that of a constraint: how near what follows is held."""


def without_invariants(phase: Phase) -> Phase:
    """The phase with each path equality that its dynamics keep asked for once; `kept` has their names, `follows` those
    of the states whose final values follow."""
    if phase.algebraic or phase.delayed or phase.steps or not any(own.bounds.fixed for own in phase.path):
        return phase
    path, boundary, outputs = list[Constraint](), list(phase.boundary), dict(phase.outputs)
    follows = list[str]()
    for own in phase.path:
        once = _asked_once(phase, own)
        if once is None:
            path.append(own)
        else:
            boundary += once
            outputs[own.name] = Output(own.function)
            follows += _following(phase, own, follows)
    names = tuple(name for name in outputs if name not in phase.outputs)
    states = tuple(
        replace(own, final=almost(own.final, own.initial)) if own.name in follows else own for own in phase.states
    )
    return replace(
        phase,
        states=states,
        path=tuple(path),
        boundary=tuple(boundary),
        outputs=outputs,
        kept=names,
        follows=tuple(follows),
    )


def told_as_kept(problem: Problem) -> Iterator[str]:
    """What is said of each such constraint, and of what follows from others."""
    for phase in problem.phases:
        for name in phase.kept:
            yield f"path constraint '{name}' is kept by the dynamics, so it is asked for at the initial time only"
        for name in phase.follows:
            yield f"the final value of {name} follows from the other final values, so it is held to {ALMOST:g} only"
        for name, others in phase.implied.items():
            yield f"constraint '{name}' follows from {' and '.join(others)}, so it is held to {ALMOST:g} only"


def _asked_once(phase: Phase, own: Constraint) -> list[Constraint] | None:
    """What is left to ask for of a path constraint: at the initial time, or nothing; None if it must stay as it is."""
    function, value = own.function, own.bounds.lower
    if not (own.bounds.fixed and isinstance(function, Expression) and _is_kept(phase, function, value)):
        return None
    given = {state.name: np.float64(state.initial.lower) for state in phase.states if state.initial.fixed}
    if names_asked(function) <= given.keys():
        return [] if abs(function(given, np) - value) <= MET * (1 + abs(value)) else None
    return [replace(own, function=function.at("initial"))]


def _following(phase: Phase, own: Constraint, chosen: Sequence[str]) -> list[str]:
    """The state whose final value follows from the others', the one that does most clearly; none where one is free, or
    where they contradict the constraint. chosen: by other constraints."""
    assert isinstance(own.function, Expression)
    asked = sorted(names_asked(own.function))
    ends = {name: (state.initial, state.final) for state in phase.states if (name := state.name) in asked}
    if not all(end.fixed for both in ends.values() for end in both):
        return []
    last = {name: np.full(SAMPLES, final.lower) for name, (_, final) in ends.items()}
    missed = float(np.max(np.abs(own.function(last, np) - own.bounds.lower)))
    left = [name for name in asked if name not in chosen]
    if not left or not missed <= MET * (1 + abs(own.bounds.lower)):
        return []
    slopes = np.abs(derivatives(own.function.tape, last, left)[0, :, 0])
    return [left[int(np.argmax(slopes))]] if slopes.max() > 0 else []


def almost(value: Range, other: Range | None = None) -> Range:
    """The range around a value that follows from others.

    value: what it would be.
    other: that of a state at the other end of time; what is near depends on the larger of both then.
    """
    size = max(abs(value.lower), abs(other.lower)) if other and other.fixed else 1 + abs(value.lower)
    near = ALMOST * (size or 1.0)
    return Range(value.lower - near, value.upper + near)


def _is_kept(phase: Phase, g: Expression, value: float) -> bool:
    """Whether dg/dt is zero where g = value, for a function of states alone: at samples of no meaning, moved there."""
    rates = {state.name: state.rate for state in phase.states}
    asked = sorted(names_asked(g))
    if not asked or not set(asked) <= rates.keys():
        return False
    needed = sorted({*asked}.union(*(names_asked(rates[name]) for name in asked)))
    values = dict(zip(needed, np.random.default_rng(0).uniform(0.1, 0.9, (len(needed), SAMPLES)), strict=True))
    with np.errstate(all="ignore"):
        for _ in range(STEPS):  # of Newton, along the gradient
            slopes = derivatives(g.tape, values, asked)[0]
            step = (g(values, np) - value) / np.sum(slopes**2, axis=0)
            values |= {name: values[name] - step * slope for name, slope in zip(asked, slopes, strict=True)}
        f = [np.broadcast_to(rates[name](values, np), SAMPLES) for name in asked]
        terms = derivatives(g.tape, values, asked)[0] * f
        missed = np.abs(g(values, np) - value)
    total, size = np.abs(terms.sum(axis=0)), np.abs(terms).sum(axis=0)
    met = missed <= MET * (1 + abs(value))
    return bool((met & np.isfinite(size) & (total <= ROUNDING * size)).all())
