"""Derivatives of a compiled program against central differences."""

import numpy as np


def dense(nlp, z, y, sigma) -> tuple[np.ndarray, np.ndarray]:
    """Jacobian, shape (m, n), and full Hessian of sigma J + y g, shape (n, n)."""
    jac, low = np.zeros((nlp.m, nlp.n)), np.zeros((nlp.n, nlp.n))
    np.add.at(jac, nlp.jacobianstructure(), nlp.jacobian(z))
    rows, cols = nlp.hessianstructure()
    assert (rows >= cols).all()
    np.add.at(low, (rows, cols), nlp.hessian(z, y, sigma))
    return jac, low + np.tril(low, -1).T


def differences(f, z: np.ndarray) -> np.ndarray:
    """df/dz by central differences of order 4, the derivatives last."""
    columns = []
    for k in range(len(z)):
        e = np.zeros(len(z))
        e[k] = 1e-4 * max(1, abs(z[k]))
        columns.append((8 * (f(z + e) - f(z - e)) - f(z + 2 * e) + f(z - 2 * e)) / (12 * e[k]))
    return np.stack(columns, axis=-1)


def check_derivatives(nlp, z, tolerance=1e-8) -> tuple[np.ndarray, np.ndarray]:
    """The Jacobian and the Hessian at z, with multipliers made here, once they and the gradient are found right."""
    y, sigma = np.random.default_rng(5).standard_normal(nlp.m), 0.7
    jac, hess = dense(nlp, z, y, sigma)

    def lagrangian_gradient(z):
        return sigma * nlp.gradient(z) + y @ dense(nlp, z, y, sigma)[0]

    for exact, numeric in (
        (nlp.gradient(z), differences(nlp.objective, z)),
        (jac, differences(nlp.constraints, z)),
        (hess, differences(lagrangian_gradient, z)),
    ):
        scale = 1 + np.abs(numeric).max(initial=0)
        np.testing.assert_allclose(exact, numeric, rtol=0, atol=tolerance * scale, equal_nan=False)
    return jac, hess
