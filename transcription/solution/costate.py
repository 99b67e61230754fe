"""Costates from the multipliers of the nonlinear program.

Perturb the dynamics by a small e: dx/dt = f + e. The optimal objective changes by  integral of lambda e dt, which
defines the costate lambda. In the nonlinear program e enters the defects of segment s through h R e, and its optimal
value changes by -mu_s . h R e, where mu_s are the defects' multipliers. Since the integral is h sum_j b_j lambda_j e_j,

    lambda(t_j) = -(R^T mu_s)_j / b_j        at the collocation nodes inside a segment.                          (1)

At a knot lambda is the change of the optimal objective with the state there. With L_s all terms of the Lagrangian that
belong to segment s (defects, path constraints, running cost),

    lambda(t_k) = d L_s / d x_k for the segment that starts at t_k, -d L_s / d x_k for the one that ends there.  (2)

(2) has the full order of the scheme, also at both ends of the trajectory and where an end is no collocation point. Both
agree unless a bound on the state is active at the knot, where a costate may jump. Where a state is fixed all the time,
that is everywhere, for itself and the states that keep it there: then (1) holds at the knots, too. Costates are those
of the minimised objective with H = w + lambda f (paper, appendix B, with the sign of (B.7)), times the problem's sense:
d J / d x as written.
"""

from __future__ import annotations

import numpy as np

from ..constraint_kinds import DEFECT
from ..engines.outcome import Outcome
from ..layout import Layout, Transcription
from ..program.compiled import CompiledNLP
from ..program.contract import NonlinearProgram
from ..schemes.scheme import collocation_scheme


def costates(transcription: Transcription, nlp: CompiledNLP, outcome: Outcome) -> list[np.ndarray | None]:
    """lambda of each phase, shape (n_x, K + N - 1): at the slots of the mesh, in objective per unit of state.

    None for a phase by finite differences.

    transcription: by collocation schemes and finite differences.
    nlp: its compiled program.
    outcome: with multipliers over time without those that act at the ends only, see `end_masses`.
    """
    sense = transcription.problem.sense
    return [
        sense * _costate(layout, transcription, nlp, outcome) if layout.mesh.schemes[0].has_costates else None
        for layout in transcription.phases
    ]


def _costate(layout: Layout, transcription: Transcription, nlp: CompiledNLP, outcome: Outcome) -> np.ndarray:
    mesh = layout.mesh
    costate = np.full((len(layout.phase.states), len(mesh.slot_points)), np.nan)
    at_ends: list[tuple[np.ndarray, np.ndarray]] = []
    for number, group in enumerate(mesh.groups):
        mu = _defect_multipliers(layout, number, transcription, nlp, outcome)
        scheme = collocation_scheme(group.scheme)
        inner = [j for j, node in enumerate(scheme.collocated) if 0 < node < len(scheme.sigma) - 1]
        slots = group.slots[:, [scheme.collocated[j] for j in inner]]
        costate[:, slots] = -(mu @ scheme.R[:, inner]) / scheme.b[inner]  # (1)
        for j in sorted(set(range(len(scheme.c))) - set(inner)):
            at_ends.append((group.slots[:, scheme.collocated[j]], -(mu @ scheme.R[:, j]) / scheme.b[j]))
    start, end = _knot_gradients(layout, nlp, outcome)
    costate[:, mesh.offset], costate[:, mesh.offset + mesh.degrees] = start, -end  # (2)
    if any(state.bounds.fixed for state in layout.phase.states):
        for slots, values in at_ends:
            costate[:, slots] = values
    return costate


def _defect_multipliers(
    layout: Layout, number: int, transcription: Transcription, nlp: NonlinearProgram, outcome: Outcome
) -> np.ndarray:
    """mu of one group of segments, shape (n_x, G, d); 0 for the rows that define an eliminated state."""
    group, names = layout.mesh.groups[number], [state.name for state in layout.phase.states]
    mu = np.zeros((len(names), len(group.segments), len(collocation_scheme(group.scheme).L)))
    for family in transcription.families:
        if (family.kind, family.phase, family.group) == (DEFECT, layout.phase.name, number):
            y = outcome.y[family.rows(nlp)]
            rows = [family.row] if isinstance(family.row, int) else list(family.row)
            mu[names.index(family.name)][:, rows] = y.reshape(len(group.segments), len(rows))
    return mu


def _knot_gradients(layout: Layout, nlp: CompiledNLP, outcome: Outcome) -> tuple[np.ndarray, np.ndarray]:
    """d L_s / d x at the first and at the last node of every segment, two arrays (n_x, N)."""
    mesh = layout.mesh
    start, end = np.zeros((2, len(layout.x), mesh.segments))
    left, right = mesh.slot_parts[mesh.offset], mesh.slot_parts[mesh.offset + mesh.degrees]
    for over, index, columns, terms in nlp.lagrangian_terms(outcome.z, outcome.y):
        if (owners := layout.owners.get(over)) is not None:
            for i, x in enumerate(layout.x):
                start[i] += _per_segment(columns == x[mesh.knots[owners], None], terms, owners, mesh.segments)
                end[i] += _per_segment(columns == x[mesh.knots[owners + 1], None], terms, owners, mesh.segments)
        elif (shared := layout.shared.get(over)) is not None:
            _add_shared(layout, shared, columns, terms, start, end)
        elif over is not None and over == layout.explicit:
            for i, x in enumerate(layout.x):
                at_point = np.zeros(layout.x.shape[1])
                at_point[index] = np.where(columns == x[index, None], terms, 0.0).sum(axis=1)
                start[i] += left * at_point[mesh.knots[:-1]]
                end[i] += right * at_point[mesh.knots[1:]]
    return start, end


def _add_shared(
    layout: Layout,
    shared: tuple[np.ndarray, np.ndarray, np.ndarray],
    columns: np.ndarray,
    terms: np.ndarray,
    start: np.ndarray,
    end: np.ndarray,
) -> None:
    """Add what states at knots are worth to others, as of `Layout.shared`; at the ends one side is none."""
    knot, before, after = shared
    for i, x in enumerate(layout.x):
        own = np.where(columns == x[layout.mesh.knots[knot], None], terms, 0.0).sum(axis=1)
        np.add.at(end[i], knot[knot > 0] - 1, (before * own)[knot > 0])
        inside = knot < layout.mesh.segments
        np.add.at(start[i], knot[inside], (after * own)[inside])


def _per_segment(mask: np.ndarray, terms: np.ndarray, owners: np.ndarray, segments: int) -> np.ndarray:
    """The sum of the masked terms of each segment, shape (N,)."""
    return np.bincount(owners, weights=np.where(mask, terms, 0.0).sum(axis=1), minlength=segments)
