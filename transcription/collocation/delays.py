"""States at earlier times: y(t) = x(t - tau) as an input of the dynamics, and the rows that say what it is.

At a collocation point t_k the time t_k - tau lies before the initial time, where the history phi gives the state, or at
theta on a segment of duration h that starts at point i:

    y_k == phi(t_k - tau)                                         before the initial time
    y_k == sum_j A_j(theta) x_{i+j} + h G(theta) f_i              on a segment

The second is the state's own interpolant. With n collocation nodes that is a polynomial of degree n through all state
nodes sigma_j. Where there are more than n of them (Gauss, Radau), A_j are their Lagrange polynomials l_j and G = 0;
where there are n, of which sigma_0 is one, its slope at sigma_0 is the other condition, h f_i:

    omega = product of (theta - sigma_j),   G = omega / omega'(0),   A_j = l_j - l_j'(0) G

So the rows are linear in x but for one f, whatever the degree, and their derivatives are exact. The method keeps its
order as long as x is smooth on each segment. The history does not end as the state begins, so at t_0 + k tau the state
has a kink, in its derivative of order k + 1. A mesh with knots there keeps the order of the method (costates at knots
that of 2 for trapezoid, 3 for Hermite-Simpson, as measured); on others the objective has order 2, and costates 1.
"""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.quantities import Delayed
from ..libraries.pyomo import pyomo
from ..program.templates import item
from ..schemes.mesh import Mesh
from ..schemes.scheme import Scheme, collocation_scheme
from .builder import PhaseBuilder
from .moving import ALIGNED, add_moving, add_rows, data_of_rows, expansion, place_on, shares_of


