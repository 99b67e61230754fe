"""Lagrange interpolation on the unit segment: barycentric weights, basis values, their integrals.

All nodes and arguments are normalised times tau in [0, 1] on one segment. Sources: the paper, appendix D;
Berrut and Trefethen, SIAM Review 46(3), 2004.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, lru_cache, wraps

import numpy as np

KEPT, LARGEST = 256, 512
"""Basis values that are kept, and arguments of what is: the same places of a segment come again in every solution."""


def barycentric_weights(c: np.ndarray) -> np.ndarray:
    """Barycentric weights of the nodes c, shape (n,), scaled so that the largest magnitude is 1 (paper, (D.4))."""
    differences = c[:, None] - c[None, :]
    np.fill_diagonal(differences, 1.0)
    # Logarithms keep the products of many small differences from underflowing at high degree.
    logs = -np.log(np.abs(differences)).sum(axis=1)
    signs = np.sign(differences).prod(axis=1)
    return signs * np.exp(logs - logs.max())


@lru_cache(maxsize=256)
def _weights(nodes: bytes) -> np.ndarray:
    """The weights of nodes that come again and again: those of a scheme, at every evaluation between its points."""
    return barycentric_weights(np.frombuffer(nodes))


def _kept(basis: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> Callable[[np.ndarray, np.ndarray], np.ndarray]:
    """The same function of nodes and arguments, whose values for few arguments are kept, and cannot be written to."""

    @lru_cache(maxsize=KEPT)
    def known(c: bytes, tau: bytes) -> np.ndarray:
        values = basis(np.frombuffer(c), np.frombuffer(tau))
        values.setflags(write=False)
        return values

    @wraps(basis)
    def of(c: np.ndarray, tau: np.ndarray) -> np.ndarray:
        c, tau = np.asarray(c, float), np.asarray(tau, float)
        return known(c.tobytes(), tau.tobytes()) if len(tau) <= LARGEST else basis(c, tau)

    return of


@_kept
def lagrange_basis(c: np.ndarray, tau: np.ndarray) -> np.ndarray:
    """The Lagrange polynomials of the nodes c, shape (n,), at tau, shape (m,): shape (m, n) (paper, (D.3))."""
    distance = tau[:, None] - c[None, :]
    at_node = distance == 0
    terms = _weights(c.tobytes()) / np.where(at_node, 1.0, distance)
    terms = np.where(at_node.any(axis=1, keepdims=True), at_node, terms)
    return terms / terms.sum(axis=1, keepdims=True)


def differentiation_matrix(c: np.ndarray, tau: np.ndarray) -> np.ndarray:
    """Slopes at some of the nodes c, shape (n,), of the polynomial through values at c: shape (m, n) (paper, (D.6)).

    tau: (m,), each one of the nodes. The diagonal is minus the sum of the row, so that constants have slope zero
    exactly.
    """
    v = barycentric_weights(c)
    own = np.array([int(np.flatnonzero(c == t)[0]) for t in tau])
    distance = c[own, None] - c[None, :]
    distance[np.arange(len(own)), own] = 1.0
    D = (v[None, :] / v[own, None]) / distance
    D[np.arange(len(own)), own] = 0.0
    D[np.arange(len(own)), own] = -D.sum(axis=1)
    return D


def jacobi_nodes(n: int, alpha: int, beta: int) -> np.ndarray:
    """Roots on [0, 1] of a Jacobi polynomial, shape (n,), increasing.

    n: degree of the polynomial.
    alpha, beta: exponents of the weight (1 - tau)^alpha tau^beta to which it is orthogonal.

    Golub and Welsch: eigenvalues of the symmetric tridiagonal matrix of the three-term recurrence, accurate to
    rounding.
    """
    k, sum_ = np.arange(n, dtype=float), alpha + beta
    with np.errstate(invalid="ignore"):
        diagonal = (beta**2 - alpha**2) / ((2 * k + sum_) * (2 * k + sum_ + 2))
    diagonal[:1] = (beta - alpha) / (sum_ + 2)
    k = k[1:]
    square = 4 * k * (k + alpha) * (k + beta) * (k + sum_)
    with np.errstate(invalid="ignore", divide="ignore"):
        square /= (2 * k + sum_) ** 2 * (2 * k + sum_ + 1) * (2 * k + sum_ - 1)
    if sum_ == 0 and n > 1:
        square[0] = 1 / 3  # the limit of 0/0 for Legendre polynomials
    matrix = np.diag(diagonal) + np.diag(np.sqrt(square), 1) + np.diag(np.sqrt(square), -1)
    return (1 + np.linalg.eigvalsh(matrix)) / 2


@cache
def gauss_legendre(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and weights of Gauss's rule on [-1, 1], each shape (n,)."""
    return np.polynomial.legendre.leggauss(n)


@_kept
def integrated_basis(c: np.ndarray, tau: np.ndarray) -> np.ndarray:
    """Integrals of the Lagrange polynomials of the nodes c from 0 to tau, shape (m, n).

    Gauss-Legendre quadrature with enough points to be exact; monomial coefficients would lose digits at high degree.
    """
    nodes, weights = gauss_legendre(len(c) // 2 + 1)
    inside = np.outer(tau, (nodes + 1) / 2)
    values = lagrange_basis(c, inside.ravel()).reshape(len(tau), len(nodes), len(c))
    return np.einsum("m,q,mqn->mn", tau, weights / 2, values)
