"""Knots of a mesh at the times of measurements.

With W_k(x, p) the weighted squared residuals at a time t_k, the objective is J + sum_k W_k(x(t_k), p), and the costates
jump there by what the measurement says:

    lambda(t_k-) = lambda(t_k+) + dW_k / dx(t_k)

A polynomial that holds such a time inside smears the jump: controls and costates lose all orders but one, as at any
jump. So each time is a knot. The residual there is one of the unknown state at the knot, which has the full order of
the method, and costates have a value on both sides of a knot in any case.
"""

from __future__ import annotations

import numpy as np

from ...problems.problem import Phase
from ..schemes.mesh import Mesh

APART = 1e-9
"""Of the duration: times that are nearer to a knot stand at it."""

NEAR = 0.2
"""Of the shorter segment beside it: a knot as near to a time of a measurement is moved there."""


def measured_fractions(phase: Phase) -> np.ndarray:
    """The normalised times of the measurements of a phase, increasing, those near an end or another one once."""
    if not phase.measured:
        return np.zeros(0)
    s = np.unique(phase.fractions_of(np.concatenate([own.instants for own in phase.measured])))
    s = s[(s > APART) & (s < 1 - APART)]
    return s[np.diff(s, prepend=-1.0) > APART]


def with_knots(mesh: Mesh, s: np.ndarray) -> Mesh:
    """The mesh with knots at normalised times s, (M,) as of `measured_fractions`; near ones are moved, others added.

    mesh: of any method that does not need equal segments.
    """
    edges = mesh.edges.copy()
    if not len(s) or mesh.schemes[0].equal:
        return mesh
    added = []
    for time in s:
        k = int(np.argmin(np.abs(edges[1:-1] - time))) + 1 if len(edges) > 2 else 0
        room = NEAR * min(edges[k] - edges[k - 1], edges[k + 1] - edges[k]) if k else 0.0
        if k and abs(edges[k] - time) <= max(room, APART) and not np.isin(edges[k], s[s != time]):
            edges[k] = time
        else:
            added.append(time)
    every = np.union1d(edges, added)
    owners = np.searchsorted(edges, (every[:-1] + every[1:]) / 2) - 1
    return Mesh(tuple(mesh.schemes[i] for i in owners), np.diff(every))


def knots_at(mesh: Mesh, s: np.ndarray) -> np.ndarray:
    """The numbers of the knots at normalised times s, shape that of s; -1 where there is none.

    mesh: of the phase.
    s: from 0 to 1.
    """
    edges = mesh.edges
    after = np.clip(np.searchsorted(edges, s), 1, len(edges) - 1)
    nearest = np.where(s - edges[after - 1] <= edges[after] - s, after - 1, after)
    return np.where(np.abs(edges[nearest] - s) <= 2 * APART, nearest, -1)
