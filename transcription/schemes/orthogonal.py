"""Orthogonal collocation (paper, 9.7 and appendix D): families of nodes, and the scheme of any of them."""

from __future__ import annotations

import numpy as np

from ...problems.sets import distinct
from .polynomials import differentiation_matrix, integrated_basis, jacobi_nodes
from .scheme import Scheme


def gauss(n: int) -> np.ndarray:
    """Roots of the Legendre polynomial of degree n, shape (n,)."""
    return jacobi_nodes(n, 0, 0)


def radau(n: int) -> np.ndarray:
    """n points with the right end among them."""
    return np.append(jacobi_nodes(n - 1, 1, 0), 1.0)


def radau_left(n: int) -> np.ndarray:
    """n points with the left end among them."""
    return np.append(0.0, jacobi_nodes(n - 1, 0, 1))


def lobatto(n: int) -> np.ndarray:
    """n + 1 points with both ends among them."""
    return np.concatenate([[0.0], jacobi_nodes(n - 1, 1, 1), [1.0]])


def chebyshev(n: int) -> np.ndarray:
    """n + 1 extreme points of the Chebyshev polynomial of degree n, both ends among them."""
    return (1 - np.cos(np.pi * np.arange(n + 1) / n)) / 2


def quadrature_order(c: np.ndarray) -> int:
    """The number of leading powers that the interpolatory quadrature on the nodes c integrates exactly."""
    b = integrated_basis(c, np.ones(1))[0]
    order = len(c)
    while order <= 2 * len(c) and abs(b @ _legendre(order, c)) < 1e-12:
        order += 1
    return order


def _legendre(k: int, c: np.ndarray) -> np.ndarray:
    """The Legendre polynomial of degree k on [0, 1]; orthogonal to 1, so its exact integral is 0."""
    return np.polynomial.legendre.Legendre.basis(k, domain=[0, 1])(c)


def collocated_at(
    c: np.ndarray,
    form: str,
    *,
    name: str,
    family: str,
    source: str,
    degree: int,
) -> Scheme:
    """The scheme with the given collocation nodes.

    c: of the unit segment, shape (n,).
    form: of its defects, "integral" or "differential"; they have the same solutions.
    name: of the method.
    family: it belongs to.
    source: of the method.
    degree: within the family.

    Integral form: x_i = x_0 + h sum_j A_ij f_j for every state node after the first, A_ij the integral of l_j.
    Differential form: the slope of the state polynomial is h f_j at every node (Gauss and Radau, (D.6)); for Lobatto
    points, whose state polynomial has one degree more than there are nodes to carry it, the rows are solved for
    f_1, f_2, ..., which leaves f_0 in each.
    """
    sigma = distinct(np.append(c, [0.0, 1.0]))
    d = len(sigma) - 1
    A = integrated_basis(c, sigma[1:])
    L, R = np.hstack([-np.ones((d, 1)), np.eye(d)]), A
    differential = form == "differential"
    if differential:
        L, R = _differential(sigma, c, A, L)
    order = quadrature_order(c)
    return Scheme(name, family, order, sigma, c, L, R, source, differential=differential, degree=degree)


def _differential(sigma: np.ndarray, c: np.ndarray, A: np.ndarray, L: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    d, n = len(sigma) - 1, len(c)
    if n == d + 1:  # Lobatto: R = A has a row for each f but f_0
        solve = np.linalg.inv(A[:, 1:])
        return solve @ L, np.hstack([solve @ A[:, :1], np.eye(d)])
    # The state polynomial has degree n: Radau's nodes carry it, and Gauss's without the end.
    D = np.hstack([differentiation_matrix(sigma[: n + 1], c), np.zeros((n, d - n))])
    if n == d:  # Radau
        return D, np.eye(n)
    end = L[-1] - A[-1] @ D  # Gauss: x_d = x_0 + h b f, with h f_j = (D x)_j
    return np.vstack([D, end]), np.vstack([np.eye(n), np.zeros((1, n))])
