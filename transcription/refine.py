"""Error of a solution -> the next mesh (paper, section 5.2 and Figure 7; Patterson, Hager and Rao 2015; Liu et al.
2018).

The error of segment s is its largest eta over the states, relative to 1 + the size of the state, or the error of its
part of an integral (of the objective, or constrained), relative to 1 + the integral. A segment that exceeds the
tolerance

    is split into three around a discontinuity of its controls, the middle part closing in on it;
    gets more collocation points, P = log(error / tolerance) / log(degree) of them, if its method has a choice of degree
        and the dynamics are smooth there: the Legendre coefficients of f decay fast;
    is split into 2, 3 or 4 otherwise, as many as its order needs to reach the tolerance.

Segments far below the tolerance lose points, and neighbours of one scheme that both are far below it are merged. Two
things keep this and splitting from taking turns: it is done only below MERGE_MARGIN of the tolerance, and after
MERGING_MESHES meshes not at all.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .error import ErrorProfile, quadrature_error
from .mesh import Mesh
from .scheme import Scheme
from .schemes import MAX_DEGREE, METHODS
from .trajectory import Trajectory

MAX_RAISED_DEGREE = 16  # beyond this, splitting is the cheaper way to the same error
MIN_DEGREE = 3
DEGREE_STEP = 3  # each degree on a mesh has templates of its own to build; fewer degrees, fewer of them
DECAY = 0.4  # decades a coefficient: slower than that, f is not smooth on the segment
MERGE_MARGIN = 1e-3
MERGING_MESHES = 4
CLOSING_IN = 0.1  # half width of the middle part around a discontinuity, relative to the segment
JUMP = 0.25  # of a control's range within one segment: a discontinuity, if the control is smooth on neither side


@dataclass(frozen=True)
class Refinement:
    """The next mesh, and the segments of this one that exceed the tolerance, in words; none if the mesh is good."""

    mesh: Mesh
    unmet: tuple[str, ...]


def relative_error(trajectory: Trajectory, error: ErrorProfile) -> np.ndarray:
    """The largest eta of each segment relative to 1 + max |x|, or error of an integral if larger, shape (N,)."""
    size = 1 + np.abs(trajectory.dense.x).max(axis=1, keepdims=True)
    return np.vstack([error.eta / size, quadrature_error(trajectory)]).max(axis=0)


def refine(trajectory: Trajectory, error: ErrorProfile, tolerance: float, merge: bool = True) -> Refinement:
    """The mesh to solve on next; pure, it changes nothing. merge: whether segments may lose points and be merged."""
    mesh, errors = trajectory.mesh, relative_error(trajectory, error)
    above = np.flatnonzero(~(errors <= tolerance))
    if not len(above):
        return Refinement(mesh, ())
    pieces = []
    for s in range(mesh.segments):
        if errors[s] <= tolerance:
            needless = merge and errors[s] < MERGE_MARGIN * tolerance
            pieces.append([(mesh.widths[s], _lowered(mesh.schemes[s]) if needless else mesh.schemes[s])])
        else:
            pieces.append(_refine_segment(trajectory, s, float(errors[s]), tolerance))
    if merge:
        pieces = _merge(pieces, errors, tolerance)
    flat = [piece for segment in pieces for piece in segment]
    widths, schemes = np.array([w for w, _ in flat]), tuple(scheme for _, scheme in flat)
    return Refinement(
        Mesh(schemes, widths), tuple(_told(trajectory, s, errors[s]) for s in _worst_first(above, errors))
    )


def _worst_first(above: np.ndarray, errors: np.ndarray) -> np.ndarray:
    return above[np.argsort(-np.nan_to_num(errors[above], nan=np.inf), kind="stable")]


def _told(trajectory: Trajectory, s: int, error: float) -> str:
    jump = _jump(trajectory, s)
    where = f"segment {s + 1}, t = {trajectory.knots[s]:.6g} to {trajectory.knots[s + 1]:.6g}: error {error:.1e}"
    return where + (
        f", a control jumps at about t = {trajectory.knots[s] + jump * trajectory.h[s]:.6g}" if jump else ""
    )


def _refine_segment(trajectory: Trajectory, s: int, error: float, tolerance: float) -> list:
    width, scheme = trajectory.mesh.widths[s], trajectory.mesh.schemes[s]
    ratio = error / tolerance if np.isfinite(error) else np.inf
    if (tau := _jump(trajectory, s)) is not None:
        cuts = np.clip([tau - CLOSING_IN, tau + CLOSING_IN], 0.0, 1.0)
        parts = np.diff(np.unique(np.concatenate([[0.0], cuts, [1.0]])))
        return [(width * part, scheme) for part in parts]
    raised = _raised(scheme, ratio)
    if raised is not None and _is_smooth(trajectory, s):
        return [(width, raised)]
    # eta of a piece falls as h^(q + 1), q being the order of the interpolant's slope.
    count = int(np.clip(np.ceil(ratio ** (1 / (len(scheme.c) + 1))), 2, 4)) if np.isfinite(ratio) else 4
    return [(width / count, scheme)] * count


def _raised(scheme: Scheme, ratio: float) -> Scheme | None:
    """The scheme with enough more points to reach the tolerance if f is analytic; None where there is none."""
    method = METHODS[scheme.name]
    if method.nodes is None or not np.isfinite(ratio):
        return None
    degree = scheme.degree
    more = int(np.ceil(np.log(ratio) / np.log(max(degree, MIN_DEGREE))))
    wanted = degree + DEGREE_STEP * -(-max(more, 1) // DEGREE_STEP)
    return method.of_degree(wanted) if wanted <= min(MAX_RAISED_DEGREE, MAX_DEGREE) else None


def _lowered(scheme: Scheme) -> Scheme:
    """The scheme with fewer points, where its method has a choice and they stay enough to tell smooth from rough."""
    method = METHODS[scheme.name]
    if method.nodes is None or scheme.degree - DEGREE_STEP < MIN_DEGREE:
        return scheme
    return method.of_degree(scheme.degree - DEGREE_STEP)


def _is_smooth(trajectory: Trajectory, s: int) -> bool:
    """Whether the Legendre coefficients of the dynamics on segment s fall by DECAY decades each, for every state."""
    scheme = trajectory.mesh.schemes[s]
    n = len(scheme.c)
    if n < 3:
        return True
    f = trajectory.f[:, trajectory.mesh.first[s] + np.array(scheme.collocated)]
    basis = np.polynomial.legendre.legvander(2 * scheme.c - 1, n - 1)
    coefficients = np.abs(np.linalg.solve(basis, f.T)).T
    floor = 1e-12 * (1 + np.abs(f).max(axis=1, keepdims=True))
    slopes = np.polyfit(np.arange(n), np.log10(np.maximum(coefficients, floor)).T, 1)[0]
    settled = (coefficients[:, -1:] <= 1e-6 * coefficients.max(axis=1, keepdims=True)).ravel()
    return bool((settled | (slopes <= -DECAY)).all())


def _jump(trajectory: Trajectory, s: int) -> float | None:
    """Where on segment s a control jumps, tau in [0, 1]; None if none does."""
    sample = trajectory.grid(np.array([s]), np.linspace(0, 1, 41))
    for i in range(len(trajectory.phase.controls)):
        u, dense = sample.u[i, 0], trajectory.dense.u[i]
        span = dense.max() - dense.min()
        steps = np.abs(np.diff(u))
        if span > 0 and abs(u[-1] - u[0]) > JUMP * span and steps.max() > 3 * np.median(steps):
            k = int(np.argmax(steps))
            return float((k + 0.5) / 40)
    return None


def _merge(pieces: list, errors: np.ndarray, tolerance: float) -> list:
    """Merge neighbours that were left alone, have one scheme and nearly one width, and are far below the tolerance."""
    merged, s = [], 0
    while s < len(pieces):
        pair = pieces[s : s + 2]
        if len(pair) == 2 and all(len(p) == 1 for p in pair) and max(errors[s : s + 2]) < MERGE_MARGIN * tolerance:
            (a, one), (b, other) = pair[0][0], pair[1][0]
            if one is other and 0.5 < a / b < 2:
                merged.append([(a + b, one)])
                s += 2
                continue
        merged.append(pieces[s])
        s += 1
    return merged
