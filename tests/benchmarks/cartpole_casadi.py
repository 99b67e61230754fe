"""What both CasADi scripts share: the cart-pole of problems/cartpole.yaml, in numbers.

Kelly 2017, section 6. Hermite-Simpson, separated: points k = 0 .. 2 N, even at the knots, odd in the middle.
"""

import json
import resource
from math import pi

import casadi as ca
import numpy as np

M1, M2, LENGTH, GRAVITY, DURATION = 1.0, 0.3, 0.5, 9.81, 2.0
START, END = (0.0, 0.0, 0.0, 0.0), (1.0, pi, 0.0, 0.0)
LIMITS = {0: 2.0, 1: 2 * pi, 4: 20.0}  # |q1|, |q2|, |u|, by place in (q1, q2, v1, v2, u)
OPTIONS = {"ipopt.tol": 1e-8, "ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": False, "record_time": True}


def rates(x, u):
    """dx/dt, (6.1) and (6.2); works for SX, MX and DM."""
    _, q2, v1, v2 = ca.vertsplit(x)
    s, c = ca.sin(q2), ca.cos(q2)
    return ca.vertcat(
        v1,
        v2,
        (LENGTH * M2 * s * v2**2 + u + M2 * GRAVITY * c * s) / (M1 + M2 * s**2),
        -(LENGTH * M2 * c * s * v2**2 + u * c + (M1 + M2) * GRAVITY * s) / (LENGTH * M1 + LENGTH * M2 * s**2),
    )


def straight_line(points):
    """The guess of the states, shape (4, points)."""
    return np.linspace(START, END, points).T


def simpson(segments):
    """Quadrature weights at the points, shape (2 segments + 1,)."""
    weights = np.zeros(2 * segments + 1)
    weights[:-1:2] += 1 / 6
    weights[1::2] += 4 / 6
    weights[2::2] += 1 / 6
    return weights * DURATION / segments


def report(seconds, cpu, stats, objective):
    """One JSON object on one line, the same fields from every tool: seconds by part, bytes of memory."""
    callbacks = ("t_wall_nlp_f", "t_wall_nlp_g", "t_wall_nlp_grad_f", "t_wall_nlp_jac_g", "t_wall_nlp_hess_l")
    record = {
        **seconds,
        "evaluate": sum(stats.get(name, 0.0) for name in callbacks),
        "total": seconds["build"] + seconds["compile"] + seconds["solve"],
        "CPU": cpu,
        "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024,
        "iterations": stats["iter_count"],
        "objective": float(objective),
        "solved": stats["success"],
    }
    print(json.dumps(record))
