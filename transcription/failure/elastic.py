"""The elastic program: constraints may be relaxed, at a price, and nothing else matters.

    minimise   sum_j c_j (P_j + Q_j)  +  NEAR / (2 n) sum_i ((z_i - start_i) / (1 + |start_i|))^2
    subject to lower_j <= g_k(z) - p_k + q_k <= upper_j,   0 <= p_k <= P_j,   0 <= q_k <= Q_j
                                                         for every row or unknown k of what is soft, j
               and all other rows and bounds as they are

So the upper bound of each soft constraint moves as a whole, by P_j, and its lower bound by Q_j. A sum of moduli is
least where few of them are not zero: the solution relaxes few constraints (Chinneck, Feasibility and Infeasibility in
Optimization, 2008, on elastic programs). The second term only keeps unknowns that nothing asks about near the start.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.text import short_repr
from ..layout import Transcription, bounded_start
from ..program.contract import NonlinearProgram

NEAR = 1e-6


@short_repr
@dataclass(frozen=True, eq=False)
class Soft:
    """What may be relaxed under one name: rows of the program, or bounds of unknowns.

    what: in words. unit: of its values, "" if none is known. places: (K,) numbers of the rows or unknowns, and
    of_unknowns: (K,) which are unknowns. s: (K,) normalised times. over_time: whether it holds at many times. lower,
    upper: its bounds. size: of its values. of_time: whether it is about a time at an end.
    """

    phase: str
    what: str
    unit: str
    of_unknowns: np.ndarray
    over_time: bool
    places: np.ndarray
    s: np.ndarray
    lower: float
    upper: float
    size: float
    of_time: bool = False


class ElasticProgram:
    """A `contract.NonlinearProgram` of the unknowns (z, p, q, P, Q), from one of z."""

    def __init__(
        self,
        transcription: Transcription,
        nlp: NonlinearProgram,
        soft: Sequence[Soft],
        start: np.ndarray,
        factors: np.ndarray,
    ) -> None:
        """factors: (J,) of the prices 1 / size of what is soft."""
        self.inner, self.start, self.seconds, self.soft = nlp, start, nlp.seconds, soft
        none, counts = np.zeros(0, int), [int(own.of_unknowns.sum()) for own in soft]
        self.unknowns = np.concatenate([none, *(own.places[own.of_unknowns] for own in soft)])
        self.softened_end = nlp.m + len(self.unknowns)
        bounds = [np.repeat([[own.lower], [own.upper]], count, axis=1) for own, count in zip(soft, counts, strict=True)]
        new = np.split(np.arange(nlp.m, self.softened_end), np.cumsum(counts))[:-1]
        self.rows_of = [own.places.copy() for own in soft]
        for rows, own, made in zip(self.rows_of, soft, new, strict=True):
            rows[own.of_unknowns] = made
        self.softened = np.concatenate([none, *self.rows_of])
        self.owner = np.repeat(np.arange(len(soft)), [len(rows) for rows in self.rows_of])
        K, J = len(self.softened), len(soft)
        self.n, self.m = nlp.n + 2 * K + 2 * J, self.softened_end + 2 * K
        over = np.repeat([[0.0], [np.inf]], 2 * K, axis=1)  # P - p and Q - q
        self.cl, self.cu = np.concatenate([[nlp.cl, nlp.cu], *bounds, over], axis=1)
        self.price = np.tile(factors / np.array([own.size for own in soft]), 2)
        _, lower, upper = bounded_start(transcription)
        free = np.isin(np.arange(nlp.n), self.unknowns)
        times = [own.places for own in soft if own.of_time]  # a phase lasts, whatever gives way
        below = free & ~np.isin(np.arange(nlp.n), np.concatenate([none, *times]))
        self.lower = np.concatenate([np.where(below, -np.inf, lower), np.zeros(2 * K + 2 * J)])
        self.upper = np.concatenate([np.where(free, np.inf, upper), np.full(2 * K + 2 * J, np.inf)])
        self.near = NEAR / (1 + np.abs(start)) ** 2 / max(nlp.n, 1)
        self._place_derivatives(K, J)

    def _place_derivatives(self, K: int, J: int) -> None:
        nlp, added, own = self.inner, len(self.unknowns), np.arange(2 * K)
        rows, columns = nlp.jacobianstructure()
        limits, slacks = self.softened_end + own, nlp.n + own
        largest = nlp.n + 2 * K + np.concatenate([self.owner, J + self.owner])
        parts = (  # rows, columns, coefficients of what is linear
            (nlp.m + np.arange(added), self.unknowns, np.ones(added)),
            (np.tile(self.softened, 2), slacks, np.repeat([-1.0, 1.0], K)),
            (limits, slacks, -np.ones(2 * K)),
            (limits, largest, np.ones(2 * K)),
        )
        self.jacobian_rows = np.concatenate([rows, *(part[0] for part in parts)])
        self.jacobian_columns = np.concatenate([columns, *(part[1] for part in parts)])
        self.constant = np.concatenate([part[2] for part in parts])
        rows, columns = nlp.hessianstructure()
        every = np.arange(nlp.n)
        self.hessian_places = np.concatenate([rows, every]), np.concatenate([columns, every])

    def first(self, z: np.ndarray) -> np.ndarray:
        """Unknowns that satisfy what is soft, at z, shape (n,)."""
        J = len(self.soft)
        g = np.nan_to_num(self.inner.constraints_unchecked(z))
        g = np.concatenate([g, z[self.unknowns]])[self.softened]
        p, q = np.maximum(g - self.cu[self.softened], 0.0), np.maximum(self.cl[self.softened] - g, 0.0)
        largest = np.zeros(2 * J)
        np.maximum.at(largest, np.concatenate([self.owner, J + self.owner]), np.concatenate([p, q]))
        return np.concatenate([z, p, q, largest])

    def slacks(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """P and Q, shape (J,) each."""
        upper, lower = np.split(z[self.inner.n + 2 * len(self.softened) :], 2)
        return upper, lower

    def values(self, z: np.ndarray) -> list[np.ndarray]:
        """What each soft constraint is about, shape (K,) each, without slacks."""
        bare = z[: self.inner.n]
        g = np.concatenate([self.inner.constraints_unchecked(bare), bare[self.unknowns]])
        return [g[rows] for rows in self.rows_of]

    # -- the contract ------------------------------------------------------------------------------------------------

    def rows(self, component: Any) -> np.ndarray:
        return self.inner.rows(component)

    def row_name(self, row: int) -> tuple[str, int | None]:
        return self.inner.row_name(row) if row < self.inner.m else ("bound", row - self.inner.m)

    def objective(self, z: np.ndarray) -> float:
        away = z[: self.inner.n] - self.start
        return float(self.price @ z[self.n - len(self.price) :] + self.near @ away**2 / 2)

    def gradient(self, z: np.ndarray) -> np.ndarray:
        slacks = np.zeros(2 * len(self.softened))
        return np.concatenate([self.near * (z[: self.inner.n] - self.start), slacks, self.price])

    def constraints(self, z: np.ndarray) -> np.ndarray:
        return self._extended(self.inner.constraints(z[: self.inner.n]), z)

    def constraints_unchecked(self, z: np.ndarray) -> np.ndarray:
        return self._extended(self.inner.constraints_unchecked(z[: self.inner.n]), z)

    def _extended(self, g: np.ndarray, z: np.ndarray) -> np.ndarray:
        n, K = self.inner.n, len(self.softened)
        p, q = z[n : n + K], z[n + K : n + 2 * K]
        upper, lower = self.slacks(z)
        found = np.concatenate([g, z[self.unknowns], upper[self.owner] - p, lower[self.owner] - q])
        found[self.softened] += q - p
        return found

    def jacobianstructure(self) -> tuple[np.ndarray, np.ndarray]:
        return self.jacobian_rows, self.jacobian_columns

    def jacobian(self, z: np.ndarray) -> np.ndarray:
        return np.concatenate([self.inner.jacobian(z[: self.inner.n]), self.constant])

    def hessianstructure(self) -> tuple[np.ndarray, np.ndarray]:
        return self.hessian_places

    def hessian(self, z: np.ndarray, y: np.ndarray, sigma: float) -> np.ndarray:
        """As of `NonlinearProgram`; f is how near the point stays to the first one.

        z: (n,) unknowns.
        y: (m,) multipliers of g.
        sigma: of f.
        """
        inner = self.inner.hessian(z[: self.inner.n], y[: self.inner.m], 0.0)
        return np.concatenate([inner, sigma * self.near])
