"""Equations that say what others say already: end values that the dynamics tie together, and constraints given twice.

Where the dynamics keep a function of states whose values are given at both ends, one of the final ones is too many (see
`conserved`). Among the equations at the ends, and among the path equalities, one follows from others if its gradient is
a combination of theirs at every sample that meets all. Then the Jacobian of the nonlinear program lacks rank, and
multipliers are not unique. What follows is held to ALMOST only, where it takes no part: it holds because others do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..expressions.expression import Expression, together
from ..probe import derivatives, names_asked
from ..problem import Phase
from ..quantities import Constraint
from .conserved import RANK, conserved, spread
from .invariant import MET, almost

SAMPLES, STEPS = 5, 15


def without_implied(phase: Phase) -> Phase:
    """The phase with what follows from the rest held to ALMOST: final values in `follows`, constraints in `implied`."""
    if phase.delayed or phase.steps:
        return phase
    if follows := _final_values(phase):
        states = tuple(replace(s, final=almost(s.final, s.initial)) if s.name in follows else s for s in phase.states)
        phase = replace(phase, states=states, follows=(*phase.follows, *follows))
    implied = {**_of(phase.boundary, _end_values(phase)), **_of(phase.path, {})}
    if not implied:
        return phase
    boundary, path = (
        tuple(replace(own, bounds=almost(own.bounds)) if own.name in implied else own for own in constraints)
        for constraints in (phase.boundary, phase.path)
    )
    return replace(phase, boundary=boundary, path=path, implied=implied)


def _final_values(phase: Phase) -> list[str]:
    """The states whose final value follows from those of others by what the dynamics keep."""
    rates = [state.rate for state in phase.states]
    if phase.algebraic or not all(isinstance(rate, Expression) for rate in rates):
        return []
    given = [state for state in phase.states if state.initial.fixed and state.final.fixed]
    first, last = ([getattr(state, end).lower for state in given] for end in ("initial", "final"))
    found = conserved([state.name for state in given], [state.rate for state in given], first, last)
    return found.following if found else []


def _end_values(phase: Phase) -> dict[str, float]:
    """The values at the ends that are given, by the names that boundary constraints have for them."""
    found = dict[str, float]()
    for end in ("initial", "final"):
        ranges = {state.name: getattr(state, end) for state in phase.states} | {"t": getattr(phase, f"{end}_time")}
        found |= {f"{name}[{end}]": own.lower for name, own in ranges.items() if own.fixed}
    return found


def _of(constraints: Sequence[Constraint], given: Mapping[str, float]) -> dict[str, tuple[str, ...]]:
    """name -> the names of what it follows from, of the equalities that follow from those before and given values."""
    equal = [own for own in constraints if own.bounds.fixed and isinstance(own.function, Expression)]
    if len(equal) < 1 + (not given):
        return {}
    asked = sorted(set[str]().union(*(names_asked(own.function) for own in equal)))
    free = [name for name in asked if name not in given]
    rows = _met(equal, free, given)
    if rows is None:
        return {}
    found, independent = dict[str, tuple[str, ...]](), list[int]()
    for i, own in enumerate(equal):
        shares = _shares(rows[:, i], rows[:, independent])
        if shares is None:
            independent.append(i)
            continue
        fixed = sorted(name for name in names_asked(own.function) if name in given)
        found[own.name] = (*(equal[k].name for k, s in zip(independent, shares, strict=True) if s > RANK), *fixed)
    return found


def _met(equal: Sequence[Constraint], free: Sequence[str], given: Mapping[str, float]) -> np.ndarray | None:
    """The gradients by the free values, (SAMPLES, constraints, free), at samples that meet all; None without such."""
    g, bounds, found = together([own.function for own in equal]), np.array([own.bounds.lower for own in equal]), []
    for sample in spread(len(free), SAMPLES).T:
        x = sample
        for _ in range(STEPS):
            values = {**given, **dict(zip(free, x, strict=True))}
            with np.errstate(all="ignore"):
                missed = np.array([float(own) for own in g(values, np)]) - bounds
                J = derivatives(g, values, free)
            if not (np.isfinite(missed).all() and np.isfinite(J).all()):
                return None
            if np.all(np.abs(missed) <= MET * (1 + np.abs(bounds))):
                break
            x = x - np.linalg.pinv(J) @ missed
        else:
            return None
        found.append(J)
    return np.array(found)


def _shares(gradients: np.ndarray, others: np.ndarray) -> np.ndarray | None:
    """How much each of the others has in a combination of them that is the gradient; None if none is at some sample.

    gradients: (SAMPLES, n). others: (SAMPLES, others, n), independent of each other.
    """
    largest = np.zeros(others.shape[1])
    for own, rest in zip(gradients, others, strict=True):
        coefficients = np.linalg.lstsq(rest.T, own, rcond=None)[0] if rest.size else np.zeros(len(rest))
        left, size = float(np.linalg.norm(own - coefficients @ rest)), float(np.linalg.norm(own))
        if left > RANK * max(size, RANK):
            return None
        largest = np.maximum(largest, np.abs(coefficients) * np.linalg.norm(rest, axis=-1))
    shares: np.ndarray = largest / max(float(largest.max(initial=0.0)), RANK)
    return shares
