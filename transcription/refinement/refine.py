"""Error of a solution -> the next mesh (paper, section 5.2 and Figure 7; Patterson, Hager and Rao 2015; Liu et al.
2018).

The error of segment s is its largest eta over the states, relative to 1 + the size of the state, or the error of its
part of an integral (of the objective, or constrained), relative to 1 + the integral. A segment is refined if one of
these is too large:

    its error, by the tolerance;
    its worth, what it adds to the error bar of J, relative to 1 + |J|, by the tolerance: where a constraint begins to
        act the dynamics may be met exactly, and J be off by multiplier times excess;
    its excess over bounds and path constraints between its points, times its share of the phase, by TOLERATED_EXCESS;
    the square of a jump of a control, relative to the control's range, times its share of the phase, by the tolerance:
        dynamics that are linear in the control show no eta there, and the objective suffers in the second order of the
        width. A jump that H does not depend on is worth nothing and is passed by.

Such a segment

    is split into three around a jump of its controls, the middle part closing in on it (see `switches`);
    gets more collocation points if its method has a choice of degree and the dynamics are smooth there: the Legendre
        coefficients of f decay fast, and the number of points is that which brings them below the tolerance;
    is split at a kink of its controls, where a constraint becomes active or inactive;
    is split into 2, 3 or 4 otherwise, as many as its order needs to reach the tolerance. Neighbours whose method has
        one degree only are divided together, at a density of segments that follows the error: ten that need 1.2 parts
        each become 12, not 20.

Where a mesh is not good enough, segments above MARGIN of the tolerance are refined as well. Segments far below the
tolerance lose points, and neighbours of one scheme that both are far below it are merged. Two things keep this and
splitting from taking turns: it is done only below MERGE_MARGIN of the tolerance, and after MERGING_MESHES meshes not
at all.
"""

from __future__ import annotations

from functools import cached_property
from itertools import groupby

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.quantities import TOLERATED_EXCESS
from ...problems.sets import distinct
from ...problems.text import short_repr
from ..measured.knots import knots_at, measured_fractions
from ..schemes.mesh import Mesh
from ..schemes.segment import Segment
from ..schemes.table import METHODS
from ..solution.error import ErrorProfile
from ..solution.trajectory import Trajectory
from ..solution.violation import of_phase
from .switches import Switches

MAX_RAISED_DEGREE = 16  # beyond this, splitting is the cheaper way to the same error
MIN_DEGREE = 3
DECAY = 0.4  # decades a coefficient: slower than that, f is not smooth on the segment
MERGE_MARGIN = 1e-3
MERGING_MESHES = 4
MARGIN = 0.8  # of the tolerance: what is nearly bad is refined along with what is, lest it needs another mesh
CLOSING_IN = 0.1  # half width of the middle part around a jump, relative to the segment
SLIVER = 0.02  # of a segment, at least, is cut off at a kink
STANDS_OUT = 10.0  # times the error of both neighbours: they are good enough to say where a kink between them is
TARGET = 0.5  # of the tolerance: what the parts of a segment aim at, as their error is not quite what is foreseen
MOST_PARTS = 4  # of a segment: its error tells no more of meshes much finer
WORTHLESS = 0.1  # of the tolerance: what a jump may be worth in the objective and not count
SAMPLES = 16  # of the density of parts on each segment

Piece = tuple[float, Segment]
"""Width and scheme of a segment of the next mesh."""


@short_repr
@dataclass(frozen=True)
class Refinement:
    """The next mesh, and the segments of this one that exceed the tolerance, in words; none if the mesh is good.

    enough: whether the next mesh can be expected to be good.
    """

    mesh: Mesh
    unmet: tuple[str, ...]
    enough: bool


def refine(trajectory: Trajectory, error: ErrorProfile, tolerance: float, merge: bool = True) -> Refinement:
    """The mesh to solve on next; pure, it changes nothing.

    trajectory: the solved phase, with the mesh to refine.
    error: of the trajectory, as `error_profile` measures it, or what `Goal` puts in its place.
    tolerance: of the relative error of each segment.
    merge: whether segments may lose points and be merged.
    """
    segments = _Segments(trajectory, error, tolerance)
    if trajectory.phase.exact or not len(segments.bad):
        return Refinement(trajectory.mesh, (), True)
    told = tuple(map(segments.told, segments.bad))
    if (scheme := trajectory.mesh.schemes[0]).equal:
        return Refinement(Mesh.of(scheme, 2 * trajectory.mesh.segments), told, segments.parts(segments.bad[0]) <= 2)
    near = segments.share > MARGIN
    pieces = [
        segments.refined(s) if near[s] else [segments.lowered(s) if merge else segments.same(s)]
        for s in range(trajectory.mesh.segments)
    ]
    enough = all(pieces[s] or segments.parts(s) < MOST_PARTS for s in np.flatnonzero(near).tolist())
    _divide(pieces, segments)
    if merge:
        pieces = _merged(pieces, segments.needless, segments.measured)
    flat = [piece for segment in pieces for piece in segment]
    widths, schemes = np.array([w for w, _ in flat]), tuple(scheme for _, scheme in flat)
    return Refinement(Mesh(schemes, widths), told, enough)


