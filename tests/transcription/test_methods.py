"""Every method on a smooth shipped problem, and every such problem by some methods, with TRAJOPT_SLOW each by each: the
same objective, within the method's own error estimate.

To first order a defect epsilon of the dynamics changes the objective by the integral of lambda epsilon, so at most by
sum_i max |lambda_i| sum_k eta_ik; the quadrature of the running cost adds its own error along the interpolants.
"""

import numpy as np
import pytest
from named import crossed, share

from trajopt.problems.build import build_all
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load
from trajopt.transcription.settings import Settings, Step, settings_of
from trajopt.transcription.solve import solve

TRUE = {  # converged (Radau of degree 5 on 160 segments) or exact
    "cartpole": 58.80766746,
    "block_move_min_force": 12.0,
    "brachistochrone": 1.801603122,
    "shot_put": 21.88843009,
    "biped": 390.79053817,
}
DIGITS = 1e-8  # relative, of the values above
METHODS = [
    ("explicit-euler", None, 300),
    ("implicit-euler", None, 300),
    ("midpoint", None, 150),
    ("trapezoid", None, 100),
    ("hermite-simpson", None, 40),
    ("hermite-simpson-compressed", None, 40),
    ("gauss", 3, 25),
    ("radau", 4, 20),
    ("radau-left", 4, 20),
    ("lobatto", 4, 20),
    ("chebyshev", 4, 20),
]


def quadrature_error(trajectory) -> float:
    """The integral of the running cost along the interpolants, less the scheme's own quadrature of it."""
    w, mesh = trajectory.phase.lagrange, trajectory.mesh
    if w is None:
        return 0.0
    nodes, weights = np.polynomial.legendre.leggauss(20)
    inside = trajectory.grid(np.arange(mesh.segments), (nodes + 1) / 2)
    values = trajectory.phase.arguments(inside.t, inside.x, inside.u, trajectory.parameters)
    exact = (trajectory.h * (np.broadcast_to(w(values, np), inside.t.shape) @ weights) / 2).sum()
    at_points = trajectory.phase.arguments(trajectory.times, trajectory.x, trajectory.u, trajectory.parameters)
    own = (trajectory.t[1] - trajectory.t[0]) * (mesh.weights * w(at_points, np)).sum()
    return float(abs(exact - own))


@pytest.mark.parametrize(
    ("name", "how"), crossed([*TRUE], METHODS) + [("cartpole", how) for how in share(METHODS, 3, 1)]
)
def test_objective_within_the_error_estimate(name, how):
    method, degree, segments = how
    spec = load(shipped()[name])
    solution = solve(build_all(spec)[-1], [Step(method, segments, 1e-9, degree)], Settings(settings_of(spec).options))
    assert solution.solved
    (trajectory,), (error,) = solution.trajectories, solution.errors
    estimate = np.abs(trajectory.dense.costate).max(axis=1) @ error.eta.sum(axis=1) + quadrature_error(trajectory)
    difference = abs(solution.objective - TRUE[name])
    assert difference <= 1.1 * estimate + DIGITS * TRUE[name]


@pytest.mark.parametrize("method", ["gauss", "radau", "radau-left", "lobatto", "hermite-simpson", "trapezoid"])
def test_costates_of_every_family_on_the_block(method):
    """Appendix B: lambda_x = -24, lambda_v = 24 t - 12, also at end points that are no collocation points."""
    spec = load(shipped()["block_move_min_force"])
    segments = 200 if method == "trapezoid" else 4
    solution = solve(build_all(spec)[0], [Step(method, segments, 1e-10)])
    (trajectory,) = solution.trajectories
    tolerance = 1e-2 if method == "trapezoid" else 1e-6
    dense = trajectory.dense
    assert dense.costate[0] == pytest.approx(-24, abs=tolerance)
    assert dense.costate[1] == pytest.approx(24 * dense.t - 12, abs=tolerance)
