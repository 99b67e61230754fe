"""The least Hamiltonian over all controls that are allowed, at every collocation point (Pontryagin's minimum).

First and second derivatives see the neighbourhood only: an extremal along which H has a lower minimum elsewhere passes
them. So at every point H is taken at many feasible controls (`candidates`), and the best few are improved. With E the
integral of what H is above the least value found, J + E is no better than the Lagrangian's value with these controls.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.text import short_repr
from ..solution.hamiltonian import Constrained, Values, minimise
from ..solution.lagrangian import PhaseLagrangian, Samples
from .candidates import SAMPLES, STEPS, box, candidates, feasible

AT_ONCE = 50_000  # values of H
ROUGH_POINTS, ROUGH_SAMPLES, ROUGH_STEPS = 50, 12, 6
POLISHED = 2  # candidates at each point
APART = 0.1  # of the box: two candidates to improve that are nearer than this would lead to the same minimum


@short_repr
@dataclass(frozen=True)
class BestControls:
    """The points of a phase (M,), the best controls that are found there (n_u, M), and by what H is above its value
    with them (M,), which is not negative."""

    points: Samples
    controls: np.ndarray
    excess: np.ndarray

    @property
    def total(self) -> float:
        """The integral of what H is above its least value, over the phase."""
        return float(self.points.weights[0] @ self.excess)


@np.errstate(all="ignore")
def least_hamiltonian(phase: PhaseLagrangian, rough: bool = False) -> BestControls:
    """H is that of the minimised objective.

    phase: one with controls and costates.
    rough: at some of its points only, which stand for all, from fewer samples, and none of them improved.
    """
    points = phase.at_points()
    if rough and len(points.t) > ROUGH_POINTS:
        points = points.some(np.linspace(0, len(points.t) - 1, ROUGH_POINTS).astype(int))
    hamiltonian, constrained = phase.over_controls(points)
    u = points.u[: phase.n]
    here = hamiltonian(u[:, None], np.arange(len(points.t)))[0]
    better, least = _least(hamiltonian, constrained, u, phase.control_bounds, rough)
    return BestControls(points, better, np.maximum(here - least, 0.0))


def _least(
    hamiltonian: Values, constrained: Constrained | None, u: np.ndarray, bounds: np.ndarray, rough: bool
) -> tuple[np.ndarray, np.ndarray]:
    """The best feasible controls that are found, shape (n, M), and H there (M,); infinite where none is found."""
    within = box(u, bounds)
    tried = candidates(u, within, ROUGH_SAMPLES if rough else SAMPLES)
    parts = np.array_split(np.arange(u.shape[1]), 1 + u.shape[1] * tried.shape[1] // AT_ONCE)
    found = [_least_of(_Part(hamiltonian, constrained, k, rough), u[:, k], tried, within) for k in parts]
    return np.concatenate([v for v, _ in found], axis=1), np.concatenate([value for _, value in found])


class _Part:
    """H and its constraints at some of the samples, k (S,), which are numbered anew from 0."""

    def __init__(self, hamiltonian: Values, constrained: Constrained | None, k: np.ndarray, rough: bool) -> None:
        self.every, self.rough = np.arange(len(k)), rough
        self.hamiltonian: Values = lambda v, s: hamiltonian(v, k[s])
        self.constrained = None
        if constrained is not None:
            values = constrained.values
            self.constrained = replace(
                constrained, values=lambda v, s: values(v, k[s]), multipliers=constrained.multipliers[:, k]
            )

    def values(self, v: np.ndarray, within: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Controls (n, B, S) moved onto the constraints, and H there (B, S), infinite where they are not met."""
        v = feasible(v, within, self.constrained, self.every, ROUGH_STEPS if self.rough else STEPS)
        H = self.hamiltonian(v, self.every)
        return v, np.where(np.isfinite(H), H, np.inf)


def _least_of(part: _Part, u: np.ndarray, tried: np.ndarray, within: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """As `_least`, of one part, from its controls u (n, S) and from those to try (n, B)."""
    own = np.clip(u, *within[:, :, None])[:, None]
    v = np.concatenate([own, np.broadcast_to(tried[:, :, None], (*tried.shape, u.shape[1]))], axis=1)
    v, H = part.values(v, within)
    if not part.rough:
        starts = [own[:, 0], *_best(v, H, np.diff(within, axis=0)[0])]
        polished = [minimise(part.hamiltonian, start, within, part.constrained).u for start in starts]
        w, value = part.values(np.stack(polished, axis=1), within)
        v, H = np.concatenate([v, w], axis=1), np.concatenate([H, value])
    best = H.argmin(axis=0)
    return v[:, best, part.every], H[best, part.every]


def _best(v: np.ndarray, H: np.ndarray, width: np.ndarray) -> Iterator[np.ndarray]:
    """The candidates v (n, B, S) with the least H, POLISHED at each sample and apart from each other: each (n, S)."""
    every, H = np.arange(v.shape[2]), H.copy()
    for _ in range(POLISHED):
        chosen = v[:, H.argmin(axis=0), every]
        chosen = np.where(np.isfinite(chosen), chosen, v[:, 0])
        yield chosen
        near = (np.abs(v - chosen[:, None]) < APART * width[:, None, None]).all(axis=0)
        H[near] = np.inf