@dataclass(frozen=True)
class _Segments:
    """The segments of a solution, and what becomes of each."""

    trajectory: Trajectory
    error: ErrorProfile
    tolerance: float

    @cached_property
    def excess(self) -> np.ndarray:
        """The largest excess of anything bounded, shape (N,)."""
        return self.error.largest_excess

    @cached_property
    def share(self) -> np.ndarray:
        """The most of error, smearing and worth over the tolerance, and excess over TOLERATED_EXCESS, shape (N,)."""
        exceeded = self.excess * self.trajectory.mesh.widths / TOLERATED_EXCESS
        return np.fmax(np.fmax(self.inexact, self.error.worth / self.tolerance), exceeded)

    @cached_property
    def inexact(self) -> np.ndarray:
        """The error over the tolerance, or the smearing of a jump if that is more, shape (N,)."""
        inexact = np.where(np.isfinite(self.error.relative), self.error.relative / self.tolerance, np.inf)
        for s, jump in self.switches.jumps.items():
            smeared = (jump.height * self.trajectory.mesh.widths[s]) ** 2
            if smeared > inexact[s] * self.tolerance and self.switches.worth(s) > WORTHLESS * self.tolerance:
                inexact[s] = smeared / self.tolerance
        return inexact

    @cached_property
    def bad(self) -> np.ndarray:
        """The numbers of the segments that are not good enough, the worst first."""
        order = np.argsort(-self.share, kind="stable")
        return order[self.share[order] > 1]

    @cached_property
    def needless(self) -> np.ndarray:
        """Whether a segment is so good that it may lose points, shape (N,)."""
        return self.share < MERGE_MARGIN

    @cached_property
    def switches(self) -> Switches:
        return Switches(self.trajectory)

    @cached_property
    def measured(self) -> np.ndarray:
        """Whether something is measured at the start of a segment, shape (N,): knots that stay where they are."""
        found = np.zeros(self.trajectory.mesh.segments, bool)
        found[knots_at(self.trajectory.mesh, measured_fractions(self.trajectory.phase))] = True
        return found

    def same(self, s: int) -> Piece:
        return self.trajectory.mesh.widths[s], self.trajectory.mesh.schemes[s]

    def lowered(self, s: int) -> Piece:
        """With fewer points if they are needless, the method has a choice, and they stay enough to tell its quality.

        Half as many fewer as the decay of f allows: the error of some methods grows twice as fast.
        """
        width, scheme = self.same(s)
        method = METHODS[scheme.name]
        if not self.needless[s] or scheme.degree is None or scheme.degree <= MIN_DEGREE:
            return width, scheme
        fewer = int(np.log10(MARGIN / max(self.share[s], 1e-16)) / max(self._decay(s), DECAY) / 2)
        return width, method.of_degree(max(scheme.degree - fewer, MIN_DEGREE))

    def refined(self, s: int) -> list[Piece]:
        width, scheme = self.same(s)
        error = self.error.relative[s]
        ratio = error / (MARGIN * self.tolerance) if np.isfinite(error) else np.inf
        if max(self.inexact[s], self.error.worth[s] / self.tolerance) > MARGIN and (jump := self.switches.jump(s)):
            cuts = np.clip([jump.tau - CLOSING_IN, jump.tau + CLOSING_IN], 0.0, 1.0)
            return [(width * part, scheme) for part in np.diff(distinct(np.array([0.0, *cuts, 1.0])))]
        if raised := self._raised(s, ratio):
            return [(width, raised)]
        if kink := self._kink(s):
            return [(width * kink, scheme), (width * (1 - kink), scheme)]
        return []

    def parts(self, s: int) -> float:
        """How many parts of segment s would each have TARGET of the tolerance, at most MOST_PARTS.

        eta of a part falls as h^(q + 1), q being the scheme's `error_order`.
        """
        ratio = self.share[s] / TARGET
        return float(min(ratio ** (1 / (self.trajectory.mesh.schemes[s].error_order + 1)), MOST_PARTS))

    def _kink(self, s: int) -> float | None:
        """Where on segment s a kink is, if it is what makes the error of this segment."""
        errors = self.error.relative
        if not 0 < s < len(errors) - 1 or not errors[s] > STANDS_OUT * max(errors[s - 1], errors[s + 1]):
            return None
        kink = self.switches.kink(s)
        return kink.tau if kink and SLIVER < kink.tau < 1 - SLIVER else None

    def _raised(self, s: int, ratio: float) -> Segment | None:
        """The scheme with enough more points to reach the tolerance, where f is smooth and the method has a choice."""
        scheme = self.trajectory.mesh.schemes[s]
        method = METHODS[scheme.name]
        if scheme.degree is None or not 1 < ratio < np.inf or (decay := self._decay(s)) < DECAY:
            return None
        wanted = scheme.degree + int(np.ceil(np.log10(ratio) / decay))
        return method.of_degree(wanted) if wanted <= MAX_RAISED_DEGREE else None

    def _decay(self, s: int) -> float:
        """By how many decades each Legendre coefficient of the dynamics on segment s is smaller than the one before.

        Of the slowest state, and at most log10 of the degree, the rate of Patterson, Hager and Rao.
        """
        scheme = self.trajectory.mesh.schemes[s]
        n = len(scheme.c)
        fastest = float(np.log10(max(scheme.degree or n, MIN_DEGREE)))
        if n < 3:
            return fastest
        f = self.trajectory.f[:, self.trajectory.mesh.first[s] + np.array(scheme.collocated)]
        basis = np.polynomial.legendre.legvander(2 * scheme.c - 1, n - 1)
        coefficients = np.abs(np.linalg.solve(basis, f.T)).T
        floor = 1e-12 * (1 + np.abs(f).max(axis=1, keepdims=True))
        slopes = np.polyfit(np.arange(n), np.log10(np.maximum(coefficients, floor)).T, 1)[0]
        settled = (coefficients[:, -1:] <= 1e-6 * coefficients.max(axis=1, keepdims=True)).ravel()
        return float(np.min(-slopes[~settled], initial=fastest))

    def told(self, s: int) -> str:
        """Segment s in words: where it is, and why it is not good enough."""
        start, end = map(self.trajectory.told, self.trajectory.knots[s : s + 2])
        error = self.error
        where = of_phase(self.trajectory.phase.name)
        text = f"segment {s + 1}{where}, t = {start:.6g} to {end:.6g}: error {error.relative[s]:.1e}"
        if self.excess[s] * self.trajectory.mesh.widths[s] > TOLERATED_EXCESS:
            name = max(error.excess, key=lambda name: error.excess[name][s])
            text += f", {name} exceeded by {self.excess[s]:.1e}"
        if error.worth[s] > self.tolerance:
            text += f", adds {error.worth[s]:.1e} of 1 + |J| to the error bar"
        if jump := self.switches.jump(s):
            text += f", {jump.name} jumps at about t = {start + jump.tau * self.trajectory.h[s]:.6g}"
        return text


