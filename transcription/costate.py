"""Costates from the multipliers of the nonlinear program.

Perturb the dynamics by a small e: dx/dt = f + e. The optimal objective changes by  integral of lambda e dt, which defines
the costate lambda. In the nonlinear program e enters the defects of segment s through h R e, and its optimal value changes
by -mu_s . h R e, where mu_s are the defects' multipliers. Since the integral is h sum_j b_j lambda_j e_j,

    lambda(t_j) = -(R^T mu_s)_j / b_j        at the collocation nodes inside a segment.                          (1)

At a knot lambda is the change of the optimal objective with the state there. With L_s all terms of the Lagrangian that
belong to segment s (defects, path constraints, running cost),

    lambda(t_k) = d L_s / d x_k for the segment that starts at t_k, -d L_s / d x_k for the one that ends there.  (2)

(2) has the full order of the scheme, also at both ends of the trajectory and where an end is no collocation point. Both
agree unless a bound on the state is active at the knot, where a costate may jump. Costates are those of the minimised
objective with H = w + lambda f (paper, appendix B, with the sign of (B.7)), times the problem's sense: d J / d x as written.
"""

from __future__ import annotations

import numpy as np

from .transcribe import Layout, Transcription
from .compiler import CompiledNLP
from .mesh import Mesh
from .outcome import Outcome


def costates(transcription: Transcription, nlp: CompiledNLP, outcome: Outcome) -> list[np.ndarray]:
    """lambda for each phase, shape (n_x, N, d + 1): at the state nodes of every segment, in J per unit of state."""
    return [transcription.problem.sense * _costate(layout, transcription, nlp, outcome) for layout in transcription.phases]


def _costate(layout: Layout, transcription: Transcription, nlp: CompiledNLP, outcome: Outcome) -> np.ndarray:
    mesh, scheme = layout.mesh, layout.mesh.scheme
    costate = np.full((len(layout.phase.states), mesh.segments, mesh.degree + 1), np.nan)
    mu = _defect_multipliers(layout, transcription, nlp, outcome)
    inner = [j for j, node in enumerate(scheme.collocated) if 0 < node < mesh.degree]
    nodes = [scheme.collocated[j] for j in inner]
    costate[:, :, nodes] = -(mu @ scheme.R[list(scheme.rows)][:, inner]) / scheme.b[inner]  # (1)
    start, end = _knot_gradients(layout, transcription, nlp, outcome)
    costate[:, :, 0], costate[:, :, -1] = start, -end  # (2)
    return costate


def _defect_multipliers(layout, transcription, nlp, outcome) -> np.ndarray:
    """mu, shape (n_x, N, rows of the scheme)."""
    defects = [f for f in transcription.families if f.kind == "defect" and f.phase == layout.phase.name]
    y = [outcome.y[nlp.rows(family.component)] for family in defects]
    return np.reshape(y, (len(layout.phase.states), -1, layout.mesh.segments)).swapaxes(1, 2)


def _knot_gradients(layout, transcription, nlp, outcome) -> tuple[np.ndarray, np.ndarray]:
    """d L_s / d x at the first and at the last node of every segment, two arrays (n_x, N)."""
    block = transcription.model.phase[layout.phase.name]
    first, last = layout.mesh.nodes[:, 0], layout.mesh.nodes[:, -1]
    start, end = np.zeros((2, len(layout.x), layout.mesh.segments))
    share = _right_shares(layout.mesh)
    for over, index, columns, terms in nlp.lagrangian_terms(outcome.z, outcome.y):
        for i, x in enumerate(layout.x):
            if over is block.segment:  # terms of one segment
                start[i] += _sum_where(columns == x[first, None], terms)
                end[i] += _sum_where(columns == x[last, None], terms)
            elif over is block.explicit:  # terms of one point: at a knot, part of them belongs to either segment
                at_point = np.zeros(layout.x.shape[1])
                at_point[index] = _sum_where(columns == x[index, None], terms)
                start[i] += share[first] * at_point[first]
                end[i] += (1 - share[last]) * at_point[last]
    return start, end


def _sum_where(mask: np.ndarray, terms: np.ndarray) -> np.ndarray:
    return np.where(mask, terms, 0.0).sum(axis=1)


def _right_shares(mesh: Mesh) -> np.ndarray:
    """The part of each point's quadrature weight that it has as the first node of a segment, shape (K,)."""
    scheme, share = mesh.scheme, np.zeros(len(mesh.fractions))
    if scheme.c[0] == 0:
        share[mesh.first] = mesh.widths * scheme.b[0] / mesh.weights[mesh.first]
    return share
