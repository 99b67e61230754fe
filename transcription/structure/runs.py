"""Points on bounds -> arcs.

A segment of the mesh is looked at as a whole: all of its points on one bound, or none. One in which a control jumps, or
that is on a bound in part, belongs to no arc: what a collocation method smears over a switch would otherwise be an arc
of its own. What is left between two arcs holds their switch.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from ..arcs import CLOSE, INSIDE, LOWER, UPPER, Arc
from ..schemes.mesh import Mesh


def arcs_of(
    on: np.ndarray,
    points: Sequence[np.ndarray],
    mesh: Mesh,
    knots: np.ndarray,
    acts: Callable[[float, float], bool],
    cut: Callable[[int, int], float],
    smeared: np.ndarray | None = None,
) -> tuple[Arc, ...]:
    """The arcs of a quantity that is on its bounds at some points of a mesh.

    on: (K,) -1 at the points where it is on its lower bound, 1 on the upper one, 0 on none.
    points: of the segments of each group of the mesh, (G, n) each: those that count.
    mesh: of N segments.
    knots: (N + 1,) their times.
    acts: whether what is on a bound from one time to another is held by it; else it is only near.
    cut: the time between two arcs, of which the last segment of one and the first of the other are given.
    smeared: (N,) the segments that are no part of an arc inside the bounds.
    """
    label, whole = np.zeros(mesh.segments, int), np.zeros(mesh.segments, bool)
    for group, nodes in zip(mesh.groups, points, strict=True):
        label[group.segments] = on[nodes][:, 0]
        whole[group.segments] = (on[nodes] == on[nodes][:, :1]).all(axis=1)
    if smeared is not None:
        whole &= (label != 0) | ~smeared
    for run in _runs(label, np.flatnonzero(whole)):
        if label[run[0]] and not acts(float(knots[run[0]]), float(knots[run[-1] + 1])):
            label[run] = 0
    runs = _runs(label, np.flatnonzero(whole))
    if not runs:
        return (Arc(float(knots[0]), float(knots[-1]), INSIDE),)
    cuts = [float(knots[0]), *(cut(int(a[-1]), int(b[0])) for a, b in pairwise(runs)), float(knots[-1])]
    return tuple(
        Arc(start, end, (INSIDE, UPPER, LOWER)[label[run[0]]])
        for (start, end), run in zip(pairwise(cuts), runs, strict=True)
    )


def _runs(label: np.ndarray, kept: np.ndarray) -> list[np.ndarray]:
    """The numbers of the segments that are kept, in runs of one label."""
    return np.split(kept, np.flatnonzero(np.diff(label[kept])) + 1) if len(kept) else []


def snapped(arcs: Sequence[Arc], times: Sequence[float]) -> tuple[Arc, ...]:
    """Arcs whose switches are at given times, where one is near: nearer than a share CLOSE of both arcs beside it.

    arcs: of a state or path constraint.
    times: at which controls switch, where they say better when.
    """
    ends = [arcs[0].start]
    for arc, after in pairwise(arcs):
        distance, nearest = min(((abs(t - arc.end), t) for t in times), default=(0.0, arc.end))
        reach = CLOSE * min(arc.end - arc.start, after.end - after.start)
        ends.append(nearest if distance <= reach else arc.end)
    ends.append(arcs[-1].end)
    return tuple(replace(arc, start=start, end=end) for arc, (start, end) in zip(arcs, pairwise(ends), strict=True))


def with_touches(arcs: Sequence[Arc], touches: Sequence[tuple[float, str]]) -> tuple[Arc, ...]:
    """Arcs with the points at which a bound is touched inside of them.

    touches: the time, and LOWER or UPPER, of each, in order.
    """
    found: list[Arc] = []
    for arc in arcs:
        start = arc.start
        margin = CLOSE * (arc.end - arc.start)
        for t, on in touches if arc.on == INSIDE else ():
            if arc.start + margin < t < arc.end - margin:
                found += [Arc(start, t, INSIDE), Arc(t, t, on)]
                start = t
        found.append(Arc(start, arc.end, arc.on))
    return tuple(found)
