"""Where a curve jumps, and how much of the phase a jump may blur: there no mesh makes a check hold that needs a limit.

A jump lies somewhere within a segment, so its segment's polynomial is neither of both sides. If both segments at a knot
share the control there, it may be spread over neighbouring ones. What is wrong there counts times the share that these
segments have of the phase, as its effect does: a mesh that resolves the jump makes it small, and a curve that jumps
everywhere is excused nowhere.
"""

from __future__ import annotations

import numpy as np

from ...transcription.refinement.switches import FLAT, JUMP, STEEP, Switches
from ...transcription.solution.trajectory import Trajectory

CLOSE = 1e-12  # of the phase: widths that add up to it


def control_shares(trajectory: Trajectory) -> np.ndarray:
    """What an excess on each segment counts, shape (N,): 1, or beside jumps of controls their share of the phase."""
    u = trajectory.inputs(np.linspace(0, 1, 11))[: len(trajectory.phase.controls)]
    marked = np.zeros(trajectory.mesh.segments, bool)
    marked[list(Switches(trajectory).jumps)] = True
    return _shares(trajectory, marked | _steep(trajectory, np.ptp(u, axis=2), _spans(u)))


def point_shares(trajectory: Trajectory, curves: np.ndarray) -> np.ndarray:
    """The same at the collocation points, shape (M,), for jumps of controls and of other curves (n, M) there."""
    mesh, points = trajectory.mesh, trajectory.mesh.collocated
    heights = np.zeros((len(curves), mesh.segments))
    for group in mesh.groups:
        heights[:, group.segments] = np.ptp(curves[:, np.searchsorted(points, group.collocated)], axis=2)
    steep = _steep(trajectory, heights, _spans(curves))
    shares = np.minimum(_shares(trajectory, steep), control_shares(trajectory))
    found = np.ones(len(points))
    for group in mesh.groups:
        here = np.searchsorted(points, group.collocated)
        np.minimum.at(found, here, np.broadcast_to(shares[group.segments][:, None], here.shape))
    return found


def _spans(curves: np.ndarray) -> np.ndarray:
    """The range of each curve, shape (n,), or a small part of its size if it hardly varies."""
    over_time = tuple(range(1, curves.ndim))
    return np.maximum(np.ptp(curves, axis=over_time), FLAT * (1 + np.abs(curves).max(axis=over_time)))


def _steep(trajectory: Trajectory, heights: np.ndarray, spans: np.ndarray) -> np.ndarray:
    """Segments (N,) in runs over which a curve changes by much, and far more steeply than beside them.

    heights: by how much each curve changes on each segment, shape (n, N). spans: of each curve, (n,).
    """
    h, found = trajectory.h, np.zeros(trajectory.mesh.segments, bool)
    for height, span in zip(heights, spans, strict=True):
        for first, last in _runs(height > JUMP * span):
            beside = [s for s in (first - 1, last + 1) if 0 <= s < len(h)]
            slope = height[first : last + 1].sum() / h[first : last + 1].sum()
            if beside and slope > 2 * STEEP * max(height[s] / h[s] for s in beside):
                found[first : last + 1] = True
    return found


def _shares(trajectory: Trajectory, marked: np.ndarray) -> np.ndarray:
    """What segments count, shape (N,): those that are marked, and the ones beside them, the width of their run."""
    near = marked.copy()
    near[1:] |= marked[:-1]
    near[:-1] |= marked[1:]
    widths, found = trajectory.mesh.widths, np.ones(len(marked))
    for first, last in _runs(near):
        share = widths[first : last + 1].sum()
        found[first : last + 1] = share if share < 1 - CLOSE else 1.0
    return found


def _runs(marked: np.ndarray) -> list[tuple[int, int]]:
    """First and last index of each run of what is marked."""
    edges = np.diff(np.concatenate([[0], marked.astype(int), [0]]))
    return list(zip(np.flatnonzero(edges == 1).tolist(), (np.flatnonzero(edges == -1) - 1).tolist(), strict=True))
