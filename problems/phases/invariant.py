r"""Path equalities that the dynamics keep by themselves: the norm of a quaternion, the sum of all compartments.

Where dg/dt = sum_i dg/dx_i f_i is zero whatever u is and whatever x with g(x) = c, that holds at all times if it does
at one. Asked for at every point besides, it says what the defects say already: the Jacobian loses rank, and the engine
takes many times the iterations. So it is asked for at the initial time only, and not at all where the initial values
have it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..expressions.expression import Expression
from ..expressions.tree import Name
from ..probe import names_asked
from ..problem import Phase, Problem
from ..quantities import Constraint, Output

SAMPLES, STEPS = 8, 20
TINY = 1e-30
"""The complex step: the derivative has no subtraction in it."""

ROUNDING = 1e-10
"""Of the sum of the moduli of dg/dx_i f_i: what their sum may be and count as zero."""

MET = 1e-9
"""Relative to 1 + |c|: what fixed initial values may miss an invariant by."""


def without_invariants(phase: Phase) -> Phase:
    """The phase with each path equality that its dynamics keep asked for once; `kept` has their names."""
    if phase.algebraic or phase.delayed or phase.steps or not any(own.bounds.fixed for own in phase.path):
        return phase
    path, boundary, outputs = list[Constraint](), list(phase.boundary), dict(phase.outputs)
    for own in phase.path:
        once = _asked_once(phase, own)
        if once is None:
            path.append(own)
        else:
            boundary += once
            outputs[own.name] = Output(own.function)
    names = tuple(name for name in outputs if name not in phase.outputs)
    return replace(phase, path=tuple(path), boundary=tuple(boundary), outputs=outputs, kept=names)


def kept(problem: Problem) -> Iterator[str]:
    """What is said of each such constraint."""
    for phase in problem.phases:
        for name in phase.kept:
            yield f"path constraint '{name}' is kept by the dynamics, so it is asked for at the initial time only"


def _asked_once(phase: Phase, own: Constraint) -> list[Constraint] | None:
    """What is left to ask for of a path constraint: at the initial time, or nothing; None if it must stay as it is."""
    function, value = own.function, own.bounds.lower
    if not (own.bounds.fixed and isinstance(function, Expression) and _is_kept(phase, function, value)):
        return None
    given = {state.name: np.float64(state.initial.lower) for state in phase.states if state.initial.fixed}
    if names_asked(function) <= given.keys():
        return [] if abs(function(given, np) - value) <= MET * (1 + abs(value)) else None
    name = "kept by the dynamics"  # no name of a file has spaces
    definitions = {**function.definitions, name: function}
    return [replace(own, function=replace(function, root=Name(0, 0, name, "initial"), definitions=definitions))]


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
            slopes = _slopes(g, values, asked)
            step = (g(values, np) - value) / np.sum(slopes**2, axis=0)
            values |= {name: values[name] - step * slope for name, slope in zip(asked, slopes, strict=True)}
        terms = _slopes(g, values, asked) * [np.broadcast_to(rates[name](values, np), SAMPLES) for name in asked]
        missed = np.abs(g(values, np) - value)
    total, size = np.abs(terms.sum(axis=0)), np.abs(terms).sum(axis=0)
    met = missed <= MET * (1 + abs(value))
    return bool((met & np.isfinite(size) & (total <= ROUNDING * size)).all())


def _slopes(g: Expression, values: Mapping[str, np.ndarray], names: Sequence[str]) -> np.ndarray:
    """The derivatives of a function by some names at samples, shape (names, SAMPLES)."""
    moved = (g({**values, name: values[name] + 1j * TINY}, np) for name in names)
    return np.array([np.broadcast_to(np.imag(own) / TINY, SAMPLES) for own in moved])
