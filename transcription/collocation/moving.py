"""States at earlier times where the times of a phase are free, or in the phase before: rows that change with the times.

A collocation point at t_k reads its state at t_k - tau, in the phase, on the segment and at the theta_0 where that was
for the times that a solve starts from. As the times change, theta moves by

    delta = ((t_k - tau - t_0)/(t_F - t_0) - s_0) / (width of the segment),

t_0 and t_F being the ends of the phase that is read, and s_0 the fraction of its duration at which theta_0 is. The
state's interpolant (see `delays`) is followed by its expansion to the second order in delta: value and first and second
derivatives are exact where delta is zero. In place of delta stands tanh(delta), the same to that order, so that what is
read stays within a segment of its place, however far the times go in a solve. A mesh is solved again from its own
solution until the times have settled (`starts.settled`), and the rows are those of the times that were found.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.quantities import Delayed
from ..constraint_kinds import DELAY
from ..libraries.pyomo import Constraint, RangeSet, pyomo
from ..program.templates import item
from ..schemes.mesh import Mesh
from ..schemes.polynomials import differentiation_matrix, lagrange_basis
from ..schemes.scheme import Scheme, collocation_scheme
from .builder import PhaseBuilder

ALIGNED = 1e-11
"""Of the duration, or of a segment: a time this near to a knot, to a node, or to the initial time, is there."""
NEAR = 1e-5
"""Of the duration: a time that moves, and is this near to a knot, is expanded from there."""

ORDER = 2
"""Of the expansion."""


def expansion(scheme: Scheme, theta: np.ndarray, order: int = ORDER) -> tuple[np.ndarray, np.ndarray]:
    """Coefficients of delta^m in the interpolant at theta + delta: A (m, M, d + 1) of states, G (m, M) of h f_0.

    scheme: of collocation.
    theta: (M,) on its segment.
    order: the largest m.
    """
    sigma = scheme.sigma
    D = differentiation_matrix(sigma, sigma)
    A = np.empty((order + 1, len(theta), len(sigma)))
    A[0] = lagrange_basis(sigma, theta)
    for m in range(1, order + 1):
        A[m] = A[m - 1] @ D / m
    G = np.zeros(A.shape[:2])
    if len(sigma) > len(scheme.c):
        return A, G
    assert scheme.collocated[0] == 0  # else there would be a state node more
    G[0] = theta
    G[1:2] = 1.0
    for node in sigma[1:]:  # omega / omega'(0) is theta times the product of (theta - sigma_j) / (0 - sigma_j)
        G[1:] = (G[1:] * (theta - node) + G[:-1]) / -node
        G[0] *= (theta - node) / -node
    return A - G[..., None] * D[0], G


def shares_of(mesh: Mesh) -> np.ndarray:
    """What of the quadrature weight of each point lies before it and what after it, shape (2, K).

    mesh: of collocation schemes.
    """
    shares = np.full((2, len(mesh.fractions)), 0.5)
    shares[0, mesh.knots] = np.append(0.0, mesh.slot_parts[mesh.offset + mesh.degrees])
    shares[1, mesh.knots] = np.append(mesh.slot_parts[mesh.offset], 0.0)
    return shares


def place_on(mesh: Mesh, s: np.ndarray, after: np.ndarray, near: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The segment of each s, the s themselves, those near to a knot moved there, and the number of that knot or -1.

    mesh: that is read.
    s: (Q,) fractions of its duration.
    after: (Q,) what of the point that reads lies after it: one with none reads the segment before the knot.
    near: to a knot, of the duration.
    """
    nearest = np.rint(np.interp(s, mesh.edges, np.arange(len(mesh.edges)))).astype(int)
    there = np.abs(s - mesh.edges[nearest]) < near
    inside = np.searchsorted(mesh.edges, s, side="right") - 1
    segment = np.clip(np.where(there, nearest - (after <= 0), inside), 0, mesh.segments - 1)
    return segment, np.where(there, mesh.edges[nearest], s), np.where(there, nearest, -1)


@dataclass(frozen=True, eq=False)
class Reads:
    """Where points of a phase read a state: points (Q,), on segment (Q,) of the source, at s (Q,) of its duration."""

    source: PhaseBuilder
    points: np.ndarray
    segment: np.ndarray
    s: np.ndarray


def add_moving(builder: PhaseBuilder) -> None:
    """Add the rows of all states at earlier times, of a phase with free times or with one before it."""
    mesh, start = builder.mesh, builder.block.t0.value
    times = start + mesh.fractions * (builder.block.tF.value - start)
    for number, own in enumerate(builder.phase.delayed):
        points, place = mesh.collocated, 0
        source: PhaseBuilder | None = builder
        while source and any(state.name == own.state for state in source.phase.states):
            reads, points = _places(source, points, times[points] - own.lag, shares_of(mesh)[1, points])
            _read(builder, f"delay{number}_{place}", own, reads)
            source, place = source.before, place + 1
        _history(builder, number, own, points)


