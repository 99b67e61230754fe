"""Defects in differential form as data: one numbering for the rows of all segments, whatever their degree.

Row q belongs to a segment that starts at point `first` and to a row r of the tables, those of its scheme:

    sum_i L[r, i] x[first + node[r, i]]  ==  h sum_j R[r, j] f[first + point[r, j]]

The tables of schemes with fewer nodes are filled up with coefficients 0 at their last node, so that one template serves
all degrees on a mesh: making and differentiating a template costs more than evaluating a few zeros.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...problems.lean.records import dataclass
from ..schemes.mesh import Mesh
from ..schemes.scheme import Scheme, collocation_scheme


@dataclass(frozen=True)
class GroupRows:
    """The rows of one group of segments: its number on the mesh, the rows of its scheme, and which q they are."""

    group: int
    rows: tuple[int, ...]
    q: slice


@dataclass(frozen=True)
class PointRows:
    """The rows with equally many dynamics f. segments, row: (Q,). L, node: (rows, nodes). R, point: (rows, terms)."""

    segments: np.ndarray
    row: np.ndarray
    L: np.ndarray
    node: np.ndarray
    R: np.ndarray
    point: np.ndarray
    parts: tuple[GroupRows, ...]

    @property
    def terms(self) -> int:
        """How many dynamics stand in a row."""
        return self.R.shape[1]


def point_rows(mesh: Mesh) -> Iterator[PointRows]:
    """The rows of all groups whose scheme is in differential form, by the number of dynamics in a row."""
    found: dict[int, list[tuple[int, list[int]]]] = {}
    for number, group in enumerate(mesh.groups):
        for terms, rows in collocation_scheme(group.scheme).point_rows or ():
            found.setdefault(terms, []).append((number, rows))
    for terms, groups in found.items():
        yield _joined(mesh, terms, groups)


def _joined(mesh: Mesh, terms: int, groups: list[tuple[int, list[int]]]) -> PointRows:
    width = max(len(mesh.groups[number].scheme.sigma) for number, _ in groups)
    segments, row, tables, parts = [], [], [], []
    start = above = 0
    for number, rows in groups:
        group = mesh.groups[number]
        segments.append(np.repeat(group.segments, len(rows)))
        row.append(above + np.tile(np.arange(len(rows)), len(group.segments)))
        tables.append(_tables(collocation_scheme(group.scheme), rows, terms, width))
        parts.append(GroupRows(number, tuple(rows), slice(start, start + len(row[-1]))))
        start, above = parts[-1].q.stop, above + len(rows)
    L, node, R, point = (np.concatenate(columns) for columns in zip(*tables, strict=True))
    return PointRows(np.concatenate(segments), np.concatenate(row), L, node, R, point, tuple(parts))


def _tables(scheme: Scheme, rows: list[int], terms: int, width: int) -> tuple[np.ndarray, ...]:
    last = len(scheme.sigma) - 1
    L = np.pad(scheme.L[rows], ((0, 0), (0, width - last - 1)))
    node = np.broadcast_to(np.minimum(np.arange(width), last), L.shape)
    # The dynamics at the row's own node come first.
    columns = np.array([np.flatnonzero(scheme.R[r])[::-1] for r in rows], int).reshape(len(rows), terms)
    return L, node, np.take_along_axis(scheme.R[rows], columns, axis=1), np.array(scheme.collocated)[columns]
