"""Cart-pole with CasADi's `Opti` and a Python loop over the segments: the way most scripts are written.

Run as `python cartpole_casadi_opti.py SEGMENTS`; prints one JSON object.

Variables are declared point by point: one opti.variable(4, points) with slices in the loop, which is seen more often,
takes 18 s instead of 4.4 s for 1000 segments.
"""

import sys
import time

began = time.perf_counter()

import casadi as ca  # noqa: E402
from cartpole_casadi import DURATION, END, LIMITS, OPTIONS, START, rates, report, straight_line  # noqa: E402

imported = time.perf_counter()


def problem(segments):
    """The Opti problem with its guess."""
    opti, h = ca.Opti(), DURATION / segments
    points = 2 * segments + 1
    guess = straight_line(points)
    x, u = [], []
    for k in range(points):
        x.append(opti.variable(4))
        u.append(opti.variable())
        opti.set_initial(x[k], guess[:, k])
    x_state, u_control = ca.SX.sym("x", 4), ca.SX.sym("u")
    dynamics = ca.Function("f", [x_state, u_control], [rates(x_state, u_control)])
    f = [dynamics(x[k], u[k]) for k in range(points)]
    cost = 0
    for k in range(0, points - 1, 2):
        opti.subject_to(x[k + 1] == (x[k] + x[k + 2]) / 2 + h / 8 * (f[k] - f[k + 2]))
        opti.subject_to(x[k + 2] == x[k] + h / 6 * (f[k] + 4 * f[k + 1] + f[k + 2]))
        cost += h / 6 * (u[k] ** 2 + 4 * u[k + 1] ** 2 + u[k + 2] ** 2)
    z = ca.vertcat(ca.horzcat(*x), ca.horzcat(*u))
    for i, limit in LIMITS.items():
        opti.subject_to(opti.bounded(-limit, z[i, :], limit))
    opti.subject_to(x[0] == ca.DM(START))
    opti.subject_to(x[-1] == ca.DM(END))
    opti.minimize(cost)
    return opti, cost


def main(segments):
    start, cpu = time.perf_counter(), time.process_time()
    opti, cost = problem(segments)
    built = time.perf_counter()
    opti.solver("ipopt", OPTIONS)
    solution = opti.solve()
    objective = solution.value(cost)
    solved, cpu = time.perf_counter(), time.process_time() - cpu
    stats = solution.stats()
    solve = stats["t_wall_total"]
    parts = {"build": built - start, "compile": solved - built - solve, "solve": solve}
    report({"import": imported - began, **parts}, cpu, stats, objective)


if __name__ == "__main__":
    main(int(sys.argv[1]))