def _places(source: PhaseBuilder, points: np.ndarray, t: np.ndarray, after: np.ndarray) -> tuple[Reads, np.ndarray]:
    """Where points are read in a phase, and those that look at what was before it.

    A point at which only the segment before it collocates, `after` being 0, looks back from there, as in `delays`.
    """
    start, mesh = source.block.t0.value, source.mesh
    duration = source.block.tF.value - start
    s = (t - start) / duration if duration > 0 else np.full(len(t), -1.0)
    here = s >= np.where(after > 0, -NEAR, NEAR)
    segment, s, _ = place_on(mesh, np.maximum(s[here], 0.0), after[here], NEAR)
    return Reads(source, points[here], segment, s), points[~here]


def _history(builder: PhaseBuilder, number: int, own: Delayed, points: np.ndarray) -> None:
    """y_k == phi(t_k - tau)."""
    if not len(points):
        return
    name = f"history{number}"
    over, (point, fraction) = data_of_rows(builder, name, [points, builder.mesh.fractions[points]])

    def rule(block: Any, q: Any) -> Any:
        t = block.t0 + builder.duration * item(fraction, q) - own.lag
        return item(block.z, own.name, item(point, q)) - own.history({"t": t}, pyomo) == 0.0

    add_rows(builder, name, over, rule, own, points)


def _read(builder: PhaseBuilder, name: str, own: Delayed, at: Reads) -> None:
    """y_k == the expansion of the interpolant."""
    if not len(at.points):
        return
    source, states = at.source, {state.name: state for state in at.source.phase.states}
    node, A, G = _expansions(source.mesh, at)
    width, h = A.shape[2], source.mesh.widths[at.segment]
    columns = [at.points, builder.mesh.fractions[at.points], at.s, 1 / h, source.mesh.first[at.segment], *(h * G)]
    over, (point, fraction, s, per_width, first, *bends) = data_of_rows(builder, name, columns)
    source.owners[over.name] = at.segment  # the costates at their knots count what is read there
    # Row q of a table of W columns starts at W q: Pyomo is slower with two indices.
    nodes = builder.data(f"{name}_node", None, node.ravel())
    weights = [builder.data(f"{name}_A{m}", None, own_A.ravel()) for m, own_A in enumerate(A)]

    def rule(block: Any, q: Any) -> Any:
        x = [item(source.block.x, own.state, item(nodes, width * q + j)) for j in range(width)]
        terms = [sum([item(row, width * q + j) * x_j for j, x_j in enumerate(x)]) for row in weights]
        if G.any():
            f = states[own.state].rate(source.at(item(first, q), states), pyomo)
            terms = [term + source.duration * item(bend, q) * f for term, bend in zip(terms, bends, strict=True)]
        earlier = block.t0 + builder.duration * item(fraction, q) - own.lag - source.block.t0
        delta = (earlier / source.duration - item(s, q)) * item(per_width, q)
        return item(block.z, own.name, item(point, q)) == _horner(terms, pyomo.tanh(delta))

    add_rows(builder, name, over, rule, own, at.points)


def _horner(coefficients: Sequence[Any], delta: Any) -> Any:
    value = coefficients[-1]
    for own in coefficients[-2::-1]:
        value = own + delta * value
    return value


def _expansions(mesh: Mesh, at: Reads) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """node (Q, W), A (m, Q, W), G (m, Q), of segments of any schemes."""
    theta = (at.s - mesh.edges[at.segment]) / mesh.widths[at.segment]
    width, count = max(len(scheme.sigma) for scheme in mesh.schemes), len(theta)
    node, A, G = np.empty((count, width), int), np.zeros((ORDER + 1, count, width)), np.zeros((ORDER + 1, count))
    for number, group in enumerate(mesh.groups):
        here, nodes = np.flatnonzero(mesh.group_of[at.segment] == number), len(group.scheme.sigma)
        A[:, here, :nodes], G[:, here] = expansion(collocation_scheme(group.scheme), theta[here])
        node[here] = mesh.first[at.segment[here], None] + np.minimum(np.arange(width), nodes - 1)
    return node, A, G


def data_of_rows(builder: PhaseBuilder, name: str, columns: Sequence[np.ndarray]) -> tuple[Any, list[Any]]:
    """A Set of rows, and a Param over it for each column.

    builder: of the phase.
    name: of the rows.
    columns: (Q,) each.
    """
    over = RangeSet(0, len(columns[0]) - 1)
    builder.block.add_component(f"{name}_q", over)
    return over, [builder.data(f"{name}_{i}", over, column) for i, column in enumerate(columns)]


def add_rows(builder: PhaseBuilder, name: str, over: Any, rule: Any, own: Delayed, points: np.ndarray) -> None:
    """Add what says what a state at an earlier time is.

    builder: of the phase.
    name: of the rows.
    over: their Set.
    rule: of the block and a row.
    own: the state.
    points: (Q,) where it is.
    """
    constraint = Constraint(over, rule=partial(rule))
    builder.block.add_component(name, constraint)
    times = builder.mesh.fractions[points]
    builder.tell(constraint, DELAY, own.name, (times, times), builder.mesh.weights[points])