def _divide(pieces: list[list[Piece]], segments: _Segments) -> None:
    """Divide what has no pieces yet: neighbours of one scheme together, so that no two have a part too many.

    Segments with a choice of degree are divided each by itself: they only are where the dynamics are not smooth, and
    knots that have come near to that place are not to leave it again.
    """
    mesh, passed = segments.trajectory.mesh, np.cumsum(segments.measured)

    def together(s: int) -> tuple[bool, Segment, int, int]:
        """What neighbours that are divided together have in common; the third is of each segment that is alone, the
        last of all between two measurements."""
        alone = METHODS[mesh.schemes[s].name].nodes is not None
        return not pieces[s], mesh.schemes[s], s if alone else -1, int(passed[s])

    for (wanted, scheme, *_), run in groupby(range(mesh.segments), key=together):
        if wanted:
            numbers = list(run)
            widths = _spread(mesh.widths[numbers], np.array([segments.parts(s) for s in numbers]))
            pieces[numbers[0]] = [(width, scheme) for width in widths]


def _spread(widths: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """The widths of neighbouring segments, of these widths (k,), divided anew into about that many parts (k,) each.

    Between the middles of the segments the density of parts changes geometrically.
    """
    edges = np.concatenate([[0.0], np.cumsum(widths)])
    t = np.append(np.linspace(edges[:-1], edges[1:], SAMPLES, endpoint=False, axis=1), edges[-1])
    density = np.exp(np.interp(t, edges[:-1] + widths / 2, np.log(parts / widths)))
    passed = np.concatenate([[0.0], np.cumsum(np.diff(t) * (density[1:] + density[:-1]) / 2)])
    count = max(int(np.ceil(passed[-1] - 1e-9)), len(widths) + 1)
    return np.diff(np.interp(np.linspace(0.0, passed[-1], count + 1), passed, t))


def _merged(pieces: list[list[Piece]], needless: np.ndarray, measured: np.ndarray) -> list[list[Piece]]:
    """Merge neighbours that were not split, have one scheme and nearly one width, and are needless; not where something
    is measured between them."""
    merged, s = [], 0
    while s < len(pieces):
        pair = pieces[s : s + 2]
        if len(pair) == 2 and all(len(p) == 1 for p in pair) and needless[s : s + 2].all():
            (a, one), (b, other) = pair[0][0], pair[1][0]
            if one is other and 0.5 < a / b < 2 and not measured[s + 1]:
                merged.append([(a + b, one)])
                s += 2
                continue
        merged.append(pieces[s])
        s += 1
    return merged