def interpolation(scheme: Scheme, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A, shape (m, d + 1), and G, shape (m,), at theta, shape (m,)."""
    A, G = expansion(scheme, theta, order=0)
    return A[0], G[0]


@dataclass(frozen=True)
class DelayRows:
    """Rows of one delay on segments. point: (Q,) where y is. segment: (Q,) where x is. node, A: (Q, W). G: (Q,).

    knot: (Q,) the number of the knot that x is read at, or -1. before, after: (Q,) what of the row then belongs to the
    segment that ends there, and to the one that starts there.
    """

    point: np.ndarray
    segment: np.ndarray
    node: np.ndarray
    A: np.ndarray
    G: np.ndarray
    knot: np.ndarray
    before: np.ndarray
    after: np.ndarray

    def of(self, which: np.ndarray) -> DelayRows:
        return DelayRows(*(getattr(self, field.name)[which] for field in fields(self)))


def delay_rows(mesh: Mesh, lag: float) -> tuple[np.ndarray, DelayRows]:
    """The collocation points that see the history, and the rows of the others.

    mesh: of collocation schemes.
    lag: of a phase of duration 1.

    A point at which only the segment before it collocates looks back from there: at a knot it sees the segment before,
    and at the initial time the history.
    """
    points = mesh.collocated
    earlier, (before, after) = mesh.fractions[points] - lag, shares_of(mesh)[:, points]
    past = earlier < np.where(after > 0, -ALIGNED, ALIGNED)
    point, s, before, after = (own[~past] for own in (points, np.maximum(earlier, 0.0), before, after))
    segment, s, knot = place_on(mesh, s, after, ALIGNED)
    theta = np.clip((s - mesh.edges[segment]) / mesh.widths[segment], 0.0, 1.0)
    theta = np.where(knot >= 0, np.where(after > 0, 0.0, 1.0), theta)
    width = max(len(scheme.sigma) for scheme in mesh.schemes)
    node, A, G = np.empty((len(s), width), int), np.zeros((len(s), width)), np.zeros(len(s))
    for number, group in enumerate(mesh.groups):
        here, sigma = mesh.group_of[segment] == number, group.scheme.sigma
        last, nearest = len(sigma) - 1, np.abs(theta[here, None] - sigma).argmin(axis=1)
        theta[here] = np.where(np.abs(theta[here] - sigma[nearest]) < ALIGNED, sigma[nearest], theta[here])
        A[here, : last + 1], G[here] = interpolation(collocation_scheme(group.scheme), theta[here])
        node[here] = mesh.first[segment[here], None] + np.minimum(np.arange(width), last)
    G[knot >= 0] = 0.0
    return points[past], DelayRows(point, segment, node, A, G, knot, before, after)


def add_delays(builder: PhaseBuilder) -> None:
    """Add the rows of all states at earlier times."""
    if not builder.phase.delayed:
        return
    ends = builder.block.t0, builder.block.tF
    if builder.before or not all(end.fixed for end in ends):
        add_moving(builder)
        return
    times = [end.value for end in ends]
    duration = times[1] - times[0]
    for number, own in enumerate(builder.phase.delayed):
        past, rows = delay_rows(builder.mesh, own.lag / duration)
        _history(builder, number, own, past, times[0] + builder.mesh.fractions[past] * duration - own.lag)
        bent, at_knot = rows.G != 0, rows.knot >= 0
        at_node = (np.count_nonzero(rows.A, axis=1) == 1) & ~bent & ~at_knot
        _interpolated(builder, f"delay{number}_inside", own, rows.of(~bent & ~at_knot & ~at_node))
        _interpolated(builder, f"delay{number}_bent", own, rows.of(bent), slope=True)
        _at_nodes(builder, f"delay{number}_at_node", own, rows.of(at_node))
        _at_knots(builder, f"delay{number}_at_knot", own, rows.of(at_knot))


def _history(builder: PhaseBuilder, number: int, own: Delayed, points: np.ndarray, t: np.ndarray) -> None:
    if not len(points):
        return
    name = f"history{number}"
    over, (point, value) = data_of_rows(builder, name, [points, own.before(t)])

    def rule(block: Any, q: Any) -> Any:
        return item(block.z, own.name, item(point, q)) - item(value, q) == 0.0

    add_rows(builder, name, over, rule, own, points)


def _interpolated(builder: PhaseBuilder, name: str, own: Delayed, rows: DelayRows, slope: bool = False) -> None:
    if not len(rows.point):
        return
    mesh, width = builder.mesh, rows.A.shape[1]
    columns = [rows.point, mesh.first[rows.segment], mesh.widths[rows.segment] * rows.G]
    over, (point, first, bend) = data_of_rows(builder, name, columns)
    builder.owners[over.name] = rows.segment  # the costates at their knots count what is read there
    # Row q of a table of W columns starts at W q: Pyomo is slower with two indices.
    A, node = (builder.data(f"{name}_{key}", None, own.ravel()) for key, own in (("A", rows.A), ("node", rows.node)))
    states = {state.name: state for state in builder.phase.states}

    def rule(block: Any, q: Any) -> Any:
        x = [item(A, width * q + j) * item(block.x, own.state, item(node, width * q + j)) for j in range(width)]
        value = sum(x)
        if slope:
            f = states[own.state].rate(builder.at(item(first, q), states), pyomo)
            value = value + builder.duration * item(bend, q) * f
        return item(block.z, own.name, item(point, q)) == value

    add_rows(builder, name, over, rule, own, rows.point)


def _at_nodes(builder: PhaseBuilder, name: str, own: Delayed, rows: DelayRows) -> None:
    """y_k == x at a node inside a segment."""
    if not len(rows.point):
        return
    node = np.take_along_axis(rows.node, rows.A.argmax(axis=1)[:, None], axis=1)[:, 0]
    over, (point, at) = data_of_rows(builder, name, [rows.point, node])
    builder.owners[over.name] = rows.segment

    def rule(block: Any, q: Any) -> Any:
        return item(block.z, own.name, item(point, q)) == item(block.x, own.state, item(at, q))

    add_rows(builder, name, over, rule, own, rows.point)


def _at_knots(builder: PhaseBuilder, name: str, own: Delayed, rows: DelayRows) -> None:
    """y_k == x at a knot, which belongs to both its segments, as y_k does; at the initial time partly the history."""
    if not len(rows.point):
        return
    first, history = rows.knot == 0, float(own.before(np.array(builder.phase.initial_time.lower)))
    shares, rests = np.where(first, rows.after, 1.0), np.where(first, rows.before * history, 0.0)
    columns = [rows.point, builder.mesh.knots[rows.knot], shares, rests]
    over, (point, knot, share, rest) = data_of_rows(builder, name, columns)
    builder.shared[over.name] = rows.knot, np.where(first, 0.0, rows.before), np.where(first, 1.0, rows.after)

    def rule(block: Any, q: Any) -> Any:
        x = item(block.x, own.state, item(knot, q))
        return item(block.z, own.name, item(point, q)) == item(share, q) * x + item(rest, q)

    add_rows(builder, name, over, rule, own, rows.point)
