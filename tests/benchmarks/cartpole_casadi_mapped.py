"""Cart-pole with CasADi's `nlpsol`, the dynamics mapped over the points: as a careful CasADi user would write it.

Run as `python cartpole_casadi_mapped.py SEGMENTS`; prints one JSON object.

The dynamics are one SX function, mapped over all points (mapping the defects of one segment over the segments was
measured 10 to 15 % slower, since the dynamics at the knots are then evaluated twice; expanding everything to SX makes
the evaluation 5 times as fast and the set-up 14 times as slow). Unknowns are ordered point by point; derivatives are
CasADi's own, exact.
"""

import sys
import time

began = time.perf_counter()

import casadi as ca  # noqa: E402
import numpy as np  # noqa: E402
from cartpole_casadi import DURATION, END, LIMITS, OPTIONS, START, rates, report, simpson, straight_line  # noqa: E402

imported = time.perf_counter()


def program(segments):
    """The nonlinear program as nlpsol takes it, z being (x_0, u_0, x_1, u_1, ...)."""
    points, h = 2 * segments + 1, DURATION / segments
    z = ca.SX.sym("z", 5)
    dynamics = ca.Function("f", [z], [rates(z[:4], z[4])])
    Z = ca.MX.sym("Z", 5, points)
    F = dynamics.map(points)(Z)
    (x0, xm, x1), (f0, fm, f1) = ((Y[:, :-1:2], Y[:, 1::2], Y[:, 2::2]) for Y in (Z[:4, :], F))
    middle = xm - (x0 + x1) / 2 - h / 8 * (f0 - f1)  # (4.4)
    simpson_defect = x1 - x0 - h / 6 * (f0 + 4 * fm + f1)  # (4.3)
    cost = ca.dot(ca.DM(simpson(segments)), Z[4, :].T ** 2)
    return {"x": ca.vec(Z), "f": cost, "g": ca.vec(ca.vertcat(middle, simpson_defect))}


def bounds(segments):
    """Lower and upper bounds of the unknowns, shape (5, points) each."""
    upper = np.full((5, 2 * segments + 1), np.inf)
    for i, limit in LIMITS.items():
        upper[i] = limit
    lower = -upper
    for ends in (lower, upper):
        ends[:4, 0], ends[:4, -1] = START, END
    return lower, upper


def main(segments):
    start, cpu = time.perf_counter(), time.process_time()
    nlp = program(segments)
    lower, upper = bounds(segments)
    guess = np.vstack([straight_line(2 * segments + 1), np.zeros(2 * segments + 1)])
    built = time.perf_counter()
    solver = ca.nlpsol("solver", "ipopt", nlp, OPTIONS)
    compiled = time.perf_counter()
    limits = {"lbx": lower.ravel("F"), "ubx": upper.ravel("F"), "lbg": 0, "ubg": 0}
    solution = solver(x0=guess.ravel("F"), **limits)
    solved, cpu = time.perf_counter(), time.process_time() - cpu
    parts = {"build": built - start, "compile": compiled - built, "solve": solved - compiled}
    report({"import": imported - began, **parts}, cpu, solver.stats(), solution["f"])


if __name__ == "__main__":
    main(int(sys.argv[1]))
