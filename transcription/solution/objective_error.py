"""draft"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...problems.problem import Phase, Range
from ..engines.outcome import Outcome, Status
from ..layout import Layout, Transcription, bounded_start
from ..schemes.runge_kutta import Shooting
from ..schemes.scheme import FiniteDifference
from .hamiltonian import Constrained, minimise
from .implicit import consistent_inputs
from .trajectory import Trajectory

GAUSS_POINTS = 6
SAFETY = 1.0


@dataclass(frozen=True)
class ObjectiveError:
    correction: float
    segments: tuple[np.ndarray, ...]
    terms: Mapping[str, tuple[np.ndarray, ...]]
    ends: float
    gap: float
    barrier: float
    infeasibility: float
    bar: float
    why_not: str = ""


def objective_error(transcription: Transcription, nlp, outcome: Outcome, trajectories: Sequence[Trajectory]):
    sense = transcription.problem.sense
    _, lower, upper = bounded_start(transcription)
    multipliers = _Multipliers(transcription, nlp, outcome, lower, upper)
    phases = [_Phase(i, layout, tr, multipliers) for i, (layout, tr) in enumerate(zip(transcription.phases, trajectories))]
    terms = [p.terms() for p in phases]
    segs = tuple(sense * sum(t.values()) for t in terms)
    ends = sense * multipliers.ends()
    infeas = multipliers.infeasibility()
    correction = float(sum(s.sum() for s in segs)) + ends
    bar = SAFETY * float(sum(np.abs(s).sum() for s in segs)) + abs(ends) + infeas
    found = all(p.found for p in phases)
    return ObjectiveError(correction, segs, {k: tuple(sense * t[k] for t in terms) for k in terms[0]}, ends,
        multipliers.gap(), multipliers.barrier, infeas, bar, "" if found else "no minimum")


class _Multipliers:
    def __init__(self, transcription, nlp, outcome, lower, upper):
        self.transcription, self.nlp, self.outcome = transcription, nlp, outcome
        self.size = 1 + abs(outcome.objective)
        z = outcome.z
        self.lower, self.upper = lower, upper
        with np.errstate(all="ignore"):
            self.low = np.where(np.isfinite(lower), outcome.z_lower * (z - lower), 0.0)
            self.high = np.where(np.isfinite(upper), outcome.z_upper * (upper - z), 0.0)
        g = nlp.constraints_unchecked(z)
        self.fixed = nlp.cl == nlp.cu
        self.g = g
        y = outcome.y
        side = np.where(y > 0, nlp.cu - g, g - nlp.cl)
        self.rows = np.where(~self.fixed & np.isfinite(side), np.abs(y) * side, 0.0)
        self.missed = np.where(self.fixed, y * (g - nlp.cl), 0.0)
        self.barrier = 0.0

    def gap(self):
        return float(self.low.sum() + self.high.sum() + self.rows.sum())

    def infeasibility(self):
        return float(np.abs(self.missed).sum())

    def active(self, z, s, scale, weight):
        """theta"""
        nu, s = np.abs(z) * scale / (self.size * weight), np.maximum(s, 0) / scale
        return np.where(nu + s > 0, nu / np.where(nu + s > 0, nu + s, 1), 1.0)

    def ends(self):
        t = self.transcription
        total = 0.0
        own = [t.parameters]
        for layout in t.phases:
            own += [layout.t[layout.t >= 0], layout.x[:, [0, -1]].ravel()]
        idx = np.concatenate(own); idx = np.unique(idx[idx >= 0])
        z = self.outcome.z[idx]
        for mult, bound, sign, prod in ((self.outcome.z_lower[idx], self.lower[idx], 1, self.low[idx]), (self.outcome.z_upper[idx], self.upper[idx], -1, self.high[idx])):
            ok = np.isfinite(bound)
            s = sign * (z[ok] - bound[ok])
            total -= (self.active(mult[ok], s, 1 + np.abs(bound[ok]), 1.0) * prod[ok]).sum()
        for family in t.families:
            if family.kind in ("boundary", "integral"):
                r = family.rows(self.nlp)
                r = r[~self.fixed[r]]
                y = self.outcome.y[r]
                b = np.where(y > 0, self.nlp.cu[r], self.nlp.cl[r])
                ok = np.isfinite(b)
                total -= (self.active(y, np.abs(self.g[r] - b), 1 + np.abs(b), 1.0) * self.rows[r])[ok].sum()
        return float(total + self.missed.sum())


class _Probe(dict):
    def __missing__(self, name):
        self[name] = np.float64(0.5)
        return self[name]


def _names(function):
    probe = _Probe()
    with np.errstate(all="ignore"):
        function(probe, np)
    return set(probe)


class _Phase:
    def __init__(self, number, layout: Layout, trajectory: Trajectory, multipliers: _Multipliers):
        self.number, self.layout, self.trajectory, self.multipliers = number, layout, trajectory, multipliers
        self.phase, self.mesh = layout.phase, layout.mesh
        self.sense = multipliers.transcription.problem.sense
        self.T = float(trajectory.t[1] - trajectory.t[0])
        self.found = True
        m = multipliers
        self.integrands = [(self.sense, self.phase.lagrange)] if self.phase.lagrange else []
        for c in self.phase.integral:
            (f,) = [f for f in m.transcription.families if (f.phase, f.kind, f.name) == (self.phase.name, "integral", c.name)]
            self.integrands.append((float(m.outcome.y[f.rows(m.nlp)][0]), c.function))
        self.inputs = {v.name for v in self.phase.inputs}
        self.n = len(self.phase.controls)

    def families(self, kind, name):
        return [f for f in self.multipliers.transcription.families if (f.phase, f.kind, f.name) == (self.phase.name, kind, name)]

    def rows_of(self, kind, name):
        m = self.multipliers
        fs = self.families(kind, name)
        if not fs:
            return np.zeros((3, 0))
        s = np.concatenate([f.span[:, 0] for f in fs]); y = np.concatenate([m.outcome.y[f.rows(m.nlp)] for f in fs])
        w = np.concatenate([f.weights for f in fs])
        o = np.argsort(s)
        return np.stack([s[o], y[o], w[o]])

    @cached_property
    def mixed(self):
        """(function of names->values, bounds, s, density)"""
        out = []
        if not self.n:
            return out
        for c in self.phase.path:
            if _names(c.function) & self.inputs:
                s, y, w = self.rows_of("path", c.name)
                out.append((c.function, c.bounds, s, y / (w * self.T)))
        for v, places in zip(self.phase.algebraic, self.layout.u[self.n:]):
            if v.bounds != Range():
                k = np.flatnonzero((places >= 0) & (self.mesh.weights > 0))
                y = self.multipliers.outcome.z_upper[places[k]] - self.multipliers.outcome.z_lower[places[k]]
                out.append((lambda values, m, name=v.name: values[name], v.bounds, self.mesh.fractions[k], y / (self.mesh.weights[k] * self.T)))
        return out

    @cached_property
    def held(self):
        """state constraints: (function, bound, s, masses)"""
        m, out = self.multipliers, []
        for i, state in enumerate(self.phase.states):
            if state.bounds == Range():
                continue
            places = self.layout.x[i]
            k = np.flatnonzero(places >= 0)
            k = k[(k > 0) & (k < len(places) - 1)]
            s, y, w = self.rows_of("bound", state.name)
            for z, bound, sign in ((m.outcome.z_lower, state.bounds.lower, -1), (m.outcome.z_upper, state.bounds.upper, 1)):
                if np.isfinite(bound):
                    ss = np.concatenate([self.mesh.fractions[k], s]); mass = np.concatenate([sign * z[places[k]], np.where(y * sign > 0, y, 0)])
                    o = np.argsort(ss)
                    out.append((lambda v, m, name=state.name: v[name], bound, ss[o], mass[o]))
        for c in self.phase.path:
            if self.n and _names(c.function) & self.inputs:
                continue
            s, y, w = self.rows_of("path", c.name)
            if c.bounds.fixed:
                out.append((c.function, c.bounds.lower, s, y))
            else:
                for bound, sign in ((c.bounds.lower, -1), (c.bounds.upper, 1)):
                    if np.isfinite(bound):
                        out.append((c.function, bound, s, np.where(y * sign > 0, y, 0)))
        return out

    def measure(self, function, bound, s, mass):
        tr = self.trajectory
        at = tr.at(s)
        u = consistent_inputs(self.phase, at.t, at.x, at.u, tr.parameters)
        g = np.broadcast_to(function(self.phase.values(at.t, at.x, u, tr.parameters), np), s.shape)
        edges = np.concatenate([[0], (s[1:] + s[:-1]) / 2, [1]])
        hat = np.diff(edges)
        theta = self.multipliers.active(mass, np.abs(g - bound), 1 + abs(bound), hat)
        return s, theta * mass / (hat * self.T)

    def terms(self):
        N = self.mesh.segments
        out = {k: np.zeros(N) for k in ("quadrature", "dynamics", "control", "constraints")}
        held = [(f, b, self.measure(f, b, s, y)) for f, b, s, y in self.held if len(s)]
        for gi, group in enumerate(self.mesh.groups):
            self.group(gi, group, held, out)
        return out

    def own(self, group):
        tr, seg = self.trajectory, group.segments
        if isinstance(group.scheme, Shooting):
            v = self.multipliers.nlp.integrals(self.multipliers.outcome.z)[self.number]
            return sum((w * v[j, seg] for j, (w, _) in enumerate(self.integrands)), np.zeros(len(seg)))
        tau, weights = group.scheme.quadrature
        S = tr.grid(seg, tau)
        return tr.h[seg] * (self.running(S.t, S.x, S.u) @ weights)

    def running(self, t, x, u):
        v = self.phase.values(t, x, u, self.trajectory.parameters)
        return sum((w * f(v, np) for w, f in self.integrands), np.zeros(np.shape(t)))

    def group(self, gi, group, held, out):
        tr, seg, phase, p = self.trajectory, group.segments, self.phase, self.trajectory.parameters
        nodes, weights = np.polynomial.legendre.leggauss(GAUSS_POINTS)
        sigma = group.scheme.sigma
        width = np.diff(sigma)[:, None]
        tau = (sigma[:-1, None] + width * (nodes + 1) / 2).ravel()
        W = tr.h[seg][:, None] * (width * weights / 2).ravel()
        S = tr.grid(seg, tau)
        shape = S.t.shape
        t, x, dx, lam, ui = S.t.ravel(), *(a.reshape(len(a), -1) for a in (S.x, S.dx, self.sense * S.costate, S.u))
        u = consistent_inputs(phase, t, x, ui, p)
        w = self.running(t, x, u)
        f = phase.dynamics(t, x, u, p)
        out["quadrature"][seg] = (W * w.reshape(shape)).sum(axis=1) - self.own(group)
        out["dynamics"][seg] = (W * (lam * (f - dx)).sum(axis=0).reshape(shape)).sum(axis=1)
        v = phase.values(t, x, u, p)
        fr = ((t - tr.t[0]) / self.T)
        for function, bound, (s, nu) in held:
            g = np.broadcast_to(function(v, np), t.shape)
            out["constraints"][seg] += (W * (np.interp(fr, s, nu) * (g - bound)).reshape(shape)).sum(axis=1)
        if self.n:
            H0 = w + (lam * f).sum(axis=0)

            def inputs(c, k):
                B = c.shape[1]
                tt = np.broadcast_to(t[k], (B, len(k)))
                xx = np.broadcast_to(x[:, None, k], (len(x), B, len(k)))
                if phase.algebraic:
                    c = np.concatenate([c, np.broadcast_to(u[self.n:, None, k], (len(u) - self.n, B, len(k)))])
                    c = consistent_inputs(phase, tt, xx, c, p)
                return tt, xx, c

            def H(c, k):
                tt, xx, uu = inputs(c, k)
                with np.errstate(all="ignore"):
                    return self.running(tt, xx, uu) + (lam[:, None, k] * phase.dynamics(tt, xx, uu, p)).sum(axis=0)

            constrained = None
            if self.mixed:
                def G(c, k):
                    tt, xx, uu = inputs(c, k)
                    with np.errstate(all="ignore"):
                        vv = phase.values(tt, xx, uu, p)
                        return np.stack([np.broadcast_to(fn(vv, np), tt.shape) for fn, *_ in self.mixed])
                constrained = Constrained(G, np.array([b.lower for _, b, *_ in self.mixed]), np.array([b.upper for _, b, *_ in self.mixed]),
                    np.stack([np.interp(fr, s, nu) for *_, s, nu in self.mixed]))
            bounds = np.array([[c.bounds.lower, c.bounds.upper] for c in phase.controls]).T
            best = minimise(H, u[: self.n], bounds, constrained)
            self.found &= bool(best.found.all())
            out["control"][seg] = (W * (best.value - H0).reshape(shape)).sum(axis=1)
