r"""Equations that say what others say already: end values that the dynamics tie together, and constraints given twice.

A function g of states, linear or quadratic in them, with dg/dt = sum_i dg/dx_i f_i = 0 for all x, u, t and p, stays
what it is at the initial time: the norm of a quaternion, the sum of compartments, the products of the columns of a
rotation. Where initial and final values of all its states are given, one of the final ones is too many. Such g are the
null space of the matrix of  d(basis function)/dt  at samples.

Among the equations at the ends, and among the path equalities, one follows from others if its gradient is a combination
of theirs at every sample that meets all. Then the Jacobian of the nonlinear program has not full rank, and multipliers
are not unique. What follows is held to ALMOST only, where it takes no part: it holds because the others do.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations_with_replacement

import numpy as np

from ..expressions.expression import Expression, together
from ..probe import derivatives, names_asked
from ..problem import Phase
from ..quantities import Constraint
from .invariant import MET, almost

MOST = 12
"""States whose products are looked at; of more, the sums only."""

SAMPLES, STEPS = 5, 15
ROUNDING, RANK = 1e-10, 1e-8
"""What is less is zero: of the largest singular value, and of the length of a gradient."""


def without_implied(phase: Phase) -> Phase:
    """The phase with what follows from the rest held to ALMOST: final values in `follows`, constraints in `implied`."""
    if phase.delayed or phase.steps:
        return phase
    if follows := _final_values(phase):
        states = tuple(replace(s, final=almost(s.final)) if s.name in follows else s for s in phase.states)
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
    given = [state for state in phase.states if state.initial.fixed and state.final.fixed]
    rates = [state.rate for state in phase.states]
    if len(given) < 2 or phase.algebraic or not all(isinstance(rate, Expression) for rate in rates):
        return []
    names = [state.name for state in given]
    pairs = list(combinations_with_replacement(range(len(names)), 2)) if len(names) <= MOST else []
    samples = 2 * (len(names) + len(pairs))
    asked = sorted({*names}.union(*(names_asked(state.rate) for state in given)))
    values = dict(zip(asked, _spread(len(asked), samples), strict=True))
    with np.errstate(all="ignore"):
        f = np.array([np.broadcast_to(state.rate(values, np), samples) for state in given])
    x = np.array([values[name] for name in names])
    matrix = np.vstack([f, *(x[i] * f[j] + x[j] * f[i] for i, j in pairs)]).T
    if not np.isfinite(matrix).all():
        return []
    kept = _kept(matrix)
    first, last = (np.array([getattr(state, end).lower for state in given]) for end in ("initial", "final"))
    if any(abs(_value(g, pairs, last) - _value(g, pairs, first)) > MET * (1 + np.abs(last).max() ** 2) for g in kept.T):
        return []  # the final values contradict the dynamics
    gradients = kept[: len(names)].copy()
    for (i, j), coefficients in zip(pairs, kept[len(names) :], strict=True):
        gradients[i] += coefficients * last[j]
        gradients[j] += coefficients * last[i]
    return [names[i] for i in _pivots(gradients.T)]


def _spread(names: int, samples: int) -> np.ndarray:
    """Samples of no meaning between 0.1 and 0.9, shape (names, samples), the same each time."""
    irrational = np.sqrt(np.arange(names) + math.e)
    return 0.1 + 0.8 * (np.outer(irrational, np.arange(1, samples + 1)) % 1.0)


def _value(g: np.ndarray, pairs: Sequence[tuple[int, int]], x: np.ndarray) -> float:
    return float(g @ np.concatenate([x, [x[i] * x[j] for i, j in pairs]]))


def _kept(matrix: np.ndarray) -> np.ndarray:
    """The combinations of columns that are zero, each of length 1, by columns.

    Columns are taken relative to their size, which depends on units: a rate of 1e-6 is not one of zero.
    """
    sizes = np.abs(matrix).max(axis=0)
    sizes[sizes == 0] = 1.0
    kept: np.ndarray = _null_space(matrix / sizes) / sizes[:, None]
    kept /= np.linalg.norm(kept, axis=0)
    return kept


def _null_space(matrix: np.ndarray) -> np.ndarray:
    """An orthonormal basis of the null space, by columns."""
    _, sizes, vectors = np.linalg.svd(matrix, full_matrices=True)
    rank = int((sizes > ROUNDING * sizes.max(initial=0.0)).sum())
    return vectors[rank:].T


def _pivots(gradients: np.ndarray) -> list[int]:
    """The columns that the rows determine most clearly, one for each row that is independent of those before."""
    rest, found = gradients.copy(), list[int]()
    while np.abs(rest).max(initial=0.0) > RANK:
        row, column = np.unravel_index(np.argmax(np.abs(rest)), rest.shape)
        found.append(int(column))
        rest = rest - np.outer(rest[:, column] / rest[row, column], rest[row])
        rest[:, column] = 0.0
        rest[row] = 0.0
    return found


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
    for sample in _spread(len(free), SAMPLES).T:
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
