"""A mesh is data: the width of each segment, as a fraction of the phase's duration, and its scheme.

    knots          0 ----- edges[1] ----- edges[2] ----- ... ----- 1          N segments
    points         0   1   2      3   4   5                        K - 1      d_s on segment s, shared at the knots
    slots          0   1   2 | 3  4   5   6 | ...                             d_s + 1 on segment s, nothing shared

Segment s owns the points first[s], first[s] + 1, ..., first[s] + d_s, the last of which is the first of segment s + 1.
Degrees may differ from segment to segment; segments of one scheme form a group, so that they are treated all at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.sets import distinct
from ...problems.text import short_repr
from .segment import Segment, SegmentGroup


@short_repr
@dataclass(frozen=True, eq=False)
class Mesh:
    """schemes: one for each segment. widths: (N,) positive, in any unit; they are scaled to a sum of 1."""

    schemes: tuple[Segment, ...]
    widths: np.ndarray

    def __post_init__(self) -> None:
        widths = np.asarray(self.widths, float)
        if widths.ndim != 1 or not len(widths) or not (widths > 0).all():
            raise ValueError("the widths of a mesh are positive numbers, one for each segment")
        if len(self.schemes) != len(widths):
            raise ValueError(f"a mesh of {len(widths)} segments has {len(self.schemes)} schemes")
        object.__setattr__(self, "widths", widths / widths.sum())

    @classmethod
    def of(cls, scheme: Segment, segments: int | Sequence[float]) -> Mesh:
        """One scheme everywhere, on that many equal segments or on segments of these widths."""
        widths = np.ones(segments) if isinstance(segments, int) else np.asarray(segments, float)
        return cls((scheme,) * len(widths), widths)

    @property
    def segments(self) -> int:
        return len(self.widths)

    def coarsened(self, points: int) -> Mesh | None:
        """A mesh with about that many points in all, knots of this one between its segments.

        None if schemes differ, or the method is none for a few long segments.
        """
        if len(self.groups) > 1 or not self.schemes[0].coarsens:
            return None
        segments = min(max(points // int(self.degrees[0]), 1), self.segments)
        kept = np.linspace(0, self.segments, segments + 1).round().astype(int)
        return Mesh(self.schemes[:segments], np.diff(self.edges[kept]))

    def divided(self, parts: int) -> Mesh:
        """A mesh with this many equal segments for each of this one."""
        schemes = tuple(scheme for scheme in self.schemes for _ in range(parts))
        return Mesh(schemes, np.repeat(self.widths / parts, parts))

    @cached_property
    def degrees(self) -> np.ndarray:
        """Points per segment, the one shared with the next segment not counted, shape (N,)."""
        return np.array([len(scheme.sigma) - 1 for scheme in self.schemes])

    @property
    def degrees_at_points(self) -> np.ndarray:
        """That of the segment that starts at or before each point, shape (K,); of the last segment at the last one."""
        return np.append(np.repeat(self.degrees, self.degrees), self.degrees[-1])

    @cached_property
    def edges(self) -> np.ndarray:
        """Normalised times of the knots, shape (N + 1,); exactly 0 and 1 at the ends."""
        return np.append(np.concatenate([[0.0], np.cumsum(self.widths[:-1])]), 1.0)

    @cached_property
    def first(self) -> np.ndarray:
        """The first point of each segment, shape (N,)."""
        return self.knots[:-1]

    @cached_property
    def knots(self) -> np.ndarray:
        """The points that are segment edges, shape (N + 1,)."""
        return np.concatenate([[0], np.cumsum(self.degrees)])

    @cached_property
    def offset(self) -> np.ndarray:
        """The first slot of each segment, shape (N,)."""
        return self.first + np.arange(self.segments)

    @cached_property
    def slot_points(self) -> np.ndarray:
        """The point of each slot, shape (K + N - 1,)."""
        points = np.empty(self.knots[-1] + self.segments, int)
        for group in self.groups:
            points[group.slots] = group.nodes
        return points

    @cached_property
    def groups(self) -> tuple[SegmentGroup, ...]:
        """The segments by scheme, each once."""
        groups = []
        for scheme in dict.fromkeys(self.schemes):
            segments = np.array([s for s, own in enumerate(self.schemes) if own is scheme])
            local = np.arange(len(scheme.sigma))
            nodes = self.first[segments, None] + local
            slots = self.offset[segments, None] + local
            groups.append(SegmentGroup(scheme, segments, nodes, nodes[:, scheme.collocated], slots))
        return tuple(groups)

    @cached_property
    def group_of(self) -> np.ndarray:
        """The number of the group of each segment, shape (N,)."""
        numbers = np.empty(self.segments, int)
        for i, group in enumerate(self.groups):
            numbers[group.segments] = i
        return numbers

    @cached_property
    def collocated(self) -> np.ndarray:
        """The numbers of the collocation points."""
        return distinct(np.concatenate([group.collocated.ravel() for group in self.groups]))

    @cached_property
    def fractions(self) -> np.ndarray:
        """Normalised times of the points, shape (K,)."""
        fractions = np.empty(self.knots[-1] + 1)
        for group in self.groups:
            start, width = self.edges[group.segments, None], self.widths[group.segments, None]
            fractions[group.nodes] = start + width * group.scheme.sigma
        fractions[self.knots] = self.edges
        return fractions

    @cached_property
    def weights(self) -> np.ndarray:
        """Quadrature weights of the points for a phase of duration 1, shape (K,); 0 where nothing is collocated."""
        weights = np.zeros(len(self.fractions))
        for group in self.groups:
            np.add.at(weights, group.collocated, self.widths[group.segments, None] * group.scheme.b)
        return weights

    @cached_property
    def slot_parts(self) -> np.ndarray:
        """The part of what a point contributes that belongs to the segment of each slot, shape (K + N - 1,).

        That of its quadrature weight; where states are simulated a knot belongs to both its segments by halves.
        """
        parts = np.zeros(len(self.slot_points))
        for group in self.groups:
            nodes = group.slots[:, group.scheme.collocated]
            parts[nodes] = self.widths[group.segments, None] * group.scheme.b
        parts /= np.where(self.weights > 0, self.weights, 1.0)[self.slot_points]
        for group in self.groups:
            if group.scheme.simulated:
                parts[group.slots] = 0.5
        return parts
