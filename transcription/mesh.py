"""A mesh is data: one scheme and the widths of the segments, as fractions of the phase's duration.

    knots          0 ----- edges[1] ----- edges[2] ----- ... ----- 1          N segments
    points         0   1   2      3   4   5                        K - 1      d per segment, shared at the knots

Segment s owns the points first[s], first[s] + 1, ..., first[s] + d, the last of which is the first of segment s + 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .schemes import Scheme


@dataclass(frozen=True, eq=False)
class Mesh:
    """scheme: of every segment. widths: (N,) positive, in any unit; they are scaled to a sum of 1."""

    scheme: Scheme
    widths: np.ndarray

    def __post_init__(self):
        widths = np.asarray(self.widths, float)
        if widths.ndim != 1 or not len(widths) or not (widths > 0).all():
            raise ValueError("the widths of a mesh are positive numbers, one for each segment")
        object.__setattr__(self, "widths", widths / widths.sum())

    @classmethod
    def uniform(cls, scheme: Scheme, segments: int) -> Mesh:
        return cls(scheme, np.ones(segments))

    @property
    def segments(self) -> int:
        return len(self.widths)

    @property
    def degree(self) -> int:
        """Points per segment, the one shared with the next segment not counted."""
        return len(self.scheme.sigma) - 1

    @cached_property
    def edges(self) -> np.ndarray:
        """Normalised times of the knots, shape (N + 1,); exactly 0 and 1 at the ends."""
        return np.append(np.concatenate([[0.0], np.cumsum(self.widths[:-1])]), 1.0)

    @cached_property
    def first(self) -> np.ndarray:
        """The first point of each segment, shape (N,)."""
        return self.degree * np.arange(self.segments)

    @cached_property
    def nodes(self) -> np.ndarray:
        """The points of each segment, shape (N, d + 1)."""
        return self.first[:, None] + np.arange(self.degree + 1)

    @cached_property
    def collocated(self) -> np.ndarray:
        """The collocation points of each segment, shape (N, n)."""
        return self.nodes[:, self.scheme.collocated]

    @cached_property
    def fractions(self) -> np.ndarray:
        """Normalised times of the points, shape (K,)."""
        inner = self.edges[:-1, None] + self.widths[:, None] * self.scheme.sigma[None, :-1]
        return np.append(inner.ravel(), 1.0)

    @cached_property
    def weights(self) -> np.ndarray:
        """Quadrature weights of the points for a phase of duration 1, shape (K,)."""
        return np.bincount(
            self.collocated.ravel(),
            weights=(self.widths[:, None] * self.scheme.b).ravel(),
            minlength=len(self.fractions),
        )
