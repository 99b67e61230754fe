"""Pyomo models made by hand, to compile and to differentiate."""

import numpy as np
from pyomo import core as pyo
from pyomo.core import Block, ConcreteModel, Constraint, Objective, Param, RangeSet, Set, Var, inequality

from trajopt.transcription.program.templates import templated


def pendulum_rates(m, k):
    return {"q": m.x["v", k], "v": m.u[k] * m.p["torque"] - m.g * pyo.sin(m.x["q", k]) / (1 + m.x["v", k] ** 2)}


def trajectory(model, n, scheme):
    """A pendulum of free end time and one static parameter, in two schemes; x[q, 0], x[v, last] are fixed."""
    per = {"trapezoid": 1, "hermite-simpson": 2}[scheme]
    last = per * n
    model.segment, model.point = RangeSet(0, n - 1), RangeSet(0, last)
    model.state = Set(initialize=["q", "v"])
    model.x = Var(model.state, model.point, initialize=0.0)
    model.u = Var(model.point, initialize=0.0)
    model.p = Var(["torque"], initialize=1.0)
    model.tf = Var(initialize=2.0)
    model.g = Param(initialize=9.81, mutable=True)
    model.first = Param(model.segment, initialize={s: per * s for s in range(n)})
    model.width = Param(model.segment, initialize=dict(enumerate(np.linspace(1, 2, n) / n)), mutable=True)
    model.w = Param(model.point, initialize=dict(enumerate(np.linspace(0.5, 1, last + 1) / n)))

    def defect(m, s, i):
        h, k = m.width[s] * (m.tf - 0.5), m.first[s]
        f = [pendulum_rates(m, k + j)[i] for j in range(per + 1)]
        rule = (f[0] + f[1]) / 2 if per == 1 else (f[0] + 4 * f[1] + f[2]) / 6
        return m.x[i, k + per] - m.x[i, k] == h * rule

    def midpoint(m, s, i):
        f = [pendulum_rates(m, 2 * s + j)[i] for j in (0, 2)]
        ends = m.x[i, 2 * s] + m.x[i, 2 * s + 2]
        return m.x[i, 2 * s + 1] == 0.5 * ends + m.tf * m.width[s] / 8 * (f[0] - f[1])

    with templated():
        for i in ("q", "v"):
            model.add_component(f"defect_{i}", Constraint(model.segment, rule=lambda m, s, i=i: defect(m, s, i)))
            if per == 2:
                model.add_component(f"mid_{i}", Constraint(model.segment, rule=lambda m, s, i=i: midpoint(m, s, i)))
        model.path = Constraint(model.point, rule=lambda m, k: inequality(-1.5, m.u[k] * m.x["q", k], 2.5))
        model.below = Constraint(model.point, rule=lambda m, k: m.u[k] ** 2 <= 4 + m.x["v", k])
        model.energy = Constraint(
            rule=lambda m: (
                m.x["q", last] ** 2
                - sum(m.w[k] * m.u[k] ** 2 for k in m.point) * 3
                + m.tf * sum(m.w[k] * pyo.cos(m.x["q", k]) for k in m.point)
                <= 100
            )
        )
        model.close = Constraint(rule=lambda m: m.x["v", 0] * m.x["v", last] == m.p["torque"] - 1)
        model.cost = Objective(
            rule=lambda m: (
                m.tf**2
                + (m.tf - 0.5) * sum(m.w[k] * m.u[k] ** 2 for k in m.point)
                - sum(m.x["q", s] * m.x["v", s + 1] for s in m.segment) / 3
            )
        )
    model.x["q", 0].fix(0.3)
    model.x["v", last].fix(-0.2)


def free(model):
    """The free variables, point by point where they have a point."""
    leaves = [v for v in model.component_data_objects(Var) if not v.fixed]

    def point(v):
        index = v.index()[-1] if isinstance(v.index(), tuple) else v.index()
        return index if isinstance(index, int) else -1

    return sorted(leaves, key=point)


def two_phases(scheme, n=4):
    model = ConcreteModel()
    model.a, model.b = Block(), Block()
    trajectory(model.a, n, scheme)
    trajectory(model.b, n + 1, scheme)
    with templated():
        model.link = Constraint(rule=lambda m: m.a.tf * m.b.x["q", 1] == m.b.x["v", 0])
        model.cost = Objective(rule=lambda m: m.a.tf + sum(m.b.w[k] * m.b.u[k] ** 2 for k in m.b.point))
    model.a.cost.deactivate(), model.b.cost.deactivate()
    return model


def small(constraint=None, objective=lambda m: m.y, n=4):
    """x[0..n], a scalar y and the given rules."""
    m = ConcreteModel()
    m.point = RangeSet(0, n)
    m.inner = RangeSet(0, n - 1)
    m.x, m.y = Var(m.point, initialize=0.5), Var(initialize=0.5)
    m.d = Param(m.point, initialize={k: 0.1 * (k + 1) for k in range(n + 1)})
    with templated():
        if constraint:
            m.c = Constraint(m.inner, rule=constraint)
        m.cost = Objective(rule=objective)
    return m


def random_point(nlp, seed=0, low=-1.0, high=1.0):
    return np.random.default_rng(seed).uniform(low, high, nlp.n)
